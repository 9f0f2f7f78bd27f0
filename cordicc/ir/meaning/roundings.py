"""First-order bounds of how far rounding moves a value, on sample points, in units of the rounding.

Every operation rounds its result, and passes on the errors of its operands times the absolute values of
its partial derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.arith.numbers.decimals import double_shift, nearest_double
from cordicc.base.arrays import Floats
from cordicc.ir.graph import Param

Errors = tuple[Floats, ...]


def _rotate(m: int, v: Sequence[Floats], e: Sequence[Floats], made: Sequence[Floats]) -> Errors:
    x, y, z = v
    if m == 0:
        return e[0], e[1] + np.abs(z) * e[0] + np.abs(x) * e[2]
    c, s = (np.cos(z), np.sin(z)) if m == 1 else (np.cosh(z), np.sinh(z))
    c, s = np.abs(c), np.abs(s)
    size = np.hypot(x, y) * (c + s)
    return (
        c * e[0] + s * e[1] + np.abs(made[1]) * e[2] + size,
        c * e[1] + s * e[0] + np.abs(made[0]) * e[2] + size,
    )


def _vector(m: int, v: Sequence[Floats], e: Sequence[Floats], made: Sequence[Floats]) -> Errors:
    x, y, _ = (np.abs(a) for a in v)
    if m == 0:
        return e[0], e[1] / x + y * e[0] / x**2 + e[2]
    norm = np.abs(made[0])
    return (x * e[0] + y * e[1]) / norm, (y * e[0] + x * e[1]) / norm**2 + e[2] + 1.0


def _lightcone(v: Sequence[Floats], e: Sequence[Floats], made: Sequence[Floats]) -> Errors:
    u, w = (np.abs(a) for a in v)
    return (w * e[0] + u * e[1]) / (2 * np.abs(made[0])), (e[0] / u + e[1] / w) / 2 + 1.0


def _implicit(m: int, v: Sequence[Floats], e: Sequence[Floats], made: Sequence[Floats]) -> Errors:
    A, B, C = (np.abs(a) for a in v)
    angle, rest = made
    c, s = (np.cos(angle), np.sin(angle)) if m == 1 else (np.cosh(angle), np.sinh(angle))
    steep = np.abs(rest)
    own = np.hypot(A, B)
    residual = np.abs(s) * e[0] + np.abs(c) * e[1] + e[2] + own
    return residual / steep + 1.0, (A * e[0] + B * e[1] + C * e[2] + own * own) / steep


_UNITS: dict[str, Callable[..., Errors]] = {
    "rotate": lambda p, v, e, made: _rotate(int(p[0]), v, e, made),
    "vector": lambda p, v, e, made: _vector(int(p[0]), v, e, made),
    "lightcone": lambda p, v, e, made: _lightcone(v, e, made),
    "implicit": lambda p, v, e, made: _implicit(int(p[0]), v, e, made),
}


def errors(
    op: str,
    params: Sequence[Param],
    values: Sequence[Floats],
    moved: Sequence[Floats],
    made: Sequence[Floats],
) -> Errors:
    """Return the error bound of every result; inputs and constants carry one rounding.

    Args:
        op: an operation of a graph of unit operations.
        params: its parameters.
        values: its operands on the samples.
        moved: the error bounds of the operands.
        made: its results.
    """
    with np.errstate(all="ignore"):
        if op in _UNITS:
            passed: Sequence[Any] = _UNITS[op](params, values, moved, made)
        elif op in ("add", "sub"):
            passed = (moved[0] + moved[1],)
        elif op == "mul":
            passed = (np.abs(values[0]) * moved[1] + np.abs(values[1]) * moved[0],)
        elif op == "cmul":
            passed = (abs(nearest_double(Fraction(params[0]))) * moved[0],)
        elif op == "shift":
            return (np.ldexp(moved[0], double_shift(Fraction(params[0]))),)
        elif op in ("neg", "abs", "flip", "guard", "wrap"):
            return (moved[0],)
        elif op in ("min", "max", "select"):
            return (np.maximum(moved[-1], moved[-2]),)
        else:
            passed = (np.zeros_like(made[0]),)
        return tuple(p + np.abs(x) for p, x in zip(passed, made, strict=True))
