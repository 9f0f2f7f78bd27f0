"""Proven error bounds of the unit's operations: what a result is off before its last rounding.

As in `bounds`, step j of a kernel turns by s alpha_j, s = +-1, and stretches by k_j; K_j is the product of
the first j stretches. F fraction bits give a block whose largest mantissa is in [2^(F-1), 2^F): lengths
below are in its last places, and each rounding half up errs by at most half of one.

A shift by S > 0 of a number v errs by at most min(1/2, |v| 2^-S), one by 0 not at all. So step j leaves
errors ex_j (its own shift of y) and ey_j (of x) behind, and the computed vector is v_i = K_i (u_i + sum over
j < i of Turn(e_j)/K_(j+1)), where u_i is a vector of exact arithmetic with the *same* decisions and Turn the
rotation by the angles of the steps j+1 to i.

Vectoring, any m. Let N be the norm, phi_i the angle of u_i (its slope, m = 0), rho_j the sum of the later
angles. The turned errors add up to at most

    across = sum (ey_j c_j + ex_j s_j)/K_(j+1),   along = sum (ex_j c_j + ey_j s_j)/K_(j+1),

c_j, s_j the largest |cos|, |sin| (m = -1: cosh, sinh; m = 0: 1 and 0) of an angle up to rho_j. The decision
is the sign of y: a wrong one needs |phi_i| <= eta_i, where N sin(eta_i) (sinh; m = 0: N eta_i) is the
`across` so far. A right one leads from |phi| <= D to max(alpha, D - alpha), a wrong one to alpha + eta. Hence

    D_(i+1) = max(alpha_i + eta_i, D_i - alpha_i),

and the angle is off by D_n and the roundings of the angle table, the norm by N (1 - cos D_n) (cosh - 1) and
`along`. |y_i| is at most K_i (N sin D_i + across), so ex_j soon vanishes, as 2^-2S.

Rotation. z is exact in its own places, so the same recursion with eta = 0, on the table's integers, gives
the angle that remains, D_n. Circular: the vector is off by N (D_n + table + reduction) and the sum of
hypot(ex_j, ey_j)/K_(j+1). Hyperbolic, in u = x + y and v = x - y, which step j multiplies by 1 +- s 2^-S:
u is off by ex + ey, relative to u_0 that is (ex_j + ey_j) e^T/K_(j+1), T the largest |angle| after the step,
at most |z| + D_j and at most the sum of the angles so far. As u_0 >= 2^(F-1), and the same for v, a relative
error of both of u and v is one of the results in units of (|u| + |v|)/2, the larger of the results.
Linear: the product is off by x (D_n + table) and the sum of ey_j; ey_j = 0 while x ends in S zero bits.

Before and after. A block's largest coordinate is exact, the other is off by half a place: so much the
rotated vector, and 2^-F the angle; the norm only by its small share, below 2^p of the block's 2^F, p the
bits of an operand. x + y and x - y are normalised to F bits, relative 2^-F each; their half sum and half
difference err by half a place together, that is 1 in u. The product with the reciprocal gain has the
constant's own relative error, which is computed, and keeps four more bits.

The two parts, angle approximation and rounding carried through the later steps, are those of Y. H. Hu, "The
quantization effects of the CORDIC algorithm", IEEE Trans. Signal Processing 40(4), 1992, pp. 834-844. The
recursion for wrong decisions and the light-cone form are our own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.kernels.reduction import LARGEST_REMAINDER, QUARTER_GUARD_BITS, QuarterTurns
from cordicc.arith.kernels.shift_sequences import (
    Sequence,
    StepTable,
    exact_angle,
    exact_gain,
    pi_fixed,
    standard,
    step_table,
)
from cordicc.arith.kernels.step_errors import shift_error
from cordicc.arith.unit.cau import Cau, standard_table

Length = TypeVar("Length", float, NDArray[np.float64])

_REDUCED = 0.35
"""The largest |r| of z = q ln 2 + r, see `reduce_hyperbolic`."""

PRODUCT_ROUNDING = 1 / 32
"""Places by which the product with the reciprocal gain is rounded: it keeps four bits more."""

_SUM_ERROR = 2.0**-48
"""Relative to the larger operand: a sum of two numbers of at least 50 bits, and of x and y."""

_LN2_ERROR = 2.0**-39
"""1024 multiples of ln 2, which is known to 2^-49; larger multiples belong to results beyond any exponent."""

_FLOAT_SLACK = 1 + 2.0**-40
"""Makes up for the roundings of this module's own arithmetic."""


