"""Exact constant folding.

Rational operations stay exact while they are short; everything else is rounded to a dyadic rational
of `PRECISION` bits.  Constants such as pi carry that precision too, so what cancels to rounding
noise is taken for the zero, the one or the half it stands for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import isqrt
from typing import Any

from mpmath import MPContext
from mpmath.libmp import mpf_pos

from cordicc.ir.ops import OPS

PRECISION = 256
"""Bits of a rounded constant."""

LARGEST = Fraction(10) ** 300
SMALLEST = 1 / LARGEST

_EXACT_BITS = 2048
_NOISE = Fraction(1, 1 << 200)
_WORKING_BITS = 2400  # covers a 300-digit argument of sin, and the neighbourhood of 1 of log and acosh

_MP: Any = MPContext()
_MP.prec = _WORKING_BITS


class FoldError(ValueError):
    """The operation has no value for these constants; the text says why, in plain English."""


def _real(number: Fraction) -> Any:
    return _MP.mpf(number.numerator) / number.denominator


def _round(number: Any) -> Fraction:
    """Return an mpf rounded to PRECISION bits; its magnitude is checked before it is made."""
    sign, mantissa, exponent, bits = mpf_pos(number._mpf_, PRECISION, "n")
    if not mantissa:
        if exponent:
            raise FoldError("the result is not a finite number")
        return Fraction(0)
    if abs(exponent + bits) > 1000:
        raise FoldError(_out_of_range(exponent > 0))
    value = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)  # int: mpmath may use gmpy2
    return -value if sign else value


def _out_of_range(large: bool) -> str:
    return "the result is larger than 1e300" if large else "the result is smaller than 1e-300"


def _checked(number: Fraction) -> Fraction:
    """Return the number, shortened if it is long; raises FoldError outside 0 and [1e-300, 1e300]."""
    if number and not SMALLEST <= abs(number) <= LARGEST:
        raise FoldError(_out_of_range(abs(number) > 1))
    if number.numerator.bit_length() + number.denominator.bit_length() > _EXACT_BITS:
        return _round(_real(number))
    return number


PI: Fraction = _round(_MP.pi + 0)
_LONG_PI = Fraction(int(_MP.floor(_MP.ldexp(_MP.pi, 2048))), 1 << 2048)
DEG: Fraction = PI / 180


def _add(a: Fraction, b: Fraction) -> Fraction:
    total = a + b
    return Fraction(0) if abs(total) < _NOISE * max(abs(a), abs(b)) else total


def _div(a: Fraction, b: Fraction) -> Fraction:
    if b == 0:
        raise FoldError("division by zero")
    return a / b


def _root(number: Fraction) -> Fraction:
    if number < 0:
        raise FoldError("square root of a negative number")
    above, below = isqrt(number.numerator), isqrt(number.denominator)
    if above * above == number.numerator and below * below == number.denominator:
        return Fraction(above, below)
    return _round(_MP.sqrt(_real(number)))


def _power(base: Fraction, exponent: Fraction) -> Fraction:
    if exponent.denominator not in (1, 2) or abs(exponent) > 64:
        raise FoldError("the exponent is not an integer or half-integer of at most 64")
    if base == 0 and exponent < 0:
        raise FoldError("division by zero")
    if exponent.denominator == 2:
        if base < 0:
            raise FoldError("root of a negative number")
        return _checked(_root(base)) ** exponent.numerator
    return base**exponent.numerator


def _noise_free(result: Fraction, argument: Fraction) -> Fraction:
    """Return a value of sin, cos or tan, taken for 0, 1/2, 1 ... if only the rounding of pi parts them."""
    near = Fraction(round(2 * result), 2)
    if near == 0 and abs(argument) < 1:
        return result
    noise = min(_NOISE * max(Fraction(1), abs(argument)), Fraction(1, 1 << 100))
    return near if abs(result - near) < noise else result


def _sin(x: Fraction) -> Fraction:
    return _noise_free(_round(_MP.sin(_real(x))), x)


def _cos(x: Fraction) -> Fraction:
    return _noise_free(_round(_MP.cos(_real(x))), x)


def _tan(x: Fraction) -> Fraction:
    if _cos(x) == 0:
        raise FoldError("tan has a pole there")
    return _noise_free(_round(_MP.tan(_real(x))), x)


def _within_one(x: Fraction, name: str) -> Fraction:
    if abs(x) > 1 + _NOISE:
        raise FoldError(f"{name} of a number outside [-1, 1]")
    return Fraction(_sign(x)) if abs(abs(x) - 1) < _NOISE else x


def _asin(x: Fraction) -> Fraction:
    return _round(_MP.asin(_real(_within_one(x, "asin"))))


def _acos(x: Fraction) -> Fraction:
    return _round(_MP.acos(_real(_within_one(x, "acos"))))


def _atan2(y: Fraction, x: Fraction) -> Fraction:
    if x == 0 and y == 0:
        raise FoldError("atan2(0, 0) is not defined")
    return _round(_MP.atan2(_real(y), _real(x)))


def _acosh(x: Fraction) -> Fraction:
    if x < 1 - _NOISE:
        raise FoldError("acosh of a number below 1")
    return Fraction(0) if x < 1 + _NOISE else _round(_MP.acosh(_real(x)))


def _atanh(x: Fraction) -> Fraction:
    if abs(x) >= 1:
        raise FoldError("atanh of a number outside (-1, 1)")
    return _round(_MP.atanh(_real(x)))


def _log(x: Fraction) -> Fraction:
    if x <= 0:
        raise FoldError("logarithm of zero or of a negative number")
    return _round(_MP.log(_real(x)))


def _elementary(name: str) -> Callable[[Fraction], Fraction]:
    """Return the folding of a function that is defined for every real number."""

    def function(x: Fraction) -> Fraction:
        if name in ("exp", "sinh", "cosh") and abs(x) > 1000:
            if name == "exp" and x < 0:
                raise FoldError(_out_of_range(False))
            raise FoldError(_out_of_range(True))
        if name == "tanh" and abs(x) > 1000:
            return Fraction(1 if x > 0 else -1)
        return _round(getattr(_MP, name)(_real(x)))

    return function


def _sign(x: Fraction) -> Fraction:
    return Fraction((x > 0) - (x < 0))


def _wrap(x: Fraction) -> Fraction:
    if -PI < x <= PI:
        return x
    pi = PI if abs(x) < 1 << 64 else _LONG_PI
    turns = -((pi - x) // (2 * pi))
    return x - 2 * pi * turns


def _guard(a: Fraction, s: Fraction, condition: str) -> Fraction:
    holds = {"any": True, "nonzero": s != 0, "nonnegative": s >= 0, "positive": s > 0}[condition]
    if not holds:
        raise FoldError(f"a number that must be {condition} is not")
    return a


def _solve(A: Fraction, B: Fraction, C: Fraction, m: int, branch: str) -> Fraction:
    """Return t with B cos t + A sin t = C, for m = -1 B cosh t + A sinh t = C."""
    sign = -1 if branch == "-" else 1
    if m == 1:
        if A == 0 and B == 0:
            raise FoldError("the equation has no unknown left")
        size = C / _checked(_root(A * A + B * B))
        if abs(size) > 1 + _NOISE:
            raise FoldError("the equation has no solution")
        return _add(_atan2(A, B), sign * _acos(size))
    if abs(A) == abs(B):
        # B cosh t + A sinh t is B e^t for A = B and B e^-t for A = -B
        if A == 0 or C * B <= 0:
            raise FoldError("the equation has no solution")
        return _log(C / B) * (1 if A == B else -1)
    if abs(A) > abs(B):
        return _add(
            _checked(-_atanh(B / A)), _elementary("asinh")(C / _checked(_root(A * A - B * B)) * _sign(A))
        )
    if branch == "none":
        raise FoldError("the equation has two solutions and no branch")
    size = C / _checked(_root(B * B - A * A)) * _sign(B)
    if size < 1 - _NOISE:
        raise FoldError("the equation has no solution")
    return _add(-_atanh(A / B), sign * _acosh(size))


def _solve_pair(
    A1: Fraction, B1: Fraction, C1: Fraction, A2: Fraction, B2: Fraction, C2: Fraction
) -> Fraction:
    determinant = _add(B1 * A2, -B2 * A1)
    if determinant == 0:
        raise FoldError("the determinant of the pair of equations is zero")
    cosine = _add(C1 * A2, -C2 * A1) / determinant
    sine = _add(B1 * C2, -B2 * C1) / determinant
    return _atan2(sine, cosine)


FOLDS: dict[str, Callable[..., Fraction]] = {
    "const": lambda value: value,
    "add": _add,
    "sub": lambda a, b: _add(a, -b),
    "mul": lambda a, b: a * b,
    "cmul": lambda a, factor: factor * a,
    "shift": lambda a, exponent: a * Fraction(2) ** int(exponent),
    "neg": lambda a: -a,
    "abs": abs,
    "sign": _sign,
    "min": min,
    "max": max,
    "flip": lambda a, s: a if s >= 0 else -a,
    "select": lambda s, a, b: a if s >= 0 else b,
    "guard": _guard,
    "wrap": _wrap,
    "div": _div,
    "pow": _power,
    "sqrt": _root,
    "hypot": lambda a, b: _root(a * a + b * b),
    "sin": _sin,
    "cos": _cos,
    "tan": _tan,
    "asin": _asin,
    "acos": _acos,
    "atan": _elementary("atan"),
    "atan2": _atan2,
    "sinh": _elementary("sinh"),
    "cosh": _elementary("cosh"),
    "tanh": _elementary("tanh"),
    "asinh": _elementary("asinh"),
    "acosh": _acosh,
    "atanh": _atanh,
    "exp": _elementary("exp"),
    "log": _log,
    "solve": _solve,
    "solve_pair": _solve_pair,
}


def fold(op: str, params: Sequence[object], args: Sequence[Fraction]) -> Fraction:
    """Return the value of an operation on constants, parameters and operands in the order of `ir.ops`.

    Exact for rational operations up to about 2048 bits, else rounded to 256 bits.  Raises FoldError
    where the operation leaves the real domain or its value leaves 0 and [1e-300, 1e300].
    """
    return _checked(Fraction(FOLDS[op](*args, **OPS[op].named(params))))
