"""Signs: of polynomials that are known, of products of them, of square roots, and of sums of squares.

Most signs are known only where the problem has a value: that y is not negative, because its root is taken
somewhere.  They make values equal.  Whether a condition may be dropped is another question, which such a
sign must not answer, as it may rest on that very condition; `unconditional` signs hold for every input
within its range.
"""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Field, Poly, monic
from cordicc.rewrite.exact.keys import Key
from cordicc.rewrite.exact.known_values import EnclosedValues

_ROUNDED = 2.0**-50
"""What the cosine of an angle of 90 deg may be below 0, as no double is 90 deg."""

_DEPTH = 8
"""Operations through which products of cosines are followed."""


def never_negative(known: EnclosedValues, value: Value, depth: int = _DEPTH) -> bool:
    """Tell whether a value is nowhere negative; the cosine of 90 deg counts as 0."""
    interval = known.range(value)
    if interval is None or depth == 0:
        return False
    if interval.lo >= 0:
        return True
    node = known.node(value)
    match node.op:
        case "cos" | "sin":
            return interval.lo >= -_ROUNDED
        case "rotate" if node.m == 1 and all(known.node(v).op == "const" for v in node.operands[:2]):
            return interval.lo >= -_ROUNDED * interval.hi
        case "cmul" if node.factor < 0:
            return False
        case "mul" | "add" | "cmul" | "shift":
            return all(never_negative(known, v, depth - 1) for v in node.operands)
    return False


class _Table:
    """Signs of monic polynomials, and what they make the signs of products of them."""

    def __init__(self) -> None:
        self.known: dict[Key, int] = {}
        self.products: dict[Key, tuple[int, int]] = {}


class Signs:
    """Known signs of monic polynomials: 1 for never negative, -1 for never positive."""

    def __init__(self, field: Field) -> None:
        self._field = field
        self._valid, self._always = _Table(), _Table()
        self._facts: dict[Key, str] = {}

    def know(self, element: Element, sign: int, unconditional: int) -> None:
        """Note the sign of the numerator of an element that has one, if its denominator has one.

        Args:
            element: a value as an element.
            sign: its sign wherever the problem has a value, 0 if none is proven.
            unconditional: its sign for every input within its range, 0 if none is proven.
        """
        factor, base = monic(element.num)
        for table, own in ((self._valid, sign), (self._always, unconditional)):
            total = own * self._of(element.den, table) if own else 0
            if total and factor:
                table.known.setdefault(Key(base), total if factor > 0 else -total)

    def assume(self, element: Element, sign: int, fact: str) -> None:
        """Note a sign that rests on a fact."""
        factor, base = monic(element.num)
        if factor:
            self._facts[Key(base)] = fact
            for table in (self._valid, self._always):
                table.known[Key(base)] = sign * self._of(element.den, table) * (1 if factor > 0 else -1)

    def of(self, poly: Poly) -> int:
        """Return the sign of a polynomial, 0 if none is proven; facts that it rests on are touched."""
        return self._of(poly, self._valid)

    def unconditional(self, poly: Poly) -> int:
        """Return the sign of a polynomial for every input within its range, 0 if none is proven.

        Where roots occur in it, for every input at which they are real.
        """
        return self._of(poly, self._always)

    def _of(self, poly: Poly, table: _Table) -> int:
        if len(poly) > LOOKUP_TERMS:
            return 0
        factor, base = monic(poly)
        sign = 1 if factor >= 0 else -1
        if base.is_constant():
            return sign
        return sign * (self._base(base, table) or self._product(base, table))

    def _product(self, base: Poly, table: _Table) -> int:
        """Return the sign of a polynomial from those of its factors; kept until a new sign is known."""
        key, known = Key(base), len(table.known)
        cached = table.products.get(key)
        if cached is None or cached[0] != known or self._facts:
            sign = 1
            for part, exponent in self._field.factors(base)[1]:
                if exponent % 2:
                    scale, normal = monic(part)
                    sign *= self._base(normal, table) * (1 if scale > 0 else -1)
            cached = table.products[key] = known, sign
        return cached[1]

    def _base(self, base: Poly, table: _Table) -> int:
        single = len(base) == 1 and base.total_degree() == 1
        if single and next(self._field.generators(base)) in self._field.radicands:
            return 1
        key = Key(base)
        if key in self._facts:
            self._field.touched.add(self._facts[key])
        return self._field.definite.get(key, 0) or table.known.get(key, 0)


def is_square_sum(known: EnclosedValues, value: Value, depth: int) -> bool:
    """Tell whether a value is a sum of squares and of values that are never negative."""
    node, interval = known.node(value), known.range(value)
    if depth == 0 or (interval is not None and interval.lo >= 0):
        return depth > 0
    if node.op == "mul" and node.operands[0] == node.operands[1]:
        return True
    if node.op == "cmul" and node.factor < 0:
        return False
    if node.op in ("add", "mul", "cmul", "shift"):
        return all(is_square_sum(known, v, depth - 1) for v in node.operands)
    return node.op == "abs"


def stays_nonnegative(known: EnclosedValues, value: Value, depth: int) -> bool:
    """Tell whether a value is not negative however what it is made of is rounded."""
    node = known.node(value)
    match node.op:
        case "sqrt" | "hypot" | "abs":
            return True
        case "mul" if node.operands[0] == node.operands[1]:
            return True
        case "const":
            return node.number >= 0
        case "input":
            return never_negative(known, value)
        case "cmul" if node.factor < 0:
            return False
        case "add" | "mul" | "cmul" | "shift":
            return depth > 0 and all(stays_nonnegative(known, v, depth - 1) for v in node.operands)
    return False
