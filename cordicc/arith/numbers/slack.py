"""The slack of an operation: how far rounding may have moved its operands across the border of its domain.

A root of a number that is negative by no more than that is 0, and |C| beyond R by no more is R: what rounding
alone puts beyond a border is on it.  An operation on exact operands has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.base.arrays import Int64s

SIZES = (2.0**-140, 2.0**140)
"""What a slack may be: a smaller one is nothing to any number format."""


@dataclass(frozen=True, slots=True)
class Slack:
    """How far beyond the border, and within the end of reach, a sample counts as on it.

    Sizes in the operands' unit, or `relative` to the power of two above the largest operand.
    """

    beyond: float = 0.0
    within: float = 0.0
    relative: bool = False

    def __post_init__(self) -> None:
        for size in (self.beyond, self.within):
            if size and not SIZES[0] <= size <= SIZES[1]:
                raise ValueError(f"{size} is no slack")
        if self.within > self.beyond:
            raise ValueError(f"{self.within} within reach counts as the end, more than {self.beyond} beyond")


EXACT = Slack()
"""Of operands that rounding has not moved."""

SLACK = "slack"
"""What it is called among the settings of an operation."""


def slack_of(settings: Mapping[str, Any]) -> Slack:
    """Return the slack among the settings of an operation."""
    slack = settings.get(SLACK, EXACT)
    assert isinstance(slack, Slack)
    return slack


@dataclass(frozen=True, slots=True)
class Rows:
    """The rows of a table of places by their exponent, `first` and what is below in the first one."""

    first: int
    count: int

    def of(self, exponent: Int64s) -> Int64s:
        """Return the row for places of 2^exponent."""
        return np.clip(exponent - self.first, 0, self.count - 1)

    def places(self, size: Fraction, limit_bits: int) -> Int64s:
        """Return a size in whole places of each row, not above, and at most 2^`limit_bits`."""
        exponents = range(self.first, self.first + self.count)
        found = [min(1 << limit_bits, math.floor(size / Fraction(2) ** exponent)) for exponent in exponents]
        return np.array(found, dtype=np.int64)


def rows_for(size: float, limit_bits: int) -> Rows:
    """Return rows from where a size is 2^`limit_bits` places to where it is none; one row for 0."""
    last = math.frexp(size)[1]
    return Rows(last - limit_bits - 1, limit_bits + 2) if size else Rows(0, 1)
