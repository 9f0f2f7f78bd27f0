"""What a unit does to one sample or one block, for numba: the functions of the modules beside it, compiled.

Each mirrors one of `cordicc.arith.kernels.micro_rotations`, `blocks` or `reduction`, which say what it
computes and why; the bits are the same.  Importing this needs numba (`cordicc[fast]`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, cast

import numba
import numpy as np

from cordicc.arith.kernels.blocks import WIDE_BITS, ZERO_EXPONENT
from cordicc.arith.kernels.thresholds import before_step
from cordicc.base.arrays import Floats, Int64s

Product = tuple[int, int, int, int]
"""Constant, shift, lower limbs (-1: the product rounds to 0), and their bits."""

Steps = tuple[Int64s, Int64s, Int64s, Int64s, Int64s, Product, Int64s, tuple[int, int]]
"""Shifts and angles, target factors with their limbs and limb bits; the product with the inverse gain; shares
of the gain before each step; how many of the first iterations are double, and have y in its own place."""

Function = TypeVar("Function", bound=Callable[..., Any])

_HIDDEN_BIT = 1 << 52
_NUMBER_BITS = 0x4338 << 48
_NUMBER = 1.5 * 2.0**52
"""For |n| < 2^51, `_NUMBER_BITS` + n are the bits of the float64 `_NUMBER` + n: conversion in vector code."""

_LEAST_POWER = -1074
_POWERS = 2.0 ** np.arange(_LEAST_POWER, 1024)
_LARGEST = 2.0**512
_LARGEST_SHIFT = 62
_LOW_BITS = _HIDDEN_BIT - 1
_ROOM_BITS = WIDE_BITS - 2


def compiled(function: Function) -> Function:
    """Compile a function by numba at its first call; the machine code is kept where numba finds a place."""
    compile_it = partial(numba.njit, error_model="numpy", nogil=True)
    try:
        return cast(Function, compile_it(cache=True)(function))
    except RuntimeError:  # no folder can be written
        return cast(Function, compile_it()(function))


BLOCK = 512
"""Samples whose integers, four to eight arrays, stay in the nearest cache."""


@compiled
def cut(
    begin: int, x: Floats, y: Floats, z: Floats, first: Floats, second: Floats
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return the block of operands and results that begins at a sample."""
    part = slice(begin, min(begin + BLOCK, x.size))
    return x[part], y[part], z[part], first[part], second[part]


@compiled
def three(size: int) -> tuple[Int64s, Int64s, Int64s]:
    """Return room for three blocks of integers.

    Each is an allocation of its own: rows of one array might overlap for all that the compiler can tell,
    which then makes no vector code.
    """
    return np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size, np.int64)


@compiled
def unpack(bits: int, width: int) -> tuple[int, int]:
    """Return mantissa and exponent of a word's value, given as the bits of a float64 that is normal or 0."""
    exponent = (bits >> 52) & 0x7FF
    size = ((bits & _LOW_BITS) | _HIDDEN_BIT) >> (53 - width)
    mask = bits >> 63
    zero = exponent == 0
    return (0 if zero else (size ^ mask) - mask), (ZERO_EXPONENT if zero else exponent - 1022 - width)


@compiled
def shifted(mantissa: int, right: int) -> int:
    """Return mantissa / 2^right rounded half up."""
    left = min(max(-right, 0), _LARGEST_SHIFT)
    count = min(max(right, 0), _LARGEST_SHIFT)
    return ((mantissa << left) + ((1 << count) >> 1)) >> count


@compiled
def normalise(mantissa: int, exponent: int, bits: int) -> tuple[int, int]:
    """Return the number with a mantissa of `bits` bits."""
    if mantissa == 0:
        return 0, ZERO_EXPONENT
    right = math.frexp(float(mantissa))[1] - bits
    return shifted(mantissa, right), exponent + right


@compiled
def zeroed(mantissa: int, exponent: int) -> int:
    """Return the exponent, that of 0 for the number 0."""
    return exponent if mantissa != 0 else ZERO_EXPONENT


@compiled
def added(a: int, a_exponent: int, b: int, b_exponent: int) -> float:
    """Return the sum of two numbers."""
    exponent = max(a_exponent, b_exponent)
    return to_float(shifted(a, exponent - a_exponent) + shifted(b, exponent - b_exponent), exponent)


@compiled
def padded_sum(result: int, exponent: int, bits: int, addend: int, addend_exponent: int, width: int) -> float:
    """Return a result of `bits` bits plus an operand."""
    room, addend_room = _ROOM_BITS - bits, _ROOM_BITS - width
    return added(
        result << room,
        zeroed(result, exponent - room),
        addend << addend_room,
        zeroed(addend, addend_exponent - addend_room),
    )


