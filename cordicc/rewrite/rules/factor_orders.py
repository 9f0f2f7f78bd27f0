"""Products of three factors share a product of two, and products that are divided share a quotient."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from itertools import permutations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.terms import product_of
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Rule

_MOST = 400
"""Products that are looked at."""

_NODES = 4_000
"""With more operations than these no quotients are added."""


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


def _add_quotients(given: Given) -> None:
    """Add a product with a quotient, or the quotient of a product, with each other factor divided."""
    store = given.store
    zero = store.const(0)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        value = Value(index, 1) if node.op == "vector" and node.m == 0 else Value(index)
        if node.op not in ("vector", "mul") or len(store.algebra.nodes) > _NODES:
            continue
        for below, factor, factors in _quotients(store, value):
            store.begin(node.origin)
            for at, part in enumerate(factors if len(factors) > 1 else ()):
                product = store.make("vector", (below, part, zero), (0, 1))[1]
                for other in factors[:at] + factors[at + 1 :]:
                    product = store.mul(product, other)
                store.union(value, store.scale(factor, product))


def _quotients(store: Store, value: Value) -> Iterator[tuple[Value, Fraction, tuple[Value, ...]]]:
    """Yield divisors, and what is divided as a product, of which a value is the quotient."""
    nodes = store.algebra.nodes
    factor, factors = product_of(nodes, value)
    for at, part in enumerate(factors):
        node = store.node(part)
        if node.op == "vector" and node.m == 0 and part.result == 1 and store.constant(node.operands[2]) == 0:
            below, above, _ = node.operands
            own, inner = product_of(nodes, above)
            yield below, factor * own, factors[:at] + factors[at + 1 :] + inner


QUOTIENT_ORDERS = Rule(
    name="orders of factors and quotients",
    mathematics="(a b)/d = a (b/d) = b (a/d)",
    apply=_add_quotients,
    words="a product divided: another one of its factors is",
)


FACTOR_ORDERS = Rule(
    name="orders of factors",
    mathematics="a (b c) = (a b) c = (a c) b",
    apply=_add_orders,
    words="factors in another order",
)
