"""Elementary functions of float64 arrays that have the same bits on every processor.

NumPy's own use the widest registers that there are, and round by the last place or two differently for it.
Where samples are compared beside singular points such a place decides, and so which plan is found.  These are
computed in extended precision, one number after the other, and rounded once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from cordicc.base.arrays import Floats


def _steady(function: Callable[..., Any]) -> Callable[..., Floats]:
    def computed(*operands: Any) -> Floats:
        with np.errstate(over="ignore", under="ignore"):
            return np.asarray(function(*(np.asarray(x, np.longdouble) for x in operands)), np.float64)

    return computed


sin = _steady(np.sin)
cos = _steady(np.cos)
tan = _steady(np.tan)
arcsin = _steady(np.arcsin)
arccos = _steady(np.arccos)
arctan = _steady(np.arctan)
arctan2 = _steady(np.arctan2)
sinh = _steady(np.sinh)
cosh = _steady(np.cosh)
tanh = _steady(np.tanh)
arcsinh = _steady(np.arcsinh)
arccosh = _steady(np.arccosh)
arctanh = _steady(np.arctanh)
exp = _steady(np.exp)
log = _steady(np.log)
_power = _steady(np.power)

_LARGEST_MULTIPLIED = 1 << 10
"""The largest size of an exponent whose power is found by products, which are far quicker."""


def power(base: Any, exponent: float) -> Floats:
    """Return base^exponent; of an integer by squares and products."""
    count = abs(int(exponent)) if abs(exponent) <= _LARGEST_MULTIPLIED else -1
    if count != abs(exponent):
        return _power(base, exponent)
    with np.errstate(over="ignore", under="ignore", divide="ignore"):
        square = np.asarray(base, np.longdouble)
        found = np.ones_like(square)
        while count:
            if count & 1:
                found = found * square
            count >>= 1
            square = square * square if count else square
        return np.asarray(1 / found if exponent < 0 else found, np.float64)
