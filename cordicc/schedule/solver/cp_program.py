"""The joint problem of starts, units and FIFO words as a constraint program (CP-SAT).

The start of an operation is interval * k + slot.  A kind of c units does at most c operations a slot, a
cumulative constraint on the slots; the same constraint on the starts is redundant, but carries bounds
from the dependences.  Which unit of its kind an operation gets does not matter here, so units are
interchangeable by construction; of schedules that symmetries turn into one another one is kept.

Operations that keep their units for several cycles are arcs of slots.  On one unit arcs do not overlap; with
several it matters which one an operation gets, as arcs may need more units than lie over any slot, so each
operation is on one of them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.goals import Goal
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem
from cordicc.schedule.solver.symmetry import Exchange, exchanges

if TYPE_CHECKING:
    from ortools.sat.python import cp_model


_MOST_SLOTS = 20_000
"""Slots of all operations together up to which each has a literal where FIFO words count."""


@dataclass(frozen=True, slots=True)
class Space:
    """Where to search: windows of starts, latencies, units of each kind (least, most), earlier goals.

    `units` has the kinds that are counted; the network's other kinds have as many as they take.  `taken`:
    units of a kind that are not to be had, by slot, because operations outside the problem use them;
    `placed`: the slots and cycles of such operations, of kinds that keep their units for several cycles.
    """

    head: Sequence[int]
    tail: Sequence[int]
    latency: tuple[int, int]
    units: Mapping[str, tuple[int, int]]
    held: Sequence[tuple[Goal, int]] = ()
    taken: Mapping[str, Sequence[int]] = field(default_factory=dict)
    placed: Mapping[str, Sequence[tuple[int, int]]] = field(default_factory=dict)

    def first(self, index: int) -> int:
        """Return the earliest start of an operation."""
        return self.head[index]

    def last(self, index: int) -> int:
        """Return the latest start of an operation."""
        return self.latency[1] - self.tail[index]


class Program:
    """The constraint program of a problem in a space, as far as FIFO words do not matter.

    A lean one leaves out what costs more time to find than it saves in a small space.  `weight` is what a
    word of each value costs in the goals, `exchanges` the symmetries that are broken.
    """

    def __init__(
        self, problem: SchedulingProblem, net: Network, space: Space, goal: Goal, *, lean: bool = False
    ) -> None:
        from ortools.sat.python import cp_model

        self.problem, self.net, self.space = problem, net, space
        self.lean = lean
        self.index = {id: index for index, id in enumerate(net.ids)}
        self.members = dict(zip(net.kinds, net.members(), strict=True))
        self.model = model = cp_model.CpModel()
        first, last = space.latency
        self.latency: cp_model.IntVar = model.new_int_var(first, last, "latency")
        self.start: list[cp_model.IntVar] = [
            model.new_int_var(space.first(index), space.last(index), f"start {id}")
            for index, id in enumerate(net.ids)
        ]
        for index, start in enumerate(self.start):
            for taker in net.after[index]:
                model.add(self.start[taker] >= start + net.latency[index])
            if first < last:
                model.add(self.latency >= start + space.tail[index])
        goals = [goal, *(held for held, _ in space.held)]
        self.weight = {
            value.name: tuple(goal.word_weight(value.name) for goal in goals) for value in problem.values
        }
        self._slots: dict[int, cp_model.IntVar] = {}
        self.at: dict[int, list[cp_model.IntVar]] = {}
        if any(goal.words for goal in goals) and problem.measure == "entries":
            self._add_slots()
        self.units: dict[str, Any] = {}
        for kind, members in self.members.items():
            if kind in space.units:
                self._share(kind, members, *space.units[kind])
        self.exchanges: tuple[Exchange, ...] = ()
        if not lean:
            self._break_symmetry()

    def _share(self, kind: str, members: Sequence[int], fewest: int, most: int) -> None:
        """Keep the operations of a kind within its units, slot by slot."""
        model = self.model
        units = fewest if fewest == most else model.new_int_var(fewest, most, f"units {kind}")
        self.units[kind] = units
        if self._suffices(kind):
            return
        if max(self.net.busy[index] for index in members) > 1 or kind in self.space.placed:
            self._share_for_long(kind, members, units, most)
            return
        taken = self.space.taken.get(kind, [0] * self.net.interval)
        slots = [self._slot(index) for index in members]
        starts = [self.start[index] for index in members]
        if self.at:
            for place in range(self.net.interval):
                model.add(sum(self.at[index][place] for index in members) <= units - taken[place])
        else:
            at_most(model, slots, units, [(place, count) for place, count in enumerate(taken) if count])
        at_most(model, starts, units, [])

    def _share_for_long(self, kind: str, members: Sequence[int], units: Any, most: int) -> None:
        """Keep operations that take their units for several cycles on units of their own meanwhile."""
        model, interval = self.model, self.net.interval
        placed = self.space.placed.get(kind, ())
        arcs = [(self._slot(index), self.net.busy[index]) for index in members]
        arcs += [(model.new_constant(slot), busy) for slot, busy in placed]
        pieces: list[list[Any]] = [[] for _ in range(most)]
        for number, (slot, busy) in enumerate(arcs):
            # Units are alike: the first operation is on the first one, the next on one of two.
            on = [model.new_bool_var(f"{kind} {number} on {unit}") for unit in range(min(most, number + 1))]
            model.add_exactly_one(on)
            for unit, literal in enumerate(on):
                if not isinstance(units, int):
                    model.add(units > unit).only_enforce_if(literal)
                # An arc beyond the last slot goes on at the first: as seen one interval later.
                for turn in (0, interval):
                    piece = model.new_optional_fixed_size_interval_var(slot + turn, busy, literal, "")
                    pieces[unit].append(piece)
        for each in pieces:
            model.add_no_overlap(each)
        busy_for = self.net.busy
        spans = [model.new_fixed_size_interval_var(self.start[i], busy_for[i], "") for i in members]
        model.add_cumulative(spans, [1] * len(spans), units)
        for place in range(interval if self.at else 0):
            over: list[Any] = [
                self.at[i][(place - passed) % interval] for i in members for passed in range(busy_for[i])
            ]
            over += [(place - slot) % interval < busy for slot, busy in placed]
            model.add(sum(over) <= units)

    def _suffices(self, kind: str) -> bool:
        """Tell whether the operations of a kind have a unit each, whatever their slots."""
        fewest, _ = self.space.units[kind]
        outside = kind in self.space.taken or kind in self.space.placed
        return not outside and fewest >= len(self.members[kind])

    def _add_slots(self) -> None:
        """Add a literal for each slot of each operation, if they are not too many."""
        model, interval = self.model, self.net.interval
        if len(self.net.ids) * interval > _MOST_SLOTS:
            return
        no, yes = model.new_constant(0), model.new_constant(1)
        for index, id in enumerate(self.net.ids):
            first = self.space.first(index)
            if first == self.space.last(index):
                self.at[index] = [yes if place == first % interval else no for place in range(interval)]
                continue
            slot = self._slot(index)
            self.at[index] = [model.new_bool_var(f"{id} at {place}") for place in range(interval)]
            model.add_exactly_one(self.at[index])
            for place, literal in enumerate(self.at[index]):
                model.add(slot == place).only_enforce_if(literal)
                model.add(slot != place).only_enforce_if(~literal)

    def _slot(self, index: int) -> cp_model.IntVar:
        """Return the slot of an operation."""
        if index not in self._slots:
            interval, model = self.net.interval, self.model
            name = self.net.ids[index]
            first, last = self.space.first(index), self.space.last(index)
            slot = model.new_int_var(0, interval - 1, f"slot {name}")
            k = model.new_int_var(first // interval, last // interval, f"k {name}")
            model.add(self.start[index] == interval * k + slot)
            self._slots[index] = slot
        return self._slots[index]

    def is_free(self, index: int) -> bool:
        """Tell whether an operation has a unit to itself, whatever its slot."""
        kind = self.kind(index)
        return kind not in self.space.units or self._suffices(kind)

    def kind(self, index: int) -> str:
        """Return the kind of an operation."""
        return self.net.kinds[self.net.kind[index]]

    def most_units(self, kind: str) -> int | None:
        """Return the units that a kind may have, None if as many as it takes."""
        return self.space.units[kind][1] if kind in self.space.units else None

    def _break_symmetry(self) -> None:
        """Keep the least of the schedules that exchanges of operations turn into one another."""
        space = self.space
        self.exchanges = exchanges(
            self.problem,
            self.net,
            # Operations that have units to themselves need not be of one kind.
            lambda index: (
                None if self.is_free(index) else self.kind(index),
                space.head[index],
                space.tail[index],
            ),
            lambda value: self.weight[value.name],
        )
        for exchange in self.exchanges:
            self.model.add(self.start[exchange.first] <= self.start[exchange.image[exchange.first]])


def at_most(
    model: cp_model.CpModel, times: Sequence[Any], units: Any, taken: Sequence[tuple[int, int]]
) -> None:
    """Keep the operations of each cycle, or slot, within the units, some of which are taken by then."""
    if isinstance(units, int) and units == 1 and not taken:
        model.add_all_different(times)
        return
    pieces = [model.new_fixed_size_interval_var(time, 1, "") for time in times]
    pieces += [model.new_fixed_size_interval_var(place, 1, "") for place, _ in taken]
    model.add_cumulative(pieces, [1] * len(times) + [count for _, count in taken], units)
