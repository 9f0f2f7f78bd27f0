"""Argument reduction before the micro-rotations, and what follows them: gain, angle sums, alignment."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.kernels.blocks import (
    WIDE_BITS,
    ZERO_EXPONENT,
    Scaled,
    joined,
    normalise,
    shifted,
    to_float,
    unpack,
    widened,
)
from cordicc.arith.kernels.micro_rotations import multiply_round
from cordicc.arith.kernels.shift_sequences import (
    StepTable,
    inverse_ln2_fixed,
    ln2_fixed,
    pi_fixed,
    turn_fixed,
)
from cordicc.base.arrays import Floats, Int64s

LN2_BITS = 48
SCALE_BITS = 4
TAU_BITS = 37
TURN_BITS = 64
TURN_TAIL_BITS = 30
PHASE_EXPONENTS = range(-192, 161)
"""Of operands whose phase is known: singles, and words with the most and the fewest fraction bits."""

THRESHOLD_BITS = 6
"""Fraction bits of the angles at which a reduction by a table goes on to the next quarter turn."""

LARGEST_REMAINDER = math.pi / 4 + 2.0 ** -(THRESHOLD_BITS + 1) + 2.0**-12
"""What a reduction by a table leaves of an angle at most, its roundings included."""

QUARTER_GUARD_BITS = 4
"""Bits below an angle's last with which a table of quarter turns is compared and subtracted, at most."""

_PI_GUARD_BITS = 64
_LARGEST_MAGNITUDE = 4
"""Binary places before the point of an angle that a table reduces: up to 16 rad."""


class Reduced(NamedTuple):
    """A reduced argument: a multiple of the period (or of ln 2), and the rest as a fixed-point angle."""

    multiple: Int64s
    remainder: Int64s


@dataclass(frozen=True, slots=True)
class QuarterTurns:
    """The quarter turns that an angle may have, with `fraction_bits` bits after the binary point.

    `thresholds` are pi/4, 3 pi/4, ... as far as the angle may reach, each to the nearest multiple of
    2^-`THRESHOLD_BITS`; `multiples` are 0, pi/2, pi, ..., one more, rounded to nearest.  Both sides of 0 are
    alike.
    """

    fraction_bits: int
    thresholds: tuple[int, ...]
    multiples: tuple[int, ...]


@cache
def quarter_turns(angle_bits: int, width_bits: int, fraction_bits: int) -> QuarterTurns | None:
    """Return the table that reduces angles in radians of a fixed-point format, None where it would be large.

    Args:
        angle_bits: fraction bits of the angles in a unit.
        width_bits: of the format's words, two's complement; the least code stands for no angle.
        fraction_bits: of the format.  With M = 2^(`width_bits` - 1 - `fraction_bits`) every angle is below M;
            there is a table up to M = 16, with at most ten thresholds, and none is needed below pi/4.
    """
    places = width_bits - 1 - fraction_bits
    if places > _LARGEST_MAGNITUDE:
        return None
    bits = max(angle_bits, min(fraction_bits, angle_bits + QUARTER_GUARD_BITS))
    count = 0
    while (2 * count + 1) * (math.pi / 4) <= math.ldexp(1.0, places):
        count += 1
    return QuarterTurns(
        bits,
        tuple(
            _eighths_of_turn(2 * k - 1, THRESHOLD_BITS) << (bits - THRESHOLD_BITS)
            for k in range(1, count + 1)
        ),
        tuple(_eighths_of_turn(2 * k, bits) for k in range(count + 1)),
    )


def _eighths_of_turn(count: int, fraction_bits: int) -> int:
    """Return count * pi/4, rounded to nearest."""
    exact = count * pi_fixed(fraction_bits + _PI_GUARD_BITS)  # times 4
    return (exact + (1 << (_PI_GUARD_BITS + 1))) >> (_PI_GUARD_BITS + 2)


def reduce_by_table(angle: Scaled, quarters: QuarterTurns, angle_bits: int) -> Reduced:
    """Return the quadrant 0..3 and the remainder of angles of the format that a table was made for.

    Let A be the `angle_bits` and G >= A the table's bits.  The angle is rounded half up to z with G bits; k
    is how many thresholds z has reached, less those that it is beyond on the other side of 0; the remainder
    is z - k pi/2, rounded half up to A bits.  Its error in units of 2^-A:

    - G = A: the format has no more than A bits and z is exact, and so is the difference; what is left is the
      rounding of k pi/2, at most 1/2.
    - A < G < A + 4: G is the format's own and z exact; the multiple is off by at most 2^(A-G)/2 and the last
      rounding by 1/2, in all at most 3/4.
    - G = A + 4: z and the multiple are off by at most 1/32 each, in all 9/16.

    Where no angle reaches pi/4 the multiple is 0 and exact.  A threshold is off by at most half of its place,
    so the remainder is within `LARGEST_REMAINDER`.  The micro-rotations converge up to 99 degrees.
    """
    bits = quarters.fraction_bits
    rest = shifted(angle.mantissa, -bits - angle.exponent)
    thresholds = np.array(quarters.thresholds, dtype=np.int64)
    multiples = np.array(quarters.multiples, dtype=np.int64)
    above = np.searchsorted(thresholds, rest, side="right")
    below = np.searchsorted(thresholds, -rest, side="left")
    rest += multiples[below] - multiples[above]
    if bits > angle_bits:
        rest = shifted_by(rest, bits - angle_bits)
    return Reduced((above - below) & 3, rest)


