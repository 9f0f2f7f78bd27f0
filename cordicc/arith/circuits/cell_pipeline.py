"""Cells in the cycles of a clock: a cell follows its operands, in the next cycle if it would come too late.

Cells are known by their numbers.  Operands that exist before the cycle of a cell wait in registers.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from cordicc.arith.circuits.cell_delays import Clocking
from cordicc.arith.circuits.circuit import SIGNAL_NAMES, Gate


class CellPipeline:
    """Cells with their cycles, when in its cycle each result exists, names, and comments."""

    def __init__(self, clocking: Clocking) -> None:
        self.cells: list[Gate] = []
        self.notes: dict[int, str] = {}
        self._clocking = clocking
        self._arrivals: list[float] = []
        self._made: dict[tuple[object, ...], int] = {}
        self._later: dict[int, int] = {}
        self._note: str | None = None
        self._names: set[str] = set()
        self._scope: list[str] = []

    def place(
        self,
        kind: str,
        operands: Sequence[int],
        params: tuple[int, ...],
        lo: int,
        hi: int,
        name: str | None = None,
    ) -> int:
        """Return the cell of a kind with some operands; there is one of each."""
        key = (kind, *operands, params, lo, hi)
        if name is None and key in self._made:
            return self._made[key]
        cells = [self.cells[each] for each in operands]
        cycles = [cell.cycle for cell in cells if cell.cycle is not None]
        constant = kind == "constant" or (bool(operands) and not cycles)
        cycle = max(cycles, default=0)
        start = self._last_arrival(operands, cycle)
        taken = 0.0 if constant else self._clocking.delay_ns(kind, cells, lo, hi)
        if start > 0 and taken > 0 and start + taken > self._clocking.free_ns:
            cycle, start = cycle + 1, 0.0
        numbers = tuple(self.at(each, cycle) for each in operands)
        number = len(self.cells)
        if name is None:
            name = self._unique("_".join([*self._scope, SIGNAL_NAMES.get(kind, kind)])) + "_"
        else:
            self._names.add(name)
        self.cells.append(Gate(kind, numbers, params, lo, hi, None if constant else cycle, name))
        self._arrivals.append(self._clocking.entry_ns if kind == "input" else start + taken)
        self._made[key] = number
        if self._note is not None and kind != "constant":
            self.notes[number] = self._note
            self._note = None
        return number

    def at(self, number: int, cycle: int) -> int:
        """Return the cell that has the result of another in a cycle, behind registers."""
        cell = self.cells[number]
        while cell.cycle is not None and cell.cycle < cycle:
            if number not in self._later:
                base = cell.name.rstrip("_")
                name = self._unique(f"{base.rpartition('_q')[0] or base}_q{cell.cycle + 1}")
                self._later[number] = len(self.cells)
                self.cells.append(Gate("register", (number,), (), cell.lo, cell.hi, cell.cycle + 1, name))
                self._arrivals.append(0.0)
            number = self._later[number]
            cell = self.cells[number]
        return number

    def loop(
        self, operands: Sequence[int], number: int, ranges: Sequence[tuple[int, int]], steps: int
    ) -> list[int]:
        """Return the cells of a loop's states after so many cycles; its operands are in registers before."""
        inside = self.together(operands, math.inf)
        cycle = max((self.cells[each].cycle or 0 for each in inside), default=0)
        found = []
        for state, (lo, hi) in enumerate(ranges):
            name = self._unique("_".join([*self._scope, SIGNAL_NAMES["loop"]])) + "_"
            found.append(len(self.cells))
            self.cells.append(Gate("loop", tuple(inside), (number, state), lo, hi, cycle + steps, name))
            self._arrivals.append(0.0)
        return found

    def cycles(self, numbers: Sequence[int]) -> int:
        """Return the cycles after which results are in registers, 0 if nothing is clocked."""
        if self._clocking.period_ns == math.inf:
            return 0
        last = max((self.cells[number].cycle or 0 for number in numbers), default=0)
        return last + (self._last_arrival(numbers, last) > 0)

    def together(self, numbers: Sequence[int], ahead_ns: float) -> list[int]:
        """Return cells in one cycle, in which what takes some time yet can follow."""
        cycle = max((self.cells[number].cycle or 0 for number in numbers), default=0)
        late = self._last_arrival(numbers, cycle)
        if late > 0 and late + ahead_ns > self._clocking.free_ns:
            cycle += 1
        return [self.at(number, cycle) for number in numbers]

    def taken_ns(self, before: Sequence[int], after: Sequence[int]) -> float:
        """Return the time from some results to others, infinite if not all are in one cycle."""
        cycles = {self.cells[number].cycle for number in (*before, *after)} - {None}
        if len(cycles) > 1:
            return math.inf
        start, end = (max(self._arrivals[number] for number in numbers) for numbers in (before, after))
        return end - start

    def latest_ns(self, numbers: Sequence[int]) -> float:
        """Return when the last of some results exists in its cycle."""
        return max((self._arrivals[number] for number in numbers), default=0.0)

    def comment(self, text: str) -> None:
        """Say something of the cells that follow."""
        self._note = text

    @contextmanager
    def scope(self, prefix: str) -> Iterator[None]:
        """Let the names of cells begin with a prefix."""
        self._scope.append(prefix)
        yield
        self._scope.pop()

    def call(self, number: int, name: str) -> None:
        """Give a result a name of its own, if it has none that somebody chose."""
        cell = self.cells[number]
        if cell.kind not in ("input", "constant") and cell.name.endswith("_"):
            self.cells[number] = replace(cell, name=self._unique("_".join([*self._scope, name])))

    def _last_arrival(self, numbers: Sequence[int], cycle: int) -> float:
        late = [self._arrivals[number] for number in numbers if self.cells[number].cycle == cycle]
        return max(late, default=0.0)

    def _unique(self, name: str) -> str:
        found, count = name, 2
        while found in self._names:
            found, count = f"{name}{count}", count + 1
        self._names.add(found)
        return found
