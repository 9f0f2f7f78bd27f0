"""Where an implicit kernel cannot tell a solution from the end of reach, |C| = R, and turns to the end.

At the end y is at its extreme and x = 0: the last angles change y by less than its roundings, so that a
comparison with the target would decide by chance, and leave an angle of sqrt(2 e/R) for an error e of y - C.
The sign of x tells the way to the end as well as it tells vectoring's. So where x >= 0 is at most a *width*
and |T - y| at most a *height* the kernel turns towards the end, that is in the target's direction (m = -1,
where y has its least value there: against it); at x = 0 either way is right. Elsewhere it compares. Notation
and places as in `circular_bound` and `hyperbolic_bound`; N stands for R (m = 1) or sqrt(B^2 - A^2) (m = -1).

Height and width. Let the exact equation have |C| = N, and let the kernel's operands move N - C by at most s
places: alignment, and a slack for what the operands were rounded before. With the errors E' of y, E of x
and D of the target, before the gain, y - T is off by at most e = E' + D + s. As |y| = sqrt(N^2 - m x^2), the
exact |y - C| is at least x^2/(2 Y), Y the larger of N and |y|, which is at most e beyond |C|. So the
comparison has the right sign, or

    |y - T| <= K e   and   x <= K (sqrt(2 Y e) + E) <= K (sqrt(2 |C| e) + sqrt(2) e + E),

K the product of stretches so far, of which the step table knows the share of the largest, rounded up.
With these as height and width, or more, *every* decision at x >= 0 is towards the end, and where x < 0 the
kernel turns back: it does what vectoring onto the y axis does, and ends within the last angle, and asin(E/N)
(m = -1: asinh), of the end. They are rounded up to a few leading bits, less 1, with which few gates compare.
Of |C| the leading bits are enough: `ROOTS` are those of its sixteenths of a block. On the circle |C| is
nearly a block's largest number, and there are two widths: for |C| below `UPPER` sixteenths, and for others.

E' is less than E. For a target at the end |psi - theta| is at most the angles still to come, so x is at most
N times the sine (m = -1: sinh) of their sum, and the roundings of its shifts, which are what y errs by,
vanish as 2^-2S; so do the products of the target that are rounded.

Depth. Elsewhere nothing changes: a decision is made by the sign of x only if the exact x is at most the width
over K and E, and |y - C| at most the height and a place over K and e; both grow by what the shares are more.
Then |N - C| is at most the `depth`: this |y - C|, and N - sqrt(N^2 - x^2) = x^2/(N + sqrt(N^2 - x^2)), or
sqrt(N^2 + x^2) - N. That is also by how much y may end beyond the target.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from cordicc.arith.kernels.circular_bound import implicit_residual_bound
from cordicc.arith.kernels.gaps import HYPERBOLIC_ALIGNMENT, HYPERBOLIC_REACH
from cordicc.arith.kernels.hyperbolic_bound import hyperbolic_residual_bound
from cordicc.arith.kernels.shift_sequences import SHARES, Sequence, step_table
from cordicc.arith.kernels.step_errors import Sizes, step_errors
from cordicc.arith.kernels.thresholds import ROOT_SCALE, ROOTS, SIXTEENTHS, UPPER
from cordicc.base.arrays import Floats

_ALIGNMENT = 1.0
"""Places by which the rounding of A, B and C to the block moves R - C, see `implicit_bounds`."""

_HEIGHT_BITS, _WIDTH_BITS = 6, 4
"""Leading bits that thresholds keep: what the height is more an angle at the end is off by."""

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
        return leading(self.stretch * (self.across + slack) * _UP, _HEIGHT_BITS)

    def rise(self, slack: Floats | float) -> Floats:
        """Return by how much the width grows with the root of |C| at most, on the circle from `UPPER` on."""
        if self.m < 0:
            return np.ceil(self._rise(slack))
        return leading(self._rise(slack) + self._room(slack), _WIDTH_BITS) - self.room(slack)

    def room(self, slack: Floats | float) -> Floats:
        """Return the width without what grows with |C|."""
        if self.m < 0:
            return np.ceil(self._room(slack))
        return leading(math.sqrt(UPPER / SIXTEENTHS) * self._rise(slack) + self._room(slack), _WIDTH_BITS)

    def width(self, slack: Floats | float, sixteenths: int = SIXTEENTHS) -> Floats:
        """Return the largest x at which its sign decides, for a |C| of so many sixteenths of a block."""
        if self.m > 0:
            return self.room(slack) + self.rise(slack) * (sixteenths >= UPPER)
        return aligned(np.ceil(self.rise(slack) * (ROOTS[sixteenths] / ROOT_SCALE)) + self.room(slack))

    def _rise(self, slack: Floats | float) -> Floats:
        return np.asarray(self.stretch * np.sqrt(2 * self.largest * (self.across + slack)) * _UP)

    def _room(self, slack: Floats | float) -> Floats:
        error = self.across + slack
        return np.asarray(self.stretch * (math.sqrt(2) * error + self.along) * _UP)

    def depth(self, slack: Floats | float) -> Floats:
        """Return the largest |N - C| in places for which the kernel may turn to the end instead."""
        over = self.rounded / self.stretch
        near = (self.height(slack) + 1) * over + self.across
        deepest = np.zeros_like(near)
        for sixteenth in range(SIXTEENTHS + 1):
            x = self.width(slack, sixteenth) * over + self.along
            # |C| is at least so many sixteenths of a block, and N, for m = -1, may be less by what is added.
            added = near + x * x / (2 * self.smallest) if self.m < 0 else 0.0
            N = np.maximum(sixteenth * self.largest / SIXTEENTHS - added, self.smallest)
            if self.m > 0:
                part = np.minimum(x, N)
                fall = part * part / (N + np.sqrt(N * N - part * part))
            else:
                fall = x * x / (N + np.hypot(N, x))
            reached = (sixteenth + 1) * self.largest / SIXTEENTHS >= self.smallest - near - fall
            deepest = np.maximum(deepest, np.where(reached, fall + near, 0.0))
        return np.asarray(deepest * _UP)


def aligned(size: Floats | float) -> Floats:
    """Return the least multiple of `SHARES` less 1 that is no less than a size of at least 0."""
    return np.asarray(np.floor(size / SHARES) * SHARES + (SHARES - 1))


def leading(size: Floats | float, bits: int) -> Floats:
    """Return the same of a multiple that has no bits but so many leading ones and trailing zeros."""
    place = np.ldexp(1.0, np.maximum(np.frexp(np.ceil(size) + 1)[1] - bits, SHARES.bit_length() - 1))
    return np.asarray(np.ceil((np.ceil(size) + 1) / place) * place - 1)


@cache
def end_of_reach(sequence: Sequence, fraction_bits: int, angle_bits: int) -> EndOfReach:
    """Return what the kernel of a sequence is off near the end; the derivation is the module's text.

    Raises ValueError if the sequence has no bound, see `implicit_residual_bound`.
    """
    largest = math.ldexp(1.0, fraction_bits)
    if sequence.m > 0:
        along = implicit_residual_bound(sequence, 0, angle_bits, math.sqrt(2) * largest).vector_rounding
        # Beside the end |C| is the largest number of the block, or all but equal to it.
        smallest, aligned = largest / 2 - 1, _ALIGNMENT
    else:
        spread = math.exp(HYPERBOLIC_REACH) * largest
        along = hyperbolic_residual_bound(sequence, 0, angle_bits, largest, spread).vector_rounding
        smallest = largest / 2 * math.exp(-HYPERBOLIC_REACH) / math.cosh(sequence.domain)
        aligned = HYPERBOLIC_ALIGNMENT
    across_turn, turn = (math.sin, math.cos) if sequence.m > 0 else (math.sinh, math.cosh)
    angles = [float(angle) for angle in sequence.angles]
    stretches, across, left, later = [1.0], aligned, math.pi, sum(angles)
    for number, angle in enumerate(angles):
        gain = stretches[-1]
        left = min(left, later + angles[-1])
        later -= angle
        # |x| as far as the angles to come reach; twice the error for that of the angle.
        x = gain * (largest * across_turn(min(left, math.pi / 2)) + 2 * along)
        sizes = Sizes(x, gain * (largest + along), gain * (largest + across), x * left + 4 * gain * along)
        errors = step_errors(sequence, number, sizes)
        stretches.append(gain * errors.stretch)
        reach = min(later, math.pi / 2)
        turned = errors.y * max(1.0, turn(reach)) + errors.x * across_turn(reach)
        across += (turned + errors.target) / stretches[-1]
    stretch = max(stretches)
    shares = step_table(sequence, angle_bits).stretched
    rounded = max(share * stretch / (SHARES * own) for share, own in zip(shares, stretches, strict=False))
    return EndOfReach(sequence.m, across, along, largest, smallest, stretch, rounded)