def reduce_circular(angle: Scaled, angle_bits: int) -> Reduced:
    """Return the quadrant 0..3 and the remainder in [-pi/4, pi/4] of any angle, by a product.

    The phase in turns is mantissa * 2^exponent/(2 pi) modulo 1, a product modulo 2^64 with a constant of
    94 fraction bits; its error is below 2^-62 turn.  The remainder errs by 0.9 of a unit of
    the `angle_bits` more (half, and 0.39 for the three bits below it, in turns), and by 2^-41 rad for the
    rounding of 2 pi.
    """
    phase = _phase(angle)
    quadrant = (phase + np.uint64(1 << 61)) >> np.uint64(62)
    rest = (phase - (quadrant << np.uint64(62))).view(np.int64)
    # 3 bits are below the angle's last; |rest| <= 2^-3 turn.
    rest = shifted_by(rest, TURN_BITS - angle_bits - 3)
    remainder = multiply_round(rest, pi_fixed(TAU_BITS + 1), TAU_BITS + 3, angle_bits)
    return Reduced((quadrant & np.uint64(3)).astype(np.int64), remainder)


def phase_in_turns(angle: Scaled) -> Floats:
    """Return an angle in radians modulo one turn, in [-1/2, 1/2] turns, to 2^-54."""
    return np.ldexp(_phase(angle).view(np.int64).astype(np.float64), -TURN_BITS)


def _phase(angle: Scaled) -> NDArray[np.uint64]:
    """Return the phase of mantissas of at most 32 bits with 64 fraction bits, modulo 1."""
    heads, tails = phase_constants()
    index = np.clip(angle.exponent, PHASE_EXPONENTS.start, PHASE_EXPONENTS.stop - 1) - PHASE_EXPONENTS.start
    phase = angle.mantissa.astype(np.uint64)
    phase *= heads[index]
    phase += ((angle.mantissa * tails[index]) >> TURN_TAIL_BITS).astype(np.uint64)
    return phase


def reduce_hyperbolic(z: Floats, operand_bits: int, angle_bits: int) -> Reduced:
    """Return q and r with z = q ln 2 + r, |r| <= 0.35; |z| saturates at 512, far beyond any result."""
    bounded = np.clip(z, -512.0, 512.0)
    number = unpack(bounded, operand_bits)
    fixed_z = shifted(number.mantissa, -angle_bits - number.exponent)
    down, up = max(0, angle_bits - 16), max(0, 16 - angle_bits)  # to 16 fraction bits
    doublings = shifted_by((fixed_z >> down << up) * inverse_ln2_fixed(30), 46)
    return Reduced(doublings, fixed_z - ln2_multiple(doublings, angle_bits))


def sum_and_difference(x: Scaled, y: Scaled, operand_bits: int, bits: int) -> tuple[Scaled, Scaled]:
    """Return x + y and x - y with mantissas of `bits` bits, to 2^-bits relative and 2^-52 of the larger."""
    (a, b), exponent = joined((x, y), operand_bits, WIDE_BITS)
    return normalise(Scaled(a + b, exponent), bits), normalise(Scaled(a - b, exponent.copy()), bits)


def angle_sum(z: Scaled, angle: Int64s, operand_bits: int, angle_bits: int) -> Floats:
    """Return z + angle in radians: all bits of the angle while |z| < 2^(50 - angle_bits), fewer beyond."""
    exponent = np.maximum(z.exponent - (WIDE_BITS - 2 - operand_bits), -angle_bits)
    total = shifted(z.mantissa, exponent - z.exponent)
    total += shifted(angle, exponent + angle_bits)
    return to_float(Scaled(total, exponent))


def ln2_multiple(count: Int64s, angle_bits: int) -> Int64s:
    """Return count * ln 2 as a fixed-point angle, for |count| <= 2^14."""
    return shifted_by(count * ln2_fixed(LN2_BITS), LN2_BITS - angle_bits)


def shifted_by(value: Int64s, count: int) -> Int64s:
    """Return value / 2^count rounded half up, in place."""
    value += 1 << (count - 1)
    value >>= count
    return value


def compensated(coordinate: Int64s, exponent: Int64s, table: StepTable) -> Scaled:
    """Divide by the gain: a product with its constant reciprocal, which keeps four more bits.

    The reciprocal has one fraction bit more than a coordinate has bits, so the quotient errs by an
    eighth of the coordinate's unit after standard iterations, by a sixth after root-free ones.
    """
    shift = table.coordinate_bits + 1 - SCALE_BITS
    product = multiply_round(coordinate, table.inverse_gain, shift, table.coordinate_bits)
    return Scaled(product, exponent - SCALE_BITS)


def padded(number: Scaled, bits: int) -> Scaled:
    """Append guard bits; the number 0 keeps the exponent of 0."""
    wide = widened(number, bits)
    return Scaled(wide.mantissa, np.where(wide.mantissa == 0, ZERO_EXPONENT, wide.exponent))


@cache
def phase_constants() -> tuple[NDArray[np.uint64], NDArray[np.int64]]:
    """Return 2^e/(2 pi) modulo 1 for each exponent e: 64 fraction bits, and the 30 after them."""
    bits = TURN_BITS + TURN_TAIL_BITS
    turns = [turn_fixed(exponent, bits) % (1 << bits) for exponent in PHASE_EXPONENTS]
    heads = np.array([turn >> TURN_TAIL_BITS for turn in turns], dtype=np.uint64)
    tails = np.array([turn & ((1 << TURN_TAIL_BITS) - 1) for turn in turns], dtype=np.int64)
    return heads, tails
