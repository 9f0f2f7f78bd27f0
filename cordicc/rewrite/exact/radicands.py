"""Square roots: what units take the root of, and the roots as elements of the field."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from cordicc.ir.graph import Node
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Field, TooLarge, rational, square_root_of
from cordicc.rewrite.exact.known_values import KnownValues


def under_root(field: Field, node: Node, operands: Sequence[Element]) -> Element:
    """Return the square of the root that a unit takes: of vectorings the norm, of equations the rest."""
    if node.op == "lightcone":
        return field.mul(*operands[:2])
    m = Fraction(node.m)
    squares = [field.mul(e, e) for e in operands[: 3 if node.op == "implicit" else 2]]
    if node.op == "implicit":
        return field.add(squares[0], field.scale(m, field.sub(squares[1], squares[2])))
    return field.add(squares[0], field.scale(m, squares[1]))


def square_root(known: KnownValues, radicand: Element) -> Element:
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
