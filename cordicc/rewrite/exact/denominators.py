"""Denominators as products of powers of irreducible polynomials.

A problem has few of them: 1 + t^2 of its angles, and the squares of its norms.  A numerator is brought to
lowest terms by dividing it by each as often as it goes, which is much less work than a greatest common
divisor: a division that does not go ends at its first terms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from flint.utils.flint_exceptions import DomainError

from cordicc.rewrite.exact.keys import Key

Powers = tuple[tuple[int, int], ...]
"""Factors by number, in order, and their exponents, all of them positive."""

_TERMS = 1_000
"""Longer polynomials are not factored."""


class Denominators:
    """Numbers the irreducible factors, all monic, and multiplies each product out once."""

    def __init__(self, one: Any, times: Callable[[Any, Any], Any]) -> None:
        self._times = times
        self._factors: list[Any] = []
        self._numbers: dict[Key, int] = {}
        self._products: dict[Powers, Any] = {(): one}
        self._known: dict[Key, Powers | None] = {}

    def of(self, poly: Any) -> Powers | None:
        """Return a polynomial other than 0, made monic, by its factors; None if it is too long for that."""
        key = Key(poly)
        if key not in self._known:
            self._known[key] = self._factored(poly)
        return self._known[key]

    def _factored(self, poly: Any) -> Powers | None:
        found = {}
        for index in range(len(self._factors)):
            poly, found[index] = self._divided(poly, index)
        if len(poly) > _TERMS:
            return None
        for base, exponent in poly.factor()[1]:
            factor = base / base.leading_coefficient()
            index = self._numbers.setdefault(Key(factor), len(self._factors))
            if index == len(self._factors):
                self._factors.append(factor)
            found[index] = exponent
        return tuple((index, power) for index, power in sorted(found.items()) if power)

    def holds(self, generator: int) -> bool:
        """Tell whether a generator occurs in a factor."""
        return any(factor.degrees()[generator] for factor in self._factors)

    def product(self, powers: Powers) -> Any:
        """Return the monic polynomial with some factors."""
        if powers not in self._products:
            *rest, (index, power) = powers
            less = (*rest, (index, power - 1)) if power > 1 else tuple(rest)
            self._products[powers] = self._times(self.product(less), self._factors[index])
        return self._products[powers]

    def lowest(self, num: Any, powers: Powers, among: Iterable[int]) -> tuple[Any, Powers]:
        """Return a numerator other than 0 and its denominator without the common ones of some factors."""
        left = dict(powers)
        for index in among:
            num, count = self._divided(num, index, left[index])
            left[index] -= count
        return num, tuple((index, power) for index, power in left.items() if power)

    def _divided(self, poly: Any, index: int, most: int | None = None) -> tuple[Any, int]:
        """Divide by a factor as often as it goes, `most` times at the most."""
        count = 0
        while count != most:
            try:
                poly = poly / self._factors[index]
            except DomainError:
                break
            count += 1
        return poly, count
