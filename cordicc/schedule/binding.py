"""Binding: which unit of its kind does an operation, so that multiplexers have the fewest inputs.

A port of a unit needs a multiplexer input for every distinct source that its operations take there: a
FIFO, an input, a constant, or a result of another unit.  Operations share a source on a port if they take
the same constant, or results of one unit directly; so the bindings of producers and takers go together.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from cordicc.plan.model import Operation
from cordicc.plan.netlist import Connection, Driver, Netlist, UnitResult
from cordicc.schedule.solver.reservations import coloured

_MOST_SWAPPED = 300
"""Operations up to which more is done than to place one after the other."""
_SWEEPS = 8
_SEED = 1

Binding = dict[str, int]
"""The number of the unit, among those of its kind, of each operation."""


@dataclass(frozen=True, slots=True)
class MadeBy:
    """A result taken as it leaves its unit, whichever does the operation; `position` among its results."""

    operation: str
    position: int


@dataclass(frozen=True, slots=True)
class Delayed:
    """The result of an operation, so many cycles after it left its unit: the tap of a delay line."""

    operation: str
    cycles: int


Taken = Driver | MadeBy | Delayed
"""What drives a port before it is known which units there are."""

Source = Driver | Delayed | tuple[str, int | str, int]
"""What drives a wire; of a result the kind and number of the unit that makes it, and its position."""


@dataclass(frozen=True, slots=True)
class Wiring:
    """What `bind` needs: the kind of each operation, its slots, and what drives each of its ports.

    An operation keeps its unit for `busy` slots from `slot` on, modulo the interval.
    """

    kind: Mapping[str, str]
    slot: Mapping[str, int]
    busy: Mapping[str, int]
    interval: int
    drivers: Mapping[str, tuple[Taken, ...]]

    def arc(self, id: str) -> tuple[int, int]:
        """Return the first slot of an operation and how many it has."""
        return self.slot[id], self.busy[id]

    def meet(self, one: str, other: str) -> bool:
        """Tell whether two operations of a kind need a unit at the same time."""
        (first, busy), (second, long) = self.arc(one), self.arc(other)
        return (second - first) % self.interval < busy or (first - second) % self.interval < long


def wiring(
    netlist: Netlist, operations: Sequence[Operation], kind: Mapping[str, str], busy: Mapping[str, int]
) -> Wiring:
    """Return the wiring of operations that have their starts; `kind` says which may share a unit."""

    def driver(connection: Connection) -> Driver | MadeBy:
        if connection.value is None or not isinstance(connection.driver, UnitResult):
            return connection.driver
        result = netlist.results[connection.value]
        return MadeBy(result.operation.id, result.position)

    drivers = {id: tuple(map(driver, ports)) for id, ports in netlist.operands.items()}
    slots = {o.id: o.start % netlist.interval for o in operations}
    return Wiring(kind, slots, busy, netlist.interval, drivers)


def bind(wires: Wiring, work: float) -> Binding:
    """Return a binding with no more units than the slots of each kind need, see `reservations.coloured`.

    `work` is the deterministic time of the exact search, 0 for none.
    """
    apart = _apart(wires)
    units: dict[str, int] = {}
    for id, unit in apart.items():
        units[wires.kind[id]] = max(units.get(wires.kind[id], 0), unit + 1)
    binding = _one_by_one(wires, units, apart)
    nothing_shared = sum(units.values()) == len(wires.kind)
    if nothing_shared or len(wires.kind) > _MOST_SWAPPED or all(count == 1 for count in units.values()):
        return binding
    swapped = _swapped(wires, units, binding)
    return _exact(wires, units, swapped, work) if work else swapped


def _apart(wires: Wiring) -> Binding:
    """Return a binding with few units, whatever the multiplexers."""
    of_kind: dict[str, list[str]] = {}
    for id, kind in wires.kind.items():
        of_kind.setdefault(kind, []).append(id)
    found: Binding = {}
    for ids in of_kind.values():
        if all(wires.busy[id] == 1 for id in ids):
            taken: Counter[int] = Counter()
            for id in ids:
                found[id] = taken[wires.slot[id]]
                taken[wires.slot[id]] += 1
        else:
            found |= zip(ids, coloured([wires.arc(id) for id in ids], wires.interval), strict=True)
    return {id: found[id] for id in wires.kind}


def _source(wires: Wiring, binding: Binding, driver: Taken) -> Source:
    if isinstance(driver, MadeBy):
        # A producer that is not placed yet counts as a unit of its own.
        unit = binding.get(driver.operation, driver.operation)
        return (wires.kind[driver.operation], unit, driver.position)
    return driver


def _ports(wires: Wiring, binding: Binding) -> dict[tuple[str, int, int], set[Source]]:
    """Return the sources of each port: by kind, unit and position."""
    found: dict[tuple[str, int, int], set[Source]] = {}
    for id, drivers in wires.drivers.items():
        for position, driver in enumerate(drivers):
            port = wires.kind[id], binding[id], position
            found.setdefault(port, set()).add(_source(wires, binding, driver))
    return found


def _cost(wires: Wiring, binding: Binding) -> int:
    """Return the sources of all ports, which are the multiplexer inputs plus a constant."""
    return sum(len(sources) for sources in _ports(wires, binding).values())


def _one_by_one(wires: Wiring, units: Mapping[str, int], apart: Binding) -> Binding:
    """Give each operation the free unit whose ports gain the fewest sources.

    Of a kind of which some operation keeps its unit for several slots, that may leave no unit for another:
    such ones stay where they are `apart`.
    """
    binding: Binding = {}
    lasting = {wires.kind[id] for id, busy in wires.busy.items() if busy > 1}
    taken: dict[tuple[str, int], set[int]] = {}
    opened: dict[str, int] = {}
    ports: dict[tuple[str, int, int], set[Source]] = {}
    for id, kind in wires.kind.items():
        sources = [_source(wires, binding, driver) for driver in wires.drivers[id]]
        busy, count = taken.setdefault((kind, wires.slot[id]), set()), opened.setdefault(kind, 0)
        # Units without an operation are alike: the first of them stands for all.
        free = [unit for unit in range(count) if unit not in busy] if len(busy) < count else []
        free += [count] if count < units[kind] else []

        def gain(unit: int, sources: Sequence[Source] = sources, kind: str = kind) -> tuple[int, int]:
            fresh = (s not in ports.get((kind, unit, p), set()) for p, s in enumerate(sources))
            return sum(fresh), unit

        unit = apart[id] if kind in lasting else min(free, key=gain)
        binding[id] = unit
        busy.add(unit)
        opened[kind] = max(count, unit + 1)
        for position, source in enumerate(sources):
            ports.setdefault((kind, unit, position), set()).add(source)
    return binding


def _exchanges(wires: Wiring, units: Mapping[str, int], now: Binding) -> Iterator[tuple[list[str], int, int]]:
    """Yield operations of a kind that may change two units for one another, whatever the others do.

    Those are the ones of a slot; where operations keep their units for several slots, those on either unit
    that overlap, one with another.  `now` may change between two of them.
    """
    members: dict[str, list[str]] = {}
    groups: dict[tuple[str, int], list[str]] = {}
    lasting = {wires.kind[id] for id, busy in wires.busy.items() if busy > 1}
    for id, kind in wires.kind.items():
        if units[kind] > 1:
            members.setdefault(kind, []).append(id)
            if kind not in lasting:
                groups.setdefault((kind, wires.slot[id]), []).append(id)
    for (kind, _), group in groups.items():
        for a, b in combinations(range(units[kind]), 2):
            yield group, a, b
    for kind in sorted(lasting.intersection(members)):
        for a, b in combinations(range(units[kind]), 2):
            left = [id for id in members[kind] if now[id] in (a, b)]
            while left:
                chain = [left.pop()]
                for id in chain:
                    chain += [other for other in left if wires.meet(id, other)]
                    left = [other for other in left if other not in chain]
                yield chain, a, b


def _swapped(wires: Wiring, units: Mapping[str, int], binding: Binding) -> Binding:
    """Exchange the units of two operations in one slot, or move one to a free unit, while that helps."""
    best = dict(binding)
    least = _cost(wires, best)
    for _ in range(_SWEEPS):
        before = least
        for group, a, b in _exchanges(wires, units, best):
            turned = {id: a + b - best[id] for id in group if best[id] in (a, b)}
            trial = best | turned
            if turned and (cost := _cost(wires, trial)) < least:
                best |= turned
                least = cost
        if least == before:
            break
    return best


def _exact(wires: Wiring, units: Mapping[str, int], seed: Binding, work: float) -> Binding:
    """Return the best binding that the constraint program finds from a seed, within fixed work."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    on: dict[tuple[str, int], Any] = {}
    slots: dict[tuple[str, int, int], list[Any]] = {}
    starts: dict[str, set[int]] = {}
    for id, kind in wires.kind.items():
        starts.setdefault(kind, set()).add(wires.slot[id])
    for id, kind in wires.kind.items():
        for unit in range(units[kind]):
            literal = model.new_bool_var("") if units[kind] > 1 else model.new_constant(1)
            on[id, unit] = literal
            if units[kind] > 1:
                model.add_hint(literal, seed[id] == unit)
            # Two that overlap do so where one of them starts.
            for slot in sorted(starts[kind]) if wires.busy[id] > 1 else (wires.slot[id],):
                if (slot - wires.slot[id]) % wires.interval < wires.busy[id]:
                    slots.setdefault((kind, unit, slot), []).append(literal)
        model.add_exactly_one(on[id, unit] for unit in range(units[kind]))
    for literals in slots.values():
        model.add_at_most_one(literals)
    for kind in units:
        for id in _first_full(wires, kind, units[kind]):
            # Units of a kind are interchangeable: the first full slot keeps the numbers of the seed.
            model.add(on[id, seed[id]] == 1)
    sources: dict[tuple[Any, ...], Any] = {}
    for id, drivers in wires.drivers.items():
        kind = wires.kind[id]
        for position, driver in enumerate(drivers):
            for unit in range(units[kind]):
                for source, given in _possible(wires, units, on, driver):
                    key = (kind, unit, position, source)
                    if key not in sources:
                        sources[key] = model.new_bool_var("")
                    model.add_bool_or([sources[key], ~on[id, unit], *(~literal for literal in given)])
    model.minimize(sum(sources.values()))
    solver = cp_model.CpSolver()
    solver.parameters.random_seed = _SEED
    solver.parameters.num_workers = 1
    solver.parameters.max_deterministic_time = work
    if solver.solve(model) not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        return seed
    found = {
        id: next(unit for unit in range(units[kind]) if solver.value(on[id, unit]))
        for id, kind in wires.kind.items()
    }
    return found if _cost(wires, found) < _cost(wires, seed) else seed


def _first_full(wires: Wiring, kind: str, count: int) -> list[str]:
    """Return the operations of the first slot in which all units of a kind are busy, if there is one."""
    members = [id for id, other in wires.kind.items() if other == kind]
    busy = {
        slot: [id for id in members if (slot - wires.slot[id]) % wires.interval < wires.busy[id]]
        for slot in {wires.slot[id] for id in members}
    }
    return next((ids for _, ids in sorted(busy.items()) if len(ids) == count), [])


def _possible(
    wires: Wiring, units: Mapping[str, int], on: Mapping[tuple[str, int], Any], driver: Taken
) -> list[tuple[Source, list[Any]]]:
    """Return the sources that a driver may be, each with the literals under which it is."""
    if not isinstance(driver, MadeBy):
        return [(driver, [])]
    kind = wires.kind[driver.operation]
    return [((kind, unit, driver.position), [on[driver.operation, unit]]) for unit in range(units[kind])]
