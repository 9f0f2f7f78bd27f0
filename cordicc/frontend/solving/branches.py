"""Conditions that choose between the two solutions of an equation: proven once, or taken at run time.

A condition counts as holding where its sides are equal.  The solution + is taken where the condition
holds for it, otherwise the solution -; where it holds for neither, the sample is invalid.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from cordicc.base.diagnostics import Report
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import (
    Call,
    Expr,
    Name,
    Neg,
    Number,
    Place,
    Relation,
    Sum,
    children,
    names,
    postorder,
)
from cordicc.frontend.lower import emit, lower
from cordicc.frontend.scope import Scope, Text
from cordicc.frontend.solving.polynomial import Coefficients, Expander, Poly
from cordicc.frontend.solving.zero import ZeroTest, adds_to_domain, cone
from cordicc.frontend.trees import rebuilt
from cordicc.ir.graph import Builder, Graph, Node, Value
from cordicc.ir.meaning.exact import FoldError
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.ranges.forward import value_ranges

CONDITIONS = ("<", ">", "<=", ">=")
_MAX_NODES = 400
_PERIODIC = ("sin", "cos", "tan")


def excess(condition: Relation) -> Expr:
    """Return the expression that is at least 0 where the condition holds."""
    left, right = condition.left, condition.right
    if condition.relation in ("<", "<="):
        left, right = right, left
    if isinstance(right, Number) and right.value == 0:
        return left
    if isinstance(left, Number) and left.value == 0:
        return Neg(right, condition.at)
    return Sum((left, right), (1, -1), condition.at)


def sine_of_angle(expr: Expr, unknowns: tuple[str, ...], sine: str = "sin") -> Expr:
    """Return sin(t), or sinh(t), for an unknown t alone: inside (-pi, pi) they have the same sign."""
    inner, negative = expr, False
    while isinstance(inner, Neg):
        inner, negative = inner.operand, not negative
    if not isinstance(inner, Name) or inner.name not in unknowns:
        return expr
    made = Call(sine, (inner,), inner.at)
    return Neg(made, expr.at) if negative else made


def sign_at_every_angle(expr: Expr, with_sine: Expr) -> Expr:
    """Return what has the sign of an excess at pi too, where the sine of the angle is 0 but the angle is not.

    Args:
        expr: the excess as written.
        with_sine: what `sine_of_angle` made of it.
    """
    return expr if isinstance(with_sine, Neg) else with_sine


def proven_sign(value: Value, zeros: ZeroTest) -> int:
    """Return 1 or -1 if a value is proven to have that sign over the ranges of the inputs, else 0."""
    nodes = zeros.builder.nodes
    order = cone(nodes, value)
    if len(order) > _MAX_NODES:
        return 0
    place = {old: new for new, old in enumerate(order)}
    moved = tuple(
        Node(node.op, node.params, tuple(Value(place[v.node], v.result) for v in node.operands))
        for node in (nodes[index] for index in order)
    )
    box = {
        name: Interval(math.nextafter(lo, -math.inf), math.nextafter(hi, math.inf))
        for name, (lo, hi) in zeros.ranges.items()
    }
    interval = value_ranges(Graph(moved, {}), box)[-1][value.result]
    if interval is None:
        return 0
    return 1 if interval.lo > 0 else -1 if interval.hi < 0 else 0


@dataclass(frozen=True, slots=True)
class Form:
    """B cos t + A sin t = C (`system` 1), or B cosh t + A sinh t = C (-1)."""

    A: Value
    B: Value
    C: Value
    system: int


def by_condition(
    condition: Relation, text: Text, unknown: str, form: Form, scope: Scope, zeros: ZeroTest
) -> Value | None:
    """Return the solution of an equation that a condition picks; None after diagnostics.

    Raises FoldError where it has no value, ExpressionError where the condition cannot choose.
    """
    builder = scope.builder
    kept = (form.A, form.B, form.C)
    plus, minus = (emit(builder, "solve", kept, (form.system, branch)) for branch in ("+", "-"))
    written = excess(condition)
    expr = sine_of_angle(written, (unknown,), "sin" if form.system == 1 else "sinh")
    linear = _linear(expr, text, unknown, scope)
    tested = sign_at_every_angle(written, expr) if form.system == 1 else expr
    if linear is not None and not any(adds_to_domain(builder.nodes, v, kept) for v in linear[:3]):
        sign, decides = _sign_of_branch(linear, form, zeros, condition.at)
        if sign:
            return plus if sign > 0 else minus
        # Where what decides is 0 both solutions hold, if the sine stands for the angle.
        if decides is not None and (tested is expr or builder.constant(form.C) != 0):
            return emit(builder, "select", [decides, plus, minus])
        signs = _signs(linear, form, builder, angle=tested is not expr)
        if signs is not None:
            return signs.chosen(builder, plus, minus)
    first, second = (condition_at(tested, text, {unknown: t}, form.system == 1, scope) for t in (plus, minus))
    return None if first is None or second is None else selected(builder, plus, minus, first, second)


def _linear(expr: Expr, text: Text, unknown: str, scope: Scope) -> tuple[Value, Value, Value, int] | None:
    """Return (E, F, G, system) of a condition E cos t + F sin t + G >= 0; None if it is not of that form."""
    quiet = replace(scope, report=Report())
    expander = Expander(quiet, text, unknown, Coefficients(scope.builder))
    try:
        poly: Poly | None = expander.expand(expr)
        if poly is None or quiet.report.failed or expander.maths.dropped:
            return None
        if any(powers not in ((0, 0), (1, 0), (0, 1)) for powers in poly):
            return None
    except (ExpressionError, FoldError):
        return None
    zero = scope.builder.const(0)
    return (
        poly.get((1, 0), zero), poly.get((0, 1), zero), poly.get((0, 0), zero), expander.system or 1,
    )  # fmt: skip


def _sign_of_branch(
    condition: tuple[Value, Value, Value, int], form: Form, zeros: ZeroTest, at: Place
) -> tuple[int, Value | None]:
    """Return the branch that a linear condition picks.

    At the solutions the condition is (P +- K r)/R**2 >= 0 with R**2 = A**2 + B**2, r = sqrt(R**2 - C**2),
    P = (E B + F A) C + G R**2 and K = F B - E A.  With P = 0 the sign of K decides: (1 or -1, None) if it
    is proven, (0, K) if not.  (0, None) if P is not proven to be 0.  Raises ExpressionError at `at` if K
    is 0: the condition is the same for both solutions.
    """
    (E, F, G, system), A, B, C = condition, form.A, form.B, form.C
    maths = Coefficients(zeros.builder)
    builder = zeros.builder
    if system != form.system:
        return 0, None
    try:
        if system == -1:
            # t = +- acosh(C/B) if A is 0: sinh has the sign of the branch
            odd = all(builder.constant(v) == 0 for v in (A, E, G))
            return (proven_sign(F, zeros), None) if odd else (0, None)
        along = maths.product(maths.plus(maths.product(E, B), maths.product(F, A)), C)
        if builder.constant(G) != 0:
            square = maths.plus(maths.product(A, A), maths.product(B, B))
            along = maths.plus(along, maths.product(G, square))
        across = maths.plus(maths.product(F, B), maths.product(E, A), -1)
        if zeros.is_zero(across):
            message = "the condition is the same for both solutions: it cannot choose a branch"
            hint = 'write branch: "+" or branch: "-", or a condition such as cos(q) > 0 or sin(q) > 0'
            raise ExpressionError("E309", message, *at, hint)
        if not zeros.is_zero(along):
            return 0, None
    except FoldError:
        return 0, None
    sign = proven_sign(across, zeros)
    return (sign, None) if sign else (0, across)


@dataclass(frozen=True, slots=True)
class _Signs:
    """A condition on the sine or the cosine alone, by signs that no rounding of an angle disturbs.

    With P and K as in `_sign_of_branch` the product of what is asked of both solutions has the sign of
    `beyond` = |C| - |K'|, K' = B for the sine and A for the cosine: where it is negative one of them meets
    the condition, and K tells which; where it is positive both or none do, as P tells; where it is 0 one
    of them lies on the border.

    `own`: K', `other`: A for the sine and B for the cosine.  `only_zero`: the condition is that the angle
    is negative, and the border is met at 0 but not at pi, where C = -K'.
    """

    P: Value
    K: Value
    own: Value
    other: Value
    C: Value
    only_zero: bool

    def chosen(self, builder: Builder, plus: Value, minus: Value) -> Value:
        """Return the solution that meets the condition, the first if both do; invalid where none does."""
        size = emit(builder, "abs", [self.own])
        by_K = emit(builder, "select", [self.K, plus, minus])
        if not self.only_zero:
            beyond = emit(builder, "sub", [emit(builder, "abs", [self.C]), size])
            both = emit(builder, "min", [beyond, self.P])
            value = emit(builder, "select", [both, plus, by_K])
            some = emit(builder, "max", [self.P, emit(builder, "neg", [beyond])])
            return emit(builder, "guard", [value, some], ("nonnegative",))
        # C counted from 0 towards the angle 0: from there on in the one direction, from pi in the other.
        towards = emit(builder, "flip", [self.C, self.own])
        past_zero, before_pi = (emit(builder, op, [towards, size]) for op in ("sub", "add"))
        # P = 0 is pi beside 0, or a double solution.
        by_other = emit(builder, "select", [emit(builder, "neg", [self.other]), plus, minus])
        first = emit(builder, "select", [self.P, by_other, by_K])
        first = emit(builder, "select", [emit(builder, "neg", [self.P]), first, plus])
        inner = emit(builder, "select", [before_pi, by_K, plus])
        value = emit(builder, "select", [past_zero, first, inner])
        within = emit(
            builder, "select", [emit(builder, "neg", [before_pi]), self.P, emit(builder, "neg", [past_zero])]
        )
        some = emit(builder, "max", [self.P, within])
        return emit(builder, "guard", [value, some], ("nonnegative",))


def _signs(
    condition: tuple[Value, Value, Value, int], form: Form, builder: Builder, *, angle: bool
) -> _Signs | None:
    """Return the signs that decide a condition k sin t >= 0 or k cos t >= 0; None for any other.

    `angle`: it is the condition that the angle is negative, of which the sine is what is left.
    """
    E, F, G = (builder.constant(v) for v in condition[:3])
    if form.system != 1 or condition[3] != 1 or G != 0 or E is None or F is None or (E == 0) == (F == 0):
        return None
    factor, other, own = (F, form.A, form.B) if E == 0 else (E, form.B, form.A)
    if angle and (builder.constant(form.C) == 0 or builder.constant(own) == 0):
        return None
    # The sign of a product, without a multiplier.
    P, K = emit(builder, "flip", [form.C, other]), own
    if factor < 0:
        P = emit(builder, "neg", [P])
    if (factor < 0) == (E == 0):
        K = emit(builder, "neg", [K])
    return _Signs(P, K, own, other, form.C, angle)


def condition_at(
    expr: Expr, text: Text, solution: Mapping[str, Value], circular: bool, scope: Scope
) -> Value | None:
    """Return the value of a condition's excess for a solution; None after diagnostics.

    A circular unknown stands for its value in (-pi, pi].
    """
    values = dict(scope.values)
    values.update(solution)
    if circular:
        expr = _with_wrapped(expr, frozenset(solution))
        used = {name.name for name in names(expr)}
        for name, value in solution.items():
            if name + ".wrapped" in used:
                values[name + ".wrapped"] = emit(scope.builder, "wrap", [value])
    return lower(expr, replace(scope, values=values), text)


def _with_wrapped(expr: Expr, unknowns: frozenset[str]) -> Expr:
    """Return the expression with wrapped unknowns, where a turn more or less makes a difference."""
    kept: set[int] = set()
    made: dict[int, Expr] = {}
    for part in postorder(expr):
        if isinstance(part, Call) and part.function in _PERIODIC:
            argument = part.args[0]
            kept |= {id(t) for t in (children(argument) if isinstance(argument, Sum) else (argument,))}
    for part in postorder(expr):
        if isinstance(part, Name) and part.name in unknowns and id(part) not in kept:
            made[id(part)] = Name(part.name + ".wrapped", part.at)
        else:
            made[id(part)] = rebuilt(part, [made[id(child)] for child in children(part)])
    return made[id(expr)]


def selected(builder: Builder, plus: Value, minus: Value, excess_plus: Value, excess_minus: Value) -> Value:
    """Return the solution for which the condition holds, invalid if there is none; raises FoldError."""
    chosen = emit(builder, "select", [excess_plus, plus, minus])
    best = emit(builder, "max", [excess_plus, excess_minus])
    return emit(builder, "guard", [chosen, best], ("nonnegative",))
