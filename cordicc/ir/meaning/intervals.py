"""Closed intervals on floats, with end points rounded outwards.

Sums, products, quotients and roots of floats far from overflow and underflow come with their exact error
(T. J. Dekker, "A floating-point technique for extending the available precision", Numer. Math. 18, 1971),
whose sign tells which way they were rounded.  Other points are evaluated by ball arithmetic (Arb) at
`PRECISION_BITS`.  So an enclosure is rigorous; ranges of functions follow from their monotone pieces, so
they are tight.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, ctx

PRECISION_BITS = 96

INF = math.inf
_LARGEST = math.nextafter(INF, 0)


@dataclass(frozen=True, slots=True)
class Interval:
    """The numbers from `lo` to `hi`, lo <= hi; an infinite end means unbounded.  Raises ValueError."""

    lo: float
    hi: float

    def __post_init__(self) -> None:
        if not self.lo <= self.hi or self.lo == INF or self.hi == -INF:
            raise ValueError(f"not an interval: [{self.lo}, {self.hi}]")

    @property
    def magnitude(self) -> float:
        """The largest absolute value."""
        return max(abs(self.lo), abs(self.hi))

    @property
    def finite(self) -> bool:
        """Whether both ends are finite."""
        return math.isfinite(self.lo) and math.isfinite(self.hi)

    def __contains__(self, number: float) -> bool:
        return self.lo <= number <= self.hi

    def intersect(self, other: Interval) -> Interval | None:
        """Return the common part, None if there is none."""
        lo, hi = max(self.lo, other.lo), min(self.hi, other.hi)
        return Interval(lo, hi) if lo <= hi else None

    def union(self, other: Interval) -> Interval:
        """Return the smallest interval that holds both."""
        return Interval(min(self.lo, other.lo), max(self.hi, other.hi))


Result = Interval | None
REALS = Interval(-INF, INF)
NON_NEGATIVE = Interval(0.0, INF)
NON_POSITIVE = Interval(-INF, 0.0)
UNIT = Interval(-1.0, 1.0)
PI_DOWN, PI_UP = math.pi, math.nextafter(math.pi, 4)
HALF_TURN = Interval(-PI_UP, PI_UP)
TURN = Interval(-2 * PI_UP, 2 * PI_UP)


def outward(ball: Any) -> tuple[float, float]:
    """Return floats below and above a ball."""
    if ball.is_finite():
        number = float(ball)
        near = arb(number)
        lo = number if near <= ball else math.nextafter(number, -INF)
        hi = number if near >= ball else math.nextafter(number, INF)
        if arb(lo) <= ball <= arb(hi):  # proven: the ball is no wider than the floats around its middle
            return lo, hi
    return _down(ball), _up(ball)


def _down(ball: Any) -> float:
    if not ball.is_finite():
        return -INF
    bound = ball.lower()
    number = float(bound)
    if math.isinf(number):
        return _LARGEST if number > 0 else -INF
    return number if arb(number) <= bound else math.nextafter(number, -INF)


def _up(ball: Any) -> float:
    return -_down(-ball)


def point(function: Callable[..., Any], *numbers: float) -> tuple[float, float]:
    """Return floats below and above a function of finite floats."""
    with ctx.workprec(PRECISION_BITS):
        return outward(function(*(arb(number) for number in numbers)))


_NEAR, _CLEAR = 1e5, 1e-9
"""An angle is near, and its number of half turns clearly no integer."""


def half_turns(a: Interval, offset: float) -> tuple[int, int]:
    """Return the first and the last integer that a/pi - offset, of finite a, may hold."""

    def rounded(number: float, end: int, to_integer: Callable[[float], int]) -> int:
        near = number / math.pi - offset
        if abs(number) < _NEAR and abs(near - round(near)) > _CLEAR:
            return to_integer(near)  # no rounding error reaches an integer
        return to_integer(point(lambda t: t / arb.pi() - offset, number)[end])

    return rounded(a.lo, 0, math.ceil), rounded(a.hi, 1, math.floor)


_SMALL, _LARGE = 2.0**-400, 2.0**400
"""Between them no product, quotient or root of two floats loses its error."""

_SPLIT = 2.0**27 + 1


def _around(number: float, error: float) -> tuple[float, float]:
    """Return the floats below and above number + error, an error of less than a last place."""
    if error > 0:
        return number, math.nextafter(number, INF)
    return (math.nextafter(number, -INF), number) if error < 0 else (number, number)


def _product_error(p: float, q: float, product: float) -> float:
    """Return p q - product exactly, for the rounded product."""
    p_high = p * _SPLIT - (p * _SPLIT - p)
    q_high = q * _SPLIT - (q * _SPLIT - q)
    p_low, q_low = p - p_high, q - q_high
    return ((p_high * q_high - product) + p_high * q_low + p_low * q_high) + p_low * q_low


def sum_of(p: float, q: float) -> tuple[float, float]:
    """Return floats below and above p + q, both finite."""
    total = p + q + 0.0  # no -0
    if not abs(total) < _LARGE:
        return point(lambda s, t: s + t, p, q)
    part = total - p
    return _around(total, (p - (total - part)) + (q - part))


def product_of(p: float, q: float) -> tuple[float, float]:
    """Return floats below and above p q, both finite."""
    if p == 0 or q == 0:
        return 0.0, 0.0
    if not (_SMALL < abs(p) < _LARGE and _SMALL < abs(q) < _LARGE):
        return point(lambda s, t: s * t, p, q)
    return _around(p * q, _product_error(p, q, p * q))


def quotient_of(p: float, q: float) -> tuple[float, float]:
    """Return floats below and above p / q, both finite, q not 0."""
    if p == 0:
        return 0.0, 0.0
    if not (_SMALL < abs(p) < _LARGE and _SMALL < abs(q) < _LARGE):
        return point(lambda s, t: s / t, p, q)
    quotient = p / q
    product = quotient * q
    rest = (p - product) - _product_error(quotient, q, product)
    return _around(quotient, rest if q > 0 else -rest)


def root_of(p: float) -> tuple[float, float]:
    """Return floats below and above the root of a number >= 0."""
    if p == 0:
        return 0.0, 0.0
    if not _SMALL < p < _LARGE:
        return point(lambda t: t.sqrt(), p)
    root = math.sqrt(p)
    product = root * root
    return _around(root, (p - product) - _product_error(root, root, product))


def enclose(pairs: Sequence[tuple[float, float]]) -> Interval:
    """Return the interval around several enclosures of points."""
    return Interval(min(p[0] for p in pairs), max(p[1] for p in pairs))


def negated(a: Interval) -> Interval:
    """Return -a."""
    return Interval(-a.hi, -a.lo)


def monotone(function: Callable[[Any], Any], a: Interval, low: float = -INF, high: float = INF) -> Interval:
    """Enclose an increasing function; `low` and `high` are its limits at the infinities, rounded out."""
    lo = low if a.lo == -INF else point(function, a.lo)[0]
    hi = high if a.hi == INF else point(function, a.hi)[1]
    return Interval(max(lo, low), min(hi, high))


def add(a: Interval, b: Interval) -> Interval:
    """Enclose a + b."""
    lo = -INF if -INF in (a.lo, b.lo) else sum_of(a.lo, b.lo)[0]
    hi = INF if INF in (a.hi, b.hi) else sum_of(a.hi, b.hi)[1]
    return Interval(lo, hi)


def sub(a: Interval, b: Interval) -> Interval:
    """Enclose a - b."""
    return add(a, negated(b))


def mul(a: Interval, b: Interval) -> Interval:
    """Enclose a b; 0 times an unbounded end is 0."""
    pairs = [(p, q) for p in {a.lo, a.hi} for q in {b.lo, b.hi}]
    rounded = [0.0 if p == 0 or q == 0 else p * q for p, q in pairs]
    least, most = min(rounded), max(rounded)
    # Rounding is monotone: an end is the rounded product of ends whose nearest float is outermost.
    return Interval(
        min(_product(*pair)[0] for pair, each in zip(pairs, rounded, strict=True) if each == least),
        max(_product(*pair)[1] for pair, each in zip(pairs, rounded, strict=True) if each == most),
    )


def _product(p: float, q: float) -> tuple[float, float]:
    if math.isinf(p) or math.isinf(q):
        return (0.0, 0.0) if p == 0 or q == 0 else (p * q, p * q)
    return product_of(p, q)


def reciprocal(a: Interval) -> Result:
    """Enclose 1/a over the non-zero part of a; None for [0, 0]."""
    if a.lo == 0 == a.hi:
        return None
    if a.lo < 0 < a.hi:
        return REALS
    lo = -INF if a.hi == 0 else 0.0 if math.isinf(a.hi) else quotient_of(1.0, a.hi)[0]
    hi = INF if a.lo == 0 else 0.0 if math.isinf(a.lo) else quotient_of(1.0, a.lo)[1]
    return Interval(lo, hi)


def div(a: Interval, b: Interval) -> Result:
    """Enclose a/b over the non-zero part of b; unbounded if b holds 0 within, None for [0, 0]."""
    if b.lo == 0 == b.hi:
        return None
    if a.lo == 0 == a.hi:
        return a
    if b.lo < 0 < b.hi:
        return REALS
    if b.hi <= 0:
        a, b = negated(a), negated(b)
    return enclose([_quotient(p, q, b) for p in (a.lo, a.hi) for q in (b.lo, b.hi)])


def _quotient(p: float, q: float, divisor: Interval) -> tuple[float, float]:
    """Enclose p/q for an end q >= 0 of the divisor; its end 0 is approached, not reached."""
    if q == 0:
        p_end = math.copysign(INF, p) if p != 0 else 0.0
        return p_end, p_end
    if math.isinf(q):
        if math.isinf(p):
            return (0.0, INF) if p > 0 else (-INF, 0.0)
        return 0.0, 0.0
    if p == 0 or math.isinf(p):
        return p, p
    return quotient_of(p, q)


def absolute(a: Interval) -> Interval:
    """Return |a|."""
    return Interval(0.0 if a.lo <= 0 <= a.hi else min(abs(a.lo), abs(a.hi)), a.magnitude)


def integer_power(a: Interval, exponent: int) -> Result:
    """Enclose a**exponent over the operands for which it has a value."""
    if exponent < 0:
        positive = integer_power(a, -exponent)
        if a.lo == 0 == a.hi or positive is None:
            return None
        return reciprocal(positive)
    if exponent == 0:
        return Interval(1.0, 1.0)
    if exponent % 2 == 0:
        return monotone(lambda t: t**exponent, absolute(a), 0.0)
    return monotone(lambda t: t**exponent, a)


def square(a: Interval) -> Interval:
    """Enclose a**2."""
    part = absolute(a)
    return Interval(
        product_of(part.lo, part.lo)[0], INF if part.hi == INF else product_of(part.hi, part.hi)[1]
    )


def sqrt(a: Interval) -> Result:
    """Enclose the root over the non-negative part of a."""
    part = a.intersect(NON_NEGATIVE)
    if part is None:
        return None
    return Interval(root_of(part.lo)[0], INF if part.hi == INF else root_of(part.hi)[1])


def hypot(a: Interval, b: Interval) -> Interval:
    """Enclose sqrt(a**2 + b**2)."""
    p, q = absolute(a), absolute(b)

    def norm(s: Any, t: Any) -> Any:
        return (s * s + t * t).sqrt()

    hi = INF if INF in (p.hi, q.hi) else point(norm, p.hi, q.hi)[1]
    return Interval(max(0.0, point(norm, p.lo, q.lo)[0]), hi)
