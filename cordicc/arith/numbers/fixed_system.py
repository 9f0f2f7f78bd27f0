"""The number system of fixed point: words of one width, a binary point for every value and constant.

Adders, multipliers and sign logic compute exactly in integers and round once, to the format of the
result; only an angle's wrapping, 2 pi being irrational, is off by 2^-6 ulp before that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.arith.kernels.micro_rotations import shift_round
from cordicc.arith.kernels.shift_sequences import pi_fixed, turn_fixed
from cordicc.arith.numbers.decimals import parse_decimal
from cordicc.arith.numbers.fixed_point import (
    FRACTIONS,
    ROUNDINGS,
    SHIFT_LIMIT,
    WIDTHS,
    FixedPoint,
    ScaledIntegers,
    fraction_bits_for,
)
from cordicc.arith.numbers.formats import BinaryPoint, NumberFormat, Signal
from cordicc.arith.numbers.operations import EXACT, kept
from cordicc.arith.numbers.slack import slack_of
from cordicc.base.arrays import Integers, Words

_MOST_DIGITS = 17
WRAP_GUARD_BITS = SHIFT_LIMIT - 2 - WIDTHS.stop


@dataclass(frozen=True, slots=True)
class FixedSystem:
    """Inputs and outputs have words of `width_bits`, values between operations `guard_bits` more."""

    width_bits: int
    guard_bits: int = 0
    rounding: str = "half-up"

    def __post_init__(self) -> None:
        if self.width_bits not in WIDTHS or self.guard_bits < 0 or self.operand_bits not in WIDTHS:
            raise ValueError(
                f"words with their guard bits have {WIDTHS.start} to {WIDTHS.stop - 1} bits, "
                f"not {self.width_bits} and {self.guard_bits}"
            )
        if self.rounding not in ROUNDINGS:
            raise ValueError(f"unknown rounding {self.rounding!r} (known: {', '.join(ROUNDINGS)})")

    @property
    def operand_bits(self) -> int:
        """Bits of the words between operations."""
        return self.width_bits + self.guard_bits

    def outside(self, magnitude: float) -> FixedPoint:
        """Return the format of an input or output within +-magnitude.  Raises OverflowError."""
        return self._format_for(magnitude, self.width_bits)

    def inside(self, magnitude: float) -> FixedPoint:
        """Return the format of a value between operations, within +-magnitude.  Raises OverflowError."""
        return self._format_for(magnitude, self.operand_bits)

    def _format_for(self, magnitude: float, width: int) -> FixedPoint:
        return FixedPoint(width, fraction_bits_for(magnitude, width), self.rounding)

    def format(self, spec: BinaryPoint | None) -> FixedPoint:
        """Return the format that a plan states.  Raises ValueError."""
        if spec is None:
            raise ValueError("a fixed-point value needs a format with 'width' and 'fraction'")
        if spec.width not in (self.width_bits, self.operand_bits):
            raise ValueError(f"the words of a value have {self.width_bits} or {self.operand_bits} bits")
        if spec.fraction not in FRACTIONS:
            raise ValueError(f"a format has {FRACTIONS.start} to {FRACTIONS.stop - 1} fraction bits")
        return FixedPoint(spec.width, spec.fraction, self.rounding)

    def constant_text(self, number: Fraction) -> str:
        """Return the shortest decimal text that reads as the nearest word."""
        wanted = self._nearest(number)
        word, format_ = wanted
        # Where the nearest double lies half way between two words, no digits of it tell which is meant.
        for value in (float(number), math.ldexp(word, -format_.fraction_bits)):
            for digits in range(1, _MOST_DIGITS + 1):
                text = f"{value:.{digits}g}"
                if self._nearest(parse_decimal(text)) == wanted:
                    return text
        raise AssertionError("17 digits tell every double, and so every word")

    def constant(self, text: str) -> Signal:
        """Read a decimal text into the format with the most fraction bits that holds it."""
        word, format_ = self._nearest(parse_decimal(text))
        return Signal(np.asarray(word, dtype=np.int64), format_)

    def _nearest(self, number: Fraction) -> tuple[int, FixedPoint]:
        try:
            format_ = self.inside(abs(float(number)))
        except OverflowError:
            raise OverflowError("the constant is too large for fixed point") from None
        scaled = number * Fraction(2) ** format_.fraction_bits
        word = round(scaled)
        if abs(word) > format_.largest_word:  # rounded up to the next power of two
            format_ = FixedPoint(format_.width_bits, format_.fraction_bits - 1, self.rounding)
            word = round(scaled / 2)
        if number and abs(word).bit_length() < self.operand_bits - 1:
            raise OverflowError("the constant is too small for fixed point")
        return word, format_

    def calculate(
        self, op: str, params: Mapping[str, Any], operands: Sequence[Signal], result: NumberFormat
    ) -> Words:
        """Execute an operation exactly (wrapping to 2^-6 ulp), then round to the result's format."""
        assert isinstance(result, FixedPoint)
        numbers = [_exact(operand) for operand in operands]
        if op == "wrap":
            return result.rounded_angle(_wrapped(numbers[0], operands[0].format.width_bits))
        return result.rounded(self._exact(op, params, numbers))

    def _exact(self, op: str, params: Mapping[str, Any], numbers: list[ScaledIntegers]) -> ScaledIntegers:
        first = numbers[0]
        if op == "mul":
            return _product(first, numbers[1])
        if op == "cmul":
            return _product(first, _exact(self.constant(params["factor"])))
        if op == "shift":
            return first._replace(fraction=first.fraction - int(params["exponent"]))
        if op == "sign":
            return ScaledIntegers(np.sign(first.mantissa), 0, first.valid)
        if op not in EXACT:
            raise ValueError(f"unknown operation {op!r}")
        mantissas, fraction = _aligned(numbers)
        valid = np.logical_and.reduce(np.broadcast_arrays(*(number.valid for number in numbers)))
        if op == "guard":
            slack = math.floor(Fraction(slack_of(params).beyond) * Fraction(2) ** fraction)
            valid = valid & kept(params["condition"], mantissas[1], min(slack, 1 << SHIFT_LIMIT))
        return ScaledIntegers(EXACT[op](*mantissas), fraction, valid)

    def spec(self) -> dict[str, Any]:
        """Return the plain-data form."""
        return {
            "kind": "fixed-point",
            "width": self.width_bits,
            "guard": self.guard_bits,
            "rounding": self.rounding,
        }


