"""Number formats outside the units: how a value becomes a word, and a word a value.

A word array is a NumPy array of the format's own type.  Every format has one invalid word, which
decodes to NaN; a value that leaves the format becomes invalid, never a quiet number.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Word = NDArray[Any]
FloatArray = NDArray[np.float64]

PI_SLACK = 2.0**-24
"""Radians beyond pi that a unit's own error may reach, and that `encode_angle` still takes for pi."""


class NumberFormat(Protocol):
    """What a unit, a simulator and a plan need to know of a number format."""

    @property
    def width_bits(self) -> int:
        """Bits of a word."""

    def encode(self, values: FloatArray) -> Word:
        """Round values to words; NaN and whatever the format cannot hold become the invalid word."""

    def encode_angle(self, values: FloatArray) -> Word:
        """Round angles in radians; one within [-pi, pi] never becomes a word beyond +-pi."""

    def decode(self, words: Word) -> FloatArray:
        """Return the exact values of words, NaN for the invalid word."""

    def constant(self, number: Fraction) -> Word:
        """Return the word nearest to a number, ties to even.

        Raises OverflowError beyond the range, and for a non-zero number too small to keep all its bits.
        """

    def constant_text(self, number: Fraction) -> str:
        """Return the shortest decimal text that reads back as `constant(number)`; raises as it does."""

    def parse_constant(self, text: str) -> Word:
        """Return the word of a decimal text.  Raises ValueError or OverflowError."""

    def spec(self) -> dict[str, Any]:
        """Return the plain data from which `format_from_spec` builds this format."""


@dataclass(frozen=True, slots=True)
class IeeeSingle:
    """IEEE 754 single precision; NaN is the invalid word, infinities are never stored."""

    width_bits: int = 32

    def encode(self, values: FloatArray) -> Word:
        """Round to nearest even, with gradual underflow; overflow becomes NaN."""
        with np.errstate(over="ignore", invalid="ignore", under="ignore"):
            words = np.asarray(values, dtype=np.float64).astype(np.float32)
        return _without_infinities(words)

    def encode_angle(self, values: FloatArray) -> Word:
        """Round to nearest even, but from at most pi to at most `SINGLE_PI`."""
        words = np.asarray(self.encode(values))
        over = np.abs(words) > SINGLE_PI
        if over.any():
            over &= np.abs(values) <= math.pi + PI_SLACK
            words[over] = np.copysign(SINGLE_PI, words[over])
        return words

    def decode(self, words: Word) -> FloatArray:
        """Return the words as float64, exactly."""
        return np.asarray(words, dtype=np.float32).astype(np.float64)

    def constant(self, number: Fraction) -> Word:
        """Round a rational once, ties to even.  Raises OverflowError."""
        return np.asarray(_nearest_single(number))

    def constant_text(self, number: Fraction) -> str:
        """Return the shortest text, such as `0.1` or `1e-20`."""
        return str(_nearest_single(number))

    def parse_constant(self, text: str) -> Word:
        """Read a decimal text.  Raises ValueError, or OverflowError beyond the format."""
        if len(text) > _LONGEST_TEXT or "/" in text:
            raise ValueError(f"not a decimal constant: {text[:_LONGEST_TEXT]!r}")
        _, _, exponent = text.lower().partition("e")
        if exponent and abs(int(exponent)) > _LARGEST_TEXT_EXPONENT:
            raise OverflowError(f"the constant {text} is outside IEEE single")
        return self.constant(Fraction(text))

    def spec(self) -> dict[str, Any]:
        """Return the plain-data form."""
        return {"kind": "ieee-single"}


SINGLE_PI = np.uint32(0x40490FDA).view(np.float32)
"""The largest single-precision number that is at most pi."""

SINGLE = IeeeSingle()

_LONGEST_TEXT = 200
_LARGEST_TEXT_EXPONENT = 1000
_LARGEST_SINGLE = Fraction(2**24 - 1) * 2**104
_OVERFLOW_FROM = Fraction(2**25 - 1) * 2**103
_SMALLEST_NORMAL = 2.0**-126


def _without_infinities(words: Word) -> Word:
    words = np.asarray(words)
    infinite = np.isinf(words)
    if infinite.any():
        words = np.where(infinite, np.float32(np.nan), words)
    return words


def _nearest_single(number: Fraction) -> np.float32:
    magnitude = abs(number)
    if magnitude >= _OVERFLOW_FROM:
        raise OverflowError("the constant is outside IEEE single")
    if magnitude == 0:
        return np.float32(0)
    exponent = magnitude.numerator.bit_length() - magnitude.denominator.bit_length()
    if magnitude < Fraction(2) ** exponent:
        exponent -= 1
    mantissa = round(magnitude / Fraction(2) ** (exponent - 23))
    value = math.ldexp(mantissa, exponent - 23)
    if value < _SMALLEST_NORMAL:
        raise OverflowError("the constant is too small for IEEE single, whose least normal number is 1.2e-38")
    return np.float32(-value if number < 0 else value)


def format_from_spec(spec: Mapping[str, Any]) -> NumberFormat:
    """Build a format from its plain-data form.  Raises ValueError."""
    if not isinstance(spec, Mapping) or set(spec) != {"kind"}:
        raise ValueError("the number format needs a 'kind' and nothing else")
    if spec["kind"] != "ieee-single":
        raise ValueError(f"unknown number format {spec['kind']!r} (known: ieee-single)")
    return SINGLE
