"""Which slots of units are taken, by operations that keep a unit for several cycles.

An operation keeps its unit for consecutive slots, cycles modulo the interval: an arc of a circle.  Arcs that
do not overlap may be on one unit; how many units arcs need is the colouring of a circular-arc graph, at least
the most arcs over any slot and sometimes more.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

_MOST_NODES = 2_000
"""Of the search in depth for a colouring with fewer units than the first fit needs."""
_MOST_LITERALS = 20_000
"""Arcs times units up to which the constraint program looks for such a colouring after that."""
_MOST_WORK = 0.5
"""Its deterministic time."""


class Reservations:
    """The free slots of some units of a kind, a bit for each slot."""

    def __init__(self, interval: int, units: int) -> None:
        self._interval = interval
        self._full = (1 << interval) - 1
        self._free = [self._full] * units

    def _arc(self, cycle: int, busy: int) -> int:
        """Return the slots of an arc."""
        return self._turned((1 << busy) - 1, cycle)

    def _turned(self, slots: int, by: int) -> int:
        """Return slots moved by so many cycles."""
        by %= self._interval
        return ((slots << by) | (slots >> (self._interval - by))) & self._full

    def is_free(self, unit: int, cycle: int, busy: int) -> bool:
        """Tell whether a unit is free for so many cycles from one on."""
        return not self._arc(cycle, busy) & ~self._free[unit]

    def unit_for(self, cycle: int, busy: int) -> int | None:
        """Return the first unit that is free for so many cycles from one on, None if there is none."""
        return next((unit for unit in range(len(self._free)) if self.is_free(unit, cycle, busy)), None)

    def take(self, unit: int, cycle: int, busy: int) -> None:
        """Take a unit for so many cycles."""
        self._free[unit] &= ~self._arc(cycle, busy)

    def release(self, unit: int, cycle: int, busy: int) -> None:
        """Undo `take`."""
        self._free[unit] |= self._arc(cycle, busy)

    def next_for(self, cycle: int, busy: int) -> tuple[int, int] | None:
        """Return the first cycle from one on, and a unit that is free for so many cycles from it on.

        None if no unit is ever free for so long.
        """
        best: tuple[int, int] | None = None
        for unit, free in enumerate(self._free):
            starts = self._turned(self._starts(free, busy), -cycle)
            if starts:
                wait = (starts & -starts).bit_length() - 1
                if best is None or wait < best[0]:
                    best = wait, unit
                if wait == 0:
                    break
        return None if best is None else (cycle + best[0], best[1])

    def _starts(self, free: int, busy: int) -> int:
        """Return the slots from which on so many are free."""
        length = 1
        while length < busy and free:
            step = min(length, busy - length)
            free &= self._turned(free, -step)
            length += step
        return free


def coloured(arcs: Sequence[tuple[int, int]], interval: int) -> list[int]:
    """Return a unit for each arc (slot of the first cycle, cycles), so that none overlaps on a unit.

    With the fewest units that searches of bounded work find; no fewer than the most arcs over a slot.
    """
    return list(_coloured(tuple(arcs), interval))


@lru_cache(maxsize=4096)
def _coloured(arcs: tuple[tuple[int, int], ...], interval: int) -> tuple[int, ...]:
    load = [0] * interval
    for slot, busy in arcs:
        for place in range(busy):
            load[(slot + place) % interval] += 1
    least = max(load, default=0)
    # Cut open where the fewest arcs cross, which are the first ones then.
    cut = min(range(interval), key=lambda place: (load[place], place), default=0)

    def rank(index: int) -> tuple[int, int]:
        slot, busy = arcs[index]
        behind = (slot - cut) % interval
        return (behind - interval if behind + busy > interval else behind), index

    order = sorted(range(len(arcs)), key=rank)
    found = _first_fit(arcs, order, interval)
    search = _Colouring(arcs, order, interval)
    for units in range(least, max(found, default=-1) + 1):
        fewer = search.within(units) or _by_program(arcs, interval, units)
        if fewer is not None:
            return tuple(fewer)
    return tuple(found)


def _by_program(arcs: Sequence[tuple[int, int]], interval: int, units: int) -> list[int] | None:
    """Return a colouring with so many units that the constraint program finds, None if it finds none."""
    if len(arcs) * units > _MOST_LITERALS:
        return None
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    on = [[model.new_bool_var("") for _ in range(units)] for _ in arcs]
    for literals in on:
        model.add_exactly_one(literals)
    # Two arcs that overlap do so where one of them begins.
    over = [
        [i for i, (slot, busy) in enumerate(arcs) if (place - slot) % interval < busy]
        for place in sorted({slot for slot, _ in arcs})
    ]
    for members in over:
        for unit in range(units):
            model.add_at_most_one(on[i][unit] for i in members)
    # Units are alike: the arcs over the fullest place are on the first ones.
    fullest = max(over, key=len)
    for unit, i in enumerate(fullest):
        model.add(on[i][unit] == 1)
    solver = cp_model.CpSolver()
    solver.parameters.random_seed = 1
    solver.parameters.num_workers = 1
    solver.parameters.max_deterministic_time = _MOST_WORK
    if solver.solve(model) not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return None
    return [next(unit for unit in range(units) if solver.value(literals[unit])) for literals in on]


def _first_fit(arcs: Sequence[tuple[int, int]], order: Sequence[int], interval: int) -> list[int]:
    slots = Reservations(interval, len(arcs))
    found = [0] * len(arcs)
    for index in order:
        unit = slots.unit_for(*arcs[index])
        assert unit is not None
        slots.take(unit, *arcs[index])
        found[index] = unit
    return found


class _Colouring:
    """A search in depth for units of arcs in an order, each on a unit used before or on the next one."""

    def __init__(self, arcs: Sequence[tuple[int, int]], order: Sequence[int], interval: int) -> None:
        self._arcs, self._order, self._interval = arcs, order, interval

    def within(self, units: int) -> list[int] | None:
        """Return a colouring with so many units, None if none was found."""
        slots = Reservations(self._interval, units)
        nodes = 0
        chosen: list[int] = []
        unit = 0
        while len(chosen) < len(self._order):
            arc = self._arcs[self._order[len(chosen)]]
            most = min(units, max(chosen, default=-1) + 2)
            while unit < most and not slots.is_free(unit, *arc):
                unit += 1
            nodes += 1
            if unit < most and nodes <= _MOST_NODES:
                slots.take(unit, *arc)
                chosen.append(unit)
                unit = 0
            elif not chosen or nodes > _MOST_NODES:
                return None
            else:
                unit = chosen.pop()
                slots.release(unit, *self._arcs[self._order[len(chosen)]])
                unit += 1
        found = [0] * len(chosen)
        for index, unit in zip(self._order, chosen, strict=True):
            found[index] = unit
        return found
