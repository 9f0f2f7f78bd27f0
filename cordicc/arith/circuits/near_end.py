"""What counts as the end of reach in circuits: thresholds by the exponent of the block, see `unit.reach`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import clipped
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.uses import Modes
from cordicc.arith.kernels.shift_sequences import SHARES
from cordicc.arith.kernels.thresholds import (
    ROOTS,
    SHARE_BITS,
    SIXTEENTHS,
    is_upper,
    risen,
    sixteenths,
)
from cordicc.arith.unit.reach import ReachTable


class NearColumns(NamedTuple):
    """The columns of `reach.Near` as signals, by the use, of some, and the exponent of the block."""

    modes: Modes
    tables: Mapping[int, ReachTable]
    row: CircuitSignal
    slack: CircuitSignal
    within: CircuitSignal
    short: CircuitSignal
    beyond: CircuitSignal

    @classmethod
    def of(cls, modes: Modes, tables: Mapping[int, ReachTable], exponent: CircuitSignal) -> NearColumns:
        """Return the rows of blocks with places of 2^exponent."""
        b = modes.builder
        known = [tables.get(number) for number in range(len(modes.uses))]
        first = b.pick(modes.mode, [table.rows.first if table else 0 for table in known])
        last = b.pick(modes.mode, [table.rows.count - 1 if table else 0 for table in known])
        row = b.named("row", clipped(b, exponent - first, 0, last))
        bare = cls(modes, tables, row, row, row, row, row)
        return bare._replace(
            slack=bare.column("slack"),
            within=bare.column("within"),
            short=bare.column("short"),
            beyond=bare.column("beyond"),
        )

    def column(self, name: str) -> CircuitSignal:
        """Return a column."""
        return self._picked([getattr(table.columns, name).tolist() for table in self.tables.values()])

    def limits(self, size: CircuitSignal, m: int, fraction_bits: int) -> tuple[Limit, Limit]:
        """Return the height and the width of the kernel for a target's size."""
        b = self.modes.builder
        columns = [table.columns for table in self.tables.values()]
        height = self._limits([[near.height.tolist() for near in columns]], None)
        if m > 0:
            widths = [[(near.room + part * near.rise).tolist() for near in columns] for part in (0, 1)]
            return height, self._limits(widths, is_upper(size, fraction_bits))
        root = b.pick(b.narrowed(sixteenths(size, fraction_bits), 0, SIXTEENTHS), list(ROOTS))
        width = self.column("room") + risen(self.column("rise"), root)
        return height, Limit(((width >> SHARE_BITS) + 1,), SHARE_BITS, None)

    def _limits(self, choices: Sequence[Sequence[Sequence[int]]], choice: CircuitSignal | None) -> Limit:
        """Return one or two thresholds by the use and the row, and what chooses the second one."""
        ends = [each + 1 for columns in choices for values in columns for each in values]
        places = min((each & -each).bit_length() - 1 for each in ends)
        multiples = (
            self._picked([[(each + 1) >> places for each in values] for values in columns])
            for columns in choices
        )
        return Limit(tuple(multiples), places, choice)

    def _picked(self, columns: Sequence[Sequence[int]]) -> CircuitSignal:
        """Return a number by the use and the row."""
        b = self.modes.builder
        found: CircuitSignal | None = None
        for (number, table), values in zip(self.tables.items(), columns, strict=True):
            own = b.pick(b.narrowed(self.row, 0, table.rows.count - 1, loose=True), values)
            found = own if found is None else b.mux(self.modes.mode.equals(number), found, own)
        assert found is not None
        return found


class Limit(NamedTuple):
    """What a number is below: a multiple of 2^places, the second one where there are two and a bit is 1."""

    multiples: tuple[CircuitSignal, ...]
    places: int
    choice: CircuitSignal | None

    @property
    def is_known(self) -> bool:
        """Whether there are constants alone."""
        return all(each.lo == each.hi for each in self.multiples)

    @property
    def largest(self) -> int:
        """The largest value."""
        return max(each.hi for each in self.multiples) << self.places

    def before(self, b: CircuitBuilder, stretched: int) -> Limit:
        """Return what holds before a step, from the gain so far as a share of the whole one."""
        if stretched == SHARES:
            return self
        down = (stretched & -stretched).bit_length() - 1
        multiples = tuple(times(b, each, stretched >> down) for each in self.multiples)
        return Limit(multiples, self.places - SHARE_BITS + down, self.choice)

    def value(self, b: CircuitBuilder) -> CircuitSignal:
        """Return the value."""
        return self._of(b, self.multiples) << self.places

    def above(self, b: CircuitBuilder, value: CircuitSignal) -> CircuitSignal:
        """Return whether a value is not negative and below."""
        value = value >> self.places
        if self.is_known:
            return self._of(b, [_below(b, value, each.hi) for each in self.multiples])
        return ~b.negative(value) & (value < self._of(b, self.multiples))

    def _of(self, b: CircuitBuilder, several: Sequence[CircuitSignal]) -> CircuitSignal:
        return several[0] if self.choice is None else b.mux(self.choice, *several)


def _below(b: CircuitBuilder, value: CircuitSignal, end: int) -> CircuitSignal:
    """Return whether a value is not negative and below a constant of few bits."""
    bits = end.bit_length()
    fits = b.pick(b.low(value, bits), [int(each < end) for each in range(1 << bits)])
    return (value >> bits).equals(0) & fits
