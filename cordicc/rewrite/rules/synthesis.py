"""Arithmetic for a polynomial: an expression of values that exist, with few products.

Polynomials have cosines and sines as generators, as `Field.display` gives them.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import Poly, TooLarge, rational
from cordicc.rewrite.exact.keys import Key
from cordicc.rewrite.exact.values import Store

_TERMS = 24
"""Longer polynomials are not written out."""

CANCELS = 1.2
"""Terms that are larger by this much show that digits cancel."""


class Synthesis:
    """Finds expressions; those found once are found again."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._done: dict[Key, Value] = {}

    def polynomial(self, poly: Poly) -> Value:
        """Return a value that is this polynomial.

        Raises TooLarge if it is long, or if no value is known for one of its generators.
        """
        key = Key(poly)
        if key not in self._done:
            if len(poly) > _TERMS:
                known = self._known(poly)
                if known is None:
                    raise TooLarge
                return known
            self._done[key] = self._write(poly)
        return self._done[key]

    def expanded(self, poly: Poly) -> Value:
        """Return a value as the sum of its terms, so that products of generators are shared.

        Squares of cosines become those of sines where fewer digits cancel then: 1 - 2 sin^2 near angle 0.
        """
        if len(poly) > _TERMS:
            raise TooLarge
        store = self._store
        total = store.const(0)
        for powers, factor in self._conditioned(poly).terms():
            value = store.const(rational(factor))
            for index, power in enumerate(powers):
                for _ in range(power):
                    value = store.mul(value, self._generator(index))
            total = store.add(total, value)
        return total

    def _conditioned(self, poly: Poly) -> Poly:
        """Return a polynomial with sines in place of squared cosines, if its terms are smaller for it."""
        turned = self._store.rotors.turned
        pairs = {(angle, m, result): index for index, (angle, m, result) in turned.items()}
        for cosine in list(self._store.field.generators(poly)):
            angle, m, result = turned.get(cosine, (None, 0, 1))
            if result or poly.degrees()[cosine] < 2:
                continue
            assert angle is not None
            gens = self._store.field.generator
            square = 1 - m * gens(pairs[angle, m, 1]) ** 2
            other = poly * 0
            for powers, factor in poly.terms():
                rest = (*powers[:cosine], powers[cosine] % 2, *powers[cosine + 1 :])
                term = self._store.field.context.from_dict({rest: factor})
                other = other + term * square ** (int(powers[cosine]) // 2)
            if len(other) <= _TERMS and CANCELS * self._terms_size(other) < self._terms_size(poly):
                poly = other
        return poly

    def _terms_size(self, poly: Poly) -> float:
        """Return the mean over the samples of the sum of the absolute values of the terms."""
        total = np.zeros(1)
        for powers, factor in poly.terms():
            term = np.array(abs(float(rational(factor))))
            for index, power in enumerate(powers):
                if power:
                    term = term * np.abs(self._store.numbers(self._generator(index))) ** int(power)
            total = total + term
        with np.errstate(over="ignore"):  # of the largest doubles
            return float(np.nanmean(total))

    def _known(self, poly: Poly) -> Value | None:
        found = self._store.affine(poly)
        if found is None:
            return None
        value, factor, constant = found
        return self._store.add(self._store.scale(factor, value), self._store.const(constant))

    def _generator(self, index: int) -> Value:
        store = self._store
        known = store.generator_value(index)
        if isinstance(known, Fraction):
            return store.const(known)
        if known is None:
            known = self._known(store.field.generator(index))
        if known is None:
            raise TooLarge
        return known

    def _write(self, poly: Poly) -> Value:
        store = self._store
        if poly.is_constant():
            number = Fraction(0) if poly.is_zero() else rational(poly.leading_coefficient())
            return store.const(number)
        known = self._known(poly)
        if known is not None:
            return known
        if len(poly) == 1 and poly.total_degree() == 1:
            index = next(store.field.generators(poly))
            return store.scale(rational(poly.leading_coefficient()), self._generator(index))
        constant, factors = store.field.factors(poly)
        if len(factors) > 1 or factors[0][1] > 1:
            value = store.const(rational(constant))
            for base, exponent in factors:
                for _ in range(exponent):
                    value = store.mul(value, self.polynomial(base))
            return value
        reduced = self._less_a_known_value(poly)
        return self._horner(poly) if reduced is None else reduced

    def _less_a_known_value(self, poly: Poly) -> Value | None:
        """Return k p + rest for the polynomial p of a value that leaves the shortest rest, if it is short."""
        store = self._store
        best: tuple[int, Poly, Fraction, Poly] | None = None
        terms = poly.to_dict()
        for other in store.polynomials.sums:
            lead = other.monoms()[0]
            if lead not in terms or len(other) < 2 or len(other) > 2 * len(poly):
                continue
            factor = terms[lead] / other.leading_coefficient()
            rest = poly - other * factor
            if len(rest) <= len(poly) - 2 and (best is None or len(rest) < best[0]):
                best = len(rest), other, rational(factor), rest
        if best is None:
            return None
        _, other, factor, rest = best
        # The value may be another multiple of it, with a constant.
        value = self._known(other)
        return None if value is None else store.add(store.scale(factor, value), self.polynomial(rest))

    def _horner(self, poly: Poly) -> Value:
        """Return g p + q for the generator g in the most terms; linear terms stay apart."""
        store = self._store
        monomials = [m for m in poly.monoms() if sum(m) > 1]
        if not monomials:
            value = store.const(0)
            for powers, factor in poly.terms():
                value = store.add(value, self.polynomial(store.field.context.from_dict({powers: factor})))
            return value
        width = len(monomials[0])
        index = max(range(width), key=lambda i: sum(1 for m in monomials if m[i]))
        inside, rest = {}, {}
        for powers, factor in poly.terms():
            if powers[index] and sum(powers) > 1:
                inside[(*powers[:index], powers[index] - 1, *powers[index + 1 :])] = factor
            else:
                rest[powers] = factor
        context = store.field.context
        product = store.mul(self._generator(index), self.polynomial(context.from_dict(inside)))
        return store.add(product, self.polynomial(context.from_dict(rest)))
