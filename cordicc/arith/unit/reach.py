"""What an implicit unit holds of the end of reach: thresholds of its kernel, by the exponent of the block."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from cordicc.arith.kernels.end_of_reach import end_of_reach
from cordicc.arith.kernels.gaps import largest_gap
from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.arith.numbers.slack import Slack, SlackPlaces, slack_places
from cordicc.base.arrays import Int64s


class Near(NamedTuple):
    """Integers in places: the slack, the kernel's height and width, and how far y and the target may end apart.

    `short` is how far y may end on the near side of the target where there is a solution, `beyond` on the
    other: there the kernel turns to the end, if that is no farther than it can tell.
    """

    slack: Int64s
    height: Int64s
    width: Int64s
    short: Int64s
    beyond: Int64s


@dataclass(frozen=True, slots=True)
class ReachTable:
    """`Near` by the slack in places, and which row a block's exponent has."""

    places: SlackPlaces
    height: Int64s
    width: Int64s
    short: Int64s
    beyond: Int64s

    def at(self, exponent: Int64s) -> Near:
        """Return the integers for blocks with places of 2^exponent."""
        rows = self.places.rows(exponent)
        return Near(
            self.places.places[rows], self.height[rows], self.width[rows], self.short[rows], self.beyond[rows]
        )


def reach_table(sequence: Sequence, fraction_bits: int, angle_bits: int, slack: Slack) -> ReachTable:
    """Return the thresholds of a kernel for operands with a slack.

    Raises ValueError if the sequence has no bound, see `implicit_residual_bound`.
    """
    if slack.relative:
        limit = 1 << fraction_bits
        one = min(limit, math.ceil(slack.size * limit))
        places = SlackPlaces(0, np.array([one], dtype=np.int64))
    else:
        places = slack_places(slack.size, fraction_bits)
    end = end_of_reach(sequence, fraction_bits, angle_bits)
    moved = places.places.astype(np.float64)
    gap = largest_gap(sequence, fraction_bits, angle_bits)
    short = gap + end.stretch * moved
    beyond = np.maximum(short, end.stretch * (end.depth(moved) + end.across))
    columns = (end.height(moved), end.width(moved), short, beyond)
    return ReachTable(places, *(np.ceil(column).astype(np.int64) for column in columns))
