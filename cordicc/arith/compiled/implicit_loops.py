"""Light-cone vectoring and the implicit mode on arrays of samples, for numba: `cau` and `implicit`.

Conventions and the reason for the blocks are those of `cordicc.arith.compiled.unit_loops`.
"""

from __future__ import annotations

import numpy as np

from cordicc.arith.compiled.step_loops import (
    BLOCK,
    Steps,
    align_block,
    angle_sum,
    compensate,
    compiled,
    cut,
    deliver_angles,
    deliver_block,
    delivered,
    implicit,
    implicit_root_free,
    normalise,
    shifted,
    three,
    to_float,
    unpack,
    unpack_block,
    vector,
    zeroed,
)
from cordicc.arith.compiled.unit_loops import Widths, ln2_multiple, sum_and_difference
from cordicc.arith.kernels.micro_rotations import NEVER
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS
from cordicc.arith.kernels.thresholds import ROOTS, SIXTEENTHS, as_limit, is_upper, risen, sixteenths
from cordicc.arith.unit.implicit import GUARD_BITS, LOG_BITS
from cordicc.base.arrays import Floats, Int64s

Rule = tuple[int, int, int]
"""1 if root-free, half a turn, and the branch: 1 for "+", -1 for "-", 0 for none."""

Reach = tuple[int, Int64s, Int64s, Int64s, Int64s, Int64s, Int64s, Int64s]
"""The first exponent of a `ReachTable`, and its columns."""

Margin = tuple[int, Int64s, int]
"""The first exponent of a root's slack, its places, and 1 if relative."""

_ROOTS = np.array(ROOTS, dtype=np.int64)
_is_upper, _sixteenths = compiled(is_upper), compiled(sixteenths)
_risen, _as_limit = compiled(risen), compiled(as_limit)
_MIDDLE = (5 << (LOG_BITS - 3)) + (1 << (LOG_BITS - 1))


@compiled
def lightcone(
    x: Floats,
    y: Floats,
    z: Floats,
    root: Floats,
    angle: Floats,
    widths: Widths,
    steps: Steps,
    sign: int,
    margin: Margin,
) -> None:
    """Return the hyperbolic norm of (x, y) and z + sign * its angle; sign 0: x and y are u and v, no z."""
    width, fraction_bits, angle_bits = widths
    first, places, relative = margin
    last = places.size - 1
    for begin in range(0, x.size, BLOCK):
        xs, ys, zs, roots, angles = cut(begin, x, y, z, root, angle)
        xb, yb, zb = xs.view(np.int64), ys.view(np.int64), zs.view(np.int64)
        a, b, c = three(xs.size)
        exponents, logs, kinds = three(xs.size)
        for i in range(c.size):
            u, v = unpack(xb[i], width), unpack(yb[i], width)
            unit = first + (max(u[1], v[1]) if relative else 0)
            if sign != 0:
                u, v = sum_and_difference(u, v, width, fraction_bits)
            # 1: both signs the same; 0: a zero; -1: signs differ.
            kinds[i] = np.sign(u[0]) * np.sign(v[0])
            um, ue = normalise(abs(u[0]), u[1], fraction_bits)
            vm, ve = normalise(abs(v[0]), v[1], fraction_bits)
            u_slack, v_slack = places[min(max(ue - unit, 0), last)], places[min(max(ve - unit, 0), last)]
            if kinds[i] < 0 and (um <= u_slack or vm <= v_slack):
                kinds[i] = 0
            if (ue + ve) & 1:
                if um < vm:
                    um, ue = um << 1, ue - 1
                else:
                    vm, ve = vm << 1, ve - 1
            a[i], b[i], c[i] = (um + vm + 1) >> 1, (um - vm + 1) >> 1, 0
            exponents[i] = ((ue + ve) >> 1) - SCALE_BITS
            logs[i] = 0 if kinds[i] == 0 else (ue - ve) >> 1
        vector(-1, a, b, c, steps)
        compensate(a, steps)
        for i in range(c.size):
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
                total, exponent = angle_sum(zm, ze, sign * turned, width, angle_bits)
                angles[i] = delivered(to_float(total, exponent))


@compiled
def _width(rise: int, room: int, target: int, bits: int) -> int:
    """Return a kernel's width near the vertex of a hyperbola."""
    root = int(_ROOTS[min(_sixteenths(abs(target), bits), SIXTEENTHS)])
    return int(_as_limit(_risen(rise, root) + room))


