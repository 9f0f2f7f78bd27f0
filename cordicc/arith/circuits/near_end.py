"""What counts as the end of reach in circuits: thresholds by the exponent of the block, see `unit.reach`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitSignal
from cordicc.arith.circuits.limits import clipped
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

    def column(self, name: str, stretched: int = SHARES) -> CircuitSignal:
        """Return a column, perhaps as it is before a step, by the gain so far as a share of the whole."""
        b = self.modes.builder
        found: CircuitSignal | None = None
        for number, table in self.tables.items():
            values = [_share(value, stretched) for value in getattr(table.columns, name).tolist()]
            own = b.pick(b.narrowed(self.row, 0, table.rows.count - 1, loose=True), values)
            found = own if found is None else b.mux(self.modes.mode.equals(number), found, own)
        assert found is not None
        return found

    def width(self, size: CircuitSignal, fraction_bits: int) -> CircuitSignal:
        """Return the width of the kernel for a target's size."""
        b = self.modes.builder
        root = b.pick(b.narrowed(size >> (fraction_bits - 4), 0, SIXTEENTHS), list(ROOTS))
        product = self.column("rise") * root + (ROOT_SCALE - 1)
        return (product >> (ROOT_SCALE.bit_length() - 1)) + self.column("room")


def _share(size: int, stretched: int) -> int:
    return (size * stretched + SHARES - 1) // SHARES