@compiled
def to_float(mantissa: int, exponent: int) -> float:
    """Return a number as float64; where the exponent saturates, `delivered` makes it infinite or 0 anyway."""
    return float(mantissa * _POWERS[min(max(exponent, _LEAST_POWER), 1023) - _LEAST_POWER])


@compiled
def delivered(value: float) -> float:
    """Return a result within the exponents that a unit has."""
    size = abs(value)
    held = 0.0 if size < 1 / _LARGEST else value
    return value * math.inf if size >= _LARGEST else held


@compiled
def multiply_round(value: Int64s, kept: int, product: Product) -> None:
    """Put value * constant / 2^shift rounded half up in the place of a block, plus itself for `kept` -1."""
    constant, shift, limbs, limb_bits = product
    half, mask, last = 1 << (shift - 1), (1 << limb_bits) - 1, shift - limbs * limb_bits
    if limbs < 0:
        for i in range(value.size):
            value[i] &= kept
    elif limbs == 0:
        for i in range(value.size):
            value[i] = (value[i] & kept) + ((value[i] * constant + half) >> shift)
    elif limbs == 1:
        for i in range(value.size):
            carry = ((value[i] & mask) * constant + half) >> limb_bits
            value[i] = (value[i] & kept) + (((value[i] >> limb_bits) * constant + carry) >> last)
    else:
        for i in range(value.size):
            carry, high = half, value[i]
            for _ in range(limbs):
                carry = (carry + (high & mask) * constant) >> limb_bits
                high >>= limb_bits
            value[i] = (value[i] & kept) + ((high * constant + carry) >> last)


@compiled
def compensate(coordinate: Int64s, steps: Steps) -> None:
    """Divide a block by the gain, in place; it keeps `SCALE_BITS` more."""
    multiply_round(coordinate, 0, steps[5])


@compiled
def angle_sum(z: int, z_exponent: int, angle: int, width: int, angle_bits: int) -> tuple[int, int]:
    """Return z + angle in radians."""
    exponent = max(z_exponent - (_ROOM_BITS - width), -angle_bits)
    return shifted(z, exponent - z_exponent) + shifted(angle, exponent + angle_bits), exponent


@compiled
def unpack_block(bits: Int64s, mantissa: Int64s, exponent: Int64s, width: int) -> None:
    """Unpack a block.  Loops over few arrays at a time are what the compiler makes vector code of."""
    for i in range(bits.size):
        mantissa[i], exponent[i] = unpack(bits[i], width)


@compiled
def align_block(mantissa: Int64s, exponent: Int64s, common: Int64s) -> None:
    """Bring mantissas to a common exponent, in place."""
    for i in range(mantissa.size):
        mantissa[i] = shifted(mantissa[i], common[i] - exponent[i])


@compiled
def deliver_block(mantissa: Int64s, exponent: Int64s, results: Floats) -> None:
    """Write a block of results; mantissas are below 2^51, and used up as the exponents are."""
    for i in range(mantissa.size):
        mantissa[i] += _NUMBER_BITS
        exponent[i] = (min(max(exponent[i], -1022), 1023) + 1023) << 52
    numbers, powers = mantissa.view(np.float64), exponent.view(np.float64)
    for i in range(mantissa.size):
        results[i] = delivered((numbers[i] - _NUMBER) * powers[i])


@compiled
def deliver_angles(angle: Int64s, angle_bits: int, results: Floats) -> None:
    """Write a block of angles of at most two turns, which are used up."""
    unit = 0.5**angle_bits
    for i in range(angle.size):
        angle[i] += _NUMBER_BITS
    numbers = angle.view(np.float64)
    for i in range(angle.size):
        results[i] = (numbers[i] - _NUMBER) * unit


@compiled
def deliver_sums(
    z: Int64s, z_exponent: Int64s, angle: Int64s, width: int, angle_bits: int, results: Floats
) -> None:
    """Write a block of z + angle in radians, of angles of at most two turns; all are used up."""
    for i in range(angle.size):
        angle[i], z_exponent[i] = angle_sum(z[i], z_exponent[i], angle[i], width, angle_bits)
    deliver_block(angle, z_exponent, results)


@compiled
def rotate(m: int, x: Int64s, y: Int64s, z: Int64s, steps: Steps) -> None:
    """Turn a block (x, y) by z, in place."""
    mirror, moves = m >> 63, -(m & 1)  # masks in the place of products by m, which no vector code has
    for step in range(steps[0].size):
        shift, angle = steps[0][step], steps[1][step]
        half = (1 << shift) >> 1
        for i in range(x.size):
            mask = z[i] >> 63
            back = mask ^ mirror
            step_x = ((((y[i] + half) >> shift) ^ back) - back) & moves
            y[i] += (((x[i] + half) >> shift) ^ mask) - mask
            x[i] -= step_x
            z[i] -= (angle ^ mask) - mask


