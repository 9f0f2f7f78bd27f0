"""Angles as sums of two others, where the sample points show a relation and rotors prove it."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import PI
from cordicc.rewrite.exact.keys import RotorKey
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.angles import angles_of
from cordicc.rewrite.rules.named_polynomials import name_of
from cordicc.rewrite.rules.rule import Given, Rule


def _add_sums(given: Given) -> None:
    """Add angles as sums of two others, where the sample points show a relation and rotors prove it."""
    store = given.store
    angles = [v for v in angles_of(store) if store.rotors.rotor(v) is not None]
    angles += [n.operands[2] for n in store.algebra.nodes if n.op == "rotate" and n.m == 1]
    distinct: dict[RotorKey, Value] = {}
    for value in angles:
        rotor = store.rotors.rotor(value)
        if rotor is not None:
            distinct.setdefault((rotor[0].key, rotor[1].key), value)
    values = list(distinct.values())[:24]
    if len(values) < 3:
        return
    turns = np.stack([np.exp(1j * store.numbers(v)) for v in values])
    for (i, p), (j, q) in combinations(enumerate(values), 2):
        for sign in (1, -1):
            both = turns[i] * (turns[j] if sign == 1 else np.conj(turns[j]))
            # One row for each angle and sign in front of the sum: how far they differ at the points.
            rests = np.stack((turns, np.conj(turns)), axis=1) * np.conj(both)
            constant = np.max(np.abs(rests - rests[..., :1]), axis=-1) < 1e-9
            for k, r in enumerate(values):
                for column, whole in enumerate((1, -1)):
                    if k not in (i, j) and constant[k, column]:
                        _add_sum(store, r, whole, p, q, sign, rests[k, column, 0])


def _add_sum(store: Store, r: Value, whole: int, p: Value, q: Value, sign: int, rest: Any) -> None:
    """Make r = whole (p + sign q + constant) if the constant is a multiple of a quarter turn."""
    quarters = np.angle(rest) / (np.pi / 2)
    if abs(quarters - round(quarters)) > 1e-9:
        return
    store.begin(store.node(r).origin)
    turned = round(quarters)
    ANGLE_SUMS.tell_of(store, r, whole, p, q, sign, turned)
    total = store.make("add" if sign == 1 else "sub", (p, q))[0]
    total = store.add(total, store.const(PI / 2 * turned))
    if whole == -1:
        total = store.make("neg", (total,))[0]
    store.rotors.rotor(total)


def _quarters(count: int) -> str:
    """Write a positive number of quarter turns."""
    return "pi" if count == 2 else f"{count}*pi/2" if count > 1 else "pi/2"


def _formulas(
    store: Store, r: Value, whole: int, p: Value, q: Value, sign: int, quarters: int
) -> tuple[str, ...]:
    """Return what an angle is the sum of, with a number of quarter turns."""
    names = [name_of(store, v) for v in (r, p, q)]
    middle = "+" if sign == 1 else "-"
    turned = f" {'+' if quarters > 0 else '-'} {_quarters(abs(quarters))}" if quarters else ""
    right = f"{names[1]} {middle} {names[2]}{turned}"
    right = f"-({right})" if whole == -1 else right
    return (f"`{names[0]} = {right}`: both sides have the same cosine and sine",)


ANGLE_SUMS = Rule(
    name="sums of angles",
    mathematics="r = p + q + n pi/2 modulo 2 pi, up to signs, where both sides have the same cosine and sine",
    apply=_add_sums,
    formulas=_formulas,
)