@dataclass(frozen=True, slots=True)
class LengthBound:
    """Error of a length: relative to a norm, and in last places of the operands' block."""

    relative: float
    places: float = 0.0

    def error(self, norm: Length, place: Length) -> Length:
        """Return the bound for a norm and the value of the block's last place, in the unit of both."""
        return self.relative * norm + self.places * place


def composed(relative: float, places: float = 0.0) -> LengthBound:
    """Return the bound of errors that follow one another, from their sums.

    Factors 1 + a and 1 + b make at most e^(a + b), and the later ones scale earlier places and a norm that
    is itself off by places.
    """
    return LengthBound(math.expm1(relative) * _FLOAT_SLACK, places * (1 + 2 * relative) * _FLOAT_SLACK)


def _angle(sum_rad: float) -> float:
    """Return the bound of an angle from its errors' sum: an arc exceeds its sine x by less than x^2."""
    return sum_rad * (1 + sum_rad) * _FLOAT_SLACK


@dataclass(frozen=True, slots=True)
class VectoringBound:
    """Errors of the norm, and of the angle in radians; for m = 0 of x, and of y/x relative to it."""

    norm: LengthBound
    angle: float


def rotation_bound(unit: Cau, m: int, quarters: QuarterTurns | None = None) -> LengthBound:
    """Bound the error of a rotation's results, which are not rounded to a format yet.

    The norm in `LengthBound.error` is sqrt(x^2 + y^2) for m = 1, and the error that of the vector; the
    larger result for m = -1; for m = 0 |x z|, if that is no less than |y|, else 2^-48 of y is to be added.
    For m = 1 the angle is reduced by the table of `quarters`; without one the bound is that of the product,
    which errs more than any table does and so holds for both.
    The derivation is the module's text.  Raises ValueError if a block does not hold an operand.
    """
    _check(unit)
    if m == 1:
        return _circular_rotation(unit, quarters)
    return (_hyperbolic_rotation if m else _linear_rotation)(unit)


def vectoring_bound(unit: Cau, m: int) -> VectoringBound:
    """Bound the errors of vectoring's results, which are not rounded to a format yet.

    Relative to the quotient for m = 0, if that is no less than |z|, else 2^-48 of z is to be added; for
    m = 1, -1 the angle's bound holds while |z| is below 2^(50 - `angle_bits`).  Raises as `rotation_bound`.
    """
    _check(unit)
    if m == 0:
        return VectoringBound(LengthBound(0.0), _quotient(unit))
    if m == -1:
        # x + y and x - y are normalised, each to half a place of at least 2^(F-1).
        normalised = math.ldexp(1.0, -unit.fraction_bits) + _SUM_ERROR
        measured = lightcone_bound(unit)
        angle = _angle(measured.angle + normalised + _place(unit) / 2)
        return VectoringBound(composed(measured.norm.relative + normalised), angle)
    return _circular_vectoring(unit)


def lightcone_bound(unit: Cau) -> VectoringBound:
    """Bound the errors of sqrt(u v), relative, and of ln(u/v)/2, which are not rounded to a format yet.

    Raises as `rotation_bound`.
    """
    _check(unit)
    sequence = standard(-1, unit.iterations)
    place = math.ldexp(1.0, 1 - unit.fraction_bits)  # relative to the smallest norm, 2^(F-1)
    low = math.ldexp(1.0, unit.fraction_bits - 1)
    # The half sum and half difference err together by a place of u, which is half of it in norm and angle.
    halved = place / 2
    turned = _turned_errors(
        sequence, math.atanh(1 / 3) + halved, low, math.ldexp(math.sqrt(2), unit.fraction_bits)
    )
    constant = gain_error(sequence, standard_table(unit, sequence.m))
    norm = math.cosh(turned.left) - 1 + (turned.along + PRODUCT_ROUNDING) * place + halved + constant
    angle = turned.left + _table_error(sequence, unit.angle_bits) + halved + _LN2_ERROR + _place(unit) / 2
    return VectoringBound(composed(norm), _angle(angle))


