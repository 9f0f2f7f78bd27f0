"""Two's-complement fixed point: a binary point for every value, words in int64 arrays.

A word w of a format with F fraction bits stands for w 2^-F.  The least code, -2^(width-1), is the invalid
word, so that the range is symmetric: +-(2^(width-1) - 1) 2^-F.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.base.arrays import Bools, Floats, Words

WIDTHS = range(4, 33)
"""Word widths in bits that a format may have."""

FRACTIONS = range(-160, 161)
"""Fraction bits that a format may have."""

SHIFT_LIMIT = 62
"""Integers of an int64 array stay below 2^`SHIFT_LIMIT`; wider ones are Python's, in object arrays."""


class ScaledIntegers(NamedTuple):
    """Integers m that stand for m 2^-fraction, and where they are valid."""

    mantissa: NDArray[Any]
    fraction: int
    valid: Bools


def _half_up(value: NDArray[Any], shift: int) -> NDArray[Any]:
    return (value + (1 << (shift - 1))) >> shift


def _half_even(value: NDArray[Any], shift: int) -> NDArray[Any]:
    odd = (value >> shift) & 1
    return np.asarray((value + ((1 << (shift - 1)) - 1 + odd)) >> shift)


def _floor(value: NDArray[Any], shift: int) -> NDArray[Any]:
    return value >> shift


_SHIFTS: dict[str, Callable[[NDArray[Any], int], NDArray[Any]]] = {
    "half-up": _half_up,
    "half-even": _half_even,
    "floor": _floor,
}

ROUNDINGS = tuple(_SHIFTS)
"""To nearest with ties up, to nearest with ties to even, and down (truncation)."""


@dataclass(frozen=True, slots=True)
class FixedPoint:
    """A format of `width_bits` bits with `fraction_bits` of them, perhaps less than 0, after the point."""

    width_bits: int
    fraction_bits: int
    rounding: str = "half-up"

    @property
    def largest_word(self) -> int:
        """The largest word; its negative is the least valid one."""
        return (1 << (self.width_bits - 1)) - 1

    @property
    def invalid_word(self) -> int:
        """The word that stands for no number."""
        return -(1 << (self.width_bits - 1))

    @property
    def ulp(self) -> float:
        """The distance of neighbouring values."""
        return math.ldexp(1.0, -self.fraction_bits)

    def encode(self, values: Floats) -> Words:
        """Round values of at most 53 bits once; beyond the range they become invalid."""
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            scaled = np.ldexp(np.asarray(values, dtype=np.float64), self.fraction_bits)
            down = np.floor(scaled)
            rest = scaled - down
            if self.rounding == "half-up":
                down += rest >= 0.5
            elif self.rounding == "half-even":
                down = np.rint(scaled)
            inside = np.abs(down) <= self.largest_word
        return np.where(inside, down, self.invalid_word).astype(np.int64)

    def encode_angle(self, values: Floats) -> Words:
        """Round angles in radians, but from at most pi (and a quarter ulp) to at most pi."""
        return self._within_pi(self.encode(values), values)

    def _within_pi(self, words: Words, values: Floats) -> Words:
        if self.width_bits - self.fraction_bits < 3:
            return words  # pi is out of range
        largest = math.floor(math.ldexp(math.pi, self.fraction_bits))
        over = (np.abs(words) > largest) & (np.abs(values) <= math.pi + self.ulp / 4)
        over &= np.asarray(words) != self.invalid_word  # whatever an invalid operand's bits say
        return np.where(over, np.sign(words) * largest, words)

    def decode(self, words: Words) -> Floats:
        """Return the exact values of words, NaN for the invalid word."""
        numbers = np.ldexp(np.asarray(words).astype(np.float64), -self.fraction_bits)
        return np.where(np.asarray(words) == self.invalid_word, np.nan, numbers)

    def exact(self, words: Words) -> ScaledIntegers:
        """Return words as integers with their validity."""
        return ScaledIntegers(words, self.fraction_bits, np.asarray(words) != self.invalid_word)

    def rounded(self, number: ScaledIntegers) -> Words:
        """Round integers of any scale once; beyond the range they become invalid."""
        mantissa, down = number.mantissa, number.fraction - self.fraction_bits
        if down > 0:
            if mantissa.dtype != object and down >= SHIFT_LIMIT:
                mantissa = mantissa.astype(object)
            mantissa = _SHIFTS[self.rounding](mantissa, down)
        elif down < 0:
            room = self.largest_word >> min(-down, self.width_bits)
            fits = np.abs(mantissa) <= room
            mantissa = np.where(fits, mantissa, 0) << np.where(fits & (mantissa != 0), -down, 0)
            mantissa = np.where(fits, mantissa, self.invalid_word)
        inside = number.valid & np.asarray(np.abs(mantissa) <= self.largest_word, dtype=bool)
        return np.where(inside, mantissa, self.invalid_word).astype(np.int64)

    def rounded_angle(self, number: ScaledIntegers) -> Words:
        """Round angles in radians as `rounded` does, but from at most pi to at most pi."""
        values = np.ldexp(number.mantissa.astype(np.float64), -number.fraction)
        return self._within_pi(self.rounded(number), values)

    @property
    def binary_point(self) -> BinaryPoint:
        """Return what a plan states of the format; its rounding is the system's."""
        return BinaryPoint(self.width_bits, self.fraction_bits)


def fraction_bits_for(magnitude: float, width_bits: int) -> int:
    """Return the most fraction bits with which words of a width hold +-magnitude.

    Raises OverflowError if even the fewest do not.
    """
    if not magnitude < math.inf:
        raise OverflowError("no format holds an unbounded value")
    largest = (1 << (width_bits - 1)) - 1
    fraction = width_bits - 1 - math.frexp(magnitude)[1] if magnitude else width_bits - 1
    if math.ldexp(magnitude, fraction) > largest:
        fraction -= 1
    if fraction < FRACTIONS.start:
        raise OverflowError("the value is too large for every format")
    return min(fraction, FRACTIONS.stop - 1)