@compiled
def implicit_circular(
    A: Floats,
    B: Floats,
    C: Floats,
    angle: Floats,
    rest: Floats,
    widths: Widths,
    steps: Steps,
    rule: Rule,
    reach: Reach,
) -> None:
    """Solve B cos t + A sin t = C."""
    width, fraction_bits, angle_bits = widths
    root_free, half_turn, branch = rule
    first, slacks, withins, all_heights, rises, rooms, shorts, _ = reach
    quarter, turns = (half_turn + 1) >> 1, root_free - 1
    for begin in range(0, A.size, BLOCK):
        As, Bs, Cs, angles, rests = cut(begin, A, B, C, angle, rest)
        x, y, z = three(As.size)
        x_exponent, y_exponent, exponents = three(As.size)
        target, target_exponent, excess = three(As.size)
        height, wide, allowed = three(As.size)
        end, at_end, starts = three(As.size)
        downs, _, _ = three(As.size)
        unpack_block(As.view(np.int64), x, x_exponent, width)
        unpack_block(Bs.view(np.int64), y, y_exponent, width)
        unpack_block(Cs.view(np.int64), target, target_exponent, width)
        for i in range(z.size):
            exponents[i] = max(x_exponent[i], y_exponent[i], target_exponent[i]) - (fraction_bits - width)
        for i in range(z.size):
            # The mirror image of a < 0, or of a = 0 > b, is negated for branch "+".
            mirrored = (x[i] > 0) | ((x[i] == 0) & (y[i] < 0))
            starts[i] = -int(mirrored if branch > 0 else x[i] < 0)
        align_block(x, x_exponent, exponents)
        align_block(y, y_exponent, exponents)
        align_block(target, target_exponent, exponents)
        for i in range(z.size):
            row = min(max(exponents[i] - first, 0), slacks.size - 1)
            # With a or b alone |c| is compared with it, and the kernel with the end elsewhere.
            alone = (As[i] == 0) | (Bs[i] == 0)
            height[i] = NEVER if alone else all_heights[row]
            wide[i] = rooms[row] + (rises[row] if _is_upper(abs(target[i]), fraction_bits) else 0)
            allowed[i] = slacks[row] if alone else shorts[row]
            excess[i] = abs(target[i]) - abs(x[i]) - abs(y[i])
            at_end[i] = alone & (excess[i] <= slacks[row]) & (-excess[i] <= withins[row])
        for i in range(z.size):
            side = starts[i]
            a, b = (x[i] ^ side) - side, (y[i] ^ side) - side
            a = -a if branch > 0 else a
            end[i] = quarter if As[i] != 0 else (half_turn if (b < 0) != (target[i] < 0) else 0)
            # A target below 0 is that of the mirror image.
            down = target[i] >> 63
            b, target[i], downs[i] = (b ^ down) - down, (target[i] ^ down) - down, down
            # The first turn by 90 degrees where y and the target differ in sign.
            apart = turns & (b >> 63)
            x[i] = (a & ~apart) | (-b & apart)
            y[i] = (b & ~apart) | (a & apart)
            z[i] = quarter & apart
        if root_free != 0:
            implicit_root_free(1, x, y, target, z, height, wide, steps)
        else:
            implicit(1, x, y, target, z, height, wide, steps, FACTOR_BITS)
        for i in range(z.size):
            alone = (As[i] == 0) | (Bs[i] == 0)
            y[i] = excess[i] if alone else target[i] - y[i]
            turned = end[i] if at_end[i] != 0 else z[i]
            turned = (-half_turn & starts[i]) + ((turned ^ downs[i]) - downs[i])
            x[i] = 0 if at_end[i] != 0 else x[i]
            one_sided = (As[i] == 0) & (Bs[i] > 0)
            least, most = (-half_turn if one_sided else -2 * half_turn), (0 if one_sided else 2 * half_turn)
            turned = min(max(turned, least), most)
            z[i] = -turned if branch > 0 else turned
        deliver_angles(z, angle_bits, angles)
        np.maximum(x, 0, x)
        compensate(x, steps)
        exponents -= SCALE_BITS
        deliver_block(x, exponents, rests)
        for i in range(z.size):
            valid = (y[i] <= allowed[i]) & ((As[i] != 0) | (Bs[i] != 0)) & ~np.isnan(As[i] + Bs[i] + Cs[i])
            angles[i], rests[i] = (angles[i] if valid else np.nan), (rests[i] if valid else np.nan)


@compiled
def _log2(mantissa: int, exponent: int) -> int:
    """Return log2 of a magnitude from its leading bits."""
    top, top_exponent = normalise(abs(mantissa), exponent, LOG_BITS + 1)
    return ((top_exponent + LOG_BITS) << LOG_BITS) + top - (1 << LOG_BITS)


