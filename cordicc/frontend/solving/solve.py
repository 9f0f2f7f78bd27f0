"""Equations in an unknown: coefficients of its cosine and sine, read off structurally.

Both sides become polynomials in (cos t, sin t), or (cosh t, sinh t), with graph values as
coefficients; sin**2 is replaced, and what is left besides 1, cos and sin has to vanish.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.base.diagnostics import Span
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Place, Relation, names
from cordicc.frontend.lower import emit
from cordicc.frontend.scope import Scope, Text
from cordicc.frontend.solving.branches import Form, by_condition
from cordicc.frontend.solving.polynomial import Coefficients, Expander, Poly, another_unknown
from cordicc.frontend.solving.zero import ZeroTest, adds_to_domain
from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import FoldError


@dataclass(frozen=True, slots=True)
class SolveRequest:
    """One or two equations, the unknown, and the branch as written (None if absent).

    `together` are both unknowns of two coupled equations, of which `unknown` is one; `condition`
    chooses the branch instead of a sign.
    """

    equations: Sequence[tuple[Relation, Text]]
    unknown: str
    branch: str | None
    span: Span
    branch_span: Span
    together: tuple[str, ...] = ()
    condition: tuple[Relation, Text] | None = None

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Return the unknowns."""
        return self.together or (self.unknown,)

    @property
    def all_relations(self) -> list[tuple[Relation, Text]]:
        """Return the equations, and the condition if there is one."""
        return [*self.equations, *([self.condition] if self.condition else [])]


@dataclass(frozen=True, slots=True)
class _Linear:
    """A cos t + sin t equation: B cos t + A sin t = C."""

    A: Value
    B: Value
    C: Value


def solve(request: SolveRequest, scope: Scope, zeros: ZeroTest) -> tuple[Value, int] | None:
    """Return the value of the unknown and the coordinate system (1 circular, -1 hyperbolic).

    None after diagnostics.
    """
    maths = Coefficients(scope.builder)
    systems: set[int] = set()
    found: list[_Linear] = []
    failed = False
    for relation, text in request.equations:
        expander = Expander(scope, text, request.unknown, maths)
        try:
            linear = _linear(relation, expander, zeros)
        except ExpressionError as error:
            text.report(scope.report, error)
            linear = None
        except FoldError as error:
            scope.report.error("E209", str(error), text.span(relation.at))
            linear = None
        if linear is None:
            failed = True
            continue
        systems.add(expander.system or 1)
        found.append(linear)
    if failed:
        return None
    if len(found) == 2:
        return _pair(request, scope, zeros, maths, found, systems)
    return _single(request, scope, zeros, maths, found[0], systems.pop())


def _linear(relation: Relation, expander: Expander, zeros: ZeroTest) -> _Linear | None:
    unknown, maths = expander.unknown, expander.maths
    sides = [relation.left, relation.right]
    if not any(name.name == unknown for side in sides for name in names(side)):
        raise ExpressionError("E305", f"the unknown '{unknown}' does not occur in the equation", *relation.at)
    left, right = (expander.expand(side) for side in sides)
    if left is None or right is None:
        return None
    difference = maths.add(left, right, -1)
    cosine, sine = _functions(expander)
    for powers, value in difference.items():
        if powers not in ((0, 0), (1, 0), (0, 1)) and not maths.vanishes(value, zeros):
            raise _not_linear(relation.at, expander, powers, value in zeros.given_up)
    zero = maths.builder.const(0)
    B, A = (
        zero if maths.vanishes(v, zeros) else v
        for v in (difference.get((1, 0), zero), difference.get((0, 1), zero))
    )
    if zero == A and zero == B:
        message = f"no unknown left: the coefficients of {cosine}({unknown}) and {sine}({unknown}) are both 0"
        raise ExpressionError("E304", message, *relation.at)
    # the constant side is taken right minus left, which spares two negations
    constant = maths.add(_constant(right), _constant(left), -1)
    return _Linear(A, B, constant.get((0, 0), zero))


def _functions(expander: Expander) -> tuple[str, str]:
    return ("cos", "sin") if expander.system != -1 else ("cosh", "sinh")


def _constant(poly: Poly) -> Poly:
    return {k: v for k, v in poly.items() if k == (0, 0)}


