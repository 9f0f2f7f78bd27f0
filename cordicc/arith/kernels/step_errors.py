"""What one iteration of an implicit kernel errs by: its half-up shifts, and what it leaves out.

A half-up shift by b > 0 places errs by at most half a place, and by at most the number times 2^-b; by b <= 0
places not at all. The factor of a standard target is rounded to half of its last bit; that of a single
rotation in a root-free sequence lacks all but the first power of two. Where the target stands for y, x errs
by their distance times 2^-S.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, Sequence, exact_stretch, target_factor


class NoBoundError(ValueError):
    """The derivation of a bound needs more fraction bits."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """The largest |x|, |y|, |target| and |target - y| before an iteration, in the places of the errors."""

    x: float
    y: float
    target: float
    apart: float


@dataclass(frozen=True, slots=True)
class StepErrors:
    """What x, y and the target err by in an iteration, in places, and its stretch."""

    x: float
    y: float
    target: float
    stretch: float

    @property
    def vector(self) -> float:
        """The larger error of the two coordinates."""
        return max(self.x, self.y)


def shift_error(shift: int, size: float) -> float:
    """Return the largest error of a half-up shift of a number of at most that size, in places."""
    return 0.0 if shift <= 0 else min(0.5, math.ldexp(size, -shift))


def step_errors(sequence: Sequence, number: int, sizes: Sizes) -> StepErrors:
    """Return the errors of an iteration, counted from 0, of numbers of some sizes."""
    m, shift, double = sequence.m, sequence.shifts[number], sequence.is_double(number)
    stretch = float(exact_stretch(m, shift, double))
    if double:
        x = shift_error(shift - 1, sizes.y) + shift_error(2 * shift, sizes.x)
        y = shift_error(shift - 1, sizes.x) + shift_error(2 * shift, sizes.y)
        return StepErrors(x, y, shift_error(2 * shift, sizes.target), stretch)
    x, y = shift_error(shift, sizes.y), shift_error(shift, sizes.x)
    if not sequence.root_free:
        rounded = min(0.5, math.ldexp(sizes.target, -FACTOR_BITS) * abs(target_factor(m, shift)))
        return StepErrors(x, y, rounded + math.ldexp(sizes.target, -FACTOR_BITS - 1), stretch)
    left_out = abs(float(exact_stretch(m, shift, False) - 1) - math.ldexp(m, -2 * shift - 1))
    if sequence.is_settled(number):
        x += math.ldexp(sizes.apart, -shift)
    return StepErrors(x, y, shift_error(2 * shift + 1, sizes.target) + sizes.target * left_out, stretch)
