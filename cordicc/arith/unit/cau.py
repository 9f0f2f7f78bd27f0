"""The CORDIC arithmetic unit (CAU) as functions on exact values: bit-true, vectorised, block floating inside.

Operands are float64 arrays that hold words exactly, NaN an invalid one; results hold at most 53 bits,
exactly, for a number format to round once.  Inside, coordinates are mantissas with `fraction_bits` under a
common exponent of `EXPONENT_BITS`, angles have `angle_bits` fraction bits.  A result is invalid (NaN) where
it has no value, and infinite where its exponent is too large; an invalid operand makes both invalid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

import numpy as np

from cordicc.arith.kernels import micro_rotations
from cordicc.arith.kernels.blocks import (
    WIDE_BITS,
    ZERO_EXPONENT,
    Scaled,
    added,
    joined,
    normalise,
    to_float,
    unpack,
)
from cordicc.arith.kernels.reduction import (
    QuarterTurns,
    angle_sum,
    compensated,
    ln2_multiple,
    padded,
    reduce_by_table,
    reduce_circular,
    reduce_hyperbolic,
    sum_and_difference,
)
from cordicc.arith.kernels.shift_sequences import (
    Sequence,
    StepTable,
    implicit_sequence,
    pi_fixed,
    standard,
    step_table,
)
from cordicc.arith.numbers.slack import EXACT, Rows, Slack, rows_for
from cordicc.arith.unit import implicit as implicit_unit
from cordicc.arith.unit.reach import reach_table
from cordicc.base.arrays import Bools, Floats, Int64s

EXPONENT_BITS = 10
"""Of the exponent inside a unit, two's complement; larger results are infinite, smaller ones 0."""

INTEGER_BITS = 3
"""Of a mantissa: the sign, and growth of the norm by root 2 and the gain to below 4."""

_LARGEST = 2.0 ** (2 ** (EXPONENT_BITS - 1))


