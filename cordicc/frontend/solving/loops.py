"""Two coupled equations of a planar loop: both unknowns by squaring and adding.

The equations are M u(f) + N u(g) = e, with u(t) = (cos t, sin t), two angles f and g that are sums of
the unknowns, and M, N multiples of rotations or reflections.  |N u(g)|**2 = |e - M u(f)|**2 is linear
in u(f): (M'e) u(f) = (|M|**2 + |e|**2 - |N|**2)/2, and the same for g with the other branch of the two.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Call, Expr, Neg
from cordicc.frontend.lower import emit
from cordicc.frontend.scope import Scope, Text
from cordicc.frontend.solving.branches import (
    condition_at,
    excess,
    proven_sign,
    selected,
    sign_at_every_angle,
    sine_of_angle,
)
from cordicc.frontend.solving.polynomial import Coefficients
from cordicc.frontend.solving.solve import SolveRequest, branch_is_valid, with_domain
from cordicc.frontend.solving.trigsum import Multiples, TrigSum, TrigSums
from cordicc.frontend.solving.zero import ZeroTest
from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import FoldError

Matrix = tuple[tuple[Value, Value], tuple[Value, Value]]


@dataclass(frozen=True, slots=True)
class _Angle:
    """An angle of the loop: the multiples of the unknowns in it, its offset, and its matrix.

    `handed` is 1 for a multiple of a rotation, -1 for one of a reflection.
    """

    multiples: Multiples
    offset: Value
    matrix: Matrix
    handed: int


def solve_loop(request: SolveRequest, scope: Scope, zeros: ZeroTest) -> tuple[Value, Value] | None:
    """Return the values of both unknowns; None after diagnostics."""
    maths = Coefficients(scope.builder)
    sums: list[TrigSum] = []
    for relation, text in request.equations:
        reader = TrigSums(scope, text, request.unknowns, maths)
        try:
            left, right = reader.expand(relation.left), reader.expand(relation.right)
            if left is not None and right is not None:
                sums.append(reader.add(left, right, -1))
        except ExpressionError as error:
            text.report(scope.report, error)
        except FoldError as error:
            scope.report.error("E209", str(error), text.span(relation.at))
    if len(sums) < len(request.equations) or not branch_is_valid(request, scope, required=True):
        return None
    try:
        angles = _angles(sums, request, maths, zeros)
        right_side = tuple(maths.negative(s.get(None, scope.builder.const(0))) for s in sums)
        assert len(right_side) == 2
        return _Loop(maths, zeros, angles, right_side).solve(request, scope)
    except ExpressionError as error:
        scope.report.error(error.code, error.message, request.span, error.hint)
    except FoldError as error:
        scope.report.error("E209", str(error), request.span)
    return None


def _angles(
    sums: list[TrigSum], request: SolveRequest, maths: Coefficients, zeros: ZeroTest
) -> tuple[_Angle, _Angle]:
    """Return the two angles of the loop, that of the first unknown first."""
    kinds = {term.multiples for s in sums for term, value in s.items() if term and not zeros.is_zero(value)}
    ordered = sorted(kinds, key=lambda n: (n != (1, 0), n[0] == 0, n))
    unknowns = " and ".join(f"'{name}'" for name in request.unknowns)
    if len(ordered) != 2 or abs(_determinant(ordered[0], ordered[1])) != 1:
        shown = ", ".join(_shown(n, request.unknowns) for n in ordered) or "none"
        message = f"the equations must have two angles that determine {unknowns}, but have {shown}"
        hint = "as in [a*cos(u) + b*cos(u + v) = x, a*sin(u) + b*sin(u + v) = y]"
        raise ExpressionError("E311", message, 0, 0, hint)
    one, two = (_angle(sums, n, request, maths, zeros) for n in ordered)
    return one, two


def _determinant(one: Multiples, two: Multiples) -> int:
    return one[0] * two[1] - one[1] * two[0]


def _shown(multiples: Multiples, unknowns: tuple[str, ...]) -> str:
    text = ""
    for n, name in zip(multiples, unknowns, strict=True):
        if n:
            factor = "" if abs(n) == 1 else f"{abs(n)}*"
            text += (" - " if n < 0 else " + ") + factor + name
    return text.removeprefix(" + ").removeprefix(" ")


def _angle(
    sums: list[TrigSum], multiples: Multiples, request: SolveRequest, maths: Coefficients, zeros: ZeroTest
) -> _Angle:
    """Return one of the angles, with a common offset as part of it."""
    builder = maths.builder
    zero = builder.const(0)
    terms = [[(t, v) for t, v in s.items() if t and t.multiples == multiples] for s in sums]
    offsets = {t.offset for row in terms for t, _ in row}
    common = offsets.pop() if len(offsets) == 1 else zero
    rows: list[tuple[Value, Value]] = []
    for row in terms:
        cosine = sine = zero
        for term, value in row:
            along, across = (value, zero)
            if term.offset != common:
                along, across = (
                    maths.product(value, emit(builder, f, [term.offset])) for f in ("cos", "sin")
                )
            if term.function == "cos":
                cosine, sine = maths.plus(cosine, along), maths.plus(sine, across, -1)
            else:
                cosine, sine = maths.plus(cosine, across), maths.plus(sine, along)
        rows.append((cosine, sine))
    (p, q), (r, s) = rows
    for handed in (1, -1):
        if zeros.is_zero(maths.plus(p, s, -handed)) and zeros.is_zero(maths.plus(q, r, handed)):
            return _Angle(multiples, common, ((p, q), (r, s)), handed)
    shown = _shown(multiples, request.unknowns)
    message = f"squaring and adding does not eliminate {shown}: its coefficients are not those of a rotation"
    hint = "the equations of a loop have the form a*cos(u) + ... = x and a*sin(u) + ... = y"
    raise ExpressionError("E311", message, 0, 0, hint)


@dataclass(frozen=True, slots=True)
class _Loop:
    maths: Coefficients
    zeros: ZeroTest
    angles: tuple[_Angle, _Angle]
    e: tuple[Value, ...]

    def solve(self, request: SolveRequest, scope: Scope) -> tuple[Value, Value] | None:
        """Return both unknowns on the branch that is asked for; None after diagnostics."""
        if request.condition is None:
            return self.unknowns(1 if request.branch == "+" else -1)
        relation, text = request.condition
        written = excess(relation)
        expr = sine_of_angle(written, request.together)
        sign = self._static(expr, request.together)
        if sign:
            return self.unknowns(sign)
        return self._at_run_time(sign_at_every_angle(written, expr), text, request, scope)

    def unknowns(self, branch: int) -> tuple[Value, Value]:
        """Return both unknowns, from the two angles less their offsets."""
        one, two = self.angles
        second = -branch * one.handed * two.handed
        found = [self._circle(one, two, branch), self._circle(two, one, second)]
        pure = [
            self.maths.plus(value, angle.offset, -1) for value, angle in zip(found, self.angles, strict=True)
        ]
        determinant = _determinant(one.multiples, two.multiples)
        (a, b), (c, d) = one.multiples, two.multiples
        return (
            self._combined(pure, (d * determinant, -b * determinant)),
            self._combined(pure, (-c * determinant, a * determinant)),
        )

    def _combined(self, values: list[Value], factors: tuple[int, int]) -> Value:
        builder = self.maths.builder
        terms = sorted(zip(factors, values, strict=True), key=lambda t: t[0] < 0)
        total = builder.const(0)
        for factor, value in terms:
            scaled = self.maths.product(builder.const(abs(factor)), value)
            total = self.maths.plus(total, scaled, 1 if factor > 0 else -1)
        return total

    def _circle(self, own: _Angle, other: _Angle, branch: int) -> Value:
        """Return an angle by its own equation, which has no other unknown."""
        maths, builder = self.maths, self.maths.builder
        (p, q), (r, s) = own.matrix
        x, y = self.e
        total = maths.plus(self._square(own), self._sum_of_squares(x, y))
        total = maths.plus(total, self._square(other), -1)
        size = builder.constant(p)
        if size is not None and size > 0 and builder.constant(q) == 0:
            # a constant link: its length divides out
            B, A = x, y if own.handed > 0 else maths.negative(y)
            C = emit(builder, "div", [total, builder.const(2 * size)])
        else:
            B = maths.plus(maths.product(p, x), maths.product(r, y))
            A = maths.plus(maths.product(q, x), maths.product(s, y))
            C = maths.product(builder.const(Fraction(1, 2)), total)
        C = with_domain(maths, C, [A, B, C])
        return emit(builder, "solve", [A, B, C], (1, "+" if branch > 0 else "-"))

    def _square(self, angle: _Angle) -> Value:
        """Return the square of the length of a link."""
        (p, q), _ = angle.matrix
        return self._sum_of_squares(p, q)

    def _sum_of_squares(self, a: Value, b: Value) -> Value:
        squares = [emit(self.maths.builder, "pow", [v], (Fraction(2),)) for v in (a, b)]
        return self.maths.plus(squares[0], squares[1])

    def _static(self, expr: Expr, unknowns: tuple[str, ...]) -> int:
        """Return the branch that a condition on the angle between the links picks, 0 if it is not proven.

        With the first link at +d of the closing vector, the second is at -d': the sine of the angle from
        the first to the second has the sign opposite to the branch.
        """
        wanted = 1
        while isinstance(expr, Neg):
            expr, wanted = expr.operand, -wanted
        if not isinstance(expr, Call) or expr.function != "sin":
            return 0
        one, two = self.angles
        builder = self.maths.builder
        if one.handed != two.handed or any(builder.constant(a.offset) != 0 for a in self.angles):
            return 0
        name = getattr(expr.args[0], "name", None)
        if name not in unknowns:
            return 0
        between = (two.multiples[0] - one.multiples[0], two.multiples[1] - one.multiples[1])
        own = (int(name == unknowns[0]), int(name == unknowns[1]))
        if between not in (own, (-own[0], -own[1])):
            return 0
        direction = 1 if between == own else -1
        diagonal = [builder.constant(a.matrix[0][1]) == 0 for a in self.angles]
        other = [builder.constant(a.matrix[0][0]) == 0 for a in self.angles]
        if not all(diagonal) and not all(other):
            return 0
        column = 0 if all(diagonal) else 1
        lengths = [proven_sign(a.matrix[0][column], self.zeros) for a in self.angles]
        return -wanted * direction * lengths[0] * lengths[1]

    def _at_run_time(
        self, expr: Expr, text: Text, request: SolveRequest, scope: Scope
    ) -> tuple[Value, Value] | None:
        plus, minus = self.unknowns(1), self.unknowns(-1)
        holds = []
        for pair in (plus, minus):
            solution: Mapping[str, Value] = dict(zip(request.together, pair, strict=True))
            at = condition_at(expr, text, solution, True, scope)
            if at is None:
                return None
            holds.append(at)
        one, two = (
            selected(scope.builder, p, m, holds[0], holds[1]) for p, m in zip(plus, minus, strict=True)
        )
        return one, two
