"""Fewer multipliers among products that are there: norms, orders of factors, pairs of sums.

A square of a result of a unit stands for the sum of squares that it is the root of.  Products of three
factors share a product of two.  a c - b d and b c + a d take three products together; a c + b d and
b c + a d take two, as half the sum and half the difference of (a + b)(c + d) and (a - b)(c - d).
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from itertools import permutations, product

from cordicc.ir.graph import Value, factored
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.products import cheaper

_SQUARES = 12
"""Longer sums of squares are left as they are."""

_MOST = 400
"""Products or sums of products that are looked at."""


def add_norms(store: Store) -> None:
    """Add x^2 + y^2 as the square of the norm, A^2 + B^2 as w^2 + C^2; the field proves them equal."""
    store.reason = ("a sum of squares as the square of its root",)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op not in ("vector", "implicit") or node.params[0] != 1:
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


def add_norm_chains(store: Store) -> None:
    """Add sums of three squares and more with x^2 + y^2 in them as the square of a norm."""
    store.reason = ("two of the squares as the square of the norm",)
    norms = [
        (Value(index), [factored(store.algebra.nodes, v) for v in node.operands[:2]])
        for index, node in enumerate(store.algebra.nodes)
        if node.op == "vector" and node.params[0] == 1
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


def add_multiples(store: Store) -> None:
    """Join sums and products with a multiple of an earlier value, plus a constant, that equals them."""
    store.reason = ("a multiple of another value, plus a constant",)
    for value, poly in tuple(store.polynomials.multiples):
        found = store.affine(poly)
        if found is None or store.node(value).op not in ("add", "sub", "mul"):
            continue
        other, factor, constant = found
        if store.find(other) != store.find(value):
            store.begin(store.node(value).origin)
            store.union(value, store.add(store.scale(factor, other), store.const(constant)))


def add_orders(store: Store) -> None:
    """Add products of three factors in the orders whose first product serves more than one."""
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
    store.reason = ("factors in another order",)
    for key, value in triples.items():
        for a, b, c in sorted(set(permutations(key))):
            if a <= b and counts[a, b] > 1:
                store.begin(store.node(value).origin)
                store.union(value, store.mul(store.mul(a, b), c))


def _pairs(key: tuple[Value, Value, Value]) -> set[tuple[Value, Value]]:
    a, b, c = key
    return {(a, b), (a, c), (b, c)}


def add_pairs(store: Store) -> None:
    """Add the cheaper forms of two sums of two products each over the same four values."""
    products: dict[Value, dict[tuple[Value, Value], None]] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "mul":
            a, b = sorted(store.find(v) for v in node.operands)
            products.setdefault(store.find(Value(index)), {})[a, b] = None
    known: _Sums = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op not in ("add", "sub") or len(known) == _MOST:
            continue
        ways = [products.get(store.find(v), {}) for v in node.operands]
        for first, second in product(*ways):
            if len({*first, *second}) == 4:
                key = frozenset((frozenset(first), frozenset(second))), node.op == "sub"
                known.setdefault(key, (Value(index), first, second))
    for (_, minus), (value, (a, c), (b, d)) in tuple(known.items()):
        # The partner holds b c and a d, or with b and d exchanged c d and a b.
        for p, q in ((b, d), (d, b)):
            for other in (False, True) if minus else (False,):
                partner = known.get((frozenset((frozenset((p, c)), frozenset((a, q)))), other))
                if partner is not None:
                    store.begin(store.node(value).origin)
                    _join(store, (a, p, c, q), (value, minus), (partner[0], other, partner[1]))


_Sums = dict[tuple[frozenset[frozenset[Value]], bool], tuple[Value, tuple[Value, Value], tuple[Value, Value]]]


def _join(
    store: Store,
    factors: tuple[Value, Value, Value, Value],
    one: tuple[Value, bool],
    two: tuple[Value, bool, tuple[Value, Value]],
) -> None:
    """Join a c + b d or a c - b d, and b c + a d or their difference, with what makes both together."""
    a, b, c, d = factors
    (value, minus), (partner, difference, leading) = one, two
    store.reason = ("two sums of products over the same four values",)
    if minus and not difference:
        first, second = cheaper(store, (a, b), (c, d), 1)
    else:
        b = store.scale(Fraction(-1), b) if minus else b
        first, second = cheaper(store, (a, b), (c, d), -1)
        # With -b for b the second is a d - b c.
        if difference and frozenset(leading) == frozenset((factors[1], c)):
            second = store.scale(Fraction(-1), second)
    store.union(value, first)
    store.union(partner, second)
