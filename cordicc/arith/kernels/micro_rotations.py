"""The micro-rotations, one function an iteration kind, on arrays of integers.

Coordinates are integers with any common number of fraction bits, angles with the `angle_bits` of the
table.  The functions run unchanged on int64 arrays and on object arrays of Python integers; they
return new arrays.  Every shift rounds half up: half of the last place is added before an arithmetic
shift.  sgn(0) = +1 throughout.

Width: a coordinate never exceeds the start's norm times the gain (below 4, if the start's components
are at most 1) plus one unit a step, so 29 fraction bits need 32-bit mantissas.  In int64 coordinates may
reach 2^44 (`COORDINATE_BITS`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cordicc.arith.kernels.shift_sequences import COORDINATE_BITS, FACTOR_BITS, SHARES, StepTable
from cordicc.arith.kernels.thresholds import before_step
from cordicc.base.arrays import Integers

Work = tuple[Integers, Integers, Integers]


NEVER = -1
"""Below 0 before every step."""


class NearEnd(NamedTuple):
    """Where x >= 0 and |target - y| are at most this, an implicit kernel turns to the end of reach.

    See `end_of_reach`.  A negative target - y counts as its bits inverted, so that it may be one place more.
    Multiples of `SHARES` less 1, or arrays of one for each sample, of the whole gain; the height `NEVER`
    keeps a sample from it.
    """

    height: Integers | int
    width: Integers | int

    def before(self, stretched: int) -> NearEnd:
        """Return what holds before a step, from the gain so far as a share of the whole one."""
        if stretched == SHARES:
            return self
        return NearEnd(*(before_step(each, stretched) for each in self))


def shift_round(value: Integers, shift: int, out: Integers | None = None) -> Integers:
    """Return value / 2^shift rounded half up, in a new array or in `out`, which may be `value`."""
    if shift <= 0:
        return np.left_shift(value, -shift, out=out)
    if shift > 63 and value.dtype != object:  # every int64 is at most half of 2^64 in magnitude
        return np.multiply(value, 0, out=out)
    result: Integers = np.add(value, 1 << (shift - 1), out=out)
    result >>= shift
    return result


def multiply_round(value: Integers, constant: int, shift: int, value_bits: int = COORDINATE_BITS) -> Integers:
    """Return value * constant / 2^shift rounded half up, in a new array.

    Exact on Python integers of any size, and in int64 where |value| <= 2^value_bits although the product
    may not fit: it is then formed limb by limb, with limbs so narrow that each partial product does fit.
    `value_bits` decides on the number of limbs, never on the result.

    Raises:
        ValueError: in int64, for |constant| >= 2^61 or a shift outside 1 to 62, or so much below
            `value_bits` that the lower limbs alone need more.
    """
    if value.dtype == object:
        return shift_round(value * constant, shift)
    constant_bits = constant.bit_length()  # of the magnitude
    if value_bits + constant_bits < shift:  # the quotient is below a half
        return np.zeros_like(value)
    lower_limbs, limb_bits = limbs(constant, shift, value_bits)
    if not lower_limbs:
        return shift_round(value * constant, shift)
    high, carry = value, np.full_like(value, 1 << (shift - 1))
    for _ in range(lower_limbs):
        carry += (high & ((1 << limb_bits) - 1)) * constant
        carry >>= limb_bits
        high = high >> limb_bits
    high = high * constant
    high += carry
    high >>= shift - lower_limbs * limb_bits
    return high


def limbs(constant: int, shift: int, value_bits: int) -> tuple[int, int]:
    """Return how many lower limbs `multiply_round` splits off, and their bits.  Raises ValueError."""
    constant_bits = constant.bit_length()  # of the magnitude
    # With value = high 2^k + low, 0 <= low < 2^k and k <= shift,
    #   floor((value c + half) / 2^shift) = floor((high c + floor((low c + half) / 2^k)) / 2^(shift - k)),
    # for floor(floor(u / 2^k) / 2^j) = floor(u / 2^(k + j)) and high c is an integer.  Repeated on `high`.
    # With |c| < 2^(62 - k), |low c| < 2^62 and half <= 2^61, so every sum is below 2^63.
    room = max(1, 62 - constant_bits)
    excess = max(0, value_bits - room)
    lower_limbs = -(-excess // room)
    limb_bits = -(-excess // max(1, lower_limbs))
    if constant_bits > 61 or not 1 <= shift <= 62 or lower_limbs * limb_bits > shift:
        raise ValueError(f"{value_bits}-bit values times {constant} / 2^{shift} do not fit int64")
    return lower_limbs, limb_bits


def sign(value: Integers, out: Integers | None = None) -> Integers:
    """Return -1 where value < 0, else +1: sgn(0) = +1; as integers of the same type, perhaps in `out`."""
    if value.dtype == object:
        return np.where(value < 0, -1, 1).astype(object)
    result: Integers = np.right_shift(value, 8 * value.itemsize - 1, out=out)
    result |= 1
    return result


def rotate(x: Integers, y: Integers, z: Integers, table: StepTable) -> tuple[Integers, Integers, Integers]:
    """Turn (x, y) by z: Walther's rotation mode, z driven to 0 (vector stretched by the gain)."""
    x, y, z = x.copy(), y.copy(), z.copy()
    work = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    for shift, angle in zip(table.shifts, table.angles, strict=True):
        direction = sign(z, work[0])
        _turn(table.m, x, y, direction, shift, work)
        direction *= angle
        z -= direction
    return x, y, z


