"""Block floating point: integer mantissas with exponents, value = mantissa * 2^exponent, as int64 arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cordicc.base.arrays import Floats, Int64s

WIDE_BITS = 52
"""Bits of a mantissa that must lose nothing; below the 53 of a float64, so that it can be one."""

ZERO_EXPONENT = -4096
"""Exponent of the number 0: below that of every other, so that 0 never sets a block's exponent."""

_LARGEST_SHIFT = 62


class Scaled(NamedTuple):
    """Numbers mantissa * 2^exponent."""

    mantissa: Int64s
    exponent: Int64s


def unpack(values: Floats, bits: int) -> Scaled:
    """Return finite float64 values of at most `bits` significant bits as mantissas of exactly `bits` bits."""
    fraction, exponent = np.frexp(values)
    mantissa = (fraction * 2.0**bits).astype(np.int64)  # exact; ldexp by one number is many times slower
    exponents = exponent.astype(np.int64)
    exponents -= bits
    exponents[mantissa == 0] = ZERO_EXPONENT
    return Scaled(mantissa, exponents)


def shifted(mantissa: Int64s, right: Int64s) -> Int64s:
    """Return mantissa / 2^right rounded half up; `right` may be negative, the result must fit."""
    left = np.clip(-right, 0, _LARGEST_SHIFT)
    result = mantissa << left
    count = np.clip(right, 0, _LARGEST_SHIFT)
    result += (np.int64(1) << count) >> 1
    result >>= count
    return result


def normalise(number: Scaled, bits: int) -> Scaled:
    """Return the number with a mantissa in [2^(bits-1), 2^bits] (or 0).  Mantissas below 2^53."""
    _, length = np.frexp(number.mantissa.astype(np.float64))
    right = length.astype(np.int64)
    right -= bits
    mantissa = shifted(number.mantissa, right)
    exponent = number.exponent + right
    exponent[mantissa == 0] = ZERO_EXPONENT
    return Scaled(mantissa, exponent)


def joined(
    numbers: tuple[Scaled, ...], operand_bits: int, bits: int, least: int = ZERO_EXPONENT
) -> tuple[list[Int64s], Int64s]:
    """Bring numbers of `operand_bits` bits to one exponent, the largest mantissa having `bits` bits.

    Args:
        numbers: the numbers.
        operand_bits: of their mantissas.
        bits: of the largest mantissa.
        least: the exponent of no number counts as less.

    Returns:
        The mantissas, and the common exponent.
    """
    largest = np.maximum(numbers[0].exponent, least)
    for number in numbers[1:]:
        largest = np.maximum(largest, number.exponent)
    exponent = largest - (bits - operand_bits)
    return [shifted(n.mantissa, exponent - n.exponent) for n in numbers], exponent


def added(a: Scaled, b: Scaled) -> Scaled:
    """Return a + b at the larger exponent of the two; the mantissas must be below 2^61."""
    exponent = np.maximum(a.exponent, b.exponent)
    total = shifted(a.mantissa, exponent - a.exponent)
    total += shifted(b.mantissa, exponent - b.exponent)
    return Scaled(total, exponent)


def widened(number: Scaled, bits: int) -> Scaled:
    """Append zero bits at the low end."""
    return Scaled(number.mantissa << bits, number.exponent - bits)


def to_float(number: Scaled) -> Floats:
    """Return mantissas below 2^53 as float64; what is beyond its range becomes infinite or 0."""
    exponent = np.clip(number.exponent, -3000, 3000).astype(np.int32)
    with np.errstate(over="ignore", under="ignore"):
        result: Floats = np.ldexp(number.mantissa.astype(np.float64), exponent)
    return result
