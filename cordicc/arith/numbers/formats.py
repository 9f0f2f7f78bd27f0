"""Number formats outside the units: how a value becomes a word, and a word a value.

A number system is what a target has; it gives every value, and every constant, its number format.

A word array is a NumPy array of the format's own type.  Every format has one invalid word, which
decodes to NaN; a value that leaves the format becomes invalid, never a quiet number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

import numpy as np

from cordicc.base.arrays import Floats, Words

PI_SLACK = 2.0**-24
"""Radians beyond pi that a unit's own error may reach, and that `encode_angle` still takes for pi."""


class BinaryPoint(NamedTuple):
    """The format of a fixed-point value: the bits of a word, and how many of them follow the point."""

    width: int
    fraction: int


class NumberFormat(Protocol):
    """How the words of one value stand for numbers."""

    @property
    def width_bits(self) -> int:
        """Bits of a word."""

    def encode(self, values: Floats) -> Words:
        """Round values to words; NaN and whatever the format cannot hold become the invalid word."""

    def encode_angle(self, values: Floats) -> Words:
        """Round angles in radians; one within [-pi, pi] never becomes a word beyond +-pi."""

    def decode(self, words: Words) -> Floats:
        """Return the exact values of words, NaN for the invalid word."""


class Signal(NamedTuple):
    """Words and the format in which they are to be read."""

    words: Words
    format: NumberFormat

    @property
    def values(self) -> Floats:
        """The exact values, NaN where a word is invalid."""
        return self.format.decode(self.words)


class NumberSystem(Protocol):
    """The number formats of a target: of values, of constants, and arithmetic on them."""

    @property
    def operand_bits(self) -> int:
        """The most significant bits that a word has."""

    def format(self, spec: BinaryPoint | None) -> NumberFormat:
        """Return the format that a plan states for a value, None where it states none.

        Raises ValueError.
        """

    def constant_text(self, number: Fraction) -> str:
        """Return the shortest decimal text that `constant` reads as the word nearest to a number.

        Raises OverflowError beyond the range, and for a non-zero number too small to keep all its bits.
        """

    def constant(self, text: str) -> Signal:
        """Return the word of a decimal text, ties to even.  Raises ValueError or OverflowError."""

    def calculate(
        self, op: str, params: Mapping[str, Any], operands: Sequence[Signal], result: NumberFormat
    ) -> Words:
        """Execute an operation of adders, multipliers and sign logic, rounding its exact result once.

        A factor among the parameters is the text of a constant; a guard may have a slack besides, by which
        its condition may be missed, see `slack_of`.  An invalid operand makes the result invalid.

        Raises ValueError for an unknown operation.
        """

    def spec(self) -> dict[str, Any]:
        """Return the plain data from which `system_from_spec` builds this system."""


@dataclass(frozen=True, slots=True)
class IeeeSingle:
    """IEEE 754 single precision; NaN is the invalid word, infinities are never stored."""

    width_bits: int = 32

    def encode(self, values: Floats) -> Words:
        """Round to nearest even, with gradual underflow; overflow becomes NaN."""
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            words = np.asarray(values, dtype=np.float64).astype(np.float32)
        return _without_infinities(words)

    def encode_angle(self, values: Floats) -> Words:
        """Round to nearest even, but from at most pi to at most `SINGLE_PI`."""
        words = np.asarray(self.encode(values))
        over = np.abs(words) > SINGLE_PI
        if over.any():
            over &= np.abs(values) <= math.pi + PI_SLACK
            words[over] = np.copysign(SINGLE_PI, words[over])
        return words

    def decode(self, words: Words) -> Floats:
        """Return the words as float64, exactly."""
        return np.asarray(words, dtype=np.float32).astype(np.float64)


SINGLE_PI = np.uint32(0x40490FDA).view(np.float32)
"""The largest single-precision number that is at most pi."""

SINGLE = IeeeSingle()


def _without_infinities(words: Words) -> Words:
    words = np.asarray(words)
    infinite = np.isinf(words)
    if infinite.any():
        words = np.where(infinite, np.float32(np.nan), words)
    return words