@compiled
def implicit_hyperbolic(
    A: Floats,
    B: Floats,
    C: Floats,
    angle: Floats,
    rest: Floats,
    widths: Widths,
    steps: Steps,
    rule: Rule,
    reach: Reach,
) -> None:
    """Solve B cosh t + A sinh t = C."""
    width, bits, angle_bits = widths
    root_free, _, branch = rule
    first_exponent, slacks, withins, all_heights, rises, rooms, shorts, beyonds = reach
    last = slacks.size - 1
    for begin in range(0, A.size, BLOCK):
        As, Bs, Cs, angles, rests = cut(begin, A, B, C, angle, rest)
        Ab, Bb, Cb = As.view(np.int64), Bs.view(np.int64), Cs.view(np.int64)
        x, y, z = three(As.size)
        target, exponents, doubled = three(As.size)
        signs, solvable, at_end = three(As.size)
        height, wide, rows = three(As.size)
        for i in range(z.size):
            a, a_exponent = unpack(Ab[i], width)
            b, b_exponent = unpack(Bb[i], width)
            c, c_exponent = unpack(Cb[i], width)
            if c < 0:
                a, b, c = -a, -b, -c
            both_exponent = max(b_exponent, c_exponent) - (bits - width)
            b_size = abs(shifted(b, both_exponent - b_exponent))
            short = b_size - abs(shifted(c, both_exponent - c_exponent))
            row = min(max(both_exponent - first_exponent, 0), last)
            p, q = sum_and_difference((b, b_exponent), (a, a_exponent), width, bits)
            mirrored = p[0] <= 0 or (branch < 0 and q[0] > 0)
            possible = q[0] > 0 if mirrored else p[0] > 0
            both = p[0] > 0 and q[0] > 0
            if branch == 0 and both:
                possible = False
            at_end[i] = both and a == 0 and short <= slacks[row] and -short <= withins[row]
            possible = possible and (not both or a != 0 or short <= slacks[row])
            if mirrored:
                p, q = q, p
            log_p, log_q = _log2(p[0], p[1]), _log2(q[0], q[1])
            log_n = max(_log2(c, c_exponent), (log_p + log_q) >> 1)
            doublings = min(max((log_n - log_p + _MIDDLE) >> LOG_BITS, -1024), 1024)
            p_exponent, q_exponent = p[1] + doublings, zeroed(q[0], q[1] - doublings)
            c_exponent += 1
            span = max(p_exponent + bits, q_exponent + bits, c_exponent + width) - (bits + GUARD_BITS)
            first, second = shifted(p[0], span - p_exponent), shifted(q[0], span - q_exponent)
            goal = shifted(c, span - c_exponent)
            size = max(abs(first - second), abs(first + second), abs(goal))
            excess = GUARD_BITS + 1 if size > 1 << (bits + GUARD_BITS) else GUARD_BITS
            x[i], y[i] = shifted(first - second, excess), shifted(first + second, excess)
            target[i], z[i] = shifted(goal, excess), 0
            exponents[i] = span + excess - 1 - SCALE_BITS
            rows[i] = min(max(span + excess - 1 - first_exponent, 0), last)
            # 1: two solutions; 2: the norm is b, and c was compared with it.
            kind = (2 if a == 0 else 1) if both else 0
            height[i] = all_heights[rows[i]] if kind == 1 else NEVER
            wide[i] = _width(rises[rows[i]], rooms[rows[i]], target[i], bits)
            rows[i] = -1 if kind == 2 else rows[i]
            doubled[i], signs[i] = doublings, -1 if mirrored else 1
            solvable[i] = possible and (c != 0 or q[0] != 0)
        if root_free != 0:
            implicit_root_free(-1, x, y, target, z, height, wide, steps)
        else:
            implicit(-1, x, y, target, z, height, wide, steps, FACTOR_BITS)
        x = np.maximum(x, 0)
        compensate(x, steps)
        for i in range(z.size):
            invalid = np.isnan(As[i]) or np.isnan(Bs[i]) or np.isnan(Cs[i])
            apart = y[i] - target[i]
            missed = rows[i] >= 0 and (apart > shorts[rows[i]] or -apart > beyonds[rows[i]])
            if invalid or not solvable[i] or missed:
                angles[i] = rests[i] = np.nan
                continue
            turned = 0 if at_end[i] != 0 else z[i] + ln2_multiple(doubled[i], angle_bits)
            angles[i] = delivered(to_float(turned * signs[i], -angle_bits))
            rests[i] = 0.0 if at_end[i] != 0 else delivered(to_float(x[i], exponents[i]))
