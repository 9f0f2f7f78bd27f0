"""Light-cone vectoring and the implicit mode on arrays of samples, for numba: `cau` and `implicit`.

Conventions and the reason for the blocks are those of `cordicc.arith.compiled_units`.
"""

from __future__ import annotations

import numpy as np

from cordicc.arith.compiled_steps import (
    Steps,
    align_block,
    angle_sum,
    compensate,
    compiled,
    deliver_block,
    delivered,
    implicit,
    implicit_root_free,
    normalise,
    shifted,
    to_float,
    unpack,
    unpack_block,
    vector,
    zeroed,
)
from cordicc.arith.compiled_units import BLOCK, Widths, ln2_multiple, sum_and_difference
from cordicc.arith.formats import FloatArray
from cordicc.arith.implicit import GUARD_BITS, LOG_BITS
from cordicc.arith.reduction import SCALE_BITS
from cordicc.arith.sequences import FACTOR_BITS

Rule = tuple[int, int, int, int]
"""1 if root-free, the tolerance, half a turn, and the branch: 1 for "+", -1 for "-", 0 for none."""

_MIDDLE = (5 << (LOG_BITS - 3)) + (1 << (LOG_BITS - 1))


@compiled
def lightcone(
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
    root: FloatArray,
    angle: FloatArray,
    widths: Widths,
    steps: Steps,
    sign: int,
) -> None:
    """Return the hyperbolic norm of (x, y) and z + sign * its angle; sign 0: x and y are u and v, no z."""
    width, fraction_bits, angle_bits = widths
    a, b, c, exponents, logs, kinds, carry = np.empty((7, BLOCK), np.int64)
    for begin in range(0, x.size, BLOCK):
        n = min(BLOCK, x.size - begin)
        part = slice(begin, begin + n)
        xs, ys, zs = x[part], y[part], z[part]
        xb, yb, zb = xs.view(np.int64), ys.view(np.int64), zs.view(np.int64)
        roots, angles = root[part], angle[part]
        for i in range(n):
            u, v = unpack(xb[i], width), unpack(yb[i], width)
            if sign != 0:
                u, v = sum_and_difference(u, v, width, fraction_bits)
            # 1: both signs the same; 0: a zero; -1: signs differ.
            kinds[i] = np.sign(u[0]) * np.sign(v[0])
            um, ue = normalise(abs(u[0]), u[1], fraction_bits)
            vm, ve = normalise(abs(v[0]), v[1], fraction_bits)
            if (ue + ve) & 1:
                if um < vm:
                    um, ue = um << 1, ue - 1
                else:
                    vm, ve = vm << 1, ve - 1
            a[i], b[i], c[i] = (um + vm + 1) >> 1, (um - vm + 1) >> 1, 0
            exponents[i] = ((ue + ve) >> 1) - SCALE_BITS
            logs[i] = 0 if kinds[i] == 0 else (ue - ve) >> 1
        vector(-1, a[:n], b[:n], c[:n], steps)
        compensate(a[:n], carry, steps)
        for i in range(n):
            roots[i] = angles[i] = np.nan
            if np.isnan(xs[i]) or np.isnan(ys[i]) or np.isnan(zs[i]):
                continue
            if kinds[i] >= 0:
                roots[i] = delivered(to_float(a[i] * kinds[i], exponents[i]))
            turned = c[i] + ln2_multiple(logs[i], angle_bits)
            if sign == 0 and kinds[i] > 0:
                angles[i] = delivered(to_float(turned, -angle_bits))
            elif sign != 0 and abs(ys[i]) < abs(xs[i]):
                zm, ze = unpack(zb[i], width)
                angles[i] = delivered(angle_sum(zm, ze, sign * turned, width, angle_bits))


@compiled
def implicit_circular(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    angle: FloatArray,
    rest: FloatArray,
    widths: Widths,
    steps: Steps,
    rule: Rule,
) -> None:
    """Solve B cos t + A sin t = C."""
    width, fraction_bits, angle_bits = widths
    root_free, tolerance, half_turn, branch = rule
    quarter = (half_turn + 1) >> 1
    arrays = np.empty((9, BLOCK), np.int64)
    for begin in range(0, A.size, BLOCK):
        part = slice(begin, min(begin + BLOCK, A.size))
        As, Bs, Cs, angles, rests = A[part], B[part], C[part], angle[part], rest[part]
        x, y, target, z, x_exponent, y_exponent, target_exponent, exponents, carry = arrays[:, : As.size]
        unpack_block(As.view(np.int64), x, x_exponent, width)
        unpack_block(Bs.view(np.int64), y, y_exponent, width)
        unpack_block(Cs.view(np.int64), target, target_exponent, width)
        for i in range(z.size):
            exponents[i] = max(x_exponent[i], y_exponent[i], target_exponent[i]) - (fraction_bits - width)
        for i in range(z.size):
            # The mirror image of a < 0, or of a = 0 > b, is negated for branch "+".
            mirrored = (x[i] > 0) | ((x[i] == 0) & (y[i] < 0))
            z[i] = -int(mirrored if branch > 0 else x[i] < 0)
        align_block(x, x_exponent, exponents)
        align_block(y, y_exponent, exponents)
        align_block(target, target_exponent, exponents)
        for i in range(z.size):
            side = z[i]
            a, b = ((-branch * x[i]) ^ side) - side, (y[i] ^ side) - side
            # The first turn by +-90 degrees where y and the target differ in sign.
            apart = (root_free == 0) & ((target[i] ^ b) < 0)
            up = 1 | (target[i] >> 63)
            x[i], y[i] = (-up * b if apart else a), (up * a if apart else b)
            z[i] = (-half_turn & side) + (up * quarter if apart else 0)
        if root_free != 0:
            implicit_root_free(1, x, y, target, z, steps)
        else:
            implicit(1, x, y, target, z, steps, FACTOR_BITS)
        for i in range(z.size):
            one_sided = (As[i] == 0) & (Bs[i] > 0)
            least, most = (-half_turn if one_sided else -2 * half_turn), (0 if one_sided else 2 * half_turn)
            z[i] = -branch * min(max(z[i], least), most)
        for i in range(z.size):
            angles[i] = delivered(to_float(z[i], -angle_bits))
        np.maximum(x, 0, x)
        compensate(x, carry, steps)
        exponents -= SCALE_BITS
        deliver_block(x, exponents, rests)
        for i in range(z.size):
            solved = abs(y[i] - target[i]) <= tolerance and (As[i] != 0 or Bs[i] != 0)
            if not solved or np.isnan(As[i] + Bs[i] + Cs[i]):
                angles[i] = rests[i] = np.nan