@compiled
def vector(m: int, x: Int64s, y: Int64s, z: Int64s, steps: Steps) -> None:
    """Turn a block (x, y) until y = 0, in place."""
    mirror, moves = m >> 63, -(m & 1)
    for step in range(steps[0].size):
        shift, angle = steps[0][step], steps[1][step]
        half = (1 << shift) >> 1
        for i in range(x.size):
            mask = y[i] >> 63
            back = mask ^ mirror
            step_x = ((((y[i] + half) >> shift) ^ back) - back) & moves
            y[i] -= (((x[i] + half) >> shift) ^ mask) - mask
            x[i] += step_x
            z[i] += (angle ^ mask) - mask


@compiled
def _towards(mirror: int, x: int, level: int, apart: int, target: int, height: int, width: int) -> int:
    """Return -1 for the negative direction, else 0; `level` has the sign of y, `apart` is target - y."""
    side = x >> 63
    # All ones where 0 <= x <= width and |target - y| <= height: there the way to the end is taken.
    end = ~(x | (width - x) | (height - (apart ^ (apart >> 63)))) >> 63
    ahead = (apart & ~end) | ((target ^ mirror) & end)
    return (((level ^ ~mirror) & side) | (ahead & ~side)) >> 63


_before_step = compiled(before_step)


@compiled
def _shares(whole: Int64s, stretched: int, part: Int64s) -> None:
    """Put what holds before a step in a block, from the gain so far as a share of the whole one."""
    for i in range(whole.size):
        part[i] = _before_step(whole[i], stretched)


@compiled
def implicit(
    m: int,
    x: Int64s,
    y: Int64s,
    target: Int64s,
    z: Int64s,
    height: Int64s,
    width: Int64s,
    steps: Steps,
    factor_bits: int,
) -> None:
    """Turn a block until y is the target, in place, by standard micro-rotations."""
    mirror = m >> 63
    heights, widths, _ = three(x.size)
    for step in range(steps[0].size):
        shift, angle = steps[0][step], steps[1][step]
        if step == 0 or steps[6][step] != steps[6][step - 1]:
            _shares(height, steps[6][step], heights)
            _shares(width, steps[6][step], widths)
        half = (1 << shift) >> 1
        for i in range(x.size):
            apart = target[i] - y[i]
            mask = _towards(mirror, x[i], y[i], apart, target[i], heights[i], widths[i])
            back = mask ^ mirror
            step_x = (((y[i] + half) >> shift) ^ back) - back
            y[i] += (((x[i] + half) >> shift) ^ mask) - mask
            x[i] -= step_x
            z[i] += (angle ^ mask) - mask
        multiply_round(target, -1, (steps[2][step], factor_bits, steps[3][step], steps[4][step]))


@compiled
def implicit_root_free(
    m: int,
    x: Int64s,
    y: Int64s,
    target: Int64s,
    z: Int64s,
    height: Int64s,
    width: Int64s,
    steps: Steps,
) -> None:
    """Turn a block until y is the target, in place, by root-free double rotations, then single ones."""
    mirror = m >> 63
    doubles, unsettled = steps[7]
    heights, widths, _ = three(x.size)
    for step in range(steps[0].size):
        shift, angle = steps[0][step], steps[1][step]
        if step == 0 or steps[6][step] != steps[6][step - 1]:
            _shares(height, steps[6][step], heights)
            _shares(width, steps[6][step], widths)
        double = 1 if step < doubles else 0
        lift, down = (1, 0) if shift < double else (0, shift - double)
        # Coordinates are below 2^44, so what is shifted by more is 0 as well.
        square, growth = min(2 * shift, 62), min(2 * shift + 1 - double, 62)
        half, half_square, half_growth = (1 << down) >> 1, (1 << square) >> 1, (1 << growth) >> 1
        squares, settled = -double, -1 if step >= unsettled else 0
        for i in range(x.size):
            level, apart = (y[i] & ~settled) | (target[i] & settled), target[i] - y[i]
            mask = _towards(mirror, x[i], level, apart, target[i], heights[i], widths[i])
            step_x = ((((level << lift) + half) >> down) ^ mask) - mask
            step_y = ((((x[i] << lift) + half) >> down) ^ mask) - mask
            step_x += ((x[i] + half_square) >> square) & squares
            grown = ((y[i] + half_square) >> square) & squares
            x[i] -= (step_x ^ mirror) - mirror
            y[i] += step_y - ((grown ^ mirror) - mirror)
            target[i] += ((((target[i] + half_growth) >> growth) & ~settled) ^ mirror) - mirror
            z[i] += (angle ^ mask) - mask
