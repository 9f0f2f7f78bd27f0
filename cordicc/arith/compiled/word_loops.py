"""Adders, multipliers and conversions on arrays of words, for numba: those of `floating` and `fixed_system`.

The sum or product of two singles in single precision is what `SingleSystem` rounds from double precision:
see `cordicc.backends.c.c_single`.  NaN is the invalid word, and takes the place of an infinity.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cordicc.arith.compiled.step_loops import compiled
from cordicc.base.arrays import Floats, Int64s, Singles

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


Rounding = tuple[int, int, int, int]
"""Places to drop (append, if negative), the rounding's place in `ROUNDINGS`, largest and invalid word."""


@compiled
def rounded(value: int, rounding: Rounding) -> int:
    """Return a number below 2^62 rounded to a word, the invalid one beyond the format."""
    down, mode, largest, invalid = rounding
    if down > 0:
        if mode == 0:
            value += 1 << (down - 1)
        elif mode == 1:
            value += (1 << (down - 1)) - 1 + ((value >> down) & 1)
        value >>= down
    elif down < 0:
        up = min(-down, 62)
        value = value << up if abs(value) <= largest >> up else invalid
    return value if abs(value) <= largest else invalid


@compiled
def add_fixed(
    a: Int64s, b: Int64s, lifts: tuple[int, int], invalid: tuple[int, int], rounding: Rounding, result: Int64s
) -> None:
    """Add words lifted to one scale."""
    for i in range(result.size):
        word = rounded((a[i] << lifts[0]) + (b[i] << lifts[1]), rounding)
        result[i] = rounding[3] if (a[i] == invalid[0]) | (b[i] == invalid[1]) else word


@compiled
def sub_fixed(
    a: Int64s, b: Int64s, lifts: tuple[int, int], invalid: tuple[int, int], rounding: Rounding, result: Int64s
) -> None:
    """Subtract words lifted to one scale."""
    for i in range(result.size):
        word = rounded((a[i] << lifts[0]) - (b[i] << lifts[1]), rounding)
        result[i] = rounding[3] if (a[i] == invalid[0]) | (b[i] == invalid[1]) else word


@compiled
def mul_fixed(a: Int64s, b: Int64s, invalid: tuple[int, int], rounding: Rounding, result: Int64s) -> None:
    """Multiply; the second operand may be a single word, of shape (1,)."""
    last = b.size - 1
    for i in range(result.size):
        other = b[min(i, last)]
        word = rounded(a[i] * other, rounding)
        result[i] = rounding[3] if (a[i] == invalid[0]) | (other == invalid[1]) else word


@compiled
def encode_fixed(values: Floats, scale: float, rounding: Rounding, result: Int64s) -> None:
    """Round numbers to words; `rounding` drops no places."""
    _, mode, largest, invalid = rounding
    for i in range(result.size):
        scaled = values[i] * scale
        down = np.floor(scaled)
        if mode == 0:
            down += 1.0 if scaled - down >= 0.5 else 0.0
        elif mode == 1:
            down = np.rint(scaled)
        result[i] = np.int64(down) if abs(down) <= largest else invalid


@compiled
def decode_fixed(words: Int64s, unit: float, invalid: int, result: Floats) -> None:
    """Return the numbers of words."""
    for i in range(result.size):
        result[i] = np.nan if words[i] == invalid else words[i] * unit
