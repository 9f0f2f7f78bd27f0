"""A graph builder that simplifies as it builds.

Only identities over the reals are used that hold for every operand, and none that loses a sample's
validity: where an operand disappears that may have no value, a `guard` keeps its validity.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from cordicc.ir.graph import Builder, Param, Value, factored
from cordicc.ir.meaning.exact import FoldError, fold
from cordicc.ir.ops import OPS, Level

_ODD = ("sin", "tan", "asin", "atan", "sinh", "tanh", "asinh", "atanh")
_EVEN = ("cos", "cosh", "abs")

_MODERATE = Fraction(1, 2**64)
"""The least factor that is moved out of a product, and the reciprocal of the largest."""

_SUMMANDS = 8
"""Summands among which those that cancel are looked for."""


def power_of_two(number: Fraction) -> int | None:
    """Return n with |number| = 2**n, or None."""
    top, bottom = abs(number.numerator), number.denominator
    if top == 0 or top & (top - 1) or bottom & (bottom - 1):
        return None
    return top.bit_length() - bottom.bit_length()


class Algebra(Builder):
    """Builds operations in a simplified form."""

    def __init__(self) -> None:
        super().__init__()
        self._may_fail: dict[int, bool] = {}

    def apply(self, op: str, operands: Sequence[Value], params: Sequence[Param] = ()) -> tuple[Value, ...]:
        """Return the results of an operation, simplified where an identity applies."""
        if op in _CONSTRUCTORS:
            return (_CONSTRUCTORS[op](self, *operands, *params),)
        folded = self._fold(op, operands, params)
        if folded is not None:
            return (folded,)
        if op == "vector" and (known := self._constant_vector(operands, params)) is not None:
            return known
        first = self.emit(op, operands, params)
        return tuple(Value(first.node, i) for i in range(len(OPS[op].results)))

    def may_fail(self, value: Value) -> bool:
        """Tell whether some input leaves the value undefined."""
        todo = [value.node]
        while todo:
            index = todo[-1]
            node = self.nodes[index]
            pending = [v.node for v in node.operands if v.node not in self._may_fail]
            if pending:
                todo += pending
                continue
            self._may_fail[index] = node.definition.partial or any(
                self._may_fail[v.node] for v in node.operands
            )
            todo.pop()
        return self._may_fail[value.node]

    def _fold(self, op: str, operands: Sequence[Value], params: Sequence[Param]) -> Value | None:
        numbers = [self.constant(v) for v in operands]
        known = [n for n in numbers if n is not None]
        if len(known) < len(numbers) or not numbers or OPS[op].level is Level.UNIT:
            return None
        try:
            return self.const(fold(op, tuple(params), known))
        except FoldError:
            return None

    def _constant_vector(
        self, operands: Sequence[Value], params: Sequence[Param]
    ) -> tuple[Value, ...] | None:
        """Return norm and angle of a vector that does not depend on the inputs, None for any other."""
        x, y = (self.constant(v) for v in operands[:2])
        if x is None or y is None:
            return None
        m, sign = params
        try:
            if m == 1:
                norm, angle = fold("hypot", (), (x, y)), fold("atan2", (), (y, x))
            else:
                quotient = fold("div", (), (y, x))
                norm = x if m == 0 else fold("sqrt", (), (x * x - y * y,))
                angle = quotient if m == 0 else fold("atanh", (), (quotient,))
        except FoldError:
            return None
        turned = self.const(angle)
        return self.const(norm), (self.add if sign == 1 else self.sub)(operands[2], turned)

    def _match(self, value: Value, op: str) -> tuple[Value, ...] | None:
        node = self.nodes[value.node]
        return node.operands if node.op == op else None

    def zero_of(self, value: Value) -> Value:
        """Return 0, invalid where `value` is."""
        zero = self.const(0)
        return self.emit("guard", (zero, value), ("any",)) if self.may_fail(value) else zero

    def add(self, a: Value, b: Value) -> Value:
        """Return a + b."""
        folded = self._fold("add", (a, b), ())
        if folded is not None:
            return folded
        if self.constant(a) is not None:
            a, b = b, a
        number = self.constant(b)
        if number is not None:
            return self._add_constant(a, number)
        if a == b:
            return self.scale(Fraction(2), a)
        minus_a, minus_b = self._match(a, "neg"), self._match(b, "neg")
        if minus_a and minus_b:
            return self.neg(self.add(minus_a[0], minus_b[0]))
        if minus_b:
            return self.sub(a, minus_b[0])
        if minus_a:
            return self.sub(b, minus_a[0])
        shorter = self._cancelled(a, b, 1)
        return self.emit("add", (a, b)) if shorter is None else shorter

    def _add_constant(self, a: Value, number: Fraction) -> Value:
        if number == 0:
            return a
        inner = self._match(a, "add")
        if inner:
            for one, other in (inner, inner[::-1]):
                constant = self.constant(one)
                if constant is not None:
                    return self._add_constant(other, constant + number)
        inner = self._match(a, "sub")
        if inner:
            constant = self.constant(inner[0])
            if constant is not None:
                return self.sub(self.const(constant + number), inner[1])
        minus = self._match(a, "neg")
        if minus:
            return self.sub(self.const(number), minus[0])
        return self.emit("add", (a, self.const(number)))

    def sub(self, a: Value, b: Value) -> Value:
        """Return a - b."""
        folded = self._fold("sub", (a, b), ())
        if folded is not None:
            return folded
        number = self.constant(b)
        if number is not None:
            return self.add(a, self.const(-number))
        if a == b:
            return self.zero_of(a)
        minus_b = self._match(b, "neg")
        if minus_b:
            return self.add(a, minus_b[0])
        if self.constant(a) == 0:
            return self.neg(b)
        minus_a = self._match(a, "neg")
        if minus_a:
            return self.neg(self.add(minus_a[0], b))
        shorter = self._cancelled(a, b, -1)
        return self.emit("sub", (a, b)) if shorter is None else shorter

    def _cancelled(self, a: Value, b: Value, sign: int) -> Value | None:
        """Return a + sign b where summands cancel and no more than two are left, else None."""
        if not {self.nodes[a.node].op, self.nodes[b.node].op} & {"add", "sub"}:
            return None
        terms: dict[Value, int] = {}
        todo = [(a, 1), (b, sign)]
        leaves = 0
        while todo:
            value, factor = todo.pop()
            node = self.nodes[value.node]
            if node.op in ("add", "sub", "neg") and leaves + len(todo) < _SUMMANDS:
                todo.append((node.operands[0], -factor if node.op == "neg" else factor))
                todo += [(v, -factor if node.op == "sub" else factor) for v in node.operands[1:]]
            else:
                terms[value] = terms.get(value, 0) + factor
                leaves += 1
        left = sorted((v, k) for v, k in terms.items() if k)
        if len(left) == len(terms) or len(left) > 2 or any(abs(k) != 1 for _, k in left):
            return None
        left.sort(key=lambda term: -term[1])
        total = self.const(0)
        for value, factor in left:
            total = self.add(total, value) if factor > 0 else self.sub(total, value)
        for value in sorted(terms):
            if not terms[value] and self.may_fail(value):
                total = self.guard(total, value, "any")
        return total

    def neg(self, a: Value) -> Value:
        """Return -a."""
        difference = self._match(a, "sub")
        if difference:
            return self.sub(difference[1], difference[0])
        return self.scale(Fraction(-1), a)

    def mul(self, a: Value, b: Value) -> Value:
        """Return a b, constant factors outermost."""
        folded = self._fold("mul", (a, b), ())
        if folded is not None:
            return folded
        for one, other in ((a, b), (b, a)):
            number = self.constant(one)
            if number is not None:
                return self.scale(number, other)
        (factor_a, base_a), (factor_b, base_b) = factored(self.nodes, a), factored(self.nodes, b)
        factor = factor_a * factor_b
        if not _MODERATE <= abs(factor) <= 1 / _MODERATE:
            # Moved out of powers, factors grow until the base underflows: (2x)^1000 is in a format where
            # x^1000 is 0.
            return self.emit("mul", (a, b))
        return self.scale(factor, self.emit("mul", (base_a, base_b)))

    def scale(self, factor: Fraction, a: Value) -> Value:
        """Return factor * a in its cheapest form: nothing, a sign, a shift, a constant product."""
        number = self.constant(a)
        if number is not None:
            return self.const(factor * number)
        if factor == 0:
            return self.zero_of(a)
        inner, base = factored(self.nodes, a)
        factor *= inner
        exponent = power_of_two(factor)
        if exponent is None:
            return self.emit("cmul", (base,), (factor,))
        if exponent:
            base = self.emit("shift", (base,), (Fraction(exponent),))
        return base if factor > 0 else self.emit("neg", (base,))

    def div(self, a: Value, b: Value) -> Value:
        """Return a / b; a division by a constant is a product."""
        folded = self._fold("div", (a, b), ())
        if folded is not None:
            return folded
        number = self.constant(b)
        if number:
            return self.scale(1 / number, a)
        factor_a, base_a = factored(self.nodes, a)
        factor_b, base_b = factored(self.nodes, b)
        return self.scale(factor_a / factor_b, self.emit("div", (base_a, base_b)))

    def power(self, a: Value, exponent: Fraction) -> Value:
        """Return a**exponent as products, a root and a reciprocal."""
        folded = self._fold("pow", (a,), (exponent,))
        if folded is not None:
            return folded
        if exponent < 0:
            return self.div(self.const(1), self.power(a, -exponent))
        if exponent.denominator == 2:
            root = self.apply("sqrt", (a,))[0]
            return (
                root if exponent.numerator == 1 else self.mul(self.power(a, exponent - Fraction(1, 2)), root)
            )
        if exponent == 1:
            return a
        half = self.power(a, Fraction(exponent.numerator // 2))
        square = self.mul(half, half)
        return self.mul(square, a) if exponent.numerator % 2 else square

    def sqrt(self, a: Value) -> Value:
        """Return the square root; that of a square is the absolute value."""
        folded = self._fold("sqrt", (a,), ())
        if folded is not None:
            return folded
        factors = self._match(a, "mul")
        if factors and factors[0] == factors[1]:
            return self.apply("abs", (factors[0],))[0]
        return self.emit("sqrt", (a,))

    def guard(self, a: Value, s: Value, condition: str) -> Value:
        """Return a, invalid where the condition on s fails."""
        number = self.constant(s)
        holds = (
            number is not None
            and {
                "any": True,
                "nonzero": number != 0,
                "nonnegative": number >= 0,
                "positive": number > 0,
            }[condition]
        )
        if holds or (condition == "any" and not self.may_fail(s)):
            return a
        return self.emit("guard", (a, s), (condition,))

    def flip(self, a: Value, s: Value) -> Value:
        """Return a, negated where s < 0."""
        number = self.constant(s)
        if number is not None:
            return a if number >= 0 else self.neg(a)
        return self.emit("flip", (a, s))

    def unary(self, op: str, a: Value) -> Value:
        """Return a function of one operand with its sign symmetry used."""
        folded = self._fold(op, (a,), ())
        if folded is not None:
            return folded
        minus = self._match(a, "neg")
        if minus and op in _EVEN:
            return self.unary(op, minus[0])
        if minus and op in _ODD:
            return self.neg(self.unary(op, minus[0]))
        return self.emit(op, (a,))


class ValueAlgebra(Algebra):
    """Builds values alone: where they exist is kept elsewhere, and no guard is built."""

    def zero_of(self, value: Value) -> Value:
        """Return 0."""
        return self.const(0)

    def guard(self, a: Value, s: Value, condition: str) -> Value:
        """Return a."""
        return a


def _constructor(op: str) -> Callable[..., Value]:
    return lambda builder, a: builder.unary(op, a)


_CONSTRUCTORS: dict[str, Callable[..., Value]] = {
    "add": Algebra.add,
    "sub": Algebra.sub,
    "mul": Algebra.mul,
    "neg": Algebra.neg,
    "div": Algebra.div,
    "sqrt": Algebra.sqrt,
    "flip": Algebra.flip,
    "guard": Algebra.guard,
    "pow": Algebra.power,
    "cmul": lambda builder, a, factor: builder.scale(factor, a),
    "shift": lambda builder, a, exponent: builder.scale(Fraction(2) ** int(exponent), a),
    **{op: _constructor(op) for op in (*_ODD, *_EVEN)},
}
