"""The CORDIC arithmetic unit (CAU) as functions on words: bit-true, vectorised, block floating inside.

Inside, coordinates are 32-bit mantissas with 29 fraction bits under a common exponent, angles have 32
fraction bits.  A result is invalid (NaN) where it has no value; an invalid operand makes both invalid.
Measured errors: rotation and norm 1 ulp of single relative to the norm, angles 2^-24 rad, each besides
the rounding of the result.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from cordicc.arith import implicit as implicit_unit
from cordicc.arith import kernels, sequences
from cordicc.arith.blocks import (
    MANTISSA_BITS,
    ZERO_EXPONENT,
    Int64,
    Scaled,
    added,
    joined,
    normalise,
    to_float,
    unpack,
)
from cordicc.arith.formats import SINGLE, FloatArray, NumberFormat, Word
from cordicc.arith.reduction import (
    ANGLE_BITS,
    SUM_GUARD_BITS,
    angle_sum,
    compensated,
    ln2_multiple,
    padded,
    reduce_circular,
    reduce_hyperbolic,
    sum_and_difference,
)
from cordicc.arith.sequences import StepTable, pi_fixed


@dataclass(frozen=True, slots=True)
class Cau:
    """A unit: 32-bit mantissas less three integer bits, iterations, and the implicit rule if it has one."""

    fraction_bits: int = 29
    iterations: int = 30
    rule: str | None = None
    format: NumberFormat = SINGLE

    def rotate(self, m: int, x: Word, y: Word, z: Word) -> tuple[Word, Word]:
        """Turn (x, y) by z: (x cos z - y sin z, y cos z + x sin z), m = 0: (x, y + x z), m = -1: cosh, sinh.

        The argument is reduced exactly for every finite z in radians.
        """
        valid, (a, b, c) = _operands(self.format, x, y, z)
        turn = {1: self._rotate_circular, 0: self._rotate_linear, -1: self._rotate_hyperbolic}[m]
        first, second = turn(a, b, c)
        return _encoded(self.format, first, valid), _encoded(self.format, second, valid)

    def vector(self, m: int, sign: int, x: Word, y: Word, z: Word) -> tuple[Word, Word]:
        """Return the norm sqrt(x^2 + m y^2) and z + sign * angle of (x, y); m = 0: x and z + sign * y/x.

        Circular: the angle is in (-pi, pi] and invalid at (0, 0), the norm 0 there.  Hyperbolic: the
        norm needs |y| <= |x|, the angle |y| < |x|.  Linear: the quotient needs x != 0.
        """
        valid, (a, b, c) = _operands(self.format, x, y, z)
        measure = {1: self._vector_circular, 0: self._vector_linear, -1: self._vector_hyperbolic}[m]
        norm, angle = measure(sign, a, b, c)
        encode = self.format.encode_angle if m == 1 else self.format.encode
        return _encoded(self.format, norm, valid), np.asarray(encode(np.where(valid, angle, np.nan)))

    def lightcone(self, u: Word, v: Word) -> tuple[Word, Word]:
        """Return sqrt(u v), for u v >= 0, and ln(u/v)/2, for u v > 0: hyperbolic vectoring by x+y and x-y."""
        valid, (a, b) = _operands(self.format, u, v)
        root, angle = self._measure_lightcone(unpack(a), unpack(b))
        radians = np.ldexp(angle.astype(np.float64), -ANGLE_BITS)
        defined = np.sign(a) * np.sign(b) > 0
        return (
            _encoded(self.format, root, valid),
            _encoded(self.format, np.where(defined, radians, np.nan), valid),
        )

    def implicit(self, m: int, branch: str, A: Word, B: Word, C: Word) -> tuple[Word, Word]:
        """Solve B cos t + A sin t = C (m = -1: cosh, sinh): t, and sqrt(A^2 + m B^2 - m C^2) >= 0.

        Both are invalid without a solution.  Circular: t is atan2(A, B) +- acos(C/hypot(A, B)), not
        wrapped, branch "+" or "-".  Hyperbolic: branch "none", or "+"/"-" which matter where |B| > |A|.
        Raises ValueError if the unit has no implicit rule.
        """
        if self.rule is None:
            raise ValueError("this unit has no implicit mode")
        valid, operands = _operands(self.format, A, B, C)
        solve = implicit_unit.circular if m == 1 else implicit_unit.hyperbolic
        angle, rest = solve(branch, operands, implicit_table(self, m), self.fraction_bits)
        encode = self.format.encode_angle if m == 1 else self.format.encode
        return np.asarray(encode(np.where(valid, angle, np.nan))), _encoded(self.format, rest, valid)

    def _rotate_circular(self, x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        quadrant, remainder = reduce_circular(unpack(z))
        (a, b), exponent = joined((unpack(x), unpack(y)), self.fraction_bits)
        odd = (quadrant & 1).astype(bool)
        a, b = np.where(odd, -b, a), np.where(odd, a, b)
        half_turn = 1 - (quadrant & 2)
        a *= half_turn
        b *= half_turn
        table = standard_table(self, 1)
        a, b, _ = kernels.rotate(a, b, remainder, table)
        return to_float(compensated(a, exponent, table)), to_float(compensated(b, exponent, table))

    def _rotate_linear(self, x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        bits = self.fraction_bits + 1
        factor, multiplicand, addend = unpack(z), unpack(x), unpack(y)
        wide = multiplicand.mantissa << (bits - MANTISSA_BITS)
        _, product, _ = kernels.rotate(
            wide,
            np.zeros_like(wide),
            factor.mantissa << (ANGLE_BITS - MANTISSA_BITS),
            standard_table(self, 0),
        )
        product *= (multiplicand.mantissa != 0) & (factor.mantissa != 0)
        exponent = multiplicand.exponent + factor.exponent + (2 * MANTISSA_BITS - bits)
        total = added(padded(Scaled(product, exponent), 20), padded(addend, SUM_GUARD_BITS))
        return x, to_float(total)

    def _rotate_hyperbolic(
        self, x: FloatArray, y: FloatArray, z: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Rotate on the light cone: u = x+y and v = x-y are scaled to one size, so that both stay exact.

        z = q ln 2 + r; CORDIC turns by r, powers of two do the rest.
        """
        doublings, remainder = reduce_hyperbolic(z)
        u, v = sum_and_difference(unpack(x), unpack(y), self.fraction_bits)
        half_sum, half_difference = u.mantissa + v.mantissa, u.mantissa - v.mantissa
        table = standard_table(self, -1)
        a, b, _ = kernels.rotate((half_sum + 1) >> 1, (half_difference + 1) >> 1, remainder, table)
        grown = compensated((a + b) * (u.mantissa != 0), u.exponent + doublings, table)
        shrunk = compensated((a - b) * (v.mantissa != 0), v.exponent - doublings, table)
        grown = Scaled(grown.mantissa, np.where(grown.mantissa == 0, ZERO_EXPONENT, grown.exponent))
        shrunk = Scaled(shrunk.mantissa, np.where(shrunk.mantissa == 0, ZERO_EXPONENT, shrunk.exponent))
        first = added(grown, shrunk)
        second = added(grown, Scaled(-shrunk.mantissa, shrunk.exponent))
        return 0.5 * to_float(first), 0.5 * to_float(second)

    def _vector_circular(
        self, sign: int, x: FloatArray, y: FloatArray, z: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        (a, b), exponent = joined((unpack(x), unpack(y)), self.fraction_bits)
        half_turn = pi_fixed(ANGLE_BITS)
        start = np.where(x < 0, np.where(y < 0, -half_turn, half_turn), 0)
        side = np.where(x < 0, -1, 1)
        table = standard_table(self, 1)
        a, _, angle = kernels.vector(a * side, b * side, start, table)
        # The exact angle has the sign of y, and a point on the positive axis the angle 0.
        np.clip(angle, np.where(y >= 0, 0, -half_turn), np.where((y > 0) | (x < 0), half_turn, 0), out=angle)
        undefined = (x == 0) & (y == 0)
        a *= ~undefined
        norm = to_float(compensated(a, exponent, table))
        return norm, np.where(undefined, np.nan, angle_sum(unpack(z), sign * angle))

    def _vector_linear(
        self, sign: int, x: FloatArray, y: FloatArray, z: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        bits = self.fraction_bits + 1
        divisor, dividend = unpack(np.abs(x)), unpack(y)
        _, _, quotient = kernels.vector(
            divisor.mantissa << (bits - MANTISSA_BITS),
            dividend.mantissa << (bits - MANTISSA_BITS),
            np.zeros_like(dividend.mantissa),
            standard_table(self, 0),
        )
        quotient *= np.where(x < 0, -sign, sign) * (dividend.mantissa != 0)
        exponent = dividend.exponent - divisor.exponent - ANGLE_BITS
        total = added(padded(Scaled(quotient, exponent), 18), padded(unpack(z), SUM_GUARD_BITS))
        return x, np.where(x == 0, np.nan, to_float(total))

    def _vector_hyperbolic(
        self, sign: int, x: FloatArray, y: FloatArray, z: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        u, v = sum_and_difference(unpack(x), unpack(y), self.fraction_bits)
        norm, angle = self._measure_lightcone(u, v)
        defined = np.abs(y) < np.abs(x)
        return norm, np.where(defined, angle_sum(unpack(z), sign * angle), np.nan)

    def _measure_lightcone(self, u: Scaled, v: Scaled) -> tuple[FloatArray, Int64]:
        """Return sqrt(u v), NaN where u v < 0, and ln(u/v)/2 with `ANGLE_BITS`, arbitrary where u v <= 0.

        u and v are brought to one size by powers of two with an even sum, which a half of the sum and a
        multiple of ln 2 undo; then 1/2 <= u/v <= 2, that is |y/x| <= 1/3.
        """
        size_u = normalise(Scaled(np.abs(u.mantissa), u.exponent), self.fraction_bits)
        size_v = normalise(Scaled(np.abs(v.mantissa), v.exponent), self.fraction_bits)
        odd = (size_u.exponent + size_v.exponent) & 1
        first_smaller = size_u.mantissa < size_v.mantissa
        lift_u, lift_v = odd * first_smaller, odd * ~first_smaller
        a, b = size_u.mantissa << lift_u, size_v.mantissa << lift_v
        exponent_u, exponent_v = size_u.exponent - lift_u, size_v.exponent - lift_v
        table = standard_table(self, -1)
        x, _, angle = kernels.vector((a + b + 1) >> 1, (a - b + 1) >> 1, np.zeros_like(a), table)
        zero = (u.mantissa == 0) | (v.mantissa == 0)
        x *= ~zero
        root = to_float(compensated(x, (exponent_u + exponent_v) >> 1, table))
        root[~zero & ((u.mantissa < 0) != (v.mantissa < 0))] = np.nan
        doublings = np.where(zero, 0, (exponent_u - exponent_v) >> 1)
        return root, angle + ln2_multiple(doublings)


def _operands(format_: NumberFormat, *words: Word) -> tuple[NDArray[np.bool_], list[FloatArray]]:
    """Decode and broadcast operands; return which samples are valid, and values with NaN replaced by 1."""
    values = [format_.decode(np.atleast_1d(w)) for w in words]
    shape = np.broadcast_shapes(*(v.shape for v in values))
    valid = np.ones(shape, dtype=bool)
    for value in values:
        valid &= ~np.isnan(value)
    return valid, [np.where(valid, value, 1.0) for value in values]


def _encoded(format_: NumberFormat, values: FloatArray, valid: NDArray[np.bool_]) -> Word:
    return np.asarray(format_.encode(np.where(valid, values, np.nan)))


@cache
def _table(m: int, iterations: int, root_free: bool) -> StepTable:
    sequence = sequences.root_free if root_free else sequences.standard
    return sequences.step_table(sequence(m, iterations), ANGLE_BITS)


def standard_table(unit: Cau, m: int) -> StepTable:
    """Return the constants of the unit's standard iterations."""
    return _table(m, unit.iterations, False)


def implicit_table(unit: Cau, m: int) -> implicit_unit.ImplicitTable:
    """Return the kernel and the constants of the unit's implicit iterations."""
    if unit.rule == "root-free":
        return implicit_unit.ImplicitTable(
            kernels.implicit_root_free, _table(m, unit.iterations, True), False
        )
    return implicit_unit.ImplicitTable(kernels.implicit, _table(m, unit.iterations, False), True)
