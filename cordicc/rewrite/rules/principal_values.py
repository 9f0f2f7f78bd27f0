"""acos(C/B) is the angle of (C, w) for the second result w = sqrt(B^2 - C^2), asin(C/A) that of (w, C)."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.rules.rule import Given, Rule


def _add_principal_values(given: Given) -> None:
    """Add the angles of circular equations with one coefficient as those of vectors."""
    store = given.store
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "implicit" or node.m != 1:
            continue
        A, B, C = node.operands
        rest = Value(index, 1)
        store.begin(node.origin)
        if store.constant(A) == 0 and node.branch == "+" and store.sign(B) > 0:
            made, size = store.make("vector", (C, rest, store.const(0)), (1, 1)), B
        elif store.constant(B) == 0 and node.branch == "-" and store.sign(A) > 0:
            made, size = store.make("vector", (rest, C, store.const(0)), (1, 1)), A
        else:
            continue
        store.union(made[0], size)
        store.union(made[1], Value(index, 0))
        store.rotors.rotor(made[1])


PRINCIPAL_VALUES = Rule(
    name="principal values",
    mathematics="acos(C/B) = atan2(w, C) and asin(C/B) = atan2(C, w), with w = sqrt(B^2 - C^2)",
    apply=_add_principal_values,
    words="acos(C/B) is the angle of (C, w), asin(C/A) that of (w, C), w = sqrt(B^2 - C^2)",
)
