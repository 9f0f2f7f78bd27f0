"""Rotations in a chain instead of products: u cos t and u sin t are one rotation of (u, 0)."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.rules.rule import Given, Rule


def _add_chains(given: Given) -> None:
    """Add rotations of (u, 0) by t where u cos t and u sin t are products."""
    store = given.store
    zero = store.const(0)
    rotors: dict[Value, tuple[Value, int]] = {}
    for index, node in enumerate(store.algebra.nodes):
        unit = node.op == "rotate" and [store.constant(v) for v in node.operands[:2]] == [1, 0]
        if unit and node.m == 1:
            for result in range(2):
                rotors.setdefault(store.find(Value(index, result)), (node.operands[2], result))
    products: dict[tuple[Value, Value], dict[int, Value]] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "mul":
            for u, turn in (node.operands, node.operands[::-1]):
                known = rotors.get(store.find(turn))
                if known is not None:
                    products.setdefault((store.find(u), known[0]), {})[known[1]] = Value(index)
    for (u, angle), values in products.items():
        if len(values) == 2:
            store.begin(store.node(values[0]).origin)
            made = store.make("rotate", (u, zero, angle), (1,))
            for result, value in values.items():
                store.union(value, made[result])


ROTATION_CHAINS = Rule(
    name="chains of rotations",
    mathematics="(u cos t, u sin t) is (u, 0) turned by t",
    apply=_add_chains,
    words="`u*cos(t)` and `u*sin(t)` as one rotation of `[u, 0]`",
)
