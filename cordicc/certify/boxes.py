"""Interval arithmetic on many boxes at once: arrays of lower and upper ends, rounded outwards.

Sums, products, quotients and roots of doubles are off by at most half a last place, so moving a result by
two makes it a bound.  Of NumPy's elementary functions an error of at most 2^-46 relative and 2^-60 besides
is assumed, some hundred times what their libraries state; a test compares them with Arb.
Infinite ends mean unbounded; 0 times them is 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cordicc.base.arrays import Bools, Floats

_LAST = 2.0**-51
_TINY = 1e-300
_LARGEST = 1e300
_FUNCTION = 2.0**-46
_FUNCTION_TINY = 2.0**-60

TAU_UP = math.nextafter(math.tau, 7)
PI_UP = math.nextafter(math.pi, 4)


@dataclass(frozen=True, slots=True)
class Boxes:
    """Intervals [lo, hi], one for each box."""

    lo: Floats
    hi: Floats

    @property
    def magnitude(self) -> Floats:
        """The largest absolute values."""
        return np.maximum(np.abs(self.lo), np.abs(self.hi))

    @property
    def mignitude(self) -> Floats:
        """The smallest absolute values."""
        return np.maximum(np.maximum(self.lo, -self.hi), 0.0)

    def __neg__(self) -> Boxes:
        return Boxes(-self.hi, -self.lo)

    def __add__(self, other: Boxes) -> Boxes:
        return _out(self.lo + other.lo, self.hi + other.hi)

    def __sub__(self, other: Boxes) -> Boxes:
        return _out(self.lo - other.hi, self.hi - other.lo)

    def __mul__(self, other: Boxes) -> Boxes:
        a, b = self.lo * other.lo, self.lo * other.hi
        c, d = self.hi * other.lo, self.hi * other.hi
        low = np.minimum(np.minimum(a, b), np.minimum(c, d))
        if np.isnan(low).any():
            a, b, c, d = (np.where(np.isnan(end), 0.0, end) for end in (a, b, c, d))
            low = np.minimum(np.minimum(a, b), np.minimum(c, d))
        return _out(low, np.maximum(np.maximum(a, b), np.maximum(c, d)))

    def __truediv__(self, other: Boxes) -> Boxes:
        """Enclose the quotient; unbounded where the divisor holds 0."""
        return self * other.reciprocal()

    def reciprocal(self) -> Boxes:
        """Enclose 1/x; unbounded where x may be 0."""
        holds = (self.lo <= 0) & (self.hi >= 0)
        made = _out(1 / np.where(holds, 1.0, self.hi), 1 / np.where(holds, 1.0, self.lo))
        return Boxes(np.where(holds, -math.inf, made.lo), np.where(holds, math.inf, made.hi))

    def scaled(self, factor: float) -> Boxes:
        """Enclose the product with a double."""
        if factor == 0:
            return Boxes(np.zeros_like(self.lo), np.zeros_like(self.hi))
        a, b = self.lo * factor, self.hi * factor
        return _out(a, b) if factor >= 0 else _out(b, a)

    def widened(self, by: Floats | float) -> Boxes:
        """Return the intervals with `by` >= 0 more on either side."""
        return _out(self.lo - by, self.hi + by)

    def meet(self, other: Boxes) -> Boxes:
        """Return the common parts, where there is none these intervals."""
        lo, hi = np.maximum(self.lo, other.lo), np.minimum(self.hi, other.hi)
        return Boxes(lo, hi).where(lo <= hi, self)

    def apart(self, other: Boxes) -> Bools:
        """Tell where there is no common part."""
        return (self.lo > other.hi) | (self.hi < other.lo)

    def within(self, size: Floats | float) -> Boxes:
        """Return the parts in [-size, size]."""
        return self.meet(Boxes(-np.asarray(size), np.asarray(size)))

    def join(self, other: Boxes) -> Boxes:
        """Return the smallest intervals around both."""
        return Boxes(np.minimum(self.lo, other.lo), np.maximum(self.hi, other.hi))

    def where(self, condition: Bools, other: Boxes) -> Boxes:
        """Return these intervals where a condition holds, else the others."""
        return Boxes(np.where(condition, self.lo, other.lo), np.where(condition, self.hi, other.hi))

    def absolute(self) -> Boxes:
        """Return |x|."""
        return Boxes(self.mignitude, self.magnitude)

    def square(self) -> Boxes:
        """Enclose x^2."""
        small, large = self.mignitude, self.magnitude
        made = _out(small * small, large * large)
        return Boxes(np.maximum(made.lo, 0.0), made.hi)

    def sqrt(self) -> Boxes:
        """Enclose the root of the non-negative parts."""
        made = _out(np.sqrt(np.maximum(self.lo, 0.0)), np.sqrt(np.maximum(self.hi, 0.0)))
        return Boxes(np.maximum(made.lo, 0.0), made.hi)

    def monotone(self, function: Callable[[Floats], Floats]) -> Boxes:
        """Enclose an increasing function of NumPy."""
        return _loose(function(self.lo), function(self.hi))


def _out(lo: Floats, hi: Floats) -> Boxes:
    low, high = lo - (np.abs(lo) * _LAST + _TINY), hi + (np.abs(hi) * _LAST + _TINY)
    if np.isnan(low).any() or np.isnan(high).any():  # a lower end of +infinity, or infinities added
        low = np.where(np.isnan(low), np.where(lo > 0, _LARGEST, -math.inf), low)
        high = np.where(np.isnan(high), np.where(hi < 0, -_LARGEST, math.inf), high)
    return Boxes(low, high)


def _loose(lo: Floats, hi: Floats) -> Boxes:
    low = lo - (np.abs(lo) * _FUNCTION + _FUNCTION_TINY)
    return Boxes(low, hi + (np.abs(hi) * _FUNCTION + _FUNCTION_TINY))


def point(value: float, count: int) -> Boxes:
    """Return the same double for each box."""
    column = np.full(count, value)
    return Boxes(column, column)


def symmetric(size: Floats) -> Boxes:
    """Return [-size, size]."""
    return Boxes(-size, size)


def hypot(a: Boxes, b: Boxes) -> Boxes:
    """Enclose sqrt(a^2 + b^2)."""
    return (a.square() + b.square()).sqrt()


def times(size: Floats, error: Floats | float) -> Floats:
    """Return the product of non-negative numbers, 0 where one of them is 0 and the other without bound."""
    size, error = np.broadcast_arrays(size, error)
    return np.multiply(size, error, out=np.zeros(size.shape), where=(size != 0) & (error != 0))


def up(value: Floats) -> Floats:
    """Return an upper bound of a non-negative number that a few roundings have made."""
    return np.asarray(value * (1 + 2.0**-45) + _TINY)


def cosine(angle: Boxes) -> Boxes:
    """Enclose cos."""
    return _wave(angle, np.cos, 0.0)


def sine(angle: Boxes) -> Boxes:
    """Enclose sin."""
    return _wave(angle, np.sin, 0.25)


def _wave(angle: Boxes, function: Callable[[Floats], Floats], top: float) -> Boxes:
    """Enclose a wave with its maxima at `top` + k turns."""
    ends = _loose(
        np.minimum(function(angle.lo), function(angle.hi)), np.maximum(function(angle.lo), function(angle.hi))
    )
    first, last = angle.lo / math.tau - top - 1e-12, angle.hi / math.tau - top + 1e-12
    high = np.floor(last) >= first
    low = np.floor(last - 0.5) >= first - 0.5
    lo = np.where(low, -1.0, np.maximum(ends.lo, -1.0))
    return Boxes(lo, np.where(high, 1.0, np.minimum(ends.hi, 1.0)))


def cosh(angle: Boxes) -> Boxes:
    """Enclose cosh."""
    made = angle.absolute().monotone(np.cosh)
    return Boxes(np.maximum(made.lo, 1.0), made.hi)


def sinh(angle: Boxes) -> Boxes:
    """Enclose sinh."""
    return angle.monotone(np.sinh)


def direction(y: Boxes, x: Boxes) -> Boxes:
    """Enclose the angle of (x, y), modulo a turn so that it has no cut but where the vector may be 0.

    The box is seen from its middle's direction; a box that holds 0 has every angle.
    """
    middle = np.arctan2((y.lo + y.hi) / 2, (x.lo + x.hi) / 2)
    c, s = np.cos(middle), np.sin(middle)
    along = Boxes(c, c) * x + Boxes(s, s) * y
    across = Boxes(c, c) * y - Boxes(s, s) * x
    # c and s are no unit vector to the last bit; the angle of the turned vector is.
    forward = along.lo > 0
    safe = np.where(forward, along.lo, 1.0)
    low = np.where(across.lo < 0, across.lo / safe, across.lo / np.where(forward, along.hi, 1.0))
    high = np.where(across.hi > 0, across.hi / safe, across.hi / np.where(forward, along.hi, 1.0))
    turn = _loose(np.arctan(low), np.arctan(high))
    made = _loose(middle + turn.lo, middle + turn.hi).widened(2.0**-48)
    return made.where(forward, Boxes(np.array(-PI_UP), np.array(PI_UP)))


def crosses_cut(y: Boxes, x: Boxes) -> Bools:
    """Tell where the vector (x, y) may reach the negative x axis, or 0."""
    return (x.lo <= 0) & (y.lo <= 0) & (y.hi >= 0)


def arc_cosine(ratio: Boxes) -> Boxes:
    """Enclose acos over the parts in [-1, 1]."""
    part = Boxes(np.clip(ratio.lo, -1.0, 1.0), np.clip(ratio.hi, -1.0, 1.0))
    made = _loose(np.arccos(part.hi), np.arccos(part.lo))
    return Boxes(np.maximum(made.lo, 0.0), np.minimum(made.hi, PI_UP))
