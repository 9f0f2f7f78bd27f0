"""Two values as half the sum and half the difference of what factors.

Sums and differences of products of cosines and sines often factor: with a = x + y and b = x - y,
P = (S + D)/2 and Q = (S - D)/2 for S = P + Q = u cos b and D = P - Q = v cos a, say.
"""

from __future__ import annotations

from contextlib import suppress
from fractions import Fraction
from itertools import combinations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import Poly, TooLarge, monic
from cordicc.rewrite.exact.keys import Key
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Need, Rule
from cordicc.rewrite.rules.synthesis import Synthesis

_VALUES = 12
"""Values that are taken in pairs."""


_ANGLES = 6
"""Angles that are added and subtracted."""


_TERMS = 16


HALF = Fraction(1, 2)
"""What the sum and the difference of a half sum and a half difference are multiplied by."""


def _add_halves(given: Given) -> None:
    """Add pairs of values of the first realisation as half sums and half differences that factor."""
    store, graph, moved = given.store, given.graphs[0], given.moved[0]
    found: dict[Value, Poly] = {}
    for index in sorted(graph.live()):
        value = moved[index][0]
        element = store.element(value) if graph.nodes[index].op in ("add", "sub") else None
        poly = None if element is None else store.field.display(element)
        if poly is not None and 1 < len(poly) <= _TERMS and all(sum(m) > 1 for m in poly.monoms()):
            found.setdefault(store.find(value), poly)
    synthesis = Synthesis(store)
    turns = _turns(store)
    for (one, P), (other, Q) in combinations(tuple(found.items())[:_VALUES], 2):
        halves = [P + Q, P - Q]
        parts = [[monic(base)[1] for base, _ in store.field.factors(half)[1]] for half in halves]
        if any(len(factors) < 2 for factors in parts):
            continue
        store.begin(store.node(one).origin)
        for key in dict.fromkeys(Key(base) for factors in parts for base in factors):
            if key not in turns:
                continue
            p, q, op = turns[key]
            angle = store.make(op, (p, q))[0]
            store.make("rotate", (store.const(1), store.const(0), angle), (1,))
        with suppress(TooLarge):
            total, difference = (synthesis.polynomial(half) for half in halves)
            store.union(one, store.scale(HALF, store.add(total, difference)))
            store.union(other, store.scale(HALF, store.make("sub", (total, difference))[0]))


def _turns(store: Store) -> dict[Key, tuple[Value, Value, str]]:
    """Return the sums and differences of two angles by their cosine and sine, as displayed and monic."""
    pairs: dict[Value, dict[int, Poly]] = {}
    for index, (angle, m, result) in store.rotors.turned.items():
        if m == 1:
            # Of an angle that was looked at again, the cosine and sine that it has now.
            pairs.setdefault(angle, {})[result] = store.field.generator(index)
    turns: dict[Key, tuple[Value, Value, str]] = {}
    found = [(angle, pair[0], pair[1]) for angle, pair in sorted(pairs.items())][:_ANGLES]
    for (p, c, s), (q, k, t) in combinations(found, 2):
        for op, sine in (("add", t), ("sub", -t)):
            for poly in (c * k - s * sine, s * k + c * sine):
                turns[Key(monic(poly)[1])] = p, q, op
    return turns


HALF_SUMS = Rule(
    name="half sums and half differences",
    mathematics="P = ((P + Q) + (P - Q))/2 and Q = ((P + Q) - (P - Q))/2, where P + Q and P - Q factor",
    apply=_add_halves,
    needs=frozenset({Need.GRAPHS}),
    words="half the sum and half the difference of two values, which factor",
)