def _circular_rotation(unit: Cau, quarters: QuarterTurns | None) -> LengthBound:
    sequence = standard(1, unit.iterations)
    table = standard_table(unit, 1)
    if quarters is None:
        # The phase, its three bits below the angle's last place, 2 pi, the product.
        reduction = math.tau * 2.0**-62 + (math.tau / 16 + 0.5) * _place(unit) + 2.0**-41
    else:
        reduction = _table_reduction_error(unit, quarters)
    left = _angles_left(table, unit, LARGEST_REMAINDER)[-1]
    gain, places = 1.0, 0.5
    for shift in sequence.shifts:
        error = shift_error(shift, math.ldexp(gain, unit.fraction_bits + 1))
        gain *= _stretch(1, shift)
        places += math.sqrt(2) * error / gain
    constant = gain_error(sequence, standard_table(unit, sequence.m))
    relative = left + _table_error(sequence, unit.angle_bits) + reduction + constant
    return composed(relative, places + math.sqrt(2) * PRODUCT_ROUNDING)


def _table_reduction_error(unit: Cau, quarters: QuarterTurns) -> float:
    """Return the error of `reduce_by_table` in radians: the multiples', and each rounding that there is."""
    below = quarters.fraction_bits - unit.angle_bits
    # 64 bits more than a multiple has; of its place pi is off by nothing that counts.
    pi, scale = pi_fixed(quarters.fraction_bits + 63), 1 << 64
    table = max(abs(count * pi - turn * scale) for count, turn in enumerate(quarters.multiples)) / scale
    rounded = 0.5 if below == QUARTER_GUARD_BITS else 0.0
    last = 0.5 if below else 0.0
    return (math.ldexp(table + rounded, -below) + last) * _place(unit)


def _linear_rotation(unit: Cau) -> LengthBound:
    table = standard_table(unit, 0)
    left = _angles_left(table, unit, 1.0)[-1] + _table_error(standard(0, unit.iterations), unit.angle_bits)
    places = sum(0.5 for shift in table.shifts if shift > _zero_bits(unit))
    # x is at least 2^F places, and the factor at least 1/2, so the product at least half of x.
    relative = 2 * (left + places * math.ldexp(1.0, -unit.fraction_bits)) + _SUM_ERROR
    return composed(relative)


def _hyperbolic_rotation(unit: Cau) -> LengthBound:
    sequence = standard(-1, unit.iterations)
    left = _angles_left(standard_table(unit, -1), unit, _REDUCED)
    place = math.ldexp(1.0, 1 - unit.fraction_bits)  # relative to the smallest u or v, 2^(F-1)
    gain, reach = 1.0, 0.0
    places = 1.5  # half sum and difference; x + y is rounded to half a place
    for shift, remaining in zip(sequence.shifts, left[1:], strict=True):
        gain *= _stretch(-1, shift)
        reach += math.atanh(math.ldexp(1.0, -shift))
        places += math.exp(min(reach, _REDUCED + remaining)) / gain
    constant = gain_error(sequence, standard_table(unit, sequence.m))
    # The product, and the sum u + v, which is rounded to no more than the product was.
    places += 2 * PRODUCT_ROUNDING * math.exp(_REDUCED)
    angle = left[-1] + _table_error(sequence, unit.angle_bits) + _LN2_ERROR + _place(unit)
    return composed(places * place + angle + constant + _SUM_ERROR)


def _circular_vectoring(unit: Cau) -> VectoringBound:
    sequence = standard(1, unit.iterations)
    low = math.ldexp(1.0, unit.fraction_bits - 1)
    turned = _turned_errors(sequence, math.pi / 2, low, math.ldexp(math.sqrt(2), unit.fraction_bits))
    aligned = 0.5 / low
    angle = (
        turned.left + _table_error(sequence, unit.angle_bits) + aligned + _place(unit)
    )  # pi and z: half a place each
    constant = gain_error(sequence, standard_table(unit, sequence.m))
    # The rounded coordinate is below 2^p, a share of 2^(p+1-F) of the norm.
    places = turned.along + PRODUCT_ROUNDING + math.ldexp(1.0, unit.operand_bits - unit.fraction_bits)
    relative = 1 - math.cos(turned.left) + constant
    return VectoringBound(composed(relative, places), _angle(angle))


