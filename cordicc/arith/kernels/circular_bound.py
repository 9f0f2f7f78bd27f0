"""Proven error bound of the circular implicit kernels: last angle plus growth of the shifts' roundings.

Notation: step i turns by s alpha_i, s = +-1, and stretches by k_i; K_i is the product of the first i
stretches, n the number of steps, theta in [-pi/2, pi/2] the wanted direction (R sin theta = C), psi_i the
direction after i steps of *exact* arithmetic with the kernel's own decisions, u_i that vector of norm R.

Roundings.  The kernel computes v' = k_i Rot(s alpha_i) v + e_i and T' = k_i T + d_i.  So v_i/K_i differs
from u_i by the sum of e_j/K_(j+1), each turned by the steps from j+1 to i, an angle of at most rho_j, the sum
of the later ones; and T_i/K_i from C by at most D, the sum of |d_j|/K_(j+1).  `step_errors` has the errors of
an iteration.  If both components of e_j are at most e, turned they are at most e (1 + sin rho_j), so either
component of v_i/K_i errs by at most E, the sum of e_j (1 + sin rho_j)/K_(j+1).  Where the target stands for
y, x errs by |T - y| 2^-S more; of an equation with a solution that distance is at most K_i times R times the
angle to go, H, D and E, by what follows.

Decisions.  Call one wrong if it is not the sign of theta - psi_i.  Let R >= 4 E.
(a) Both the computed and the exact x are >= 0: a wrong comparison means |R sin psi_i - C| <= D + E.
(b) Both are < 0. After the first step nothing has been rounded yet (S = 0), so the sign of y is exact.
    Later steps turn by at most 53.2 degrees from within asin(E/R) of the right half-plane, so psi_i stays
    at least 36.8 degrees less asin(E/R) away from 180, and |y| > E has the right sign: never wrong.
(c) The signs differ: |x| <= E, so psi_i is within asin(E/R) of +-90 degrees, where R - |y| <= E^2/R.
    Where the kernel turns back, a wrong turn has theta between psi_i and +-90 degrees; where it compares,
    y is within D + E of C or C is beyond y. Either way all of y between psi_i and theta lies within D + E
    + E^2/R of C.
So at a wrong decision every direction between psi_i and theta has a residual of at most H = D + E + E^2/R.

End.  With |theta - psi_0| and each alpha_i at most the later angles plus the last (Walther's condition,
`Sequence.converges`), right decisions alone end within the last angle of theta.  After the last wrong one
the direction ends within the last angle of the arc from psi_i to theta: moving by an angle changes y by
at most R times it.  Hence, with delta for the rounding of the angle table,

    |B cos t + A sin t - C| <= R (alpha_last + delta) + D + E + E^2/R,

and the branch is right: psi_i is at most asin(E/R) outside the right half-plane, so the exact x at the end
is at least -E - R (alpha_last + delta).

The two parts are those of Y. H. Hu, "The quantization effects of the CORDIC algorithm", IEEE Trans. Signal
Processing 40(4), 1992 (angle approximation, and rounding carried through the later steps); the argument for
wrong decisions with an arbitrary target is our own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.arith.kernels.step_errors import NoBoundError, Sizes, step_errors

Norm = TypeVar("Norm", float, NDArray[np.float64])


@dataclass(frozen=True, slots=True)
class ImplicitBound:
    """The parts of the bound, lengths in units of the start vector's, angles in radians."""

    last_angle: float
    angle_rounding: float
    vector_rounding: float
    target_rounding: float

    @property
    def smallest_norm(self) -> float:
        """The norm from which on the bound holds."""
        return 4 * self.vector_rounding

    def residual(self, norm: Norm) -> Norm:
        """Return the bound of |B cos t + A sin t - C| for a norm in [`smallest_norm`, the largest]."""
        angle = self.last_angle + self.angle_rounding
        square = self.vector_rounding * self.vector_rounding
        return norm * angle + self.target_rounding + self.vector_rounding + square / norm

    def smallest_end_x(self, norm: Norm) -> Norm:
        """Return the smallest A cos t - B sin t: below 0, but not so far as to be the other solution."""
        return -(norm * (self.last_angle + self.angle_rounding) + self.vector_rounding)


def implicit_residual_bound(
    sequence: Sequence, fraction_bits: int, angle_bits: int, largest_norm: float = 1.0
) -> ImplicitBound:
    """Bound the residual of a circular implicit kernel; the derivation is the module's text.

    Args:
        sequence: a circular sequence; `root_free` says which of the two kernels runs it.
        fraction_bits: of x, y and the target inside the kernel, guard bits included.
        angle_bits: fraction bits of z.
        largest_norm: the largest norm of a start vector; its components are exact.

    Raises:
        ValueError: not circular, too small a domain, or not convergent.
    """
    needed = math.pi if sequence.root_free else math.pi / 2  # the standard kernel starts with a quarter turn
    single_zero = sequence.shifts[0] == 0 and min(sequence.shifts[1:], default=1) >= 1
    if sequence.m != 1 or not single_zero or sequence.domain < needed or not sequence.converges:
        raise ValueError(
            f"no bound for {sequence.name}: it must be circular, start with the only 0, converge"
        )
    largest = math.ldexp(largest_norm, fraction_bits)
    angles = [float(angle) for angle in sequence.angles]
    later, left = sum(angles), math.pi
    gain, vector, target = 1.0, 0.0, 0.0
    for number, angle in enumerate(angles):
        norm, height = gain * (largest + math.sqrt(2) * vector), gain * (largest + target)
        left = min(left, later + angles[-1])
        later -= angle
        # Of the errors to come each is at most two places.
        come = 2.0 * (len(angles) - number)
        apart = gain * (largest * left + 2 * (target + come) + 2.25 * (vector + come))
        errors = step_errors(sequence, number, Sizes(norm, norm, height, apart))
        gain *= errors.stretch
        vector += errors.vector * (1 + math.sin(min(later, math.pi / 2))) / gain
        target += errors.target / gain
        if sequence.is_settled(number) and max(errors.vector, errors.target) > gain:
            raise NoBoundError(
                f"{sequence.name}: too few fraction bits for {len(angles)} iterations, "
                "of which the last take the target for y"
            )
    vector, target = math.ldexp(vector, -fraction_bits), math.ldexp(target, -fraction_bits)
    # Half a unit an angle and for the half turn; the quarter turn, half of a rounded pi, errs by 3/4.
    angle_rounding = (len(sequence.shifts) + 3) * math.ldexp(1.0, -angle_bits - 1)
    return ImplicitBound(sequence.resolution, angle_rounding, vector, target)
