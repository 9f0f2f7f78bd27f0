"""The operations on real numbers rounded to `PRECISION` bits, by mpmath: a row for each of `cordicc.ir.ops`.

A result without a value is None.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import Any

from mpmath import libmp
from mpmath.libmp import fone, fzero

PRECISION = 113
"""Significand bits of the evaluation, those of IEEE quadruple precision."""

_POLE = 100
"""A tangent beyond 2^100 is that of a pole: its angle, rounded, is within rounding of one."""

_EXPONENT_BITS = 1200
"""Bits of the exponents of powers that are calculated."""

Real = Any  # mpmath's raw number: the tuple (sign, mantissa, exponent, bit count)
Result = Real | None
WORKING = (PRECISION, "n")


def _add(a: Real, b: Real) -> Real:
    return libmp.mpf_add(a, b, *WORKING)


def _sub(a: Real, b: Real) -> Real:
    return libmp.mpf_sub(a, b, *WORKING)


def _mul(a: Real, b: Real) -> Real:
    return libmp.mpf_mul(a, b, *WORKING)


@lru_cache(maxsize=4096)
def from_fraction(number: Fraction) -> Real:
    """Return a rational rounded to `PRECISION` bits."""
    return libmp.from_rational(number.numerator, number.denominator, *WORKING)


def _plain(function: Callable[..., Result]) -> Callable[[], Callable[..., Result]]:
    """Make a table row of an operation without parameters."""
    return lambda: function


def _unary(function: Callable[..., Real]) -> Callable[[], Callable[..., Result]]:
    return lambda: lambda a: function(a, PRECISION, "n")


def _negative(a: Real) -> bool:
    return bool(a[0])


def _less(a: Real, b: Real) -> bool:
    return bool(libmp.mpf_lt(a, b))


def _div(a: Real, b: Real) -> Result:
    return None if b == fzero else libmp.mpf_div(a, b, *WORKING)


def _sqrt(a: Real) -> Result:
    return None if _negative(a) else libmp.mpf_sqrt(a, *WORKING)


def _hypot(a: Real, b: Real) -> Real:
    return libmp.mpf_hypot(a, b, *WORKING)


def _atan2(y: Real, x: Real) -> Result:
    return None if x == fzero and y == fzero else libmp.mpf_atan2(y, x, *WORKING)


def _tan(a: Real) -> Result:
    tangent = libmp.mpf_tan(a, *WORKING)
    return None if tangent[2] + tangent[3] > _POLE else tangent


def _log(a: Real) -> Result:
    return None if _negative(a) or a == fzero else libmp.mpf_log(a, *WORKING)


def _within_one(function: Callable[..., Real], a: Real) -> Result:
    return None if _less(fone, libmp.mpf_abs(a)) else function(a, *WORKING)


def _atanh(a: Real) -> Result:
    return libmp.mpf_atanh(a, *WORKING) if _less(libmp.mpf_abs(a), fone) else None


def _acosh(a: Real) -> Result:
    return None if _less(a, fone) else libmp.mpf_acosh(a, *WORKING)


def _sign(a: Real) -> Real:
    return libmp.from_int(libmp.mpf_sign(a))


_PI = libmp.mpf_pi(2 * PRECISION)
_MINUS_PI = libmp.mpf_neg(_PI)
_TURN = libmp.mpf_shift(_PI, 1)


def _wrap(a: Real) -> Real:
    if _less(_MINUS_PI, a) and not _less(_PI, a):
        return a
    turns = libmp.mpf_ceil(libmp.mpf_div(_sub(a, _PI), _TURN, *WORKING), *WORKING)
    return _sub(a, libmp.mpf_mul(turns, _TURN, 2 * PRECISION, "n"))


def _power(exponent: Fraction) -> Callable[[Real], Result]:
    whole = exponent.numerator if exponent.denominator == 1 else None

    def power(a: Real) -> Result:
        if a == fzero and exponent < 0:
            return None
        if whole is not None:
            return _whole_power(a, whole)
        root = _sqrt(a)
        return None if root is None else _whole_power(root, exponent.numerator)

    return power


def _whole_power(a: Real, n: int) -> Result:
    """Return a^n; for exponents of thousands of bits, which would take long, no more than its size."""
    size = libmp.mpf_cmp(libmp.mpf_abs(a), fone)
    if n.bit_length() <= _EXPONENT_BITS or a == fzero or size == 0:
        return libmp.mpf_pow_int(a, n, *WORKING)
    # |log2 |a|| is 2^-PRECISION at the least, so neither a^n nor its logarithm is near a double.
    if (size > 0) == (n > 0):
        return None
    return libmp.from_man_exp(-1 if _negative(a) and n % 2 else 1, -(abs(n) >> PRECISION))


def _scale(factor: Fraction) -> Callable[[Real], Real]:
    number = from_fraction(factor)
    return lambda a: libmp.mpf_mul(a, number, PRECISION, "n")


def _guard(condition: str) -> Callable[[Real, Real], Result]:
    holds: Callable[[Real], bool] = {
        "any": lambda s: True,
        "nonzero": lambda s: s != fzero,
        "nonnegative": lambda s: not _negative(s),
        "positive": lambda s: s != fzero and not _negative(s),
    }[condition]
    return lambda a, s: a if holds(s) else None


def _square(a: Real) -> Real:
    return _mul(a, a)


def _circular_solution(branch: str, A: Real, B: Real, C: Real) -> Result:
    """Return atan2(A, B) +- acos(C / sqrt(A^2 + B^2))."""
    radius = _hypot(A, B)
    centre, ratio = _atan2(A, B), _div(C, radius)
    if centre is None or ratio is None:
        return None
    offset = _within_one(libmp.mpf_acos, ratio)
    return None if offset is None else (_add if branch == "+" else _sub)(centre, offset)


def _hyperbolic_solution(branch: str, A: Real, B: Real, C: Real) -> Result:
    """Return the logarithm of the root E > 0 of p E^2 - C E + q = 0, p = (B+A)/2, q = (B-A)/2.

    With |B| > |A| both roots have one sign and the branch picks one; else at most one is positive.
    """
    p, q = libmp.mpf_shift(_add(B, A), -1), libmp.mpf_shift(_sub(B, A), -1)
    if p == fzero and q == fzero:
        return None
    root = _sqrt(_sub(_square(C), libmp.mpf_shift(_mul(p, q), 2)))
    if root is None:
        return None
    sign = libmp.mpf_neg if _negative(C) else libmp.mpf_pos
    p, q = sign(p), sign(q)
    total = _add(libmp.mpf_abs(C), root)
    p_positive, q_positive = (not _negative(x) and x != fzero for x in (p, q))
    if total == fzero:
        return None
    if p_positive and q_positive and branch == "none":
        return None
    if p_positive and not (q_positive and branch == "-"):
        return _log(libmp.mpf_div(total, libmp.mpf_shift(p, 1), *WORKING))
    if q_positive:
        return _log(libmp.mpf_div(libmp.mpf_shift(q, 1), total, *WORKING))
    return None


def _solve(m: int, branch: str) -> Callable[[Real, Real, Real], Result]:
    solution = _circular_solution if m == 1 else _hyperbolic_solution
    return lambda A, B, C: solution(branch, A, B, C)


def _solve_pair(A1: Real, B1: Real, C1: Real, A2: Real, B2: Real, C2: Real) -> Result:
    determinant = _sub(_mul(B1, A2), _mul(B2, A1))
    cosine = _div(_sub(_mul(C1, A2), _mul(C2, A1)), determinant)
    sine = _div(_sub(_mul(B1, C2), _mul(B2, C1)), determinant)
    return None if cosine is None or sine is None else _atan2(sine, cosine)


def _implicit(m: int, branch: str) -> Callable[..., tuple[Result, ...]]:
    solution = _circular_solution if m == 1 else _hyperbolic_solution

    def implicit(A: Real, B: Real, C: Real) -> tuple[Result, Result]:
        angle = solution(branch, A, B, C)
        combine = (_add, _sub) if m == 1 else (_sub, _add)
        rest = combine[1](combine[0](_square(A), _square(B)), _square(C))
        return (None, None) if angle is None else (angle, _sqrt(rest))

    return implicit


def _rotate(m: int) -> Callable[..., tuple[Result, ...]]:
    def rotate(x: Real, y: Real, z: Real) -> tuple[Result, Result]:
        if m == 0:
            return x, _add(y, _mul(x, z))
        if m == 1:
            cosine, sine = libmp.mpf_cos_sin(z, *WORKING)
            return _sub(_mul(x, cosine), _mul(y, sine)), _add(_mul(y, cosine), _mul(x, sine))
        cosine, sine = libmp.mpf_cosh_sinh(z, *WORKING)
        return _add(_mul(x, cosine), _mul(y, sine)), _add(_mul(y, cosine), _mul(x, sine))

    return rotate


def _vector(m: int, sign: int) -> Callable[..., tuple[Result, ...]]:
    combine = _add if sign == 1 else _sub

    def vector(x: Real, y: Real, z: Real) -> tuple[Result, Result]:
        norm: Result
        if m == 1:
            norm, angle = _hypot(x, y), _atan2(y, x)
        elif m == 0:
            norm, angle = x, _div(y, x)
        else:
            ratio = _div(y, x)
            norm = _sqrt(_sub(_square(x), _square(y)))
            angle = None if ratio is None else _atanh(ratio)
        return norm, None if angle is None else combine(z, angle)

    return vector


def _lightcone(u: Real, v: Real) -> tuple[Result, Result]:
    ratio = _div(u, v)
    angle = None if ratio is None else _log(ratio)
    return _sqrt(_mul(u, v)), None if angle is None else libmp.mpf_shift(angle, -1)


OPERATIONS: dict[str, Callable[..., Callable[..., Any]]] = {
    "add": _plain(_add),
    "sub": _plain(_sub),
    "mul": _plain(_mul),
    "cmul": _scale,
    "shift": lambda exponent: lambda a: libmp.mpf_shift(a, int(exponent)),
    "neg": _plain(libmp.mpf_neg),
    "abs": _plain(libmp.mpf_abs),
    "sign": _plain(_sign),
    "min": _plain(lambda a, b: a if _less(a, b) else b),
    "max": _plain(lambda a, b: b if _less(a, b) else a),
    "flip": _plain(lambda a, s: libmp.mpf_neg(a) if _negative(s) else a),
    "select": _plain(lambda s, a, b: b if _negative(s) else a),
    "guard": _guard,
    "wrap": _plain(_wrap),
    "div": _plain(_div),
    "pow": _power,
    "sqrt": _plain(_sqrt),
    "hypot": _plain(_hypot),
    "sin": _unary(libmp.mpf_sin),
    "cos": _unary(libmp.mpf_cos),
    "tan": _plain(_tan),
    "asin": _plain(lambda a: _within_one(libmp.mpf_asin, a)),
    "acos": _plain(lambda a: _within_one(libmp.mpf_acos, a)),
    "atan": _unary(libmp.mpf_atan),
    "atan2": _plain(_atan2),
    "sinh": _unary(libmp.mpf_sinh),
    "cosh": _unary(libmp.mpf_cosh),
    "tanh": _unary(libmp.mpf_tanh),
    "asinh": _unary(libmp.mpf_asinh),
    "acosh": _plain(_acosh),
    "atanh": _plain(_atanh),
    "exp": _unary(libmp.mpf_exp),
    "log": _plain(_log),
    "solve": _solve,
    "solve_pair": _plain(_solve_pair),
    "rotate": _rotate,
    "vector": _vector,
    "lightcone": lambda: _lightcone,
    "implicit": _implicit,
}
"""Functions of the parameters by name; what they return is a function of the operands in their order."""
