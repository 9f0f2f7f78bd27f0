"""What an implicit unit holds of the end of reach: thresholds of its kernel, by the exponent of the block."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from cordicc.arith.kernels.end_of_reach import end_of_reach
from cordicc.arith.kernels.gaps import largest_gap
from cordicc.arith.kernels.micro_rotations import NEVER, NearEnd
from cordicc.arith.kernels.shift_sequences import Sequence
from cordicc.arith.kernels.thresholds import ROOTS, SIXTEENTHS, as_limit, is_upper, risen, sixteenths
from cordicc.arith.numbers.slack import Rows, Slack, rows_for
from cordicc.base.arrays import Bools, Int64s


class Near(NamedTuple):
    """Integers in places: what counts as the end, the kernel's thresholds, how far y ends from the target.

    The end is where |C| is at most `slack` beyond it, or `within` before it.  The kernel's width is `room`
    and as much of `rise` as the root of |C| tells, see `EndOfReach`.  `short` is how far y may end on the
    near side of the target where there is a solution, `beyond` on the other: there the kernel turns to the
    end, if that is no farther than it can tell.
    """

    slack: Int64s
    within: Int64s
    height: Int64s
    rise: Int64s
    room: Int64s
    short: Int64s
    beyond: Int64s

    def thresholds(self, m: int, target: Int64s, fraction_bits: int, kept: Bools | bool) -> NearEnd:
        """Return the thresholds of a kernel for targets in places; `NEVER` where a sample is kept from it."""
        size = np.abs(target)
        if m > 0:
            width = self.rise * is_upper(size, fraction_bits) + self.room
        else:
            root = _ROOTS[np.minimum(sixteenths(size, fraction_bits), SIXTEENTHS)]
            width = risen(self.rise, root) + self.room
        return NearEnd(np.where(kept, NEVER, self.height), as_limit(width))


_ROOTS = np.array(ROOTS, dtype=np.int64)


@dataclass(frozen=True, slots=True)
class ReachTable:
    """The columns of `Near`, and which row a block's exponent has."""

    rows: Rows
    columns: Near

    def at(self, exponent: Int64s) -> Near:
        """Return the integers for blocks with places of 2^exponent."""
        row = self.rows.of(exponent)
        return Near(*(column[row] for column in self.columns))


def reach_table(sequence: Sequence, fraction_bits: int, angle_bits: int, slack: Slack) -> ReachTable:
    """Return the thresholds of a kernel for operands with a slack.

    Raises ValueError if the sequence has no bound, see `implicit_residual_bound`.
    """
    # A relative slack is one of the power of two above a block's largest number.
    scale = Fraction(1 << fraction_bits if slack.relative else 1)
    rows = rows_for(0.0 if slack.relative else slack.beyond, fraction_bits)
    within = rows.places(Fraction(slack.within) * scale, fraction_bits)
    end = end_of_reach(sequence, fraction_bits, angle_bits)
    near = within.astype(np.float64)
    beyond = rows.places(Fraction(slack.beyond) * scale, fraction_bits)
    short = largest_gap(sequence, fraction_bits, angle_bits) + end.stretch * beyond.astype(np.float64)
    farther = np.maximum(short, end.stretch * (end.depth(near) + end.across))
    columns = (end.height(near), end.rise(near), end.room(near), short, farther)
    return ReachTable(rows, Near(beyond, within, *(np.ceil(c).astype(np.int64) for c in columns)))
