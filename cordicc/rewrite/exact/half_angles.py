"""Functions of the tangents of half angles, written as polynomials in cosines and sines.

The field holds the cosine and sine of an angle as fractions in the tangent t of its half.  For arithmetic,
and to find equal values up to a constant, they are written in the cosine and sine themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import fmpq

Poly = Any


class HalfAngles:
    """Knows the tangents: for each the generators of its cosine and sine, and m, -1 if hyperbolic."""

    def __init__(self, context: Any) -> None:
        self._context = context
        self._gens = context.gens()
        self._tangents: dict[int, tuple[int, int, int]] = {}
        self._powers: dict[tuple[int, int, int], Poly] = {}

    def add(self, tangent: int, cosine: int, sine: int, m: int) -> None:
        """Make a tangent known."""
        self._tangents[tangent] = cosine, sine, m

    def displays(self, polys: list[Poly], den: Poly) -> list[Poly] | None:
        """Return p/den in cosines and sines, None unless den is a product of powers of 1 + t^2."""
        degrees = [p.degrees() for p in (den, *polys)]
        for tangent in [i for i in self._tangents if any(each[i] for each in degrees)]:
            m = self._tangents[tangent][2]
            below = 1 + m * self._gens[tangent] ** 2
            if m == -1:
                polys, den = self._completed(polys, den, self._gens[tangent])
            power = 0
            while den.degrees()[tangent]:
                if not (den % below).is_zero():
                    return None
                den, power = den / below, power + 1
            if any(p.degrees()[tangent] > 2 * power for p in polys):
                return None
            polys = [self._half_angles(p, tangent, power) for p in polys]
        return [p / den.leading_coefficient() for p in polys] if den.is_constant() else None

    def least_terms(self, poly: Poly) -> int:
        """Return a number of terms that a polynomial has at the least when it is displayed.

        Displaying changes the tangents alone: there are no fewer terms than without them.
        """
        degrees = poly.degrees()
        tangents = {str(self._gens[i]): 5 + 2 * i for i in self._tangents if degrees[i]}
        return len(poly.subs(tangents)) if tangents else len(poly)

    def half_degree(self, degrees: Sequence[int]) -> Poly:
        """Return the product of powers of 1 + t^2 that polynomials of some degrees are divided by."""
        product = self._context.constant(1)
        for tangent, (_, _, m) in self._tangents.items():
            product = product * (1 + m * self._gens[tangent] ** 2) ** ((degrees[tangent] + 1) // 2)
        return product

    @staticmethod
    def _completed(polys: list[Poly], den: Poly, t: Poly) -> tuple[list[Poly], Poly]:
        """Give a denominator as many factors 1 + t as it has of t - 1, and the other way round."""
        counts = []
        for factor in (t - 1, t + 1):
            count, rest = 0, den
            while (rest % factor).is_zero():
                rest, count = rest / factor, count + 1
            counts.append(count)
        most = max(counts)
        missing = (t - 1) ** (most - counts[0]) * (t + 1) ** (most - counts[1])
        return [p * missing for p in polys], den * missing

    def _half_angles(self, poly: Poly, tangent: int, power: int) -> Poly:
        """Return poly/(1 + m t^2)^power, in which neither cosine nor sine of the angle occurs yet."""
        parts: dict[int, dict[Any, Any]] = {}
        for powers, factor in poly.terms():
            parts.setdefault(powers[tangent], {})[(*powers[:tangent], 0, *powers[tangent + 1 :])] = factor
        total = self._context.constant(0)
        for exponent, terms in parts.items():
            total = total + self._context.from_dict(terms) * self._turned(tangent, power, exponent)
        return total

    def _turned(self, tangent: int, power: int, exponent: int) -> Poly:
        """Return t^j/(1 + m t^2)^power: with C, S of half the angle it is C^(2 power - j) S^j."""
        key = tangent, power, exponent
        if key not in self._powers:
            cosine, sine, m = self._tangents[tangent]
            c, s = self._gens[cosine], self._gens[sine]
            odd, half = exponent % 2, fmpq(1, 2)
            even = ((1 + c) * half) ** ((2 * power - exponent - odd) // 2)
            turned = even * ((1 - c) * half * m) ** ((exponent - odd) // 2)
            self._powers[key] = turned * (s * half) if odd else turned
        return self._powers[key]
