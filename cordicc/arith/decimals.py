"""Decimal texts of constants, read without limit of digits but not without bound."""

from __future__ import annotations

from fractions import Fraction

_LONGEST_TEXT = 200
_LARGEST_EXPONENT = 1000


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
