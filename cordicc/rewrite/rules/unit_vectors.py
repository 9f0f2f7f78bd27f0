"""A vector (x, y) divided by its norm is the cosine and sine of its angle."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.rules.rule import Given, Rule


def _add_unit_vectors(given: Given) -> None:
    """Add the cosine and sine of each vector that is divided by its norm."""
    store = given.store
    divisors = {
        store.find(node.operands[0]) for node in store.algebra.nodes if node.op == "vector" and node.m == 0
    }
    for index, node in enumerate(tuple(store.algebra.nodes)):
        plain = (
            node.op == "vector" and (node.m, node.sign) == (1, 1) and store.constant(node.operands[2]) == 0
        )
        if plain and store.find(Value(index, 0)) in divisors:
            store.begin(node.origin)
            store.make("rotate", (store.const(1), store.const(0), Value(index, 1)), (1,))


UNIT_VECTORS = Rule(
    name="unit vectors",
    mathematics="(x, y)/hypot(x, y) = (cos t, sin t) for t = atan2(y, x)",
    apply=_add_unit_vectors,
    words="a vector divided by its norm: cosine and sine of its angle",
)