def vector(x: Integers, y: Integers, z: Integers, table: StepTable) -> tuple[Integers, Integers, Integers]:
    """Turn (x, y), x >= 0, until y = 0: Walther's vectoring mode; z gains the angle of (x, y)."""
    x, y, z = x.copy(), y.copy(), z.copy()
    side, step_x, step_y = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    for shift, angle in zip(table.shifts, table.angles, strict=True):
        side = sign(y, side)
        step_y = shift_round(x, shift, step_y)
        step_y *= side
        if table.m:
            step_x = shift_round(y, shift, step_x)
            # A shift keeps the sign, so sgn(y) times it is its magnitude.
            np.abs(step_x, out=step_x)
            if table.m > 0:
                x += step_x
            else:
                x -= step_x
        y -= step_y
        side *= angle
        z += side
    return x, y, z


def _turn(m: int, x: Integers, y: Integers, direction: Integers, shift: int, work: Work) -> None:
    """Apply one standard micro-rotation in place; the last two arrays of `work` are overwritten."""
    step_y = shift_round(x, shift, work[1])
    step_y *= direction
    if m:
        step_x = shift_round(y, shift, work[2])
        step_x *= direction
        if m > 0:
            x -= step_x
        else:
            x += step_x
    y += step_y


def implicit(
    x: Integers, y: Integers, target: Integers, z: Integers, table: StepTable, near: NearEnd | None = None
) -> tuple[Integers, Integers, Integers, Integers]:
    """Turn (x, y) until y is the target and x >= 0, by standard micro-rotations.

    The target is scaled by each step's true gain, so every comparison is with the true norm.  Circular:
    the remaining angle must be within the sum of the angles (99.9 degrees); see `quarter_turn`.  Hyperbolic:
    within `table.domain`, and x >= |y| or |y| > |x|; of two solutions it is the one with x >= 0, and the
    other is the mirror image, from -x with -z.  How far y ends from the target where there is a solution is
    proven in `cordicc.arith.kernels.circular_bound` (circular) and
    `cordicc.arith.kernels.hyperbolic_bound`; elsewhere it is farther, by which a unit knows that there is
    none.  `near` makes the end of reach exact, where y has its extreme and a comparison tells nothing.

    Returns:
        x, y, the scaled target, and z plus the angle turned.
    """
    x, y, target, z = x.copy(), y.copy(), target.copy(), z.copy()
    work = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    steps = zip(table.shifts, table.angles, table.target_factors, table.stretched, strict=True)
    for shift, angle, factor, stretched in steps:
        direction = _towards(table.m, x, y, y, target, work, near and near.before(stretched))
        _turn(table.m, x, y, direction, shift, work)
        if factor:
            target += multiply_round(target, factor, FACTOR_BITS, table.coordinate_bits)
        direction *= angle
        z += direction
    return x, y, target, z


