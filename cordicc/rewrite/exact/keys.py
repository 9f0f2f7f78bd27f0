"""Polynomials as keys of dictionaries, without writing them out.

The polynomials of python-flint are not hashable.  Of one field, two are equal if their terms are; the hash
looks at two of the terms.
"""

from __future__ import annotations

from typing import Any


class Key:
    """A polynomial as a key; those of equal polynomials are equal.  In order by their texts."""

    __slots__ = ("_hash", "_poly")

    def __init__(self, poly: Any) -> None:
        self._poly = poly
        size = len(poly)
        if size:
            middle = poly.coefficient(size // 2)
            number = int(middle.p), int(middle.q)
            self._hash = hash((size, number, poly.monomial(size // 2), poly.monomial(size - 1)))
        else:
            self._hash = 0

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Key) and self._hash == other._hash and bool(self._poly == other._poly)

    def __lt__(self, other: Key) -> bool:
        return str(self._poly) < str(other._poly)

    def __str__(self) -> str:
        return str(self._poly)


ElementKey = tuple[Key, Key]
"""Numerator and denominator."""

RotorKey = tuple[ElementKey, ElementKey]
"""Cosine and sine."""
