"""How far y may end from the target in an implicit kernel, though the equation has a solution.

The unit calls an equation solved if the two end within this gap, so it must be proven, or solutions are
lost. Notation and places as in `bounds` and `hyperbolic_bounds`: before the kernels' gain, the computed y and
target differ from the exact ones by at most E and D more than those from one another,

    |y_n - T_n|/K_n <= |y(psi_n) - C| + E + D.

Circular: |y(psi_n) - C| is at most R alpha_last + D + E + E^2/R. Hyperbolic: at most H + (S + H) (e^a - 1), S
the larger of |C| and the second result, which is at most e^0.9 2^F places, see `implicit_bounds`. Operands
rounded to places may leave an equation without a solution by at most one place (circular; |C| > R) or by
what rounding moves y and C (hyperbolic); the kernel then ends as if the target were off by as much, which
counts twice: on the way and at the end.
"""

from __future__ import annotations

import math

from cordicc.arith.kernels.circular_bound import implicit_residual_bound
from cordicc.arith.kernels.hyperbolic_bound import hyperbolic_residual_bound
from cordicc.arith.kernels.shift_sequences import Sequence

HYPERBOLIC_REACH = 0.9
"""The largest |t| that the hyperbolic kernel is left with, by `implicit.hyperbolic`'s powers of two."""

HYPERBOLIC_ALIGNMENT = (0.5 + 2.0**-8) * (math.exp(HYPERBOLIC_REACH) + 1)
"""Places by which the rounding of x, y and C moves y - C: each is off by half, with guard bits before."""


def largest_gap(sequence: Sequence, fraction_bits: int, angle_bits: int) -> float:
    """Return the bound of |y - target| at the end, in places of a block below 1.

    Raises ValueError if the sequence has no bound, see `implicit_residual_bound`.
    """
    largest = math.ldexp(1.0, fraction_bits)
    if sequence.m == 1:
        kernel = implicit_residual_bound(sequence, 0, angle_bits, math.sqrt(2) * largest)
        roundings = 2 * (kernel.vector_rounding + kernel.target_rounding)
        square = 2 * kernel.vector_rounding**2 / largest
        return sequence.gain * (math.sqrt(2) * largest * kernel.last_angle + roundings + square + 2)
    spread = math.exp(HYPERBOLIC_REACH) * largest
    end = hyperbolic_residual_bound(sequence, 0, angle_bits, largest, spread)
    near = near_target(sequence, end.vector_rounding, end.target_rounding, fraction_bits)
    moved = (near + HYPERBOLIC_ALIGNMENT) * math.exp(end.angle) + spread * math.expm1(end.angle)
    return sequence.gain * (moved + end.vector_rounding + end.target_rounding + HYPERBOLIC_ALIGNMENT)


def near_target(sequence: Sequence, vector: float, target: float, fraction_bits: int) -> float:
    """Return H of the hyperbolic kernel in places: how near y is to C at a wrong decision.

    Two branches: if x comes near 0, then the smallest y is N >= y0/cosh P, P the domain, and y0 is at least
    e^-0.9 of the block's largest number, so of 2^(F-1) places.
    """
    narrowest = math.ldexp(math.exp(-HYPERBOLIC_REACH), fraction_bits - 1) / math.cosh(sequence.domain)
    return target + vector + min(vector, vector * vector / (2 * narrowest))
