"""What counts as the end of reach in circuits: thresholds by the exponent of the block, see `unit.reach`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import clipped
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.uses import Modes
from cordicc.arith.kernels.end_of_reach import ROOT_SCALE, ROOTS, SIXTEENTHS
from cordicc.arith.kernels.shift_sequences import SHARES
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
        b = self.modes.builder
        found: CircuitSignal | None = None
        for number, table in self.tables.items():
            values = getattr(table.columns, name).tolist()
            own = b.pick(b.narrowed(self.row, 0, table.rows.count - 1, loose=True), values)
            found = own if found is None else b.mux(self.modes.mode.equals(number), found, own)
        assert found is not None
        return found

    def limits(self, size: CircuitSignal, fraction_bits: int) -> tuple[Limit, Limit]:
        """Return the height and the width of the kernel for a target's size."""
        b = self.modes.builder
        rise, room = self.column("rise"), self.column("room")
        width = room
        if rise.hi:
            root = b.pick(b.narrowed(size >> (fraction_bits - 4), 0, SIXTEENTHS), list(ROOTS))
            width = room + ((rise * root + (ROOT_SCALE - 1)) >> (ROOT_SCALE.bit_length() - 1))
        return self._limit(self.column("height"), "height"), self._limit(width, None if rise.hi else "room")

    def _limit(self, threshold: CircuitSignal, column: str | None) -> Limit:
        """Return a threshold of which the rows tell the places that are all 1."""
        places = SHARES.bit_length() - 1
        if column is not None:
            columns = [getattr(table.columns, column) for table in self.tables.values()]
            ends = [each + 1 for values in columns for each in values.tolist()]
            places = min((each & -each).bit_length() - 1 for each in ends)
        return Limit((threshold >> places) + 1, places)


class Limit(NamedTuple):
    """What a number is below: a multiple of 2^places."""

    multiple: CircuitSignal
    places: int

    def before(self, b: CircuitBuilder, stretched: int) -> Limit:
        """Return what holds before a step, from the gain so far as a share of the whole one."""
        shift = SHARES.bit_length() - 1
        if stretched == SHARES:
            return self
        down = (stretched & -stretched).bit_length() - 1
        return Limit(times(b, self.multiple, stretched >> down), self.places - shift + down)

    def above(self, b: CircuitBuilder, value: CircuitSignal) -> CircuitSignal:
        """Return whether a value is not negative and below."""
        value, multiple = value >> self.places, self.multiple
        if multiple.lo != multiple.hi:
            return ~b.negative(value) & (value < multiple)
        bits = multiple.hi.bit_length()
        fits = b.pick(b.low(value, bits), [int(each < multiple.hi) for each in range(1 << bits)])
        return (value >> bits).equals(0) & fits
