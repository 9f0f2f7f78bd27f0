"""Roots of squares, and angles through them: sqrt(q^2) is |q|, and acos(C/B) the angle of (C, |q|).

The second result w of an implicit unit has w^2 = B^2 + A^2 - C^2.  Where that is a square, as for the cosine
of the angle between two vectors, whose sine is their cross product by their lengths, acos(C/B) is the angle
of (C, |q|), of which common factors that are never negative are left out.
"""

from __future__ import annotations

from contextlib import suppress

from cordicc.ir.graph import Node, Value
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Poly, TooLarge, rational, square_root_of
from cordicc.rewrite.exact.radicands import square_root, under_root
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Rule
from cordicc.rewrite.rules.synthesis import Synthesis


def _add_perfect_squares(given: Given) -> None:
    """Add the absolute value for each root of a square, and the angles of equations with such a rest."""
    store = given.store
    synthesis = Synthesis(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        square = _radicand(store, node)
        with suppress(TooLarge, ZeroDivisionError):
            q = None if square is None else _square_root(store, square)
            if q is None or q.constant is not None:
                continue
            store.begin(node.origin)
            PERFECT_SQUARES.tell(store)
            poly = store.field.display(q)
            if poly is not None:
                size = absolute(store, synthesis.polynomial(poly))
                store.union(Value(index, 1 if node.op == "implicit" else 0), size)
            if node.op == "implicit":
                _add_angle(store, synthesis, index, node, q)


def _radicand(store: Store, node: Node) -> Element | None:
    """Return the square of the root that an operation takes."""
    if node.op not in ("implicit", "lightcone") and (node.op != "vector" or node.m == 0):
        return None
    operands = [store.element(v) for v in node.operands]
    known = [e for e in operands if e is not None]
    if len(known) < len(operands) or any(len(e.num) > LOOKUP_TERMS for e in known):
        return None
    with suppress(TooLarge):
        return under_root(store.field, node, known)
    return None


def _square_root(store: Store, square: Element) -> Element | None:
    """Return an element with a given square, whatever its sign; the denominator may have any root."""
    if square.is_zero:
        return None
    num = _halved(store, square.num)
    if num is None or store.poly_sign(square.den) <= 0:
        return None
    below = square_root(store, Element(square.den, store.field.one))
    return store.field.div(Element(num, store.field.one), below)


def _halved(store: Store, poly: Poly) -> Poly | None:
    """Return a polynomial of which one is the square."""
    if len(poly) > LOOKUP_TERMS:
        return None
    constant, factors = store.field.factors(poly)
    number = square_root_of(rational(constant)) if constant > 0 else None
    if number is None or any(exponent % 2 for _, exponent in factors):
        return None
    root = store.field.number(number).num
    for base, exponent in factors:
        root = root * base ** (exponent // 2)
    return root


def absolute(store: Store, value: Value) -> Value:
    """Return the root of the square of a value."""
    return store.make("abs", (value,))[0]


def _add_angle(store: Store, synthesis: Synthesis, index: int, node: Node, q: Element) -> None:
    """Add the angle of an equation with one coefficient as that of a vector with the components C and |q|."""
    A, B, C = node.operands
    field, element = store.field, store.element(C)
    cosine = store.constant(A) == 0 and node.branch == "+" and store.sign(B) > 0
    sine = store.constant(B) == 0 and node.branch == "-" and store.sign(A) > 0
    if node.m != 1 or element is None or not (cosine or sine):
        return
    ratio = field.div(element, q)
    scale = field.div(q, Element(ratio.den, field.one))
    sign = store.poly_sign(scale.num) * store.poly_sign(scale.den)
    components = [field.display(Element(p, field.one)) for p in (ratio.num, ratio.den)]
    if sign == 0 or any(poly is None for poly in components):
        return
    PERFECT_SQUARES.tell(store, "angle")
    along, across = (synthesis.polynomial(poly) for poly in components)
    along = along if sign > 0 else store.make("neg", (along,))[0]
    pair = (along, absolute(store, across))
    made = store.make("vector", (*(pair if cosine else reversed(pair)), store.const(0)), (1, 1))
    store.union(made[1], Value(index, 0))
    store.rotors.rotor(made[1])


PERFECT_SQUARES = Rule(
    name="roots of squares",
    mathematics="sqrt(q^2) = |q|, and acos(C/B) = atan2(|q|, C) where B^2 - C^2 = q^2",
    apply=_add_perfect_squares,
    words="the root of a square is an absolute value",
    cases={
        "angle": "acos(C/B) is the angle of (C, w), asin(C/A) that of (w, C), w^2 = B^2 - C^2 a square",
    },
)
