"""Adders and multipliers of single precision on arrays of words, for numba, with the bits of `floating`.

The sum or product of two singles in single precision is what `SingleSystem` rounds from double precision:
see `cordicc.backends.c_model_single`.  NaN is the invalid word, and takes the place of an infinity.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.compiled_steps import compiled

Singles = NDArray[np.float32]

_LARGEST = np.finfo(np.float32).max
_INVALID = np.float32(np.nan)


@compiled
def held(value: Any) -> Any:
    """Return a result, invalid beyond the format."""
    return value if abs(value) <= _LARGEST else _INVALID


@compiled
def add(a: Singles, b: Singles, result: Singles) -> None:
    """Add."""
    for i in range(result.size):
        result[i] = held(a[i] + b[i])


@compiled
def sub(a: Singles, b: Singles, result: Singles) -> None:
    """Subtract."""
    for i in range(result.size):
        result[i] = held(a[i] - b[i])


@compiled
def mul(a: Singles, b: Singles, result: Singles) -> None:
    """Multiply."""
    for i in range(result.size):
        result[i] = held(a[i] * b[i])


@compiled
def cmul(a: Singles, factor: Singles, result: Singles) -> None:
    """Multiply by a constant, of shape (1,)."""
    for i in range(result.size):
        result[i] = held(a[i] * factor[0])
