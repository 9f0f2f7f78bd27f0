"""Hyperbolic angles with the same cosine and sine are equal: inverse functions that cancel."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.keys import RotorKey
from cordicc.rewrite.rules.rule import Given, Rule


def _join_areas(given: Given) -> None:
    """Make hyperbolic angles with the same cosine and sine equal: inverse functions that cancel."""
    store = given.store
    known: dict[RotorKey, Value] = {}
    for index, node in enumerate(tuple(store.algebra.nodes)):
        value = None
        if node.op == "rotate" and node.m == -1:
            value = node.operands[2]
        elif (angle := node.hyperbolic_angle) is not None:
            value = Value(index, angle)
        rotor = None if value is None else store.rotors.rotor(value, -1)
        if value is not None and rotor is not None:
            store.union(known.setdefault((rotor[0].key, rotor[1].key), value), value)


HYPERBOLIC_ANGLES = Rule(
    name="equal hyperbolic angles",
    mathematics="u = v where cosh u = cosh v and sinh u = sinh v",
    apply=_join_areas,
)