def _exact(signal: Signal) -> ScaledIntegers:
    assert isinstance(signal.format, FixedPoint)
    return signal.format.exact(signal.words)


def _product(a: ScaledIntegers, b: ScaledIntegers) -> ScaledIntegers:
    """Return a b; words have at most 32 bits, so the product fits int64."""
    return ScaledIntegers(a.mantissa * b.mantissa, a.fraction + b.fraction, a.valid & b.valid)


def _aligned(numbers: list[ScaledIntegers]) -> tuple[list[Integers], int]:
    """Return the integers at the finest scale among them, as Python's where int64 might not hold a sum."""
    fraction = max(number.fraction for number in numbers)
    spread = fraction - min(number.fraction for number in numbers)
    mantissas = [number.mantissa for number in numbers]
    if spread + WIDTHS.stop >= SHIFT_LIMIT:
        mantissas = [mantissa.astype(object) for mantissa in mantissas]
    return [m << (fraction - n.fraction) for m, n in zip(mantissas, numbers, strict=True)], fraction


def wraps_in_int64(width_bits: int, fraction_bits: int) -> bool:
    """Tell whether words of angles are wrapped in 64-bit integers, to 2^-6 ulp of any result's word.

    2 pi then has `WRAP_GUARD_BITS` fraction bits more than the angle; it is wrong by 2^-(fraction + 28) a
    turn, of which there are at most 2^(width - fraction - 3).
    """
    return 2 * fraction_bits >= width_bits + 4


def _wrapped(angle: ScaledIntegers, width_bits: int) -> ScaledIntegers:
    """Return an angle in radians modulo 2 pi: angle - q 2 pi, with guard bits, within 2^-6 ulp of a word.

    q is the nearest number of turns but for the roundings of the quotient; beside a half turn either
    neighbour is right within them, and the result is rounded to pi.
    """
    if angle.fraction >= WIDTHS.stop - 2:
        return angle  # below 2, whatever the word
    mantissa, fraction, guard = angle.mantissa, angle.fraction, WRAP_GUARD_BITS
    if not wraps_in_int64(width_bits, fraction):
        # Python's integers, with a guard bit more for each bit of the number of turns.
        mantissa = mantissa.astype(object) << max(0, -fraction)
        guard = WIDTHS.stop + max(0, width_bits - fraction)
        fraction = max(0, fraction)
    quotient_bits = WIDTHS.stop - 1 if mantissa.dtype != object else guard
    turns = shift_round(mantissa * turn_fixed(0, quotient_bits), fraction + quotient_bits)
    return ScaledIntegers(
        (mantissa << guard) - turns * pi_fixed(fraction + guard + 1), fraction + guard, angle.valid
    )
