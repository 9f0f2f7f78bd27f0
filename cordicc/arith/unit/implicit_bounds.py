"""Proven error bounds of the unit's implicit operations: those of the kernels, and what surrounds them.

Places are the last places of the block of A, B and C. `bounds` and `hyperbolic_bounds` derive what the
kernels do on exact operands; added here is the alignment, which rounds operands to half a place.

Circular. The largest operand is exact. So A, B, C as the kernel sees them move B cos t + A sin t - C by at
most one place: by cos/2 + 1/2, or sin/2 + 1/2, or, if C is the largest, (cos + sin)/2. They may also have
|C| > R, though the operands have not, by one place at most: the kernel then ends as if C were R, a rounding
of the target by one more place. R is at least 2^(F-1) places, for if C is the largest then R >= |C|.

Hyperbolic, p = (B + A)/2, q = (B - A)/2, E = e^t, after the scaling by powers of two that leaves |ln E| at
most 0.9 (`implicit.hyperbolic`). S is the larger of |C| and the second result; it is |p| E + |q|/E. The
block's largest number is at least 2^(F-1) places and at most e^0.9 S. p and q are rounded to F bits each,
which moves p E + q/E by 2^-F S; then x, y and C to places, after eight guard bits, which moves y by at most
(1/2 + 2^-8) e^0.9 and C by 1/2 + 2^-8, counted twice for equations that lose their solution by it. On the way
from psi to theta both |x| and |y| are at most S + H, so the last angle a adds at most (S + H) (e^a - 1).

The end of reach. Where |C| is within the kernel's depth of N = R or sqrt(B^2 - A^2), see `end_of_reach`, the
unit may deliver the end instead: the residual is then at most that depth, and the angle is off by about
sqrt(2 depth/N) at most. With A or B alone the norm is known, and it delivers the end within the slack only.

Second result, both. With h the bound of |y(psi) - C|, alignment included, and w the exact result, x^2 differs
from w^2 by at most d = 2 |C| h + h^2, so x from w by at most d/w and sqrt d, and the roundings.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cordicc.arith.kernels.circular_bound import implicit_residual_bound
from cordicc.arith.kernels.end_of_reach import EndOfReach, end_of_reach
from cordicc.arith.kernels.gaps import HYPERBOLIC_ALIGNMENT, HYPERBOLIC_REACH, near_target
from cordicc.arith.kernels.hyperbolic_bound import hyperbolic_residual_bound
from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.arith.kernels.step_errors import NoBoundError
from cordicc.arith.unit.cau import Cau, implicit_iterations, implicit_steps
from cordicc.arith.unit.unit_bounds import PRODUCT_ROUNDING, LengthBound, composed, gain_error
from cordicc.base.arrays import Floats

_TOO_FEW = "{} fraction bits are too few for {} iterations"


@dataclass(frozen=True, slots=True)
class ImplicitUnitBound:
    """Errors of an implicit operation, not rounded to a format yet.

    `residual` bounds |B cos t + A sin t - C|, `across` the same before the angle table's rounding, `along`
    what the second result is off besides. The norm in `LengthBound.error` is hypot(A, B), or S for m = -1,
    the larger of |C| and the second result. All but `rest` hold where the unit does not deliver the end of
    reach instead, that is beyond `depth` of it; `end` tells what the kernel is off there.
    """

    residual: LengthBound
    across: LengthBound
    along: LengthBound
    end: EndOfReach

    def depth(self, place: Floats, slack: Floats | float, alone: bool) -> Floats:
        """Return the largest ||C| - N| at which the unit delivers the end, in the operands' unit.

        Args:
            place: the value of the block's last place.
            slack: what counts as the end before it, in the operands' unit.
            alone: whether A or B is 0.
        """
        known = np.asarray(slack, dtype=np.float64)
        return known if alone else np.asarray(self.end.depth(known / place) * place)

    def rest(
        self, norm: Floats, target: Floats, rest: Floats, place: Floats, depth: Floats | float = 0.0
    ) -> Floats:
        """Return the bound of the second result's error, from C and the exact second result.

        A result that may be that of the end is off by its depth there.
        """
        near = self.across.error(norm, place)
        near = np.where(rest <= end_rest(norm, depth), np.maximum(near, depth), near)
        change = near * (2 * np.abs(target) + near)
        return np.asarray(change / np.maximum(rest, np.sqrt(change)) + self.along.error(norm, place))


def end_rest(norm: Floats, depth: Floats | float) -> Floats:
    """Return the second result at a depth from the end; the norm is R, or for m = -1 at least |C|."""
    return np.asarray(np.sqrt(depth * (2 * norm + depth)) * (1 + 2.0**-40))


def implicit_bound(unit: Cau, m: int) -> ImplicitUnitBound:
    """Bound the errors of an implicit operation; the derivation is the module's text.

    Raises:
        ValueError: no implicit rule.
        NoBoundError: too few fraction bits.
    """
    return (_circular if m == 1 else _hyperbolic)(unit, implicit_iterations(unit, m))


def _circular(unit: Cau, sequence: Sequence) -> ImplicitUnitBound:
    largest = math.ldexp(math.sqrt(2), unit.fraction_bits)
    smallest = math.ldexp(1.0, unit.fraction_bits - 1)
    kernel = implicit_residual_bound(sequence, 0, unit.angle_bits, largest)
    if smallest < kernel.smallest_norm:
        raise NoBoundError(_TOO_FEW.format(unit.fraction_bits, unit.iterations))
    near = kernel.target_rounding + kernel.vector_rounding + kernel.vector_rounding**2 / smallest
    places = near + 2
    constant = gain_error(sequence, implicit_steps(unit, sequence.m))
    return ImplicitUnitBound(
        composed(kernel.last_angle + kernel.angle_rounding, places),
        composed(kernel.last_angle, places),
        composed(constant, kernel.vector_rounding + math.sqrt(0.5) + PRODUCT_ROUNDING),
        end_of_reach(sequence, unit.fraction_bits, unit.angle_bits),
    )


def _hyperbolic(unit: Cau, sequence: Sequence) -> ImplicitUnitBound:
    place = math.ldexp(math.exp(HYPERBOLIC_REACH), 1 - unit.fraction_bits)  # at most this of S
    largest = math.ldexp(1.0, unit.fraction_bits)
    spread = math.exp(HYPERBOLIC_REACH) * largest
    kernel = hyperbolic_residual_bound(sequence, 0, unit.angle_bits, largest, spread)
    if math.ldexp(math.exp(-HYPERBOLIC_REACH), unit.fraction_bits - 1) < 2 * kernel.smallest_start:
        raise NoBoundError(_TOO_FEW.format(unit.fraction_bits, unit.iterations))
    vector = kernel.vector_rounding
    near = near_target(sequence, vector, kernel.target_rounding, unit.fraction_bits)
    angle = kernel.angle + 2.0**-39 + math.ldexp(0.5, -unit.angle_bits)  # the multiple of ln 2
    places = (near + HYPERBOLIC_ALIGNMENT) * math.exp(angle) + HYPERBOLIC_ALIGNMENT
    flat = math.ldexp(1.0, -unit.fraction_bits) + 2.0**-48 + place * places
    along = place * (vector + HYPERBOLIC_ALIGNMENT + PRODUCT_ROUNDING) + gain_error(
        sequence, implicit_steps(unit, sequence.m)
    )
    end = end_of_reach(sequence, unit.fraction_bits, unit.angle_bits)
    return ImplicitUnitBound(composed(flat + angle), composed(flat + kernel.angle), composed(along), end)