def _not_linear(at: Place, expander: Expander, powers: tuple[int, int], given_up: bool) -> ExpressionError:
    unknown, hint = expander.unknown, None
    cosine, sine = _functions(expander)
    multiples = {abs(multiple) for multiple in expander.multiples}
    if len(multiples) == 1 and multiples != {1}:
        hint = another_unknown(multiples.pop(), unknown)
    parts = [
        f"{name}({unknown})" + (f"**{power}" if power > 1 else "")
        for name, power in zip((cosine, sine), powers, strict=True)
        if power
    ]
    if given_up:
        hint = "its coefficient seems to be 0, but is too large for a proof: simplify the equation by hand"
    message = f"the equation is not linear in {cosine}({unknown}) and {sine}({unknown})"
    return ExpressionError("E302", f"{message}: {'*'.join(parts)} does not cancel", *at, hint)


def _single(
    request: SolveRequest,
    scope: Scope,
    zeros: ZeroTest,
    maths: Coefficients,
    linear: _Linear,
    system: int,
) -> tuple[Value, int] | None:
    if not branch_is_valid(request, scope, required=system == 1):
        return None
    constant = with_domain(maths, linear.C, [linear.A, linear.B, linear.C])
    try:
        if request.condition is not None:
            form = Form(linear.A, linear.B, constant, system)
            value = by_condition(*request.condition, request.unknown, form, scope, zeros)
        else:
            params = (system, request.branch or "none")
            value = emit(scope.builder, "solve", (linear.A, linear.B, constant), params)
    except FoldError as error:
        scope.report.error("E209", str(error), request.span)
        return None
    except ExpressionError as error:
        scope.report.error(error.code, error.message, request.branch_span, error.hint)
        return None
    return None if value is None else (value, system)


def branch_is_valid(request: SolveRequest, scope: Scope, required: bool) -> bool:
    """Report a branch that is missing or malformed."""
    if request.condition is not None:
        relation, text = request.condition
        used = {name.name for side in (relation.left, relation.right) for name in names(side)}
        if not used & set(request.unknowns):
            unknowns = " and ".join(f"'{name}'" for name in request.unknowns)
            message = f"the condition does not depend on {unknowns}: it cannot choose a branch"
            scope.report.error("E309", message, text.span(relation.at))
            return False
        return True
    hint = f'write branch: "+" or branch: "-", or a condition such as branch: {request.unknowns[-1]} > 0'
    if request.branch not in (None, "+", "-"):
        scope.report.error("E307", "the branch must be '+' or '-'", request.branch_span, hint)
        return False
    if request.branch is None and required:
        unknowns = ", ".join(f"'{name}'" for name in request.unknowns)
        subject = "the equations have" if request.together else "the equation has"
        message = f"{subject} two solutions for {unknowns}: a branch is required"
        scope.report.error("E307", message, request.span, hint)
        return False
    return True


def _pair(
    request: SolveRequest,
    scope: Scope,
    zeros: ZeroTest,
    maths: Coefficients,
    found: list[_Linear],
    systems: set[int],
) -> tuple[Value, int] | None:
    report = scope.report
    if request.branch is not None or request.condition is not None:
        message = "a pair of equations has one solution and takes no branch"
        report.error("E307", message, request.branch_span, "remove 'branch'")
        return None
    if systems != {1}:
        message = "a pair of equations must be in cos and sin of the unknown"
        hint = "pairs are for cos and sin; solve one equation in cosh and sinh by itself"
        report.error("E303", message, request.span, hint)
        return None
    one, two = found
    try:
        left = maths.product(one.B, two.A)
        determinant = maths.plus(left, maths.product(two.B, one.A), -1)
        if zeros.is_zero(determinant):
            message = f"the two equations do not determine '{request.unknown}': their determinant is 0"
            report.error("E308", message, request.span)
            return None
    except FoldError as error:
        report.error("E209", str(error), request.span)
        return None
    constant = with_domain(maths, two.C, [one.A, one.B, one.C, two.A, two.B, two.C])
    try:
        operands = (one.A, one.B, one.C, two.A, two.B, constant)
        return emit(scope.builder, "solve_pair", operands), 1
    except FoldError as error:
        report.error("E209", str(error), request.span)
        return None


def with_domain(maths: Coefficients, value: Value, kept: list[Value]) -> Value:
    """Return the value, invalid also where a coefficient that cancelled has no value."""
    kept = list(kept)
    for dropped in dict.fromkeys(maths.dropped):
        if adds_to_domain(maths.builder.nodes, dropped, kept):
            value = maths.builder.emit("guard", (value, dropped), ("any",))
            kept.append(dropped)
    return value
