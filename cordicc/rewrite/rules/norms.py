"""A sum of squares as the square of the result of a unit that is its root."""

from __future__ import annotations

from cordicc.ir.graph import Value, factored
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Rule

_SQUARES = 12
"""Longer sums of squares are left as they are."""


def _add_norms(given: Given) -> None:
    """Add x^2 + y^2 as the square of the norm, A^2 + B^2 as w^2 + C^2; the field proves them equal."""
    store = given.store
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op not in ("vector", "implicit") or node.m != 1:
            continue
        store.begin(node.origin)
        root = Value(index, 0 if node.op == "vector" else 1)
        C = node.operands[2]
        # A variable C takes as many products as there are without.
        if store.element(root) is None or (node.op == "implicit" and store.constant(C) is None):
            continue
        square = store.mul(root, root)
        x, y = node.operands[:2]
        squares = store.add(store.mul(x, x), store.mul(y, y))
        store.union(store.add(square, store.mul(C, C)) if node.op == "implicit" else square, squares)


def _add_norm_chains(given: Given) -> None:
    """Add sums of three squares and more with x^2 + y^2 in them as the square of a norm."""
    store = given.store
    norms = [
        (Value(index), [factored(store.algebra.nodes, v) for v in node.operands[:2]])
        for index, node in enumerate(store.algebra.nodes)
        if node.op == "vector" and node.m == 1
    ]
    for index, node in enumerate(tuple(store.algebra.nodes)):
        squares = _squares(store, Value(index)) if node.op == "add" else []
        if not 2 < len(squares) <= _SQUARES:
            continue
        for norm, legs in norms:
            roots = [store.find(base) for _, base in legs]
            if legs[0][0] ** 2 != legs[1][0] ** 2 or not all(root in squares for root in roots):
                continue
            rest = list(squares)
            for root in roots:
                if root in rest:
                    rest.remove(root)
            if len(rest) == len(squares) - 2:
                store.begin(node.origin)
                total = store.scale(1 / legs[0][0] ** 2, store.mul(norm, norm))
                for root in rest:
                    total = store.add(total, store.mul(root, root))
                store.union(Value(index), total)


def _squares(store: Store, value: Value) -> list[Value]:
    """Return v1, v2, ... for v1^2 + v2^2 + ..., nothing for other sums."""
    node = store.node(value)
    if node.op == "mul" and store.find(node.operands[0]) == store.find(node.operands[1]):
        return [store.find(node.operands[0])]
    parts = [_squares(store, v) for v in node.operands] if node.op == "add" else []
    return [v for part in parts for v in part] if parts and all(parts) else []


NORMS = Rule(
    name="squares of norms",
    mathematics="x^2 + y^2 = hypot(x, y)^2, and A^2 + B^2 = w^2 + C^2 for the second result w of an equation",
    apply=_add_norms,
    words="a sum of squares as the square of its root",
)


NORM_CHAINS = Rule(
    name="squares of norms in longer sums",
    mathematics="x^2 + y^2 + z^2 + ... = hypot(x, y)^2 + z^2 + ...",
    apply=_add_norm_chains,
    words="two of the squares as the square of the norm",
)