@dataclass(frozen=True, slots=True)
class Cau:
    """A unit: its widths in bits, iterations, and the implicit rule if it has one."""

    fraction_bits: int = 29
    iterations: int = 30
    rule: str | None = None
    operand_bits: int = 24
    angle_bits: int = 32

    def rotate(
        self,
        m: int,
        x: Floats,
        y: Floats,
        z: Floats,
        *,
        quarters: QuarterTurns | None = None,
        least: int = ZERO_EXPONENT,
    ) -> tuple[Floats, Floats]:
        """Turn (x, y) by z: (x cos z - y sin z, y cos z + x sin z), m = 0: (x, y + x z), m = -1: cosh, sinh.

        The argument is reduced for every finite z in radians: for m = 1 by the table of `quarters`, if it is
        that of z's format (see `quarter_turns`) and the unit's angle bits, and without one by a product.
        For m = 1 the block of x and y has an exponent of at least `least`: with that of the largest words of
        a fixed-point format it has it always, and needs no shifts.
        """
        valid, (a, b, c) = _operands(x, y, z)
        if m == 1:
            first, second = self._rotate_circular(a, b, c, quarters, least)
        else:
            first, second = (self._rotate_hyperbolic if m else self._rotate_linear)(a, b, c)
        return _delivered(first, valid), _delivered(second, valid)

    def vector(
        self, m: int, sign: int, x: Floats, y: Floats, z: Floats, *, slack: Slack = EXACT
    ) -> tuple[Floats, Floats]:
        """Return the norm sqrt(x^2 + m y^2) and z + sign * angle of (x, y); m = 0: x and z + sign * y/x.

        Circular: the angle is in (-pi, pi] and invalid at (0, 0), the norm 0 there.  Hyperbolic: the
        norm needs |y| <= |x|, the angle |y| < |x|; where |y| is beyond |x| within the slack the norm is 0.
        Linear: the quotient needs x != 0.
        """
        valid, (a, b, c) = _operands(x, y, z)
        if m == -1:
            norm, angle = self._vector_hyperbolic(sign, a, b, c, slack)
        else:
            norm, angle = (self._vector_circular if m else self._vector_linear)(sign, a, b, c)
        return _delivered(norm, valid), _delivered(angle, valid)

    def lightcone(self, u: Floats, v: Floats, *, slack: Slack = EXACT) -> tuple[Floats, Floats]:
        """Return sqrt(u v), for u v >= 0, and ln(u/v)/2, for u v > 0: hyperbolic vectoring by x+y and x-y.

        Where u and v differ in sign, but one of them is within the slack of 0, the root is 0.
        """
        valid, (a, b) = _operands(u, v)
        root, angle = self._measure_lightcone(self._unpack(a), self._unpack(b), slack, np.int64(0))
        radians = np.ldexp(angle.astype(np.float64), -self.angle_bits)
        defined = np.sign(a) * np.sign(b) > 0
        return _delivered(root, valid), _delivered(np.where(defined, radians, np.nan), valid)

    def implicit(
        self, m: int, branch: str, A: Floats, B: Floats, C: Floats, *, slack: Slack = EXACT
    ) -> tuple[Floats, Floats]:
        """Solve B cos t + A sin t = C (m = -1: cosh, sinh): t, and sqrt(A^2 + m B^2 - m C^2) >= 0.

        Both are invalid without a solution.  Circular: t is atan2(A, B) +- acos(C/hypot(A, B)), not
        wrapped, branch "+" or "-".  Hyperbolic: branch "none", or "+"/"-" which matter where |B| > |A|.
        Where the equation has no solution, but would have one with C changed by the slack, t is the end of
        reach and the rest 0.  Raises ValueError if the unit has no implicit rule.
        """
        table = implicit_table(self, m, slack)
        valid, operands = _operands(A, B, C)
        solve = implicit_unit.circular if m == 1 else implicit_unit.hyperbolic
        angle, rest = solve(branch, operands, table)
        return _delivered(angle, valid), _delivered(rest, valid)

    def _unpack(self, values: Floats) -> Scaled:
        return unpack(values, self.operand_bits)

    def _rotate_circular(
        self, x: Floats, y: Floats, z: Floats, quarters: QuarterTurns | None, least: int
    ) -> tuple[Floats, Floats]:
        if quarters is None:
            quadrant, remainder = reduce_circular(self._unpack(z), self.angle_bits)
        else:
            quadrant, remainder = reduce_by_table(self._unpack(z), quarters, self.angle_bits)
        numbers = self._unpack(x), self._unpack(y)
        (a, b), exponent = joined(numbers, self.operand_bits, self.fraction_bits, least)
        odd = (quadrant & 1).astype(bool)
        a, b = np.where(odd, -b, a), np.where(odd, a, b)
        half_turn = 1 - (quadrant & 2)
        a *= half_turn
        b *= half_turn
        table = standard_table(self, 1)
        a, b, _ = micro_rotations.rotate(a, b, remainder, table)
        return to_float(compensated(a, exponent, table)), to_float(compensated(b, exponent, table))

    def _rotate_linear(self, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
        bits = self.fraction_bits + 1
        factor, multiplicand, addend = self._unpack(z), self._unpack(x), self._unpack(y)
        wide = multiplicand.mantissa << (bits - self.operand_bits)
        _, product, _ = micro_rotations.rotate(
            wide,
            np.zeros_like(wide),
            factor.mantissa << (self.angle_bits - self.operand_bits),
            standard_table(self, 0),
        )
        product *= (multiplicand.mantissa != 0) & (factor.mantissa != 0)
        exponent = multiplicand.exponent + factor.exponent + (2 * self.operand_bits - bits)
        total = self._sum(Scaled(product, exponent), bits, addend)
        return x, to_float(total)

    def _sum(self, result: Scaled, bits: int, addend: Scaled) -> Scaled:
        """Return a result of `bits` bits plus an operand, to 2^-50 of the larger."""
        room = WIDE_BITS - 2
        return added(padded(result, room - bits), padded(addend, room - self.operand_bits))

    def _rotate_hyperbolic(self, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
        """Rotate on the light cone: u = x+y and v = x-y are scaled to one size, so that both stay exact.

        z = q ln 2 + r; CORDIC turns by r, powers of two do the rest.
        """
        doublings, remainder = reduce_hyperbolic(z, self.operand_bits, self.angle_bits)
        u, v = sum_and_difference(self._unpack(x), self._unpack(y), self.operand_bits, self.fraction_bits)
        half_sum, half_difference = u.mantissa + v.mantissa, u.mantissa - v.mantissa
        table = standard_table(self, -1)
        a, b, _ = micro_rotations.rotate((half_sum + 1) >> 1, (half_difference + 1) >> 1, remainder, table)
        grown = compensated((a + b) * (u.mantissa != 0), u.exponent + doublings, table)
        shrunk = compensated((a - b) * (v.mantissa != 0), v.exponent - doublings, table)
        grown = Scaled(grown.mantissa, np.where(grown.mantissa == 0, ZERO_EXPONENT, grown.exponent))
        shrunk = Scaled(shrunk.mantissa, np.where(shrunk.mantissa == 0, ZERO_EXPONENT, shrunk.exponent))
        first = added(grown, shrunk)
        second = added(grown, Scaled(-shrunk.mantissa, shrunk.exponent))
        return 0.5 * to_float(first), 0.5 * to_float(second)

    def _vector_circular(self, sign: int, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
        (a, b), exponent = joined((self._unpack(x), self._unpack(y)), self.operand_bits, self.fraction_bits)
        half_turn = pi_fixed(self.angle_bits)
        start = np.where(x < 0, np.where(y < 0, -half_turn, half_turn), 0)
        side = np.where(x < 0, -1, 1)
        table = standard_table(self, 1)
        a, _, angle = micro_rotations.vector(a * side, b * side, start, table)
        # The exact angle has the sign of y, and a point on the positive axis the angle 0.
        np.clip(angle, np.where(y >= 0, 0, -half_turn), np.where((y > 0) | (x < 0), half_turn, 0), out=angle)
        undefined = (x == 0) & (y == 0)
        a *= ~undefined
        norm = to_float(compensated(a, exponent, table))
        total = angle_sum(self._unpack(z), sign * angle, self.operand_bits, self.angle_bits)
        return norm, np.where(undefined, np.nan, total)

    def _vector_linear(self, sign: int, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
        bits = self.fraction_bits + 1
        divisor, dividend = self._unpack(np.abs(x)), self._unpack(y)
        _, _, quotient = micro_rotations.vector(
            divisor.mantissa << (bits - self.operand_bits),
            dividend.mantissa << (bits - self.operand_bits),
            np.zeros_like(dividend.mantissa),
            standard_table(self, 0),
        )
        quotient *= np.where(x < 0, -sign, sign) * (dividend.mantissa != 0)
        exponent = dividend.exponent - divisor.exponent - self.angle_bits
        total = self._sum(Scaled(quotient, exponent), self.angle_bits + 2, self._unpack(z))
        return x, np.where(x == 0, np.nan, to_float(total))

    def _vector_hyperbolic(
        self, sign: int, x: Floats, y: Floats, z: Floats, slack: Slack
    ) -> tuple[Floats, Floats]:
        a, b = self._unpack(x), self._unpack(y)
        u, v = sum_and_difference(a, b, self.operand_bits, self.fraction_bits)
        unit = np.maximum(a.exponent, b.exponent) if slack.relative else np.int64(0)
        norm, angle = self._measure_lightcone(u, v, slack, unit)
        defined = np.abs(y) < np.abs(x)
        total = angle_sum(self._unpack(z), sign * angle, self.operand_bits, self.angle_bits)
        return norm, np.where(defined, total, np.nan)

    def root_slack(self, slack: Slack) -> tuple[Rows, Int64s]:
        """Return the slack in places of u or v, by their exponent less that of what it is relative to."""
        size = math.ldexp(slack.beyond, self.operand_bits) if slack.relative else slack.beyond
        rows = rows_for(size, self.fraction_bits + 1)
        return rows, rows.places(Fraction(size), self.fraction_bits + 1)

    def _measure_lightcone(
        self, u: Scaled, v: Scaled, slack: Slack, unit: Int64s | np.int64
    ) -> tuple[Floats, Int64s]:
        """Return sqrt(u v), NaN where u v < 0, and ln(u/v)/2 as an angle, arbitrary where u v <= 0.

        Where u v < 0, but |u| or |v| is within the slack, the root is 0; a slack may be relative to a number
        with the last place 2^`unit`.  u and v are brought to one size by powers of two with an even sum,
        which a half of the sum and a multiple of ln 2 undo; then 1/2 <= u/v <= 2, that is |y/x| <= 1/3.
        """
        size_u = normalise(Scaled(np.abs(u.mantissa), u.exponent), self.fraction_bits)
        size_v = normalise(Scaled(np.abs(v.mantissa), v.exponent), self.fraction_bits)
        odd = (size_u.exponent + size_v.exponent) & 1
        first_smaller = size_u.mantissa < size_v.mantissa
        lift_u, lift_v = odd * first_smaller, odd * ~first_smaller
        a, b = size_u.mantissa << lift_u, size_v.mantissa << lift_v
        exponent_u, exponent_v = size_u.exponent - lift_u, size_v.exponent - lift_v
        table = standard_table(self, -1)
        x, _, angle = micro_rotations.vector((a + b + 1) >> 1, (a - b + 1) >> 1, np.zeros_like(a), table)
        zero = (u.mantissa == 0) | (v.mantissa == 0)
        apart = ~zero & ((u.mantissa < 0) != (v.mantissa < 0))
        if slack.beyond:
            rows, places = self.root_slack(slack)
            rounded = size_u.mantissa <= places[rows.of(size_u.exponent - unit)]
            rounded |= size_v.mantissa <= places[rows.of(size_v.exponent - unit)]
            zero |= apart & rounded
            apart &= ~rounded
        x *= ~zero
        root = to_float(compensated(x, (exponent_u + exponent_v) >> 1, table))
        root[apart] = np.nan
        doublings = np.where(zero, 0, (exponent_u - exponent_v) >> 1)
        return root, angle + ln2_multiple(doublings, self.angle_bits)


def _operands(*operands: Floats) -> tuple[Bools, list[Floats]]:
    """Broadcast operands; return which samples are valid, and values with NaN replaced by 1."""
    values = [np.atleast_1d(np.asarray(operand, dtype=np.float64)) for operand in operands]
    shape = np.broadcast_shapes(*(v.shape for v in values))
    valid = np.ones(shape, dtype=bool)
    for value in values:
        valid &= ~np.isnan(value)
    if valid.all():
        return valid, [np.broadcast_to(value, shape) for value in values]
    return valid, [np.where(valid, value, 1.0) for value in values]


def _delivered(values: Floats, valid: Bools) -> Floats:
    """Return results within the exponents that a unit has, NaN where an operand is invalid."""
    size = np.abs(values)
    if ((size < _LARGEST) & (size >= 1 / _LARGEST) & valid).all():
        return values
    inside = np.where(size < _LARGEST, values, np.copysign(np.inf, values))
    inside = np.where(size < 1 / _LARGEST, 0.0, inside)
    return np.where(valid & ~np.isnan(values), inside, np.nan)


@cache
def _table(unit: Cau, sequence: Sequence) -> StepTable:
    return step_table(sequence, unit.angle_bits, unit.fraction_bits + INTEGER_BITS)


def standard_table(unit: Cau, m: int) -> StepTable:
    """Return the constants of the unit's standard iterations."""
    return _table(unit, standard(m, unit.iterations))


def implicit_iterations(unit: Cau, m: int) -> Sequence:
    """Return the sequence of the unit's implicit iterations.  Raises ValueError if it has no rule."""
    if unit.rule is None:
        raise ValueError("this unit has no implicit mode")
    return implicit_sequence(unit.rule, m, unit.iterations, unit.fraction_bits)


def implicit_steps(unit: Cau, m: int) -> StepTable:
    """Return the constants of the unit's implicit iterations.  Raises as `implicit_iterations`."""
    return _table(unit, implicit_iterations(unit, m))


@cache
def implicit_table(unit: Cau, m: int, slack: Slack = EXACT) -> implicit_unit.ImplicitTable:
    """Return the kernel, the widths and the constants of the unit's implicit iterations.

    Raises as `implicit_iterations`.
    """
    root_free = unit.rule == "root-free"
    return implicit_unit.ImplicitTable(
        kernel=micro_rotations.implicit_root_free if root_free else micro_rotations.implicit,
        steps=implicit_steps(unit, m),
        quarter_turns=not root_free,
        operand_bits=unit.operand_bits,
        fraction_bits=unit.fraction_bits,
        angle_bits=unit.angle_bits,
        reach=reach_table(implicit_iterations(unit, m), unit.fraction_bits, unit.angle_bits, slack),
    )
