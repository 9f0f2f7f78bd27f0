"""The slack of an operation: how far rounding may have moved its operands across the border of its domain.

A root of a number that is negative by no more than that is 0, and |C| beyond R by no more is R: what rounding
alone puts beyond a border is on it.  An operation on exact operands has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from cordicc.arith.numbers.decimals import parse_decimal
from cordicc.base.arrays import Int64s

ABSOLUTE, RELATIVE = "slack", "relative_slack"
"""The parameters of an operation that hold it, decimal texts."""

SIZES = (Fraction(1, 1 << 600), Fraction(1 << 600))
"""Beyond what a slack may be: every size between is a double."""


@dataclass(frozen=True, slots=True)
class Slack:
    """A size, in the operands' unit or `relative` to the power of two above the largest operand."""

    size: Fraction = Fraction(0)
    relative: bool = False

    @classmethod
    def of(cls, params: Mapping[str, Any]) -> Slack:
        """Return the slack among the parameters of an operation.  Raises ValueError or OverflowError."""
        for name, relative in ((ABSOLUTE, False), (RELATIVE, True)):
            if name in params:
                size = parse_decimal(params[name])
                if not SIZES[0] <= size <= SIZES[1]:
                    raise ValueError(f"{name} = {params[name]} is no slack")
                return cls(size, relative)
        return EXACT


EXACT = Slack()
"""Of operands that rounding has not moved."""


@dataclass(frozen=True, slots=True)
class SlackPlaces:
    """The slack in places by their exponent: `places[0]` up to the exponent `first`, and so on; 0 at last."""

    first: int
    places: Int64s

    def rows(self, exponent: Int64s) -> Int64s:
        """Return the index into `places` for places of 2^exponent."""
        if len(self.places) == 1:
            return np.zeros_like(exponent)
        return np.clip(exponent - self.first, 0, len(self.places) - 1)

    def at(self, exponent: Int64s) -> Int64s:
        """Return the whole places of 2^exponent within the slack."""
        return self.places[self.rows(exponent)]


@cache
def slack_places(size: Fraction, limit_bits: int) -> SlackPlaces:
    """Return a size in whole places, not above, and at most 2^`limit_bits`."""
    if not size:
        return SlackPlaces(0, np.zeros(1, dtype=np.int64))
    last = math.frexp(float(size))[1]  # no whole place there, and 2^limit_bits of them at the first
    exponents = range(last - limit_bits - 1, last + 1)
    found = [min(1 << limit_bits, int(size / Fraction(2) ** exponent)) for exponent in exponents]
    return SlackPlaces(exponents.start, np.array(found, dtype=np.int64))
