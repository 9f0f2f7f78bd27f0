"""Polynomials in the cosine and sine of an unknown, with graph values as coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Call, Expr, Name, Neg, Power, Product, Sum, children, postorder
from cordicc.frontend.lower import checked_exponent, emit, lower
from cordicc.frontend.scope import Scope, Text
from cordicc.frontend.solving.zero import ZeroTest
from cordicc.ir.graph import Builder, Value

Poly = Mapping[tuple[int, int], Value]
"""Coefficients by powers of (cos, sin) or (cosh, sinh); an absent one is 0."""

MAX_MULTIPLE = 8
_MAX_DEGREE = 16
_MAX_SHOWN = 100
_SYSTEMS = {"cos": 1, "sin": 1, "cosh": -1, "sinh": -1}


@dataclass(slots=True)
class Coefficients:
    """Arithmetic on coefficients that spares operations with 0 and 1.

    `dropped` collects the values that cancelled, for what they say about the domain.
    """

    builder: Builder
    dropped: list[Value] = field(default_factory=list)

    def plus(self, a: Value, b: Value, sign: int = 1) -> Value:
        """Return a + sign * b."""
        if self.builder.constant(b) == 0:
            return a
        if self.builder.constant(a) == 0:
            return b if sign > 0 else self.negative(b)
        if self._negated(b) is not None:
            b, sign = self._negated(b) or b, -sign
        if sign < 0 and a == b:
            self.dropped.append(a)
            return self.builder.const(0)
        inner = self._negated(a)
        if sign > 0 and inner is not None:
            return self.plus(b, inner, -1)
        return emit(self.builder, "add" if sign > 0 else "sub", [a, b])

    def _negated(self, value: Value) -> Value | None:
        node = self.builder.nodes[value.node]
        return node.operands[0] if node.op == "neg" else None

    def negative(self, a: Value) -> Value:
        """Return -a."""
        node = self.builder.nodes[a.node]
        if node.op == "sub":
            return emit(self.builder, "sub", node.operands[::-1])
        return self._negated(a) or emit(self.builder, "neg", [a])

    def product(self, a: Value, b: Value) -> Value:
        """Return a * b."""
        for one, other in ((a, b), (b, a)):
            number = self.builder.constant(one)
            if number == 0:
                self.dropped.append(other)
                return one
            if number == 1:
                return other
            if number == -1:
                return self.negative(other)
        return emit(self.builder, "mul", [a, b])

    def vanishes(self, value: Value, zeros: ZeroTest) -> bool:
        """Return whether a coefficient is proven zero, and remember it if it is."""
        if not zeros.is_zero(value):
            return False
        self.dropped.append(value)
        return True

    def add(self, p: Poly, q: Poly, sign: int = 1) -> Poly:
        """Return p + sign * q."""
        result = dict(p)
        zero = self.builder.const(0)
        for powers, value in q.items():
            result[powers] = self.plus(result.get(powers, zero), value, sign)
        return {k: v for k, v in result.items() if v != zero}

    def scale(self, p: Poly, factor: Value) -> Poly:
        """Return p times a coefficient."""
        zero = self.builder.const(0)
        scaled = {k: self.product(v, factor) for k, v in p.items()}
        return {k: v for k, v in scaled.items() if v != zero}

    def multiply(self, p: Poly, q: Poly, system: int) -> Poly:
        """Return p * q with sin**2 = 1 - cos**2, or sinh**2 = cosh**2 - 1."""
        result: Poly = {}
        for (i, j), a in p.items():
            for (k, n), b in q.items():
                value = self.product(a, b)
                if j + n < 2:
                    result = self.add(result, {(i + k, j + n): value})
                else:
                    result = self.add(result, {(i + k, 0): value}, system)
                    result = self.add(result, {(i + k + 2, 0): value}, -system)
        return result


def another_unknown(multiple: Fraction | int, unknown: str) -> str:
    """Return the hint to solve for a multiple of the unknown."""
    return f"solve for another unknown such as {'v' if unknown == 'w' else 'w'} = {multiple}*{unknown}"


class Expander:
    """Expands expressions in one unknown; parts free of it are lowered as they are written."""

    def __init__(self, scope: Scope, text: Text, unknown: str, maths: Coefficients) -> None:
        self.scope = scope
        self.text = text
        self.unknown = unknown
        self.maths = maths
        self.system: int | None = None
        self.multiples: set[int] = set()
        self._bound: set[int] = set()

    def expand(self, expr: Expr) -> Poly | None:
        """Return the polynomial of an expression; None, with diagnostics, if a name in it has no value.

        Raises ExpressionError where the expression is not a polynomial in the cosine and sine.
        """
        self._mark(expr)
        polys: dict[int, Poly | None] = {}
        for part in self._outer(expr):
            polys[id(part)] = self._one(part, polys)
        return polys[id(expr)]

    def _mark(self, expr: Expr) -> None:
        for part in postorder(expr):
            own = isinstance(part, Name) and part.name == self.unknown
            if own or any(id(child) in self._bound for child in children(part)):
                self._bound.add(id(part))

    def _outer(self, expr: Expr) -> list[Expr]:
        """Return the parts in order of evaluation, without what is inside functions or free parts."""
        found, todo = [], [expr]
        while todo:
            part = todo.pop()
            found.append(part)
            if id(part) in self._bound and not isinstance(part, Call):
                todo.extend(children(part))
        return found[::-1]

    def _lower(self, expr: Expr) -> Value | None:
        return lower(expr, self.scope, self.text, self.unknown)

    def _one(self, expr: Expr, polys: Mapping[int, Poly | None]) -> Poly | None:
        if id(expr) not in self._bound:
            value = self._lower(expr)
            if value is None:
                return None
            return {(0, 0): value} if self.maths.builder.constant(value) != 0 else {}
        parts = [polys[id(child)] for child in children(expr)] if not isinstance(expr, Call) else []
        known = [p for p in parts if p is not None]
        if len(known) != len(parts):
            return None
        maths = self.maths
        match expr:
            case Call():
                return self._call(expr)
            case Neg():
                return maths.add({}, known[0], -1)
            case Sum(_, signs):
                total: Poly = {}
                for poly, sign in zip(known, signs, strict=True):
                    total = maths.add(total, poly, sign)
                return total
            case Product(factors, signs):
                result = known[0]
                for factor, poly, sign in list(zip(factors, known, signs, strict=True))[1:]:
                    result = self._times(result, poly, expr) if sign > 0 else self._over(result, poly, factor)
                return result
            case Power():
                return self._power(expr, known)
            case _:
                raise self._outside(expr)

    def _outside(self, expr: Expr, inside: str = "") -> ExpressionError:
        unknown = self.unknown
        place = f"inside {inside}" if inside else "outside sin and cos"
        message = f"'{unknown}' appears {place}: the equation is transcendental in {unknown}"
        hint = None
        if inside in ("tan", "tanh"):
            message = f"'{unknown}' appears inside {inside}, not in cos and sin alone"
            hint = f"multiply the equation by the cosine: {inside} is a quotient"
        return ExpressionError("E301", message, *expr.at, hint)

    def _times(self, p: Poly, q: Poly, expr: Expr) -> Poly:
        degree = sum(max((i + j for i, j in poly), default=0) for poly in (p, q))
        if degree > _MAX_DEGREE:
            message = f"the equation has degree {degree} in the cosine and sine of '{self.unknown}'"
            raise ExpressionError("E302", message, *expr.at)
        for poly, other in ((p, q), (q, p)):
            if set(poly) <= {(0, 0)}:
                if not poly:
                    self.maths.dropped.extend(other.values())
                return self.maths.scale(other, poly[0, 0]) if poly else {}
        return self.maths.multiply(p, q, self.system or 1)

    def _over(self, p: Poly, q: Poly, divisor: Expr) -> Poly:
        if id(divisor) in self._bound:
            message = f"a division by an expression in '{self.unknown}'"
            raise ExpressionError("E302", message, *divisor.at, "multiply the equation by the divisor")
        value = q.get((0, 0), self.maths.builder.const(0))
        if self.maths.builder.constant(value) == 0:
            raise ExpressionError("E209", "division by zero", *divisor.at)
        if self.maths.builder.constant(value) == 1:
            return p
        if not p:
            self.maths.dropped.append(emit(self.maths.builder, "div", [self.maths.builder.const(0), value]))
        return {k: emit(self.maths.builder, "div", [v, value]) for k, v in p.items()}

    def _power(self, expr: Power, parts: list[Poly]) -> Poly:
        if id(expr.exponent) in self._bound:
            raise self._outside(expr.exponent, "an exponent")
        value = parts[1].get((0, 0), self.maths.builder.const(0))
        exponent = checked_exponent(self.maths.builder.constant(value), expr)
        if exponent.denominator != 1 or exponent < 0:
            message = f"a root or reciprocal of an expression in '{self.unknown}'"
            raise ExpressionError("E302", message, *expr.at)
        result: Poly = {(0, 0): self.maths.builder.const(1)}
        if exponent == 0:
            self.maths.dropped.extend(parts[0].values())
        for _ in range(int(exponent)):
            result = self._times(result, parts[0], expr)
        return result

    def _call(self, expr: Call) -> Poly | None:
        system = _SYSTEMS.get(expr.function)
        if system is None:
            raise self._outside(expr, expr.function)
        if self.system not in (None, system):
            message = f"circular and hyperbolic functions of '{self.unknown}' in one equation"
            raise ExpressionError("E303", message, *expr.at)
        self.system = system
        argument = self._argument(expr.args[0])
        if argument is None:
            return None
        multiple, offset = argument
        if multiple.denominator != 1 or abs(multiple) > MAX_MULTIPLE:
            message = f"{expr.function} of {multiple} times '{self.unknown}'"
            hint = f"multiples must be integers of at most {MAX_MULTIPLE}"
            if 1 < multiple.denominator <= _MAX_SHOWN:
                hint += f"; {another_unknown(multiple, self.unknown)}"
            raise ExpressionError("E302", message, *expr.at, hint)
        self.multiples.add(int(multiple))
        cosine, sine = self._multiple_angle(int(multiple), system)
        return self._shifted(expr.function, cosine, sine, offset, system)

    def _multiple_angle(self, multiple: int, system: int) -> tuple[Poly, Poly]:
        """Return the cosine and the sine of an integer multiple of the unknown."""
        one = self.maths.builder.const(1)
        cosine: Poly = {(0, 0): one}
        sine: Poly = {}
        first: tuple[Poly, Poly] = ({(1, 0): one}, {(0, 1): one})
        for _ in range(abs(multiple)):
            both = self.maths.multiply(first[1], sine, system)
            cross = self.maths.multiply(first[1], cosine, system)
            sine = self.maths.add(self.maths.multiply(first[0], sine, system), cross)
            cosine = self.maths.add(self.maths.multiply(first[0], cosine, system), both, -system)
        return cosine, sine if multiple > 0 else self.maths.add({}, sine, -1)

    def _shifted(self, function: str, cosine: Poly, sine: Poly, offset: Value | None, system: int) -> Poly:
        """Return the function of an angle plus an offset, by the addition theorem."""
        maths = self.maths
        wants_cosine = function in ("cos", "cosh")
        if offset is None or maths.builder.constant(offset) == 0:
            return cosine if wants_cosine else sine
        names = ("cos", "sin") if system == 1 else ("cosh", "sinh")
        c, s = (emit(maths.builder, name, [offset]) for name in names)
        if wants_cosine:
            return maths.add(maths.scale(cosine, c), maths.scale(sine, s), -system)
        return maths.add(maths.scale(sine, c), maths.scale(cosine, s))

    def _argument(self, expr: Expr) -> tuple[Fraction, Value | None] | None:
        """Return (n, offset) of an argument n t + offset; None if a name in it has no value."""
        maths = self.maths
        zero = Fraction(0)
        found: dict[int, tuple[Fraction, Value | None]] = {}
        for part in self._outer(expr):
            if id(part) not in self._bound:
                value = self._lower(part)
                if value is None:
                    return None
                found[id(part)] = (zero, value)
                continue
            match part:
                case Name():
                    found[id(part)] = (Fraction(1), None)
                case Neg(operand):
                    n, rest = found[id(operand)]
                    found[id(part)] = (-n, None if rest is None else maths.negative(rest))
                case Sum(terms, signs):
                    n, total = zero, maths.builder.const(0)
                    for term, sign in zip(terms, signs, strict=True):
                        k, rest = found[id(term)]
                        n += sign * k
                        total = total if rest is None else maths.plus(total, rest, sign)
                    found[id(part)] = (n, total)
                case Product():
                    found[id(part)] = self._scaled_argument(part, found)
                case Call(function):
                    message = f"'{self.unknown}' is inside nested functions ({function} within another)"
                    raise ExpressionError("E306", message, *part.at)
                case _:
                    raise self._unfit_argument(part)
        return found[id(expr)]

    def _unfit_argument(self, expr: Expr) -> ExpressionError:
        message = f"the argument must be an integer multiple of '{self.unknown}' plus terms without it"
        return ExpressionError("E302", message, *expr.at)

    def _scaled_argument(
        self, expr: Product, found: Mapping[int, tuple[Fraction, Value | None]]
    ) -> tuple[Fraction, Value | None]:
        builder = self.maths.builder
        n, rest = Fraction(0), None
        seen = False
        factor = Fraction(1)
        for part, sign in zip(expr.factors, expr.signs, strict=True):
            k, value = found[id(part)]
            number = builder.constant(value) if value is not None else None
            if id(part) in self._bound:
                if seen or sign < 0:
                    raise self._unfit_argument(expr)
                n, rest, seen = k, value, True
            elif number is None or (sign < 0 and number == 0):
                raise self._unfit_argument(part)
            else:
                factor = factor * number if sign > 0 else factor / number
        if rest is not None:
            rest = self.maths.product(builder.const(factor), rest)
        return n * factor, rest
