"""The operations of a unit on arrays of samples, for numba: those of `arith.unit.cau`, with the same bits.

Every function takes its operands and arrays for its two results, float64 of one shape (n,), contiguous,
the widths of the unit and the constants of its iterations.  It works through blocks that stay in the
nearest cache: operands to integers, iterations, integers to results.  NaN marks what is invalid.
"""

from __future__ import annotations

import numpy as np

from cordicc.arith.compiled.step_loops import (
    BLOCK,
    Product,
    Steps,
    added,
    align_block,
    compensate,
    compiled,
    cut,
    deliver_block,
    deliver_sums,
    delivered,
    multiply_round,
    normalise,
    padded_sum,
    rotate,
    shifted,
    three,
    unpack,
    unpack_block,
    vector,
    zeroed,
)
from cordicc.arith.kernels.blocks import WIDE_BITS, ZERO_EXPONENT
from cordicc.arith.kernels.reduction import LN2_BITS, PHASE_EXPONENTS, SCALE_BITS, TURN_BITS, TURN_TAIL_BITS
from cordicc.arith.kernels.shift_sequences import inverse_ln2_fixed, ln2_fixed
from cordicc.base.arrays import Floats, Int64s

Widths = tuple[int, int, int]
"""Bits of an operand, of the fraction of a coordinate, and of the fraction of an angle."""

Reduction = tuple[Int64s, Int64s, Product]
"""Heads and tails of the phase by exponent; the product with 2 pi."""

Quarters = tuple[int, Int64s, Int64s]
"""Fraction bits, thresholds and multiples of a table of quarter turns; -1 bits where there is none."""

_FIRST_EXPONENT, _LAST_EXPONENT = PHASE_EXPONENTS.start, PHASE_EXPONENTS.stop - 1
_LN2 = ln2_fixed(LN2_BITS)
_INVERSE_LN2 = inverse_ln2_fixed(30)


@compiled
def ln2_multiple(count: int, angle_bits: int) -> int:
    """Return count * ln 2 as a fixed-point angle."""
    return shifted(count * _LN2, LN2_BITS - angle_bits)


