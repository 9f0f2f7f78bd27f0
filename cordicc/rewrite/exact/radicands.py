"""What values are made of: sums of squares, long parts, square roots."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Protocol

from cordicc.ir.graph import Node, Param, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Field, Poly, TooLarge, rational
from cordicc.rewrite.exact.roots import square_root_of

_LONG = 8
"""Terms of the longest elements that are not worth a generator of their own."""

_LINEAR = ("add", "sub", "neg", "cmul", "shift")


class Enclosed(Protocol):
    """What values are made by, and their ranges."""

    def node(self, value: Value) -> Node:
        """Return the node that makes a value."""
        ...

    def range(self, value: Value) -> Interval | None:
        """Return the enclosure of a value."""
        ...


class Known(Enclosed, Protocol):
    """What is known about values."""

    field: Field

    def element(self, value: Value) -> Element | None:
        """Return a value as an element."""
        ...

    def poly_sign(self, poly: Poly) -> int:
        """Return the sign of a polynomial."""
        ...


def is_square_sum(known: Enclosed, value: Value, depth: int) -> bool:
    """Tell whether a value is a sum of squares and of values that are never negative."""
    node, interval = known.node(value), known.range(value)
    if depth == 0 or (interval is not None and interval.lo >= 0):
        return depth > 0
    if node.op == "mul" and node.operands[0] == node.operands[1]:
        return True
    if node.op == "cmul" and Fraction(node.params[0]) < 0:
        return False
    if node.op in ("add", "mul", "cmul", "shift"):
        return all(is_square_sum(known, v, depth - 1) for v in node.operands)
    return node.op == "abs"


def long_parts(known: Known, index: int) -> set[Value]:
    """Return long factors of products that a node adds up, or its long operands."""

    def is_long(value: Value) -> bool:
        element = known.element(value)
        return element is not None and len(element.num) + len(element.den) > _LONG

    node = known.node(Value(index))
    found: set[Value] = set()
    todo = [Value(index)] if node.op in (*_LINEAR, "mul") else list(node.operands)
    while todo:
        inner = known.node(todo.pop())
        if inner.op in _LINEAR:
            todo += inner.operands
        elif inner.op == "mul":
            todo += [v for v in inner.operands if known.node(v).op == "mul"]
            found |= {v for v in inner.operands if known.node(v).op != "mul" and is_long(v)}
    return found or {v for v in node.operands if is_long(v)}


def under_root(field: Field, op: str, params: Sequence[Param], operands: Sequence[Element]) -> Element:
    """Return the square of the root that a unit takes: of vectorings the norm, of equations the rest."""
    if op == "lightcone":
        return field.mul(*operands[:2])
    m = Fraction(params[0])
    squares = [field.mul(e, e) for e in operands[: 3 if op == "implicit" else 2]]
    if op == "implicit":
        return field.add(squares[0], field.scale(m, field.sub(squares[1], squares[2])))
    return field.add(squares[0], field.scale(m, squares[1]))


def square_root(known: Known, radicand: Element) -> Element:
    """Return the non-negative root: squares of known sign leave it, the rest becomes a generator."""
    field = known.field
    if radicand.is_zero:
        return radicand
    whole = field.times(radicand.num, radicand.den)
    outside = Element(field.one, radicand.den, radicand.powers)
    if not radicand.is_polynomial and known.poly_sign(radicand.den) == 0:
        raise TooLarge
    if known.poly_sign(radicand.den) < 0:
        outside = field.scale(Fraction(-1), outside)
    constant, factors = field.squarefree_factors(whole) if len(whole) <= LOOKUP_TERMS else (1, [(whole, 1)])
    inside = field.one * constant
    pulled = field.one
    for base, exponent in factors:
        sign = known.poly_sign(base)
        half = exponent // 2 if sign else 0
        pulled = field.times(pulled, (base * sign) ** half) if half else pulled
        inside = inside * base ** (exponent - 2 * half)
    number = rational(inside.leading_coefficient()) if inside.is_constant() else None
    root = None if number is None else square_root_of(number)
    result = field.number(root) if root is not None else field.root(field.reduce(inside))
    return field.mul(field.mul(result, Element(pulled, field.one)), outside)
