"""Binding: which unit of its kind does an operation, so that multiplexers have the fewest inputs.

A port of a unit needs a multiplexer input for every distinct source that its operations take there: a
FIFO, an input, a constant, or a result of another unit.  Operations share a source on a port if they take
the same constant, or results of one unit directly; so the bindings of producers and takers go together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from cordicc.plan.model import Operation
from cordicc.plan.netlist import Connection, Driver, Netlist, UnitResult

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
    """What `bind` needs: the kind and the slot of each operation, and what drives each of its ports."""

    kind: Mapping[str, str]
    slot: Mapping[str, int]
    drivers: Mapping[str, tuple[Taken, ...]]


def wiring(netlist: Netlist, operations: Sequence[Operation], kind: Mapping[str, str]) -> Wiring:
    """Return the wiring of operations that have their starts; `kind` says which may share a unit."""

    def driver(connection: Connection) -> Driver | MadeBy:
        if connection.value is None or not isinstance(connection.driver, UnitResult):
            return connection.driver
        result = netlist.results[connection.value]
        return MadeBy(result.operation.id, result.position)

    drivers = {id: tuple(map(driver, ports)) for id, ports in netlist.operands.items()}
    return Wiring(kind, {o.id: o.start % netlist.interval for o in operations}, drivers)


def bind(wires: Wiring, work: float) -> Binding:
    """Return a binding with no more units than the fullest slot of each kind needs.

    `work` is the deterministic time of the exact search, 0 for none.
    """
    units = _unit_counts(wires)
    binding = _one_by_one(wires, units)
    nothing_shared = sum(units.values()) == len(wires.kind)
    if nothing_shared or len(wires.kind) > _MOST_SWAPPED or all(count == 1 for count in units.values()):
        return binding
    swapped = _swapped(wires, units, binding)
    return _exact(wires, units, swapped, work) if work else swapped


def _unit_counts(wires: Wiring) -> dict[str, int]:
    busy: dict[tuple[str, int], int] = {}
    units: dict[str, int] = {}
    for id, kind in wires.kind.items():
        place = kind, wires.slot[id]
        busy[place] = busy.get(place, 0) + 1
        units[kind] = max(units.get(kind, 0), busy[place])
    return units


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


def _one_by_one(wires: Wiring, units: Mapping[str, int]) -> Binding:
    """Give each operation the free unit whose ports gain the fewest sources."""
    binding: Binding = {}
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

        unit = min(free, key=gain)
        binding[id] = unit
        busy.add(unit)
        opened[kind] = max(count, unit + 1)
        for position, source in enumerate(sources):
            ports.setdefault((kind, unit, position), set()).add(source)
    return binding


def _swapped(wires: Wiring, units: Mapping[str, int], binding: Binding) -> Binding:
    """Exchange the units of two operations in one slot, or move one to a free unit, while that helps."""
    groups: dict[tuple[str, int], list[str]] = {}
    for id, kind in wires.kind.items():
        if units[kind] > 1:
            groups.setdefault((kind, wires.slot[id]), []).append(id)
    best = dict(binding)
    least = _cost(wires, best)
    for _ in range(_SWEEPS):
        before = least
        for (kind, _), group in groups.items():
            for a, b in combinations(range(units[kind]), 2):
                trial = dict(best)
                for id in group:
                    trial[id] = b if best[id] == a else a if best[id] == b else best[id]
                if trial != best and (cost := _cost(wires, trial)) < least:
                    best, least = trial, cost
        if least == before:
            break
    return best


def _exact(wires: Wiring, units: Mapping[str, int], seed: Binding, work: float) -> Binding:
    """Return the best binding that the constraint program finds from a seed, within fixed work."""
    from ortools.sat.python import cp_model

    model = cp_model.CpModel()
    on: dict[tuple[str, int], Any] = {}
    slots: dict[tuple[str, int, int], list[Any]] = {}
    for id, kind in wires.kind.items():
        for unit in range(units[kind]):
            literal = model.new_bool_var("") if units[kind] > 1 else model.new_constant(1)
            on[id, unit] = literal
            if units[kind] > 1:
                model.add_hint(literal, seed[id] == unit)
            slots.setdefault((kind, unit, wires.slot[id]), []).append(literal)
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
    """Return the operations of the first slot in which all units of a kind are busy."""
    busy: dict[int, list[str]] = {}
    for id, other in wires.kind.items():
        if other == kind:
            busy.setdefault(wires.slot[id], []).append(id)
    return next(ids for _, ids in sorted(busy.items()) if len(ids) == count)


def _possible(
    wires: Wiring, units: Mapping[str, int], on: Mapping[tuple[str, int], Any], driver: Taken
) -> list[tuple[Source, list[Any]]]:
    """Return the sources that a driver may be, each with the literals under which it is."""
    if not isinstance(driver, MadeBy):
        return [(driver, [])]
    kind = wires.kind[driver.operation]
    return [((kind, unit, driver.position), [on[driver.operation, unit]]) for unit in range(units[kind])]
