"""Constants: decimal texts, read within bounds, and exact numbers of any size as doubles."""

from __future__ import annotations

import math
from fractions import Fraction

_LONGEST_TEXT = 200
_LARGEST_EXPONENT = 1000

_ALL_PLACES = 4096
"""By which the smallest double is shifted beyond the largest one, or the other way round."""


def parse_decimal(text: str) -> Fraction:
    """Return the number of a decimal text such as `-0.25` or `1e-20`.

    Raises:
        ValueError: not a decimal number.
        OverflowError: an exponent that no format holds.
    """
    if len(text) > _LONGEST_TEXT or "/" in text:
        raise ValueError(f"not a decimal constant: {text[:_LONGEST_TEXT]!r}")
    _, _, exponent = text.lower().partition("e")
    if exponent and abs(int(exponent)) > _LARGEST_EXPONENT:
        raise OverflowError(f"the constant {text} is outside every number format")
    return Fraction(text)


def nearest_double(number: Fraction) -> float:
    """Return the nearest double; an infinity beyond the largest one."""
    try:
        return float(number)
    except OverflowError:
        return math.inf if number > 0 else -math.inf


def double_shift(places: Fraction | int) -> int:
    """Return a number of places that shifts every double as far as a whole number of any size does."""
    return int(max(-_ALL_PLACES, min(_ALL_PLACES, places)))
