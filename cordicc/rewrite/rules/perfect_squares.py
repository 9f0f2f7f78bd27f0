"""Roots of squares, and angles through them: sqrt(q^2) is |q|, and acos(C/B) the angle of (C, |q|).

The second result w of an implicit unit has w^2 = B^2 + A^2 - C^2.  Where that is a square, as for the cosine
of the angle between two vectors, whose sine is their cross product by their lengths, acos(C/B) is the angle
of (C, |q|), of which common factors that are never negative are left out.  The product of two roots is the
root of the product.
"""

from __future__ import annotations

from contextlib import suppress

from cordicc.ir.graph import Node, Value
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Poly, TooLarge, rational
from cordicc.rewrite.exact.radicands import square_root, under_root
from cordicc.rewrite.exact.roots import square_root_of
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.synthesis import Synthesis


def add_perfect_squares(store: Store) -> None:
    """Add the absolute value for each root of a square, and the angles of equations with such a rest."""
    synthesis = Synthesis(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        square = _radicand(store, node)
        with suppress(TooLarge, ZeroDivisionError):
            q = None if square is None else _square_root(store, square)
            if q is None or q.constant is not None:
                continue
            store.begin(node.origin)
            store.reason = ("the root of a square is an absolute value",)
            poly = store.field.display(q)
            if poly is not None:
                size = _size(store, synthesis.polynomial(poly))
                store.union(Value(index, 1 if node.op == "implicit" else 0), size)
            if node.op == "implicit":
                _add_angle(store, synthesis, index, node, q)


def _radicand(store: Store, node: Node) -> Element | None:
    """Return the square of the root that an operation takes."""
    if node.op not in ("implicit", "lightcone") and (node.op != "vector" or node.params[0] == 0):
        return None
    operands = [store.element(v) for v in node.operands]
    known = [e for e in operands if e is not None]
    if len(known) < len(operands) or any(len(e.num) > LOOKUP_TERMS for e in known):
        return None
    with suppress(TooLarge):
        return under_root(store.field, node.op, node.params, known)
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


def _size(store: Store, value: Value) -> Value:
    return store.make("abs", (value,))[0]


def _add_angle(store: Store, synthesis: Synthesis, index: int, node: Node, q: Element) -> None:
    """Add the angle of an equation with one coefficient as that of a vector with the components C and |q|."""
    A, B, C = node.operands
    field, element = store.field, store.element(C)
    cosine = store.constant(A) == 0 and node.params[1] == "+" and store.sign(B) > 0
    sine = store.constant(B) == 0 and node.params[1] == "-" and store.sign(A) > 0
    if node.params[0] != 1 or element is None or not (cosine or sine):
        return
    ratio = field.div(element, q)
    scale = field.div(q, Element(ratio.den, field.one))
    sign = store.poly_sign(scale.num) * store.poly_sign(scale.den)
    components = [field.display(Element(p, field.one)) for p in (ratio.num, ratio.den)]
    if sign == 0 or any(poly is None for poly in components):
        return
    store.reason = ("acos(C/B) is the angle of (C, w), asin(C/A) that of (w, C), w^2 = B^2 - C^2 a square",)
    along, across = (synthesis.polynomial(poly) for poly in components)
    along = along if sign > 0 else store.make("neg", (along,))[0]
    pair = (along, _size(store, across))
    made = store.make("vector", (*(pair if cosine else reversed(pair)), store.const(0)), (1, 1))
    store.union(made[1], Value(index, 0))
    store.rotors.rotor(made[1])


def add_roots_of_products(store: Store) -> None:
    """Add the product of two roots as the root of the product."""
    store.reason = ("the product of two roots is the root of the product",)
    roots = _roots(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "mul" or node.operands[0] == node.operands[1]:
            continue
        first, second = (roots.get(store.find(v)) for v in node.operands)
        if first is not None and second is not None:
            store.begin(node.origin)
            made = store.make("lightcone", (_square(store, first), _square(store, second)))
            store.union(made[0], Value(index))


def _roots(store: Store) -> dict[Value, Node]:
    """Return the values that are roots of a sum or product of two, with what makes them."""
    found: dict[Value, Node] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "lightcone" or (node.op == "vector" and node.params[0] == 1):
            found.setdefault(store.find(Value(index)), node)
    return found


def _square(store: Store, root: Node) -> Value:
    """Return the square of a root."""
    x, y = root.operands[:2]
    return store.mul(x, y) if root.op == "lightcone" else store.add(store.mul(x, x), store.mul(y, y))
