"""Proven error bound of the hyperbolic implicit kernels: last angle plus growth of the shifts' roundings.

Notation as in `cordicc.arith.kernels.circular_bound`: step i turns by s alpha_i and stretches by k_i, K_i
is the product of the first i stretches, psi_i the angle turned after i steps of *exact* arithmetic with the
kernel's own decisions, u_i = (x(psi_i), y(psi_i)) the start (A, B) turned by it, y(t) = B cosh t + A sinh t
and x(t) = A cosh t + B sinh t = dy/dt, theta the wanted angle, y(theta) = C.  P is the sum of all angles.

Starts. Either A >= |B|, A > 0 (one solution), or |B| > |A|, where the kernel looks for the solution with
x >= 0: then N = sqrt(B^2 - A^2), and |C| >= N with the sign of B.  theta lies in the domain, P plus the
last angle.  The larger of |A| and |B| exceeds E exp(P), E below.  Then on the whole way the larger
component exceeds E: (|A| + B) exp(t)/2 + (|A| - B) exp(-t)/2 >= |A| exp(-|t|), likewise with A, B exchanged.

Roundings.  A rotation by the hyperbolic angle a makes the larger component grow by at most exp(|a|).  So each
component of v_i/K_i differs from that of u_i by at most E, the sum of |e_j|/K_(j+1) exp(sum of the angles
after j), and T_i/K_i from C by at most D, the sum of |d_j|/K_(j+1).  `step_errors` has the errors e_j and d_j
of step j, |T| being at most K (|C| + D).  Where the target stands for y, their distance is at most
what y moves by the angle to go, from a solution where |x| and |y| are at most `largest_size`, and H, D and E.

Decisions.  Call one wrong if it is not the sign of theta - psi_i.
(a) A >= |B|: x > E, so the computed x is positive, the kernel compares, y(t) grows with t: a wrong decision
    means |y(psi_i) - C| <= D + E.  The same with |B| > |A| if both the computed and the exact x are >= 0.
(b) |B| > |A| and both are < 0: the kernel turns back by the sign of y, which |y| > E makes right.
(c) |B| > |A| and the signs differ: |x(psi_i)| <= E, so |y(psi_i)| exceeds N by at most G = E^2/(2 N), and by
    at most E.  Say B > 0.  A wrong comparison (exact x < 0) has C <= y(psi_i) + D + E, and between psi_i and
    theta y lies between N and the larger of y(psi_i) and C; a wrong turn back (exact x >= 0) has theta
    between 0 and psi_i, so y and C between N and y(psi_i).
So at a wrong decision all of y between psi_i and theta lies within H = D + E + min(E, G) of C.

End.  Each angle is at most the later ones plus the last plus s, a shortfall that repeated shifts keep small.
Hence right decisions alone end within alpha_last + s of theta, and after the last wrong one the direction
ends within that of the arc from psi_i to theta.  With delta for the rounding of the angle table, z is
within a = alpha_last + s + delta of an angle where |y - C| <= H, |y| <= Y = |C| + H and |x| <= W, W the root
of max(0, A^2 - B^2 + Y^2).  As y(t + a) - y(t) = y(t) (cosh a - 1) + x(t) sinh a,

    |B cosh z + A sinh z - C| <= Q = H + W sinh a + Y (cosh a - 1),

and from x^2 = A^2 - B^2 + y^2, with w = sqrt(A^2 - B^2 + C^2) and q = Q (2 |C| + Q), the computed x/K_n obeys

    ||x/K_n| - w| <= q / max(w, sqrt q) + E,

which is the square root's own condition: dw = C dC / w.  The branch is right: x >= -E at psi_i and x >= 0 at
theta, so x/K_n >= -E (1 + cosh a) - Y sinh a at the end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.arith.kernels.step_errors import NoBoundError, Sizes, step_errors
from cordicc.base.arrays import Floats


@dataclass(frozen=True, slots=True)
class HyperbolicBound:
    """The parts of the bound, lengths in units of the start vector's, angles in radians."""

    angle: float
    vector_rounding: float
    target_rounding: float
    smallest_start: float
    """Below this size of the larger component of a start the bound says nothing."""

    def residual(self, A: Floats, B: Floats, C: Floats) -> Floats:
        """Return the bound of |B cosh z + A sinh z - C|."""
        near = self._near(A, B)
        height = np.abs(C) + near
        width = np.sqrt(np.maximum(0, (A - B) * (A + B) + height**2))
        return np.asarray(near + width * math.sinh(self.angle) + height * (math.cosh(self.angle) - 1))

    def _near(self, A: Floats, B: Floats) -> Floats:
        """Return H."""
        two_branches = np.abs(B) > np.abs(A)
        narrowest = np.sqrt(np.where(two_branches, (B - A) * (B + A), np.inf))
        excess = np.minimum(self.vector_rounding, self.vector_rounding**2 / (2 * narrowest))
        return np.asarray(self.target_rounding + self.vector_rounding + excess)

    def smallest_end_x(self, A: Floats, B: Floats, C: Floats) -> Floats:
        """Return the smallest x/gain: below 0, but not so far as to be the other solution."""
        height = np.abs(C) + self._near(A, B)
        flat = self.vector_rounding * (1 + math.cosh(self.angle))
        return np.asarray(-flat - height * math.sinh(self.angle))

    def root(self, A: Floats, B: Floats, C: Floats) -> Floats:
        """Return the bound of ||x/gain| - sqrt(A^2 - B^2 + C^2)|."""
        residual = self.residual(A, B, C)
        change = residual * (2 * np.abs(C) + residual)
        root = np.sqrt(np.maximum(0, (A - B) * (A + B) + C**2))
        return np.asarray(change / np.maximum(root, np.sqrt(change)) + self.vector_rounding)


