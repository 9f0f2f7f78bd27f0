"""A value that is a multiple of an earlier one, plus a constant."""

from __future__ import annotations

from cordicc.rewrite.rules.rule import Given, Rule


def _add_multiples(given: Given) -> None:
    """Join sums and products with a multiple of an earlier value, plus a constant, that equals them."""
    store = given.store
    for value, poly in tuple(store.polynomials.multiples):
        found = store.affine(poly)
        if found is None or store.node(value).op not in ("add", "sub", "mul"):
            continue
        other, factor, constant = found
        if store.find(other) != store.find(value):
            store.begin(store.node(value).origin)
            store.union(value, store.add(store.scale(factor, other), store.const(constant)))


MULTIPLES = Rule(
    name="multiples of values",
    mathematics="p = k v + d, with constants k and d, where the polynomials of both sides are equal",
    apply=_add_multiples,
    words="a multiple of another value, plus a constant",
)
