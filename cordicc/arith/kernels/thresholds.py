"""Thresholds of the end of reach: shares of the gain, and what a width grows by with |C|.

The functions take integers, arrays of them and signals of circuits alike, and numba compiles them: emulator,
compiled units and circuits have them from here, the C model and `plan.json` the constants.  `end_of_reach`
tells why they are what they are.
"""

from __future__ import annotations

import math
from typing import Any

from cordicc.arith.kernels.shift_sequences import SHARES

SHARE_BITS = SHARES.bit_length() - 1

SIXTEENTHS = 16

UPPER = 12
"""Sixteenths of a block from which on |C| has the larger width on the circle."""

ROOT_SCALE = 256
ROOT_BITS = ROOT_SCALE.bit_length() - 1

ROOTS = tuple(math.ceil(ROOT_SCALE * math.sqrt((n + 1) / SIXTEENTHS)) for n in range(SIXTEENTHS + 1))
"""Roots of |C| as a share of a block, by its whole sixteenths, rounded up, in units of 1/`ROOT_SCALE`."""


def before_step(whole: Any, stretched: Any) -> Any:
    """Return a threshold before a step, of the whole gain, from the gain so far in units of 1/`SHARES`.

    A multiple of `SHARES` less 1; what is below 0 stays there.
    """
    return ((whole + 1) >> SHARE_BITS) * stretched - 1


def sixteenths(size: Any, fraction_bits: int) -> Any:
    """Return the whole sixteenths of a block in |C|."""
    return size >> (fraction_bits - 4)


def is_upper(size: Any, fraction_bits: int) -> Any:
    """Return whether |C| has the larger width on the circle."""
    return size >= UPPER << (fraction_bits - 4)


def risen(rise: Any, root: Any) -> Any:
    """Return what the width near a vertex grows by, from the root of |C|."""
    return (rise * root + (ROOT_SCALE - 1)) >> ROOT_BITS


def as_limit(width: Any) -> Any:
    """Return the next multiple of `SHARES`, less 1."""
    return width | (SHARES - 1)
