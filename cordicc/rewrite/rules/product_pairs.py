"""Two sums of two products each over the same four values.

a c - b d and b c + a d take three products together; a c + b d and b c + a d take two, as half the sum and
half the difference of (a + b)(c + d) and (a - b)(c - d).
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.products import cheaper
from cordicc.rewrite.rules.rule import Given, Rule

_MOST = 400
"""Sums of products that are looked at."""


_Sums = dict[tuple[frozenset[frozenset[Value]], bool], tuple[Value, tuple[Value, Value], tuple[Value, Value]]]


def _add_pairs(given: Given) -> None:
    """Add the cheaper forms of two sums of two products each over the same four values."""
    store = given.store
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


def _join(
    store: Store,
    factors: tuple[Value, Value, Value, Value],
    one: tuple[Value, bool],
    two: tuple[Value, bool, tuple[Value, Value]],
) -> None:
    """Join a c + b d or a c - b d, and b c + a d or their difference, with what makes both together."""
    a, b, c, d = factors
    (value, minus), (partner, difference, leading) = one, two
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


PRODUCT_PAIRS = Rule(
    name="pairs of sums of products",
    mathematics="(a c + b d, b c + a d) = (S + D, S - D)/2 for S = (a + b)(c + d) and D = (a - b)(c - d)",
    apply=_add_pairs,
    words="two sums of products over the same four values",
)