@compiled
def _log2(mantissa: int, exponent: int) -> int:
    """Return log2 of a magnitude from its leading bits."""
    top, top_exponent = normalise(abs(mantissa), exponent, LOG_BITS + 1)
    return ((top_exponent + LOG_BITS) << LOG_BITS) + top - (1 << LOG_BITS)


@compiled
def implicit_hyperbolic(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    angle: FloatArray,
    rest: FloatArray,
    widths: Widths,
    steps: Steps,
    rule: Rule,
) -> None:
    """Solve B cosh t + A sinh t = C."""
    width, bits, angle_bits = widths
    root_free, tolerance, _, branch = rule
    x, y, target, z, exponents, carry = np.empty((6, BLOCK), np.int64)
    doubled, signs, solvable = np.empty((3, BLOCK), np.int64)
    for begin in range(0, A.size, BLOCK):
        n = min(BLOCK, A.size - begin)
        part = slice(begin, begin + n)
        As, Bs, Cs = A[part], B[part], C[part]
        Ab, Bb, Cb = As.view(np.int64), Bs.view(np.int64), Cs.view(np.int64)
        angles, rests = angle[part], rest[part]
        for i in range(n):
            a, a_exponent = unpack(Ab[i], width)
            b, b_exponent = unpack(Bb[i], width)
            c, c_exponent = unpack(Cb[i], width)
            if c < 0:
                a, b, c = -a, -b, -c
            p, q = sum_and_difference((b, b_exponent), (a, a_exponent), width, bits)
            mirrored = p[0] <= 0 or (branch < 0 and q[0] > 0)
            possible = q[0] > 0 if mirrored else p[0] > 0
            if branch == 0 and p[0] > 0 and q[0] > 0:
                possible = False
            if mirrored:
                p, q = q, p
            log_p, log_q = _log2(p[0], p[1]), _log2(q[0], q[1])
            log_n = max(_log2(c, c_exponent), (log_p + log_q) >> 1)
            doublings = min(max((log_n - log_p + _MIDDLE) >> LOG_BITS, -1024), 1024)
            p_exponent, q_exponent = p[1] + doublings, zeroed(q[0], q[1] - doublings)
            c_exponent += 1
            wide = max(p_exponent + bits, q_exponent + bits, c_exponent + width) - (bits + GUARD_BITS)
            first, second = shifted(p[0], wide - p_exponent), shifted(q[0], wide - q_exponent)
            goal = shifted(c, wide - c_exponent)
            size = max(abs(first - second), abs(first + second), abs(goal))
            excess = GUARD_BITS + 1 if size > 1 << (bits + GUARD_BITS) else GUARD_BITS
            x[i], y[i] = shifted(first - second, excess), shifted(first + second, excess)
            target[i], z[i] = shifted(goal, excess), 0
            exponents[i] = wide + excess - 1 - SCALE_BITS
            doubled[i], signs[i] = doublings, -1 if mirrored else 1
            solvable[i] = possible and (c != 0 or q[0] != 0)
        if root_free != 0:
            implicit_root_free(-1, x[:n], y[:n], target[:n], z[:n], steps)
        else:
            implicit(-1, x[:n], y[:n], target[:n], z[:n], steps, FACTOR_BITS)
        x[:n] = np.maximum(x[:n], 0)
        compensate(x[:n], carry, steps)
        for i in range(n):
            invalid = np.isnan(As[i]) or np.isnan(Bs[i]) or np.isnan(Cs[i])
            if invalid or not solvable[i] or abs(y[i] - target[i]) > tolerance:
                angles[i] = rests[i] = np.nan
                continue
            turned = z[i] + ln2_multiple(doubled[i], angle_bits)
            angles[i] = delivered(to_float(turned * signs[i], -angle_bits))
            rests[i] = delivered(to_float(x[i], exponents[i]))
