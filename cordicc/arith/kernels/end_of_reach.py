"""Where an implicit kernel cannot tell a solution from the end of reach, |C| = R, and turns to the end.

At the end y is at its extreme and x = 0: the last angles change y by less than its roundings, so that a
comparison with the target would decide by chance, and leave an angle of sqrt(2 e/R) for an error e of y - C.
The sign of x tells the way to the end as well as it tells vectoring's. So where x > 0 is at most a *width*
and |y - T| at most a *height* the kernel turns towards the end, that is in the target's direction (m = -1,
where y has its least value there: against it). Elsewhere it compares; at x = 0 either way is right, and
sgn(0) = +1 the one from which a first turn by 90 degrees comes back. Notation and places as in
`circular_bound` and `hyperbolic_bound`; N stands for R (m = 1) or sqrt(B^2 - A^2) (m = -1).

Height and width. Let the exact equation have |C| = N, and let the kernel's operands move N - C by at most s
places: alignment, and a slack for what the operands were rounded before. With the errors E' of y, E of x
and D of the target, before the gain, y - T is off by at most e = E' + D + s. As |y| = sqrt(N^2 - m x^2), the
exact |y - C| is at least x^2/(2 Y), Y the largest of N and |y|, at most e beyond the largest number of a
block. So the comparison has the right sign, or

    |y - T| <= K e   and   x <= K (sqrt(2 Y e) + E),

K the product of stretches so far, of which the step table knows the share of the largest, rounded up. With
these as height and width *every* decision at x > 0 is towards the end, and where x < 0 the kernel turns
back: it does what vectoring onto the y axis does, and ends within the last angle, and asin(E/N) (m = -1:
asinh), of the end.

E' is less than E. For a target at the end |psi - theta| is at most the angles still to come, so x is at most
N times their sum, and the roundings of its shifts, which are what y errs by, vanish as 2^-2S (m = 1; for
m = -1 E is taken).

Depth. Elsewhere nothing changes: a decision is made by the sign of x only if the exact x is at most the width
over K and E, and |y - C| at most the height over K and e; both grow by the rounding of the shares. Then
|N - C| is at most the `depth`: this |y - C|, and N - sqrt(N^2 - x^2) = x^2/(N + sqrt(N^2 - x^2)), or
sqrt(N^2 + x^2) - N. That is also by how much y may end beyond the target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from cordicc.arith.kernels.circular_bound import implicit_residual_bound, shift_error
from cordicc.arith.kernels.gaps import HYPERBOLIC_ALIGNMENT, HYPERBOLIC_REACH
from cordicc.arith.kernels.hyperbolic_bound import hyperbolic_residual_bound
from cordicc.arith.kernels.shift_sequences import SHARES, Sequence, exact_angle, step_table
from cordicc.base.arrays import Floats

_ALIGNMENT = 1.0
"""Places by which the rounding of A, B and C to the block moves R - C, see `implicit_bounds`."""

_UP = 1 + 2.0**-40
"""Makes up for the roundings of this module's own arithmetic."""


@dataclass(frozen=True, slots=True)
class EndOfReach:
    """What a kernel is off near the end, in places before the gain, and the sizes that matter there.

    `across` is e without the slack, `along` E; `largest` a block's largest number and `smallest` the least
    N; `stretch` the largest product of stretches, `rounded` by what factor a share of it exceeds one.
    """

    m: int
    across: float
    along: float
    largest: float
    smallest: float
    stretch: float
    rounded: float

    def height(self, slack: Floats | float) -> Floats:
        """Return the largest |y - T| at which the sign of x decides, in the kernel's places.

        Args:
            slack: places by which the operands may have moved N - C before.
        """
        return np.asarray(self.stretch * (self.across + slack) * _UP)

    def width(self, slack: Floats | float) -> Floats:
        """Return the largest x at which the sign of x decides, in the kernel's places."""
        error = self.across + slack
        return np.asarray(self.stretch * (np.sqrt(2 * (self.largest + error) * error) + self.along) * _UP)

    def depth(self, slack: Floats | float) -> Floats:
        """Return the largest |N - C| in places for which the kernel may turn to the end instead."""
        over = self.rounded / self.stretch
        x = self.width(slack) * over + self.along
        if self.m > 0:
            part = np.minimum(x, self.smallest)
            fall = part * part / (self.smallest + np.sqrt(self.smallest**2 - part**2))
        else:
            fall = x * x / (self.smallest + np.hypot(self.smallest, x))
        return np.asarray((fall + self.height(slack) * over + self.across) * _UP)


@cache
def end_of_reach(sequence: Sequence, fraction_bits: int, angle_bits: int) -> EndOfReach:
    """Return what the kernel of a sequence is off near the end; the derivation is the module's text.

    Raises ValueError if the sequence has no bound, see `implicit_residual_bound`.
    """
    largest = math.ldexp(1.0, fraction_bits)
    stretches = [1.0]
    for shift in sequence.shifts:
        square = 1 + sequence.m * math.ldexp(1.0, -2 * shift)
        stretches.append(stretches[-1] * (square if sequence.root_free else math.sqrt(square)))
    stretch = max(stretches)
    shares = step_table(sequence, angle_bits).stretched
    rounded = max(share * stretch / (SHARES * own) for share, own in zip(shares, stretches, strict=False))
    if sequence.m > 0:
        # Beside the end |C| is the largest number of the block, or all but equal to it.
        bound = implicit_residual_bound(sequence, 0, angle_bits, math.sqrt(2) * largest)
        across = _error_of_y(sequence, largest, bound.vector_rounding) + bound.target_rounding + _ALIGNMENT
        return EndOfReach(1, across, bound.vector_rounding, largest, largest / 2 - 1, stretch, rounded)
    end = hyperbolic_residual_bound(sequence, 0, angle_bits, largest)
    across = end.vector_rounding + end.target_rounding + HYPERBOLIC_ALIGNMENT
    smallest = largest / 2 * math.exp(-HYPERBOLIC_REACH) / math.cosh(sequence.domain)
    return EndOfReach(-1, across, end.vector_rounding, largest, smallest, stretch, rounded)


def _error_of_y(sequence: Sequence, largest: float, along: float) -> float:
    """Return E': the roundings of y's own shifts, and of x's as far as later steps turn them into y."""
    angles = [float(exact_angle(1, shift, sequence.root_free)) for shift in sequence.shifts]
    left, later, gain, total = math.pi, sum(angles), 1.0, 0.0
    for shift, angle in zip(sequence.shifts, angles, strict=True):
        later -= angle
        norm = gain * (largest + along)
        across = gain * (largest * min(left, 1.0) + 2 * along)  # |x|, twice the error for asin(E/R)
        if sequence.root_free:
            error_y = shift_error(shift - 1, across) + shift_error(2 * shift, norm)
            error_x = shift_error(shift - 1, norm) + shift_error(2 * shift, across)
            gain *= 1 + math.ldexp(1.0, -2 * shift)
        else:
            error_y, error_x = shift_error(shift, across), shift_error(shift, norm)
            gain *= math.sqrt(1 + math.ldexp(1.0, -2 * shift))
        total += (error_y + error_x * math.sin(min(later, math.pi / 2))) / gain
        left = later + angles[-1]
    return total
