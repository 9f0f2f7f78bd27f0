"""First-order bounds of how far rounding moves a value, on sample points, in units of the rounding.

Every operation rounds its result, and passes on the errors of its operands times the absolute values of
its partial derivatives.  Numbers with exponents are rounded relative to themselves; a fixed-point word has
one step for all that it holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from cordicc.arith.numbers.decimals import double_shift, nearest_double
from cordicc.base import elementary
from cordicc.base.arrays import Floats
from cordicc.ir.graph import Node, Param
from cordicc.ir.ops import OPS

Errors = tuple[Floats, ...]
_Arrays = Sequence[Floats]


@dataclass(frozen=True, slots=True)
class Words:
    """How numbers are rounded.

    Attributes:
        rounding: half a last place of a number of size 1, in a word between operations.
        outside: how many such roundings one of an input or output is.
        fixed: words have one step for all that they hold.
    """

    rounding: float = 2.0**-24
    outside: float = 1.0
    fixed: bool = False

    def steps(self, node: Node, made: Sequence[Floats]) -> Errors:
        """Return how far each result of an operation is rounded, given it on all samples, in roundings."""
        if not self.fixed:
            return tuple(np.abs(x) for x in made)
        angles = {node.angle, node.hyperbolic_angle}
        held = [np.fmax.reduce(np.abs(x), initial=_ANGLE * (i in angles)) for i, x in enumerate(made)]
        coarser = self.outside if node.op == "input" else 1.0
        return tuple(np.asarray(coarser * _power_above(float(size))) for size in held)


SINGLE = Words()
"""Those of single precision."""

_ANGLE = 0.5
"""Finer words than for angles of this size would only show the error of the unit that made one."""


def _power_above(size: float) -> float:
    """Return the least power of two that is no less than a number, 0 for 0."""
    fraction, exponent = math.frexp(size)
    if not fraction or math.isinf(fraction):
        return size
    return math.ldexp(1.0, min(exponent - (fraction == _HALF), _LARGEST))


_HALF = 0.5
_LARGEST = 1023


def errors(
    op: str,
    params: Sequence[Param],
    values: _Arrays,
    moved: _Arrays,
    made: _Arrays,
    steps: _Arrays,
) -> Errors:
    """Return the error bound of every result; inputs and constants carry one rounding.

    Args:
        op: an operation of a graph of unit operations.
        params: its parameters in the order of its definition.
        values: its operands on the samples.
        moved: the error bounds of the operands.
        made: its results.
        steps: how far each of them is rounded, see `Words.steps`.
    """
    with np.errstate(all="ignore"):
        passed = ERRORS[op](values, moved, made, **OPS[op].named(params))
        if op in EXACT:
            return passed
        return tuple(p + step for p, step in zip(passed, steps, strict=True))


def _none(v: _Arrays, e: _Arrays, made: _Arrays, **params: Param) -> Errors:
    return (np.zeros_like(made[0]),)


def _sum(v: _Arrays, e: _Arrays, made: _Arrays) -> Errors:
    return (e[0] + e[1],)


def _product(v: _Arrays, e: _Arrays, made: _Arrays) -> Errors:
    return (np.abs(v[0]) * e[1] + np.abs(v[1]) * e[0],)


def _scaled(v: _Arrays, e: _Arrays, made: _Arrays, factor: Fraction) -> Errors:
    return (abs(nearest_double(factor)) * e[0],)


def _shifted(v: _Arrays, e: _Arrays, made: _Arrays, exponent: Fraction) -> Errors:
    return (np.ldexp(e[0], double_shift(exponent)),)


def _kept(v: _Arrays, e: _Arrays, made: _Arrays, **params: Param) -> Errors:
    return (e[0],)


def _chosen(v: _Arrays, e: _Arrays, made: _Arrays) -> Errors:
    return (np.maximum(e[-1], e[-2]),)


def _rotate(v: _Arrays, e: _Arrays, made: _Arrays, m: int) -> Errors:
    x, y, z = v
    if m == 0:
        return e[0], e[1] + np.abs(z) * e[0] + np.abs(x) * e[2]
    c, s = (elementary.cos(z), elementary.sin(z)) if m == 1 else (elementary.cosh(z), elementary.sinh(z))
    c, s = np.abs(c), np.abs(s)
    size = np.hypot(x, y) * (c + s)
    return (
        c * e[0] + s * e[1] + np.abs(made[1]) * e[2] + size,
        c * e[1] + s * e[0] + np.abs(made[0]) * e[2] + size,
    )


def _vector(v: _Arrays, e: _Arrays, made: _Arrays, m: int, sign: int) -> Errors:
    x, y, _ = (np.abs(a) for a in v)
    if m == 0:
        return e[0], e[1] / x + y * e[0] / x**2 + e[2]
    norm = np.abs(made[0])
    return (x * e[0] + y * e[1]) / norm, (y * e[0] + x * e[1]) / norm**2 + e[2] + 1.0


def _lightcone(v: _Arrays, e: _Arrays, made: _Arrays) -> Errors:
    u, w = (np.abs(a) for a in v)
    return (w * e[0] + u * e[1]) / (2 * np.abs(made[0])), (e[0] / u + e[1] / w) / 2 + 1.0


def _implicit(v: _Arrays, e: _Arrays, made: _Arrays, m: int, branch: str) -> Errors:
    A, B, C = (np.abs(a) for a in v)
    angle, rest = made
    c, s = (
        (elementary.cos(angle), elementary.sin(angle))
        if m == 1
        else (elementary.cosh(angle), elementary.sinh(angle))
    )
    steep = np.abs(rest)
    own = np.hypot(A, B)
    residual = np.abs(s) * e[0] + np.abs(c) * e[1] + e[2] + own
    return residual / steep + 1.0, (A * e[0] + B * e[1] + C * e[2] + own * own) / steep


ERRORS: dict[str, Callable[..., Errors]] = {
    "input": _none,
    "const": _none,
    "add": _sum,
    "sub": _sum,
    "mul": _product,
    "cmul": _scaled,
    "shift": _shifted,
    "neg": _kept,
    "abs": _kept,
    "sign": _none,
    "min": _chosen,
    "max": _chosen,
    "flip": _kept,
    "select": _chosen,
    "guard": _kept,
    "wrap": _kept,
    "rotate": _rotate,
    "vector": _vector,
    "lightcone": _lightcone,
    "implicit": _implicit,
}
"""What results take on of their operands, besides their own rounding."""

EXACT = ("shift", "neg", "abs", "flip", "guard", "wrap", "min", "max", "select")
"""Operations whose results are not rounded."""
