"""The implicit mode of a unit: B cos t + A sin t = C, or with cosh and sinh, solved by one rotation.

The start vector (x, y) = (A, B) is turned until y = C; the angle turned is t, and x ends at
sqrt(A^2 + m B^2 - m C^2).  Whether there is a solution shows at the end: y reaches C or it does not.

The end of reach, |C| = R, is exact. If A or B is 0 the norm is the other one: |C| is compared with it, and at
the end the angle is a multiple of a quarter turn.  Else the kernel turns to the end where it cannot tell it
from the solution (`kernels.end_of_reach`).  The slack of the operands counts as the end in both cases.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cordicc.arith.kernels.blocks import ZERO_EXPONENT, Scaled, joined, normalise, shifted, to_float, unpack
from cordicc.arith.kernels.micro_rotations import NearEnd, quarter_turn, sign
from cordicc.arith.kernels.reduction import compensated, ln2_multiple, sum_and_difference
from cordicc.arith.kernels.shift_sequences import StepTable, pi_fixed
from cordicc.arith.unit.reach import Near, ReachTable
from cordicc.base.arrays import Bools, Floats, Int64s, Integers

Kernel = Callable[[Integers, Integers, Integers, Integers, StepTable, NearEnd], tuple[Integers, ...]]

LOG_BITS = 8
GUARD_BITS = 8


@dataclass(frozen=True, slots=True)
class ImplicitTable:
    """A kernel, its constants, whether it needs the first turn by +-90 degrees, and the unit's widths.

    `reach` tells how far y and C end apart in a solved equation, and what counts as the end of reach.
    """

    kernel: Kernel
    steps: StepTable
    quarter_turns: bool
    operand_bits: int
    fraction_bits: int
    angle_bits: int
    reach: ReachTable

    def unpack(self, values: Floats) -> Scaled:
        """Return operands as mantissas."""
        return unpack(values, self.operand_bits)


def circular(branch: str, operands: list[Floats], table: ImplicitTable) -> tuple[Floats, Floats]:
    """Return t = atan2(A, B) +- acos(C/R) in (-2 pi, 2 pi], not wrapped, and sqrt(R^2 - C^2).

    Branch "-" has x >= 0 at the end.  With psi the angle of (A, B), t is the target angle less psi, up to
    a turn: a start with A < 0 is negated, which adds pi to psi, and its t counted from -pi is the
    formula's own value.  Branch "+" is the mirror image: -A for A and -t for t.
    """
    A, B, C = operands
    half_turn = pi_fixed(table.angle_bits)
    block = (table.unpack(A), table.unpack(B), table.unpack(C))
    (x, y, target), exponent = joined(block, table.operand_bits, table.fraction_bits)
    if branch == "+":
        np.negative(x, out=x)
        # A = 0 > B must give atan2(0, B) = +pi, which the mirror image would turn into -pi.
        negated = (A > 0) | ((A == 0) & (B < 0))
    else:
        negated = A < 0
    side = np.where(negated, -1, 1)
    x *= side
    y *= side
    start = np.where(negated, -half_turn, 0)
    quarter = (half_turn + 1) >> 1
    near = table.reach.at(exponent)
    # With A or B alone the norm is known: the end is where |C| is equal to it, and its angle too.
    alone = (A == 0) | (B == 0)
    below = sign(target)
    excess = np.abs(target) - np.abs(x) - np.abs(y)
    at_end = alone & (excess <= near.slack) & (-excess <= near.within)
    across = np.where(A == 0, np.where((y < 0) == (target < 0), 0, half_turn), quarter)
    # A target below 0 is that of the mirror image: of -y, and of the angle the other way round.
    y, target = y * below, target * below
    z = np.zeros_like(x)
    if table.quarter_turns:
        x, y, z = quarter_turn(x, y, target, z, quarter)
    turning = near.thresholds(1, target, table.fraction_bits, alone)
    x, y, target, z = table.kernel(x, y, target, z, table.steps, turning)
    z, x = start + below * np.where(at_end, across, z), np.where(at_end, 0, x)
    # With A = 0 < B the formula is +-acos(C/B), which has one sign.
    np.clip(
        z,
        np.where((A == 0) & (B > 0), -half_turn, -2 * half_turn),
        np.where((A == 0) & (B > 0), 0, 2 * half_turn),
        out=z,
    )
    if branch == "+":
        z = -z
    # Where there is no solution y cannot reach the target; beyond it is where the kernel turned to the end.
    solved = np.where(alone, excess <= near.slack, target - y <= near.short)
    solved &= (A != 0) | (B != 0)
    return _results(solved, z, Scaled(x, exponent), table)


def hyperbolic(branch: str, operands: list[Floats], table: ImplicitTable) -> tuple[Floats, Floats]:
    """Return t with B cosh t + A sinh t = C, and sqrt(A^2 - B^2 + C^2).

    With E = e^t, p = (B+A)/2, q = (B-A)/2 the equation is p E + q/E = C.  Made C >= 0 by negation, and
    mirrored (A, t to -A, -t) where needed, the solution is always E = N/(2p) with p > 0 and
    N = C + sqrt(C^2 - 4 p q), which lies in [M, 2.42 M] for M = max(C, 2 sqrt|p q|).  So the logarithms
    of p, q and C to a few bits give k = log2 E within 1.3; p 2^k and q 2^-k leave a solution within
    0.9, inside the domain of the iterations.
    """
    A, B, C = operands
    negated = np.where(C < 0, -1, 1)
    a, b, c = table.unpack(A * negated), table.unpack(B * negated), table.unpack(C * negated)
    p, q = sum_and_difference(b, a, table.operand_bits, table.fraction_bits)  # twice p and q of the docstring
    p_positive, q_positive = p.mantissa > 0, q.mantissa > 0
    both = p_positive & q_positive
    mirrored = ~p_positive if branch != "-" else ~p_positive | q_positive
    possible = np.where(mirrored, q_positive, p_positive)
    if branch == "none":
        possible &= ~both
    p, q = _swapped(p, q, mirrored)
    doublings = _estimate(p, q, c)
    p = Scaled(p.mantissa, p.exponent + doublings)
    q = Scaled(q.mantissa, np.where(q.mantissa == 0, ZERO_EXPONENT, q.exponent - doublings))
    twice_c = Scaled(c.mantissa, c.exponent + 1)
    x, y, target, exponent = _vector_of(p, q, twice_c, table)
    near = table.reach.at(exponent - 1)
    turning = near.thresholds(-1, target, table.fraction_bits, ~both | (A == 0))
    x, y, target, z = table.kernel(x, y, target, np.zeros_like(x), table.steps, turning)
    z += ln2_multiple(doublings, table.angle_bits)
    z *= np.where(mirrored, -1, 1)
    alone = both & (A == 0)
    short, known = _short_of_vertex(b, c, table)
    at_end = alone & (short <= known.slack) & (-short <= known.within)
    z, x = np.where(at_end, 0, z), np.where(at_end, 0, x)
    # Without a solution y stays above the target; below it is where the kernel turned to the end.
    reached = (y - target <= near.short) & (target - y <= near.beyond)
    possible &= np.where(alone, short <= known.slack, reached)
    possible &= (c.mantissa != 0) | (q.mantissa != 0)
    return _results(possible, z, Scaled(x, exponent - 1), table)


def _short_of_vertex(b: Scaled, c: Scaled, table: ImplicitTable) -> tuple[Int64s, Near]:
    """Return by how much |C| falls short of |B|, the least of |B cosh t|, and what counts as equal."""
    (b_size, c_size), exponent = joined((b, c), table.operand_bits, table.fraction_bits)
    return np.abs(b_size) - np.abs(c_size), table.reach.at(exponent)


def _results(solved: Bools, angle: Int64s, rest: Scaled, table: ImplicitTable) -> tuple[Floats, Floats]:
    mantissa = np.maximum(rest.mantissa, 0)
    root = to_float(compensated(mantissa, rest.exponent, table.steps))
    radians = np.ldexp(angle.astype(np.float64), -table.angle_bits)
    return np.where(solved, radians, np.nan), np.where(solved, root, np.nan)


def _swapped(p: Scaled, q: Scaled, where: Bools) -> tuple[Scaled, Scaled]:
    first = Scaled(np.where(where, q.mantissa, p.mantissa), np.where(where, q.exponent, p.exponent))
    second = Scaled(np.where(where, p.mantissa, q.mantissa), np.where(where, p.exponent, q.exponent))
    return first, second


def _estimate(twice_p: Scaled, twice_q: Scaled, c: Scaled) -> Int64s:
    """Return log2 of N/(2p) to the nearest integer, within 0.8 more."""
    log_p, log_q, log_c = _log2(twice_p), _log2(twice_q), _log2(c)
    log_n = np.maximum(log_c, (log_p + log_q) >> 1)
    middle = 5 << (LOG_BITS - 3)  # 0.625: N is M times 1 to 2.42
    log_e = log_n - log_p + (middle + (1 << (LOG_BITS - 1)))
    doublings: Int64s = np.clip(log_e >> LOG_BITS, -1024, 1024)
    return doublings


def _log2(number: Scaled) -> Int64s:
    """Return log2 |number| with `LOG_BITS`, from the leading bits (J. N. Mitchell, 1962): up to 0.09 low."""
    top = normalise(Scaled(np.abs(number.mantissa), number.exponent), LOG_BITS + 1)
    return ((top.exponent + LOG_BITS) << LOG_BITS) + top.mantissa - (1 << LOG_BITS)


def _vector_of(
    p: Scaled, q: Scaled, c: Scaled, table: ImplicitTable
) -> tuple[Int64s, Int64s, Int64s, Int64s]:
    """Return (p - q, p + q, c) as a block below 1 with the unit's fraction bits, and its exponent."""
    bits = table.fraction_bits
    sizes = [p.exponent + bits, q.exponent + bits, c.exponent + table.operand_bits]
    largest = np.maximum(np.maximum(sizes[0], sizes[1]), sizes[2])
    wide = largest - (bits + GUARD_BITS)
    first, second, target = (shifted(n.mantissa, wide - n.exponent) for n in (p, q, c))
    x, y = first - second, first + second
    size = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.abs(target))
    excess = np.where(size > 1 << (bits + GUARD_BITS), GUARD_BITS + 1, GUARD_BITS)
    return shifted(x, excess), shifted(y, excess), shifted(target, excess), wide + excess
