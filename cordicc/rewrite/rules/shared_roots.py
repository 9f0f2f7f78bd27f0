"""The angle of an equation as that of a vector, by the root that the unit of another equation yields."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import permutations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import TooLarge
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.products import turned
from cordicc.rewrite.rules.rule import Given, Need, Rule

_MOST = 6
"""Equations with one root between them; of more, the first."""


def _add_vectors(given: Given) -> None:
    """Add the angle of each equation as that of (B C -+ A w, A C +- B w), with the root w of another one."""
    store = given.store
    for equations in _by_root(store).values():
        for (angle, own), (other, factor) in permutations(equations[:_MOST], 2):
            A, B, C = store.node(angle).operands
            store.begin(store.node(angle).origin)
            w = store.scale(own / factor, Value(other.node, 1))
            w = w if store.node(angle).branch == "+" else store.make("neg", (w,))[0]
            try:
                made = turned(store, (B, A), (C, w))
            except TooLarge:
                continue
            vector = store.make("vector", (*made, store.const(0)), (1, 1))[1]
            store.same_turn(angle, vector)
            store.rotors.rotor(vector)


def _by_root(store: Store) -> Mapping[object, list[tuple[Value, Fraction]]]:
    """Return the angles of equations by the value of which their roots are multiples, with the factors."""
    found: dict[object, list[tuple[Value, Fraction]]] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op != "implicit" or node.m != 1:
            continue
        element = store.element(Value(index, 1))
        poly = None if element is None else store.field.display(element)
        known = None if poly is None else store.affine(poly)
        if known is None or known[2] != 0:
            continue
        value, factor, _ = known
        equations = found.setdefault(store.find(value), [])
        classes = [store.find(Value(angle.node)) for angle, _ in equations]
        if store.find(Value(index)) not in classes:
            equations.append((Value(index), factor))
    return found


SHARED_ROOTS = Rule(
    name="roots of two equations",
    mathematics="B cos t + A sin t = C: t = atan2(A C + B w, B C - A w), w = sqrt(A^2 + B^2 - C^2), branch +",
    apply=_add_vectors,
    needs=frozenset({Need.TOGETHER}),
    words="the angle of a vector that takes the root of another equation: errors of the two cancel",
)
