"""The range of every operation over closed intervals, rounded outwards."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from flint import arb

from cordicc.ir.meaning.intervals import (
    HALF_TURN,
    INF,
    NON_NEGATIVE,
    NON_POSITIVE,
    PI_DOWN,
    PI_UP,
    REALS,
    TURN,
    UNIT,
    Interval,
    Result,
    absolute,
    add,
    div,
    enclose,
    half_turns,
    hypot,
    integer_power,
    monotone,
    mul,
    negated,
    point,
    sqrt,
    square,
    sub,
)
from cordicc.ir.ops import OPS

_HALF_PI_UP = PI_UP / 2

_EXPONENTS = 1000
"""Powers of two to less than this are floats."""


@lru_cache(maxsize=4096)
def constant(value: Fraction | int | str) -> Interval:
    """Enclose a rational."""
    number = Fraction(value)
    return Interval(*point(lambda: arb(number.numerator) / arb(number.denominator)))


def _scaled(a: Interval, factor: Fraction | str) -> Interval:
    return mul(constant(factor), a)


def _shift(a: Interval, exponent: Fraction | int) -> Interval:
    if abs(int(exponent)) < _EXPONENTS:
        factor = math.ldexp(1.0, int(exponent))
        return mul(Interval(factor, factor), a)
    power = arb(2) ** int(exponent)
    return monotone(lambda t: t * power, a)


def _sign(a: Interval) -> Interval:
    return Interval(float((a.lo > 0) - (a.lo < 0)), float((a.hi > 0) - (a.hi < 0)))


def _minimum(a: Interval, b: Interval) -> Interval:
    return Interval(min(a.lo, b.lo), min(a.hi, b.hi))


def _maximum(a: Interval, b: Interval) -> Interval:
    return Interval(max(a.lo, b.lo), max(a.hi, b.hi))


def _select(s: Interval, a: Interval, b: Interval) -> Interval:
    if s.lo >= 0:
        return a
    return b if s.hi < 0 else a.union(b)


def _flip(a: Interval, s: Interval) -> Interval:
    return _select(s, a, negated(a))


def _guard(a: Interval, s: Interval, condition: str) -> Result:
    never = {
        "any": False,
        "nonzero": s.lo == 0 == s.hi,
        "nonnegative": s.hi < 0,
        "positive": s.hi <= 0,
    }[condition]
    return None if never else a


def _wrap(a: Interval) -> Interval:
    if a.lo >= -PI_DOWN and a.hi <= PI_DOWN:
        return a
    if math.isinf(a.lo) or math.isinf(a.hi):
        return HALF_TURN

    def turns(t: Any) -> Any:
        return (t - arb.pi()) / (2 * arb.pi())

    first, last = point(turns, a.lo), point(turns, a.hi)
    count = math.ceil(first[0])
    if count != math.ceil(last[1]) or abs(count) >= 2**50:
        return HALF_TURN
    moved = monotone(lambda t: t - 2 * count * arb.pi(), a)
    return moved.intersect(HALF_TURN) or HALF_TURN


def _power(a: Interval, exponent: Fraction | int | str) -> Result:
    power = Fraction(exponent)
    if power.denominator == 1:
        return integer_power(a, power.numerator)
    root = sqrt(a)
    return None if root is None else integer_power(root, power.numerator)


def _holds_parity(a: Interval, offset: float, parity: int | None) -> bool:
    """Whether a/pi - offset may hold an integer, of that parity if one is given."""
    if math.isinf(a.lo) or math.isinf(a.hi):
        return True
    first, last = half_turns(a, offset)
    if parity is not None and (first - parity) % 2:
        first += 1
    return first <= last


def _wave(function: Callable[[Any], Any], offset: float, a: Interval) -> Interval:
    """Enclose sine or cosine, with maxima at (offset + 2 k) pi and minima at (offset + 2 k + 1) pi."""
    if math.isinf(a.lo) or math.isinf(a.hi):
        return UNIT
    first, last = half_turns(a, offset)
    if first < last:
        return UNIT
    ends = enclose([point(function, a.lo), point(function, a.hi)])
    top, bottom = (first == last and first % 2 == parity for parity in (0, 1))
    return Interval(-1.0 if bottom else max(-1.0, ends.lo), 1.0 if top else min(1.0, ends.hi))


def _sin(a: Interval) -> Interval:
    return _wave(lambda t: t.sin(), 0.5, a)


def _cos(a: Interval) -> Interval:
    return _wave(lambda t: t.cos(), 0.0, a)


def _tan(a: Interval) -> Interval:
    return REALS if _holds_parity(a, 0.5, None) else monotone(lambda t: t.tan(), a)


def _asin(a: Interval) -> Result:
    part = a.intersect(UNIT)
    return None if part is None else monotone(lambda t: t.asin(), part)


def _acos(a: Interval) -> Result:
    part = a.intersect(UNIT)
    return None if part is None else negated(monotone(lambda t: -t.acos(), part, -PI_UP, 0.0))


def _atan(a: Interval) -> Interval:
    return monotone(lambda t: t.atan(), a, -_HALF_PI_UP, _HALF_PI_UP)


def _atan2(y: Interval, x: Interval) -> Result:
    """Enclose the angle of (x, y): from the corners of the box, unless it crosses the cut x < 0, y = 0."""
    if y.lo == 0 == y.hi and x.lo == 0 == x.hi:
        return None
    if x.lo < 0 and y.lo < 0 <= y.hi:
        return HALF_TURN
    corners = [_direction(q, p) for q in (y.lo, y.hi) for p in (x.lo, x.hi)]
    directions = [angle for corner in corners for angle in corner]
    return enclose(directions).intersect(HALF_TURN)


def _direction(y: float, x: float) -> list[tuple[float, float]]:
    """Enclose the angle of a corner; an infinite one stands for both directions that it bounds."""
    if x == 0 == y:
        return []
    if math.isinf(x) and math.isinf(y):
        return _direction(y, 0.0) + _direction(math.copysign(1.0, y), x)
    if math.isinf(x):
        return [(0.0, 0.0)] if x > 0 else [(-PI_UP, -PI_DOWN)] if y < 0 else [(PI_DOWN, PI_UP)]
    if math.isinf(y):
        return _direction(math.copysign(1.0, y), 0.0)
    return [point(lambda s, t: arb.atan2(s, t), y, x)]


def _cosh(a: Interval) -> Interval:
    return monotone(lambda t: t.cosh(), absolute(a), 1.0)


def _sinh(a: Interval) -> Interval:
    return monotone(lambda t: t.sinh(), a)


def _exp(a: Interval) -> Interval:
    return monotone(lambda t: t.exp(), a, 0.0)


def _acosh(a: Interval) -> Result:
    part = a.intersect(Interval(1.0, INF))
    return None if part is None else monotone(lambda t: t.acosh(), part, 0.0)


def _atanh(a: Interval) -> Result:
    if a.lo >= 1 or a.hi <= -1:
        return None
    lo = -INF if a.lo <= -1 else point(lambda t: t.atanh(), a.lo)[0]
    hi = INF if a.hi >= 1 else point(lambda t: t.atanh(), a.hi)[1]
    return Interval(lo, hi)


def _log(a: Interval) -> Result:
    if a.hi <= 0:
        return None
    lo = -INF if a.lo <= 0 else point(lambda t: t.log(), a.lo)[0]
    return Interval(lo, INF if a.hi == INF else point(lambda t: t.log(), a.hi)[1])


def _solve(A: Interval, B: Interval, C: Interval, m: int, branch: str) -> Result:
    return _circular(branch, A, B, C) if int(m) == 1 else _hyperbolic(branch, A, B, C)


def _circular(branch: str, A: Interval, B: Interval, C: Interval) -> Result:
    """atan2(A, B) +- acos(C/hypot(A, B))."""
    centre, ratio = _atan2(A, B), div(C, hypot(A, B))
    offset = None if ratio is None else _acos(ratio)
    if centre is None or offset is None:
        return None
    return (add if branch == "+" else sub)(centre, offset).intersect(TURN)


def _hyperbolic(branch: str, A: Interval, B: Interval, C: Interval) -> Result:
    """Enclose ln E with p E^2 - C E + q = 0, 2p = B+A, 2q = B-A; C <= 0 is negated first."""
    found: Result = None
    for part, sign in ((C.intersect(NON_NEGATIVE), False), (C.intersect(NON_POSITIVE), True)):
        if part is not None:
            a, b, c = (negated(t) if sign else t for t in (A, B, part))
            found = _joined(found, _hyperbolic_part(branch, add(b, a), sub(b, a), c))
    return found


def _hyperbolic_part(branch: str, p: Interval, q: Interval, c: Interval) -> Result:
    """As `_hyperbolic` for C >= 0 and 2p, 2q: E is N/(2p), or 2q/N, with N = C + sqrt(C^2 - 4 p q)."""
    found: Result = None
    for mirrored in (False, True):
        leading, other = (q, p) if mirrored else (p, q)
        leading_part = leading.intersect(NON_NEGATIVE)
        takes_both = branch == ("-" if mirrored else "+")
        other_part: Result = other if takes_both else other.intersect(NON_POSITIVE)
        if leading_part is None or other_part is None:
            continue
        root = sqrt(sub(square(c), mul(leading_part, other_part)))
        exponential = None if root is None else div(add(c, root), leading_part)
        logarithm = None if exponential is None else _log(exponential)
        if logarithm is not None:
            found = _joined(found, negated(logarithm) if mirrored else logarithm)
    return found


def _joined(a: Result, b: Result) -> Result:
    if a is None or b is None:
        return a or b
    return a.union(b)


def _solve_pair(A1: Interval, B1: Interval, C1: Interval, A2: Interval, B2: Interval, C2: Interval) -> Result:
    determinant = sub(mul(B1, A2), mul(B2, A1))
    cosine = div(sub(mul(C1, A2), mul(C2, A1)), determinant)
    sine = div(sub(mul(B1, C2), mul(B2, C1)), determinant)
    return None if cosine is None or sine is None else _atan2(sine, cosine)


def _rotate(x: Interval, y: Interval, z: Interval, m: int) -> tuple[Result, Result]:
    if int(m) == 0:
        return x, add(y, mul(x, z))
    if int(m) == 1:
        cosine, sine, radius = _cos(z), _sin(z), hypot(x, y).hi
        bound = Interval(-radius, radius)
        first, second = sub(mul(x, cosine), mul(y, sine)), add(mul(y, cosine), mul(x, sine))
        return first.intersect(bound), second.intersect(bound)
    cosine, sine = _cosh(z), _sinh(z)
    grown, shrunk = mul(add(x, y), _exp(z)), mul(sub(x, y), _exp(negated(z)))
    first, second = add(mul(x, cosine), mul(y, sine)), add(mul(y, cosine), mul(x, sine))
    return (
        first.intersect(_shift(add(grown, shrunk), -1)),
        second.intersect(_shift(sub(grown, shrunk), -1)),
    )


def _vector(x: Interval, y: Interval, z: Interval, m: int, sign: int) -> tuple[Result, Result]:
    norm: Result
    if int(m) == 1:
        norm, angle = hypot(x, y), _atan2(y, x)
    elif int(m) == 0:
        norm, angle = x, div(y, x)
    else:
        ratio = div(y, x)
        norm = sqrt(sub(square(x), square(y)))
        angle = None if ratio is None else _atanh(ratio)
    return norm, None if angle is None else (add if int(sign) == 1 else sub)(z, angle)


def _lightcone(u: Interval, v: Interval) -> tuple[Result, Result]:
    ratio = div(u, v)
    logarithm = None if ratio is None else _log(ratio)
    return sqrt(mul(u, v)), None if logarithm is None else _shift(logarithm, -1)


def _implicit(A: Interval, B: Interval, C: Interval, m: int, branch: str) -> tuple[Result, Result]:
    angle = _solve(A, B, C, m, branch)
    plus, minus = (B, C) if int(m) == 1 else (C, B)
    rest = sqrt(sub(add(square(A), square(plus)), square(minus)))
    return (None, None) if angle is None or rest is None else (angle, rest)


ENCLOSURES: dict[str, Callable[..., Any]] = {
    "const": constant,
    "add": add,
    "sub": sub,
    "mul": mul,
    "cmul": _scaled,
    "shift": _shift,
    "neg": negated,
    "abs": absolute,
    "sign": _sign,
    "min": _minimum,
    "max": _maximum,
    "flip": _flip,
    "select": _select,
    "guard": _guard,
    "wrap": _wrap,
    "div": div,
    "pow": _power,
    "sqrt": sqrt,
    "hypot": hypot,
    "sin": _sin,
    "cos": _cos,
    "tan": _tan,
    "asin": _asin,
    "acos": _acos,
    "atan": _atan,
    "atan2": _atan2,
    "sinh": _sinh,
    "cosh": _cosh,
    "tanh": lambda a: monotone(lambda t: t.tanh(), a, -1.0, 1.0),
    "asinh": lambda a: monotone(lambda t: t.asinh(), a),
    "acosh": _acosh,
    "atanh": _atanh,
    "exp": _exp,
    "log": _log,
    "solve": _solve,
    "solve_pair": _solve_pair,
    "rotate": _rotate,
    "vector": _vector,
    "lightcone": _lightcone,
    "implicit": _implicit,
}
"""Functions of the operands in their order and of the parameters by name."""


def result_ranges(
    op: str, params: Mapping[str, Any] | Sequence[Any], operands: Sequence[Interval | None]
) -> tuple[Interval | None, ...]:
    """Enclose every result of an operation on operands in intervals.

    Args:
        op: any operation of the graph but `input`.
        params: its parameters, by name or in the order of the operation's definition.
        operands: an interval each, or None for one that never has a value.

    Returns:
        An interval for each result, over the operands for which it has a value; None where it has a
        value for none of them.

    Raises:
        ValueError: unknown operation.
    """
    if op not in ENCLOSURES:
        raise ValueError(f"no enclosure for operation {op!r}")
    definition = OPS[op]
    if any(operand is None for operand in operands):
        return (None,) * len(definition.results)
    named = params if isinstance(params, Mapping) else definition.named(params)
    result = ENCLOSURES[op](*operands, **named)
    return result if isinstance(result, tuple) else (result,)
