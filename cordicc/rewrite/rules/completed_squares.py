"""Roots of what is a sum of squares once squares are completed: the length of the vector of what is squared.

a^2 + b^2 - 2 a b cos t is (a - b cos t)^2 + (b sin t)^2, x^2 + 2 x y + 2 y^2 is (x + y)^2 + y^2, 1 - cos^2 t
is sin^2 t and 2 - 2 cos t is (1 - cos t)^2 + sin^2 t.  As a length a small root keeps its digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from fractions import Fraction
from typing import Any

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import Poly, TooLarge, rational
from cordicc.rewrite.exact.radicands import under_root
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.legs import leg, length
from cordicc.rewrite.rules.rule import Given, Rule
from cordicc.rewrite.rules.synthesis import Synthesis

_TERMS = 12
"""Longer radicands are left as they are."""

_MOST = 4
"""Squares of a sum."""

Square = tuple[Fraction, Poly]
"""A positive factor and what is squared."""


def _add_lengths(given: Given) -> None:
    """Add roots of sums of squares, completed where need be, as lengths."""
    store = given.store
    synthesis = Synthesis(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "lightcone":
            continue
        operands = [store.element(v) for v in node.operands]
        with suppress(TooLarge, ZeroDivisionError):
            known = [e for e in operands if e is not None]
            if len(known) < 2:
                continue
            radicand = under_root(store.field, node, known)
            poly = store.field.display(radicand)
            squares = None if poly is None or len(poly) > _TERMS else _squares(store, poly, _MOST)
            if squares is not None and len(squares) > 1:
                store.begin(node.origin)
                legs = [leg(store, synthesis.polynomial(inside), factor) for factor, inside in squares]
                store.union(Value(index), length(store, legs))
                store.know_square_sum(store.field.times(radicand.num, radicand.den))


def _squares(store: Store, poly: Poly, most: int) -> list[Square] | None:
    """Return a polynomial in cosines and sines as a sum of squares, None if none is found."""
    for other in _turned(store, poly):
        found = _plain(store, other)
        if found is not None:
            return found if len(found) <= most else None
    for index in store.field.generators(poly) if most > 1 else ():
        square, rest = _completed(store, poly, index)
        if square is not None and (rest.is_zero() or len(rest) <= len(poly)):
            others = [] if rest.is_zero() else _squares(store, rest, most - 1)
            if others is not None:
                return [square, *others]
    return None


def _turned(store: Store, poly: Poly) -> Iterator[Poly]:
    """Yield a polynomial, and the same with sines in place of squared cosines."""
    yield poly
    field, sines = store.field, {}
    for index, (angle, m, result) in store.rotors.turned.items():
        if result == 1:
            sines[angle, m] = index
    for index, (angle, m, result) in store.rotors.turned.items():
        if result == 0 and (angle, m) in sines and poly.degrees()[index] > 1:
            total, square = poly * 0, 1 - m * field.generator(sines[angle, m]) ** 2
            for powers, factor in poly.terms():
                rest = (*powers[:index], powers[index] % 2, *powers[index + 1 :])
                total = total + field.context.from_dict({rest: factor}) * square ** (int(powers[index]) // 2)
            poly = total
    yield poly


def _plain(store: Store, poly: Poly) -> list[Square] | None:
    """Return a sum of squares of products, and of such multiples of p - q cos t with p >= |q|."""
    cosines = {i for i, (_, m, result) in store.rotors.turned.items() if m == 1 and result == 0}
    even: dict[tuple[int, ...], Fraction] = {}
    turned: list[tuple[tuple[int, ...], int, Fraction]] = []
    for powers, factor in poly.terms():
        odd = [i for i, power in enumerate(powers) if power % 2]
        if len(odd) > 1 or (odd and (odd[0] not in cosines or powers[odd[0]] > 1)):
            return None
        own = tuple(int(power) - (i in odd) for i, power in enumerate(powers))
        if odd:
            turned.append((own, odd[0], rational(factor)))
        else:
            even[own] = even.get(own, Fraction(0)) + rational(factor)
    found: list[Square] = []
    pairs = {(angle, result): i for i, (angle, m, result) in store.rotors.turned.items() if m == 1}
    for own, cosine, factor in turned:
        # |q| (1 +- c) is |q|/2 times (1 +- c)^2 + s^2.
        even[own] = even.get(own, Fraction(0)) - abs(factor)
        base = _halved(store, own)
        gens = store.field.generator
        sine = pairs.get((store.rotors.turned[cosine][0], 1))
        if sine is None:
            return None
        sign = 1 if factor > 0 else -1
        found.append((abs(factor) / 2, base * (1 + sign * gens(cosine))))
        found.append((abs(factor) / 2, base * gens(sine)))
    found += [(factor, _halved(store, own)) for own, factor in even.items() if factor]
    return found if all(factor > 0 for factor, _ in found) else None


def _halved(store: Store, powers: tuple[int, ...]) -> Poly:
    return store.field.context.from_dict({tuple(power // 2 for power in powers): 1})


def _completed(store: Store, poly: Poly, index: int) -> tuple[Square | None, Poly]:
    """Return a square that holds all terms of a generator, None if there is none, and the rest."""
    parts: dict[int, dict[Any, Any]] = {}
    for powers, factor in poly.terms():
        rest = (*powers[:index], 0, *powers[index + 1 :])
        parts.setdefault(int(powers[index]), {})[rest] = factor
    context = store.field.context
    lead, linear = (context.from_dict(parts.get(power, {})) for power in (2, 1))
    if max(parts) != 2 or not lead.is_constant() or linear.is_zero():
        return None, poly
    factor = rational(lead.leading_coefficient())
    if factor <= 0:
        return None, poly
    inside = store.field.generator(index) + linear / (2 * lead.leading_coefficient())
    return (factor, inside), store.field.reduce(poly - inside * inside * lead.leading_coefficient())


COMPLETED_SQUARES = Rule(
    name="completed squares",
    mathematics="sqrt(a^2 + b^2 - 2 a b cos t) = hypot(a - b cos t, b sin t)",
    apply=_add_lengths,
    words="a root of what is a sum of squares: the length of the vector of what is squared",
)