def _quotient(unit: Cau) -> float:
    sequence = standard(0, unit.iterations)
    low = math.ldexp(1.0, unit.fraction_bits)
    turned = _turned_errors(sequence, 2.0, low, 2 * low, _zero_bits(unit))
    # The mantissas' quotient is at least 1/2.
    return composed(2 * (turned.left + _table_error(sequence, unit.angle_bits)) + _SUM_ERROR).relative


@dataclass(frozen=True, slots=True)
class _VectoringEnd:
    """The angle left at the end of vectoring, and the roundings' sum along the final vector, in places."""

    left: float
    along: float


def _turned_errors(
    sequence: Sequence, start: float, low: float, high: float, zero_bits: int = 0
) -> _VectoringEnd:
    """Follow vectoring from |angle| <= `start`, with norms from `low` to `high` places.

    x and y end in `zero_bits` zeros at the start, which matters for m = 0 only, where x stays.
    """
    m = sequence.m
    angles = [float(exact_angle(m, shift, False)) for shift in sequence.shifts]
    gain, left, along, across = 1.0, start, 0.0, 0.0
    for index, (shift, angle) in enumerate(zip(sequence.shifts, angles, strict=True)):
        cosine, sine = _extremes(m, sum(angles[index + 1 :]))
        wide, tall = _extremes(m, left)
        error_y = shift_error(shift, gain * (high * wide + along)) if shift > zero_bits else 0.0
        error_x = shift_error(shift, gain * (high * tall + across)) if m else 0.0
        left = max(angle + _angle_of(m, across / low), left - angle)
        gain *= _stretch(m, shift)
        along += (error_x * cosine + error_y * sine) / gain
        across += (error_y * cosine + error_x * sine) / gain
    return _VectoringEnd(left, along)


def _extremes(m: int, angle: float) -> tuple[float, float]:
    """Return the largest |cos| and |sin| up to an angle, cosh and sinh for m = -1, 1 and 0 for m = 0."""
    if m > 0:
        return 1.0, math.sin(min(angle, math.pi / 2))
    return (math.cosh(angle), math.sinh(angle)) if m else (1.0, 0.0)


def _angle_of(m: int, slope: float) -> float:
    """Return the angle whose sine (m = -1: hyperbolic) is the slope; m = 0: the slope."""
    if m > 0:
        return math.asin(min(slope, 1.0))
    return math.asinh(slope) if m else slope


def _stretch(m: int, shift: int) -> float:
    return math.sqrt(1 + m * math.ldexp(1.0, -2 * shift))


def _angles_left(table: StepTable, unit: Cau, start: float) -> list[float]:
    """Return the largest |z| in radians before each step of a rotation, and after the last."""
    left = [math.floor(math.ldexp(start, unit.angle_bits)) + 1]
    for angle in table.angles:
        left.append(max(angle, left[-1] - angle))
    return [value * _place(unit) for value in left]


@cache
def _table_error(sequence: Sequence, angle_bits: int) -> float:
    """Return the sum of the roundings of the angle table in radians."""
    table = step_table(sequence, angle_bits)
    scale = 1 << angle_bits
    exact = (exact_angle(sequence.m, shift, False) * scale for shift in sequence.shifts)
    return sum(float(abs(a - b)) for a, b in zip(exact, table.angles, strict=True)) / scale


def gain_error(sequence: Sequence, table: StepTable) -> float:
    """Return the relative error of the reciprocal gain."""
    product = exact_gain(sequence) * table.inverse_gain / (1 << (table.coordinate_bits + 1))
    return float(abs(product - 1))


def _zero_bits(unit: Cau) -> int:
    """Return the zero bits in which x ends in linear modes."""
    return unit.fraction_bits + 1 - unit.operand_bits


def _check(unit: Cau) -> None:
    if unit.fraction_bits < unit.operand_bits:
        raise ValueError(
            f"{unit.fraction_bits} fraction bits do not hold operands of {unit.operand_bits} bits"
        )


def _place(unit: Cau) -> float:
    """Return the last place of an angle in radians."""
    return math.ldexp(1.0, -unit.angle_bits)
