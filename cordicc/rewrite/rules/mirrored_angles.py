"""Angles of a vector and of its mirror images: one is the other, negated and turned by quarter turns."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import PI
from cordicc.rewrite.exact.keys import RotorKey
from cordicc.rewrite.rules.angles import angles_of
from cordicc.rewrite.rules.rule import Given, Rule

_MOST = 48
"""Angles that are compared with one another."""


def _add_mirrored(given: Given) -> None:
    """Add angles as others, negated or not, and turned; the sample points show which, rotors prove it."""
    store = given.store
    distinct: dict[RotorKey, Value] = {}
    for value in angles_of(store):
        rotor = store.rotors.rotor(value)
        if rotor is not None:
            distinct.setdefault((rotor[0].key, rotor[1].key), value)
    for p, r in combinations(list(distinct.values())[:_MOST], 2):
        for negated in (False, True):
            other = -store.numbers(p) if negated else store.numbers(p)
            rest = np.exp(1j * (store.numbers(r) - other))
            quarters = np.angle(rest[0]) / (np.pi / 2)
            if np.max(np.abs(rest - rest[0])) < 1e-9 and abs(quarters - round(quarters)) < 1e-9:
                store.begin(store.node(r).origin)
                turned = store.make("neg", (p,))[0] if negated else p
                store.rotors.rotor(store.add(turned, store.const(PI / 2 * round(quarters))))
                # And the other way round: which of the two is made is for the choice among them.
                back = store.make("neg", (r,))[0] if negated else r
                number = PI / 2 * round(quarters)
                store.rotors.rotor(store.add(back, store.const(number if negated else -number)))


MIRRORED_ANGLES = Rule(
    name="mirrored angles",
    mathematics="atan2(-y, -x) = atan2(y, x) + pi, atan2(-y, x) = -atan2(y, x), ... modulo 2 pi",
    apply=_add_mirrored,
    words="the angle of a mirrored vector: that of the vector, turned by quarter turns or negated",
)
