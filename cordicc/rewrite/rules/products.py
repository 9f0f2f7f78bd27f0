"""Products of a vector with the cosine and sine of an angle, with fewer multipliers than they show.

A complex product takes three: with k = c (x + y), x c - y s = k - y (c + s) and y c + x s = k + x (s - c).
A hyperbolic rotation takes two in light-cone coordinates: x C + y S and y C + x S are half the sum and
half the difference of (x + y)(C + S) and (x - y)(C - S).
"""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.values import Store

Pair = tuple[Value, Value]

_WORDS = {
    1: "three products: `x*c - y*s = c*(x + y) - y*(c + s)`",
    -1: "light cone: `x*C + y*S = ((x + y)*(C + S) + (x - y)*(C - S))/2`",
}
"""By coordinate system what explains a cheaper form, besides the rule that asks for the product."""


def turned(store: Store, vector: Pair, rotor: Pair, m: int = 1) -> Pair:
    """Return (x c - m y s, y c + x s), with the cheaper forms as alternatives."""
    (x, y), (c, s) = vector, rotor
    first = store.make("sub" if m == 1 else "add", (store.mul(x, c), store.mul(y, s)))[0]
    second = store.add(store.mul(y, c), store.mul(x, s))
    if all(store.constant(v) is None for v in (x, y, c, s)):
        for plain, other in zip((first, second), cheaper(store, vector, rotor, m), strict=True):
            store.union(plain, other)
    return first, second


def cheaper(store: Store, vector: Pair, rotor: Pair, m: int) -> Pair:
    """Return (x c - m y s, y c + x s) by three products for m = 1, by two for m = -1."""
    with store.explained(_WORDS[m]):
        return _three_products(store, vector, rotor) if m == 1 else _light_cone(store, vector, rotor)


def _three_products(store: Store, vector: Pair, rotor: Pair) -> Pair:
    (x, y), (c, s) = vector, rotor
    shared = store.mul(c, store.add(x, y))
    first = store.make("sub", (shared, store.mul(y, store.add(c, s))))[0]
    second = store.make("add", (shared, store.mul(x, store.make("sub", (s, c))[0])))[0]
    return first, second


def _light_cone(store: Store, vector: Pair, rotor: Pair) -> Pair:
    (x, y), (c, s) = vector, rotor
    plus = store.mul(store.add(x, y), store.add(c, s))
    minus = store.mul(store.make("sub", (x, y))[0], store.make("sub", (c, s))[0])
    half = Fraction(1, 2)
    total = store.make("add", (plus, minus))[0]
    difference = store.make("sub", (plus, minus))[0]
    return store.scale(half, total), store.scale(half, difference)
