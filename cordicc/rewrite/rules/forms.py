"""Sums as sums of terms, rotations as products with one cosine and sine, multiple angles as polynomials."""

from __future__ import annotations

from contextlib import suppress

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.angle_rotors import MOST_TURNS
from cordicc.rewrite.exact.field import TooLarge
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.products import turned
from cordicc.rewrite.rules.rule import Given, Rule
from cordicc.rewrite.rules.synthesis import Synthesis


def _add_forms(given: Given) -> None:
    """Add scalars as sums of terms, and rotations as products with one cosine and sine."""
    store = given.store
    synthesis = Synthesis(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        store.begin(node.origin)
        if node.op == "rotate" and node.m != 0:
            m = node.m
            rotor = store.make("rotate", (store.const(1), store.const(0), node.operands[2]), (m,))
            x, y = node.operands[:2]
            if store.constant(x) is None and store.constant(y) is None:
                for result, value in enumerate(turned(store, (x, y), (rotor[0], rotor[1]), m)):
                    store.union(Value(index, result), value)
            if store.constant(x) == 1 and store.constant(y) == 0:
                _add_multiple_angle(store, synthesis, index)
        element = store.element(Value(index)) if node.op in ("add", "sub") else None
        poly = None if element is None else store.field.display(element)
        if poly is not None:
            with suppress(TooLarge):
                synthesis.expanded(poly)


def _add_multiple_angle(store: Store, synthesis: Synthesis, index: int) -> None:
    """Add cosine and sine of a multiple of an angle as polynomials in those of the angle."""
    for value in (Value(index, 0), Value(index, 1)):
        element = store.element(value)
        poly = None if element is None else store.field.display(element)
        if poly is not None and 1 < poly.total_degree() <= MOST_TURNS:
            with suppress(TooLarge):
                store.union(value, synthesis.expanded(poly))


FORMS = Rule(
    name="sums of products",
    mathematics="(x, y) turned by t is (x cos t - y sin t, y cos t + x sin t), and cos 2t = 1 - 2 sin^2 t",
    apply=_add_forms,
    words="written as a sum of products",
)
