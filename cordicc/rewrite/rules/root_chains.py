"""Roots of sums of three squares and more as chains of vectorings: hypot(hypot(x, y), z)."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import combinations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.terms import terms_of
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.legs import leg, length, root_of
from cordicc.rewrite.rules.rule import Given, Need, Rule

_MOST = 12
"""Longer sums of squares are left as they are."""

_PAIRED = 4
"""Of longer ones not every pair is tried."""

Squares = Mapping[Value | None, Fraction]
"""Coefficients by the class of what is squared, None for 1."""


def _add_chains(given: Given) -> None:
    """Add roots of sums of squares as lengths of vectors with the root of some of them for a component."""
    store = given.store
    taken = {
        store.find(moved[v.node][v.result])
        for graph, moved in zip(given.graphs, given.moved, strict=True)
        for v in graph.used_results()
    }
    roots: dict[Value, tuple[Value, Squares]] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "lightcone" or (node.op == "vector" and node.m == 1):
            squares = _squares(store, Value(index))
            if squares is not None and 1 < len(squares) <= _MOST:
                roots.setdefault(store.find(Value(index)), (Value(index), squares))
    for root, squares in tuple(roots.values()):
        if len(squares) < 3 or store.find(root) not in taken:
            continue
        store.begin(store.node(root).origin)
        for other, part in roots.values():
            if len(part) < len(squares) and all(squares.get(v) == k for v, k in part.items()):
                rest = [_leg(store, v, k) for v, k in squares.items() if v not in part]
                store.union(root, length(store, [other, *rest]))
        legs = [_leg(store, v, k) for v, k in squares.items()]
        for pair in combinations(legs, 2) if len(legs) <= _PAIRED else [(legs[0], legs[1])]:
            rest = [v for v in legs if v not in pair]
            store.union(root, length(store, [length(store, pair), length(store, rest)]))


def _squares(store: Store, root: Value) -> Squares | None:
    """Return the square of a root as a sum of squares, None if it is no such sum."""
    total: dict[Value | None, Fraction] = {}
    todo = [(Fraction(1), root)]
    while todo:
        factor, value = todo.pop()
        node = store.node(value)
        if node.op == "lightcone" and value.result == 0:
            number = store.constant(node.operands[1])
            terms = None if number is None else terms_of(store.algebra.nodes, node.operands[0])
            if terms is None:
                return None
            for own, factors in terms:
                squared = {store.find(v) for v in factors}
                if number is None or len(squared) > 1 or len(factors) not in (0, 2):
                    return None
                base = next(iter(squared), None)
                total[base] = total.get(base, Fraction(0)) + factor * number * own
        elif node.op == "vector" and node.m == 1 and value.result == 0:
            for leg in node.operands[:2]:
                number, (own, base) = store.constant(leg), store.factored(leg)
                if number is not None:
                    total[None] = total.get(None, Fraction(0)) + factor * number**2
                else:
                    todo.append((factor * own**2, base))
        else:
            base = store.find(value)
            total[base] = total.get(base, Fraction(0)) + factor
    return total if all(k > 0 for k in total.values()) else None


def _leg(store: Store, value: Value | None, square: Fraction) -> Value:
    """Return the root of a multiple of a square, whatever its sign; the value None stands for 1."""
    return store.const(root_of(square)) if value is None else leg(store, value, square)


ROOT_CHAINS = Rule(
    name="chains of lengths",
    mathematics="sqrt(x^2 + y^2 + z^2) = hypot(hypot(x, y), z)",
    apply=_add_chains,
    needs=frozenset({Need.GRAPHS}),
    words="a root of three squares and more: the length of a vector with the root of some of them in it",
)