def implicit_root_free(
    x: Integers, y: Integers, target: Integers, z: Integers, table: StepTable, near: NearEnd | None = None
) -> tuple[Integers, Integers, Integers, Integers]:
    """Turn (x, y) until y is the target and x >= 0, by root-free double rotations.

    x' = (1 - m h^2) x - 2 m s h y, y' = (1 - m h^2) y + 2 s h x, target' = (1 + m h^2) target, h = 2^-S.
    The last `singles` of the table are single, by h: x' = x - m s h y, y' = y + s h x,
    target' = (1 + m h^2/2) target; in the last `settled` of them x' = x - m s h target, target stays, and
    where x < 0 its sign is taken for that of y.  Results as of `implicit`.
    """
    m = table.m
    x, y, target, z = x.copy(), y.copy(), target.copy(), z.copy()
    work = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    small = np.empty_like(x)
    steps = zip(table.shifts, table.angles, table.stretched, strict=True)
    for number, (shift, angle, stretched) in enumerate(steps):
        double, settled = number < table.doubles, number >= table.unsettled
        level = target if settled else y
        direction = _towards(m, x, y, level, target, work, near and near.before(stretched))
        step_x = shift_round(level, shift - double, work[1])
        step_x *= direction
        step_y = shift_round(x, shift - double, work[2])
        step_y *= direction
        if double:
            step_x += shift_round(x, 2 * shift, small)
            small = shift_round(y, 2 * shift, small)
            step_y -= small if m > 0 else -small
        if m > 0:
            x -= step_x
        else:
            x += step_x
        y += step_y
        if not settled:
            grown = shift_round(target, 2 * shift + (not double), small)
            target += grown if m > 0 else -grown
        direction *= angle
        z += direction
    return x, y, target, z


def _towards(
    m: int,
    x: Integers,
    y: Integers,
    level: Integers,
    target: Integers,
    work: Work,
    near: NearEnd | None,
) -> Integers:
    """Return the direction towards the point with y = target and x >= 0; `work` is overwritten.

    `level` has the sign of y, or is the target where it stands for y.

    Where x >= 0, y grows with the angle, so the comparison of y and target is that of the angles.
    Where x < 0 the vector has overshot and turns back: towards +x on the circle, along the branch of
    the hyperbola.
    """
    direction, other, _ = work
    np.subtract(target, y, out=direction)
    if near is not None:
        np.invert(direction, out=other)
        np.maximum(direction, other, out=other)
        close = np.asarray(other <= near.height, dtype=bool)
        if close.any():
            # The extreme of y at x = 0: the greatest on the target's side of the circle, else the least.
            close &= np.asarray((x >= 0) & (x <= near.width), dtype=bool)
            direction[close] = m * sign(target[close])
    if x.dtype == object:
        back = ~level if m > 0 else level
        return sign(np.where(x < 0, back, direction))
    # In two's complement the sign of a ^ ((a ^ b) & c) is that of b where c < 0, else that of a.
    np.bitwise_xor(direction, level, out=other)
    if m > 0:
        np.invert(other, out=other)
    np.bitwise_and(other, x, out=other)
    direction ^= other
    return sign(direction, direction)


def quarter_turn(
    x: Integers, y: Integers, target: Integers, z: Integers, quarter: int
) -> tuple[Integers, Integers, Integers]:
    """Turn a vector with x >= 0 by +-90 degrees where y and the target differ in sign.

    Then at most 90 degrees remain to the target.  `quarter` is pi/2 in the unit of z.
    """
    up = (target >= 0) & (y < 0)
    down = (target < 0) & (y >= 0)
    turned_x = np.where(up, -y, np.where(down, y, x))
    turned_y = np.where(up, x, np.where(down, -x, y))
    turn = up.astype(np.int64) - down.astype(np.int64)
    return turned_x, turned_y, z + turn.astype(z.dtype, copy=False) * quarter