def hyperbolic_residual_bound(
    sequence: Sequence,
    fraction_bits: int,
    angle_bits: int,
    largest_target: float = 1.0,
    largest_size: float = math.inf,
) -> HyperbolicBound:
    """Bound the errors of a hyperbolic implicit kernel; the derivation is the module's text.

    Args:
        sequence: a hyperbolic sequence; `root_free` says which of the two kernels runs it.
        fraction_bits: of x, y and the target inside the kernel, guard bits included.
        angle_bits: fraction bits of z.
        largest_target: the largest |C|; start and target are exact.
        largest_size: the largest |x| and |y| at a solution, which matters where the target stands for y.

    Raises:
        ValueError: not hyperbolic, or the target stands for y too early.
    """
    if sequence.m != -1:
        raise ValueError(f"no bound for {sequence.name}: it must be hyperbolic")
    place = math.ldexp(1.0, -fraction_bits)
    angles = [float(angle) for angle in sequence.angles]
    later, end = sum(angles), angles[-1] + _shortfall(angles)
    gain, vector, target = 1.0, 0.0, 0.0
    for number, angle in enumerate(angles):
        left = later + end
        later -= angle
        # Of the errors to come each is at most two places.
        come = 2.0 * (len(angles) - number)
        rounded = (2 * (vector + come) + target + come) * math.exp(left) + vector + target + 2 * come
        apart = gain * (largest_size / place * math.expm1(left) + rounded)
        sizes = Sizes(math.inf, math.inf, gain * (largest_target / place + target), apart)
        errors = step_errors(sequence, number, sizes)
        gain *= errors.stretch
        vector += errors.vector / gain * math.exp(later)
        target += errors.target / gain
        if sequence.is_settled(number) and max(errors.vector * math.exp(later), errors.target) > 2 * gain:
            raise NoBoundError(
                f"{sequence.name}: too few fraction bits for {len(angles)} iterations, "
                "of which the last take the target for y"
            )
    vector, target = vector * place, target * place
    rounding = len(angles) * math.ldexp(1.0, -angle_bits - 1)
    return HyperbolicBound(end + rounding, vector, target, vector * math.exp(sum(angles)))


def _shortfall(angles: list[float]) -> float:
    """Return by how much an angle exceeds the sum of the later ones plus the last at most."""
    rest, shortfall = angles[-1], 0.0
    for angle in reversed(angles):
        shortfall = max(shortfall, angle - rest)
        rest += angle
    return shortfall
