"""Square roots of rationals."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt


def square_root_of(number: Fraction) -> Fraction | None:
    """Return the root of a number that is the square of a rational, else None."""
    if number < 0:
        return None
    above, below = isqrt(number.numerator), isqrt(number.denominator)
    exact = above * above == number.numerator and below * below == number.denominator
    return Fraction(above, below) if exact else None
