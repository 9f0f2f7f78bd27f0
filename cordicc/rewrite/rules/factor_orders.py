"""Products of three factors share a product of two."""

from __future__ import annotations

from collections import Counter
from itertools import permutations

from cordicc.ir.graph import Value
from cordicc.rewrite.rules.rule import Given, Rule

_MOST = 400
"""Products that are looked at."""


def _add_orders(given: Given) -> None:
    """Add products of three factors in the orders whose first product serves more than one."""
    store = given.store
    triples: dict[tuple[Value, Value, Value], Value] = {}
    factors: dict[Value, tuple[Value, Value]] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "mul":
            factors.setdefault(store.find(Value(index)), (node.operands[0], node.operands[1]))
    for index, node in enumerate(store.algebra.nodes):
        if node.op != "mul":
            continue
        for one, other in (node.operands, node.operands[::-1]):
            inner = factors.get(store.find(other))
            if inner is not None and len(triples) < _MOST:
                key = tuple(sorted(store.find(v) for v in (one, *inner)))
                triples.setdefault((key[0], key[1], key[2]), Value(index))
    counts = Counter(pair for key in triples for pair in _pairs(key))
    for key, value in triples.items():
        for a, b, c in sorted(set(permutations(key))):
            if a <= b and counts[a, b] > 1:
                store.begin(store.node(value).origin)
                store.union(value, store.mul(store.mul(a, b), c))


def _pairs(key: tuple[Value, Value, Value]) -> set[tuple[Value, Value]]:
    a, b, c = key
    return {(a, b), (a, c), (b, c)}


FACTOR_ORDERS = Rule(
    name="orders of factors",
    mathematics="a (b c) = (a b) c = (a c) b",
    apply=_add_orders,
    words="factors in another order",
)
