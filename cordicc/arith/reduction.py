"""Argument reduction before the micro-rotations, and what follows them: gain, angle sums, alignment."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.blocks import (
    MANTISSA_BITS,
    ZERO_EXPONENT,
    Int64,
    Scaled,
    joined,
    normalise,
    shifted,
    to_float,
    unpack,
    widened,
)
from cordicc.arith.formats import FloatArray
from cordicc.arith.sequences import GAIN_BITS, StepTable, inverse_ln2_fixed, ln2_fixed, pi_fixed, turn_fixed

ANGLE_BITS = 32
"""Fraction bits of an angle in radians inside a unit."""

SUM_GUARD_BITS = 28
"""Zero bits appended to 24-bit mantissas before x + y and x - y, which then are exact to 2^-52."""

_PRODUCT_DROP = 12
_LN2_BITS = 48
_PHASE_EXPONENTS = range(-176, 129)


class Reduced(NamedTuple):
    """A reduced argument: a multiple of the period (or of ln 2), and the rest with `ANGLE_BITS`."""

    multiple: Int64
    remainder: Int64


def reduce_circular(angle: Scaled) -> Reduced:
    """Return the quadrant 0..3 and the remainder in [-pi/4, pi/4] of any angle, to 2^-31 rad.

    The phase in turns is mantissa * 2^exponent/(2 pi) modulo 1, a product modulo 2^64; its error is at
    most half of the constant's last place times 2^24, that is 2^-41 turn.
    """
    phase = _phase(angle)
    quadrant = (phase + np.uint64(1 << 61)) >> np.uint64(62)
    rest = (phase - (quadrant << np.uint64(62))).view(np.int64)
    rest >>= 31
    rest *= pi_fixed(29)  # 2 pi with 28 fraction bits
    return Reduced((quadrant & np.uint64(3)).astype(np.int64), shifted_by(rest, 61 - ANGLE_BITS))


def phase_in_turns(angle: Scaled) -> FloatArray:
    """Return an angle in radians modulo one turn, in [-1/2, 1/2] turns, to 2^-41."""
    return np.ldexp(_phase(angle).view(np.int64).astype(np.float64), -64)


def _phase(angle: Scaled) -> NDArray[np.uint64]:
    constants = _phase_constants()
    index = np.clip(angle.exponent, _PHASE_EXPONENTS.start, _PHASE_EXPONENTS.stop - 1)
    phase = angle.mantissa.astype(np.uint64)
    phase *= constants[index - _PHASE_EXPONENTS.start]
    return phase


def reduce_hyperbolic(z: FloatArray) -> Reduced:
    """Return q and r with z = q ln 2 + r, |r| <= 0.35; |z| saturates at 512, far beyond any result."""
    bounded = np.clip(z, -512.0, 512.0)
    number = unpack(bounded)
    fixed_z = shifted(number.mantissa, -ANGLE_BITS - number.exponent)
    doublings = shifted_by((fixed_z >> 16) * inverse_ln2_fixed(30), 46)
    return Reduced(doublings, fixed_z - ln2_multiple(doublings))


def sum_and_difference(x: Scaled, y: Scaled, bits: int) -> tuple[Scaled, Scaled]:
    """Return x + y and x - y with mantissas of `bits` bits, to a relative 2^-bits."""
    (a, b), exponent = joined((x, y), MANTISSA_BITS + SUM_GUARD_BITS)
    return normalise(Scaled(a + b, exponent), bits), normalise(Scaled(a - b, exponent.copy()), bits)


def angle_sum(z: Scaled, angle: Int64) -> FloatArray:
    """Return z + angle in radians: `ANGLE_BITS` fraction bits while |z| < 16, fewer beyond."""
    exponent = np.maximum(z.exponent - (36 - MANTISSA_BITS), -ANGLE_BITS)
    total = shifted(z.mantissa, exponent - z.exponent)
    total += shifted(angle, exponent + ANGLE_BITS)
    return to_float(Scaled(total, exponent))


def ln2_multiple(count: Int64) -> Int64:
    """Return count * ln 2 with `ANGLE_BITS`, for |count| <= 2^14."""
    return shifted_by(count * ln2_fixed(_LN2_BITS), _LN2_BITS - ANGLE_BITS)


def shifted_by(value: Int64, count: int) -> Int64:
    """Return value / 2^count rounded half up, in place."""
    value += 1 << (count - 1)
    value >>= count
    return value


def compensated(coordinate: Int64, exponent: Int64, table: StepTable) -> Scaled:
    """Divide by the gain: a product with its constant reciprocal, kept to 48 bits."""
    product = coordinate * table.inverse_gain
    return Scaled(shifted_by(product, _PRODUCT_DROP), exponent - (GAIN_BITS - _PRODUCT_DROP))


def padded(number: Scaled, bits: int) -> Scaled:
    """Append guard bits; the number 0 keeps the exponent of 0."""
    wide = widened(number, bits)
    return Scaled(wide.mantissa, np.where(wide.mantissa == 0, ZERO_EXPONENT, wide.exponent))


@cache
def _phase_constants() -> NDArray[np.uint64]:
    """Return 2^e/(2 pi) modulo 1 with 64 fraction bits for each exponent e."""
    turns = [turn_fixed(exponent, 64) % 2**64 for exponent in _PHASE_EXPONENTS]
    return np.array(turns, dtype=np.uint64)