@compiled
def sum_and_difference(
    x: tuple[int, int], y: tuple[int, int], width: int, bits: int
) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return x + y and x - y with mantissas of `bits` bits."""
    exponent = max(x[1], y[1]) - (WIDE_BITS - width)
    a, b = shifted(x[0], exponent - x[1]), shifted(y[0], exponent - y[1])
    return normalise(a + b, exponent, bits), normalise(a - b, exponent, bits)


@compiled
def _reduce_by_product(
    angle: Int64s, exponent: Int64s, quadrant: Int64s, angle_bits: int, reduction: Reduction
) -> None:
    """Put the remainder in the place of a block of angles, and its quadrants in theirs."""
    heads, tails, tau = reduction
    rest_shift = TURN_BITS - angle_bits - 3
    for i in range(angle.size):
        index = min(max(exponent[i], _FIRST_EXPONENT), _LAST_EXPONENT) - _FIRST_EXPONENT
        angle[i] = angle[i] * heads[index] + ((angle[i] * tails[index]) >> TURN_TAIL_BITS)
    for i in range(angle.size):
        quadrant[i] = (angle[i] + (1 << 61)) >> 62
        angle[i] = shifted(angle[i] - (quadrant[i] << 62), rest_shift)
    multiply_round(angle, 0, tau)


@compiled
def _reduce_by_table(
    angle: Int64s, exponent: Int64s, quadrant: Int64s, angle_bits: int, quarters: Quarters
) -> None:
    """Put the remainder in the place of a block of angles, and its quadrants in theirs."""
    bits, thresholds, multiples = quarters
    for i in range(angle.size):
        angle[i] = shifted(angle[i], -bits - exponent[i])
        quadrant[i] = 0
    for threshold in thresholds:
        for i in range(angle.size):
            quadrant[i] += int(angle[i] >= threshold) - int(angle[i] < -threshold)
    for i in range(angle.size):
        turns = quadrant[i]
        rest = angle[i] + (multiples[-turns] if turns < 0 else -multiples[turns])
        angle[i] = shifted(rest, bits - angle_bits)


@compiled
def rotate_circular(
    x: Floats,
    y: Floats,
    z: Floats,
    first: Floats,
    second: Floats,
    widths: Widths,
    steps: Steps,
    reduction: Reduction,
    quarters: Quarters,
    least: int,
) -> None:
    """Turn (x, y) by z."""
    width, fraction_bits, angle_bits = widths
    for begin in range(0, x.size, BLOCK):
        xs, ys, zs, firsts, seconds = cut(begin, x, y, z, first, second)
        a, b, c = three(xs.size)
        a_exponent, b_exponent, exponents = three(xs.size)
        quadrants = np.empty(xs.size, np.int64)
        unpack_block(zs.view(np.int64), c, exponents, width)
        if quarters[0] < 0:
            _reduce_by_product(c, exponents, quadrants, angle_bits, reduction)
        else:
            _reduce_by_table(c, exponents, quadrants, angle_bits, quarters)
        unpack_block(xs.view(np.int64), a, a_exponent, width)
        unpack_block(ys.view(np.int64), b, b_exponent, width)
        for i in range(c.size):
            exponents[i] = max(a_exponent[i], b_exponent[i], least) - (fraction_bits - width)
        align_block(a, a_exponent, exponents)
        align_block(b, b_exponent, exponents)
        for i in range(c.size):
            odd, half_turn = -(quadrants[i] & 1), -((quadrants[i] >> 1) & 1)
            u, v = (a[i] & ~odd) | (-b[i] & odd), (b[i] & ~odd) | (a[i] & odd)
            a[i], b[i] = (u ^ half_turn) - half_turn, (v ^ half_turn) - half_turn
        rotate(1, a, b, c, steps)
        compensate(a, steps)
        compensate(b, steps)
        exponents -= SCALE_BITS
        a_exponent[:] = exponents
        deliver_block(a, a_exponent, firsts)
        deliver_block(b, exponents, seconds)
        for i in range(c.size):
            invalid = np.isnan(xs[i] + ys[i] + zs[i])
            firsts[i], seconds[i] = (np.nan if invalid else firsts[i]), (np.nan if invalid else seconds[i])


@compiled
def rotate_linear(
    x: Floats,
    y: Floats,
    z: Floats,
    first: Floats,
    second: Floats,
    widths: Widths,
    steps: Steps,
) -> None:
    """Return x and y + x z."""
    width, fraction_bits, angle_bits = widths
    bits = fraction_bits + 1
    for begin in range(0, x.size, BLOCK):
        xs, ys, zs, firsts, seconds = cut(begin, x, y, z, first, second)
        a, b, c = three(xs.size)
        exponents = np.empty(xs.size, np.int64)
        xb, yb, zb = xs.view(np.int64), ys.view(np.int64), zs.view(np.int64)
        for i in range(c.size):
            xm, xe = unpack(xb[i], width)
            zm, ze = unpack(zb[i], width)
            a[i], b[i], c[i] = xm << (bits - width), 0, zm << (angle_bits - width)
            exponents[i] = xe + ze + 2 * width - bits
        rotate(0, a, b, c, steps)
        for i in range(c.size):
            if np.isnan(xs[i]) or np.isnan(ys[i]) or np.isnan(zs[i]):
                firsts[i] = seconds[i] = np.nan
            else:
                product = 0 if xs[i] == 0 or zs[i] == 0 else b[i]
                ym, ye = unpack(yb[i], width)
                firsts[i] = delivered(xs[i])
                seconds[i] = delivered(padded_sum(product, exponents[i], bits, ym, ye, width))


@compiled
def rotate_hyperbolic(
    x: Floats,
    y: Floats,
    z: Floats,
    first: Floats,
    second: Floats,
    widths: Widths,
    steps: Steps,
) -> None:
    """Turn (x, y) by z on the light cone."""
    width, fraction_bits, angle_bits = widths
    down, up = max(0, angle_bits - 16), max(0, 16 - angle_bits)
    bounded = np.minimum(np.maximum(z, -512.0), 512.0).view(np.int64)
    for begin in range(0, x.size, BLOCK):
        xs, ys, zs, firsts, seconds = cut(begin, x, y, z, first, second)
        a, b, c = three(xs.size)
        grow, shrink, _ = three(xs.size)
        xb, yb = xs.view(np.int64), ys.view(np.int64)
        for i in range(c.size):
            zm, ze = unpack(bounded[begin + i], width)
            fixed_z = shifted(zm, -angle_bits - ze)
            doublings = shifted((fixed_z >> down << up) * _INVERSE_LN2, 46)
            c[i] = fixed_z - ln2_multiple(doublings, angle_bits)
            u, v = sum_and_difference(unpack(xb[i], width), unpack(yb[i], width), width, fraction_bits)
            a[i], b[i] = (u[0] + v[0] + 1) >> 1, (u[0] - v[0] + 1) >> 1
            # The exponent of 0 marks the half that is 0.
            grow[i], shrink[i] = zeroed(u[0], u[1] + doublings), zeroed(v[0], v[1] - doublings)
        rotate(-1, a, b, c, steps)
        for i in range(c.size):
            a[i], b[i] = a[i] + b[i], a[i] - b[i]
        compensate(a, steps)
        compensate(b, steps)
        for i in range(c.size):
            if np.isnan(xs[i]) or np.isnan(ys[i]) or np.isnan(zs[i]):
                firsts[i] = seconds[i] = np.nan
                continue
            u_end = a[i] if grow[i] != ZERO_EXPONENT else 0
            v_end = b[i] if shrink[i] != ZERO_EXPONENT else 0
            ue, ve = zeroed(u_end, grow[i] - SCALE_BITS), zeroed(v_end, shrink[i] - SCALE_BITS)
            firsts[i] = delivered(0.5 * added(u_end, ue, v_end, ve))
            seconds[i] = delivered(0.5 * added(u_end, ue, -v_end, ve))


@compiled
def vector_circular(
    x: Floats,
    y: Floats,
    z: Floats,
    norm: Floats,
    angle: Floats,
    widths: Widths,
    steps: Steps,
    sign: int,
    half_turn: int,
) -> None:
    """Return the norm of (x, y) and z + sign * its angle."""
    width, fraction_bits, angle_bits = widths
    for begin in range(0, x.size, BLOCK):
        xs, ys, zs, norms, angles = cut(begin, x, y, z, norm, angle)
        a, b, c = three(xs.size)
        a_exponent, b_exponent, exponents = three(xs.size)
        unpack_block(xs.view(np.int64), a, a_exponent, width)
        unpack_block(ys.view(np.int64), b, b_exponent, width)
        for i in range(c.size):
            exponents[i] = max(a_exponent[i], b_exponent[i]) - (fraction_bits - width)
        for i in range(c.size):
            side, up = a[i] >> 63, b[i] >> 63
            c[i] = ((half_turn ^ up) - up) & side
            b[i] = (shifted(b[i], exponents[i] - b_exponent[i]) ^ side) - side
        align_block(a, a_exponent, exponents)
        np.abs(a, a)
        vector(1, a, b, c, steps)
        compensate(a, steps)
        exponents -= SCALE_BITS
        deliver_block(a, exponents, norms)
        for i in range(c.size):
            least = 0 if ys[i] >= 0 else -half_turn
            most = half_turn if (ys[i] > 0) | (xs[i] < 0) else 0
            turned = min(max(c[i], least), most)
            c[i] = turned if sign > 0 else -turned
        unpack_block(zs.view(np.int64), b, b_exponent, width)
        deliver_sums(b, b_exponent, c, width, angle_bits, angles)
        for i in range(c.size):
            invalid, nowhere = np.isnan(xs[i] + ys[i] + zs[i]), (xs[i] == 0) & (ys[i] == 0)
            norms[i] = np.nan if invalid else (0.0 if nowhere else norms[i])
            angles[i] = np.nan if invalid | nowhere else angles[i]


@compiled
def vector_linear(
    x: Floats,
    y: Floats,
    z: Floats,
    norm: Floats,
    angle: Floats,
    widths: Widths,
    steps: Steps,
    sign: int,
) -> None:
    """Return x and z + sign * y/x."""
    width, fraction_bits, angle_bits = widths
    room = fraction_bits + 1 - width
    for begin in range(0, x.size, BLOCK):
        xs, ys, zs, norms, angles = cut(begin, x, y, z, norm, angle)
        a, b, c = three(xs.size)
        exponents = np.empty(xs.size, np.int64)
        xb, yb, zb = xs.view(np.int64), ys.view(np.int64), zs.view(np.int64)
        for i in range(c.size):
            xm, xe = unpack(xb[i], width)
            ym, ye = unpack(yb[i], width)
            a[i], b[i], c[i], exponents[i] = abs(xm) << room, ym << room, 0, ye - xe - angle_bits
        vector(0, a, b, c, steps)
        for i in range(c.size):
            u, v = xs[i], ys[i]
            if np.isnan(u) or np.isnan(v) or np.isnan(zs[i]):
                norms[i] = angles[i] = np.nan
                continue
            norms[i], angles[i] = delivered(u), np.nan
            if u != 0:
                quotient = c[i] * (-sign if u < 0 else sign) * (v != 0)
                zm, ze = unpack(zb[i], width)
                total = padded_sum(quotient, exponents[i], angle_bits + 2, zm, ze, width)
                angles[i] = delivered(total)
