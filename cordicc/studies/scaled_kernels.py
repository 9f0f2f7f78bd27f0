"""Root-free micro-rotations scaled within the iterations: Krieger and Hosticka 1996, eqs. 13 to 16 and 9.

One iteration, with h = 2^-S, s = +-1 and the scaling digit e in {-1, 0, 1} of a circular (m = 1) or
hyperbolic (m = -1) sequence:

    x' = x - m h^2 x - 2 m s h y,   y' = y - m h^2 y + 2 s h x,   x'' = x' - e h^2 x',   y'' = y' - e h^2 y'.

It turns by 2 atan h (2 atanh h) and, all iterations together, leaves the norm as it was, but for |prod (1 -
e h^2)(1 + m h^2) - 1|.  z counts the whole angle; the paper prints half of it.  Arrays, shifts and sgn(0) =
+1 are those of `cordicc.arith.kernels.micro_rotations`: each product with a power of two is rounded half up
by itself, and the sums are exact.  The paper gives digits for m = 1 only (`krieger96`); with m = -1 the
norm is kept if e = -1 brings 1 - h^2 back, which needs a sequence made for it.

Rounding: an iteration errs by at most a unit in x' and y' (half for each shift) and half in the scaling.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.kernels.micro_rotations import shift_round, sign
from cordicc.arith.kernels.shift_sequences import StepTable
from cordicc.base.arrays import Integers


class ScaledTurn(NamedTuple):
    """A vector after the iterations, its angle, and where they mean something."""

    x: Integers
    y: Integers
    z: Integers
    valid: NDArray[np.bool_]


def rotate_scaled(x: Integers, y: Integers, z: Integers, table: StepTable) -> ScaledTurn:
    """Turn (x, y) by z, driven to 0: (x cos z - y sin z, y cos z + x sin z), m = -1: cosh and sinh.

    Valid where |z| <= `table.domain`; then z ends within the last angle, and as many units as an angle
    exceeds the sum of the later ones plus the last.
    """
    valid = np.abs(z) <= table.domain
    return ScaledTurn(*_iterated(x, y, z, table, lambda x, y, z: sign(z), counts=-1), valid.astype(np.bool_))


def vector_scaled(x: Integers, y: Integers, z: Integers, table: StepTable) -> ScaledTurn:
    """Turn (x, y) until y = 0: x becomes sgn(x) sqrt(x^2 + m y^2), z gains atan(y/x) (atanh).

    Circular: valid but at (0, 0), whose angle is none; the vector ends on its own side of x = 0.
    Hyperbolic: valid where |y| < |x| and the iterations have brought y within the last angle of 0, rounding
    included, which they do if |atanh(y/x)| is at most the sum of the angles plus the last.
    """
    x_end, y_end, z_end = _iterated(x, y, z, table, lambda x, y, z: -sign(x) * sign(y), counts=-1)
    if table.m > 0:
        valid = (x != 0) | (y != 0)
    else:
        valid = (np.abs(y) < np.abs(x)) & (np.abs(y_end) <= _last_turn(np.abs(x_end), table))
    return ScaledTurn(x_end, y_end, z_end, valid.astype(np.bool_))


def implicit_scaled(x: Integers, y: Integers, target: Integers, z: Integers, table: StepTable) -> ScaledTurn:
    """Turn (x, y) until y is the target by the paper's rule, eq. 9; z gains the angle turned.

    Kept for study: the norm is right only after the last iteration, so earlier comparisons with the target
    may be wrong, for some inputs beyond repair, and which of two solutions comes out depends on the data.
    Valid where y has come within the last angle of the target, rounding included, so not where there is
    no solution, nor where the rule has failed.
    """
    x_end, y_end, z_end = _iterated(x, y, z, table, lambda x, y, z: -sign(y - target) * sign(x), counts=1)
    reach = _last_turn(np.abs(x_end) + np.abs(y_end), table)
    valid = (np.abs(y_end - target) <= reach) & ((x != 0) | (y != 0))
    return ScaledTurn(x_end, y_end, z_end, valid.astype(np.bool_))


Rule = Callable[[Any, Any, Any], Integers]


def _iterated(
    x: Integers, y: Integers, z: Integers, table: StepTable, rule: Rule, counts: int
) -> tuple[Integers, Integers, Integers]:
    """Apply every micro-rotation; z gains `counts` times the angle turned."""
    for shift, angle, digit in zip(table.shifts, table.angles, table.eta, strict=True):
        direction = rule(x, y, z)
        turn_x = table.m * direction * shift_round(y, shift - 1)
        turn_y = direction * shift_round(x, shift - 1)
        x = x - table.m * shift_round(x, 2 * shift) - turn_x
        y = y - table.m * shift_round(y, 2 * shift) + turn_y
        if digit:
            x = x - digit * shift_round(x, 2 * shift)
            y = y - digit * shift_round(y, 2 * shift)
        z = z + counts * angle * direction
    return x, y, z


def _last_turn(size: Integers, table: StepTable) -> Integers:
    """Return what the last angle can move y by, 2h times the size, and four units an iteration of rounding.

    Circular: 2 atan h <= 2h and an iteration errs by at most 5/4 + 1/2 units in x'' and y'', 2.5 in length.
    Hyperbolic: y/x <= tanh(2 atanh h) <= 2h.
    """
    return shift_round(size, table.shifts[-1] - 1) + 4 * len(table.shifts)
