"""The joint problem of starts, units and FIFO words as a constraint program (CP-SAT).

The start of an operation is interval * k + slot.  A kind of c units does at most c operations a slot, a
cumulative constraint on the slots; the same constraint on the starts is redundant, but carries bounds
from the dependences.  Which unit of its kind an operation gets does not matter here, so units are
interchangeable by construction; of schedules that symmetries turn into one another one is kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cordicc.schedule.goals import Goal
from cordicc.schedule.network import Network
from cordicc.schedule.problem import SchedulingProblem
from cordicc.schedule.symmetry import exchanges, least
from cordicc.schedule.words import Words

if TYPE_CHECKING:
    from ortools.sat.python import cp_model


_MOST_SLOTS = 20_000
"""Slots of all operations together up to which each has a literal where FIFO words count."""


@dataclass(frozen=True, slots=True)
class Space:
    """Where to search: windows of starts, latencies, units of each kind (least, most), earlier goals.

    `units` has the kinds that are counted; the network's other kinds have as many as they take.
    """

    head: Sequence[int]
    tail: Sequence[int]
    latency: tuple[int, int]
    units: Mapping[str, tuple[int, int]]
    held: Sequence[tuple[Goal, int]] = ()

    def first(self, index: int) -> int:
        """Return the earliest start of an operation."""
        return self.head[index]

    def last(self, index: int) -> int:
        """Return the latest start of an operation."""
        return self.latency[1] - self.tail[index]


class Program:
    """The constraint program of a problem in a space, as far as FIFO words do not matter."""

    def __init__(self, problem: SchedulingProblem, net: Network, space: Space, goal: Goal) -> None:
        from ortools.sat.python import cp_model

        self.problem, self.net, self.space = problem, net, space
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
        self._weight = {
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
        self._words: Words | None = None
        self._break_symmetry()

    def _share(self, kind: str, members: Sequence[int], fewest: int, most: int) -> None:
        """Keep the operations of a kind within its units, slot by slot."""
        model = self.model
        units = fewest if fewest == most else model.new_int_var(fewest, most, f"units {kind}")
        self.units[kind] = units
        if fewest >= len(members):
            return
        slots = [self._slot(index) for index in members]
        starts = [self.start[index] for index in members]
        if self.at:
            for place in range(self.net.interval):
                model.add(sum(self.at[index][place] for index in members) <= units)
        elif most == 1:
            model.add_all_different(slots)
        if most == 1:
            model.add_all_different(starts)
            return
        for times in (starts,) if self.at else (slots, starts):
            pieces = [model.new_fixed_size_interval_var(time, 1, "") for time in times]
            model.add_cumulative(pieces, [1] * len(pieces), units)

    def _add_slots(self) -> None:
        """Add a literal for each slot of each operation, if they are not too many."""
        model, interval = self.model, self.net.interval
        if len(self.net.ids) * interval > _MOST_SLOTS:
            return
        for index, id in enumerate(self.net.ids):
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
        return kind not in self.space.units or self.space.units[kind][0] >= len(self.members[kind])

    def kind(self, index: int) -> str:
        """Return the kind of an operation."""
        return self.net.kinds[self.net.kind[index]]

    def most_units(self, kind: str) -> int | None:
        """Return the units that a kind may have, None if as many as it takes."""
        return self.space.units[kind][1] if kind in self.space.units else None

    def _break_symmetry(self) -> None:
        """Keep the least of the schedules that exchanges of operations turn into one another."""
        self._exchanges = exchanges(
            self.problem,
            self.net,
            # Operations that have units to themselves need not be of one kind.
            lambda index: None if self.is_free(index) else self.kind(index),
            lambda value: self._weight[value.name],
        )
        for exchange in self._exchanges:
            self.model.add(self.start[exchange.first] <= self.start[exchange.image[exchange.first]])

    def cost(self, goal: Goal) -> Any:
        """Return the expression of a goal."""
        terms = [weight * self.units[kind] for kind, weight in goal.units.items() if kind in self.units]
        terms.append(goal.latency * self.latency)
        if goal.words:
            if self._words is None:
                self._words = Words(self, self._weight)
            terms += [goal.word_weight(name) * count for name, count in self._words.count.items()]
        return sum(terms)

    def hint(self, start: Sequence[int]) -> None:
        """Start the search from a schedule, completed by what follows from it."""
        from ortools.sat.python import cp_model

        now = least(start if self._words is None else self._words.early(start), self._exchanges)
        latency = max(self.space.latency[0], self.net.makespan(now))
        fixed = self.model.clone()
        for variable, number in zip([*self.start, self.latency], [*now, latency], strict=True):
            fixed.add(variable == number)
        solver = cp_model.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.max_deterministic_time = 1.0
        if solver.solve(fixed) in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            for index, number in enumerate(solver.response_proto.solution):
                self.model.add_hint(self.model.get_int_var_from_proto_index(index), number)
            return
        for variable, number in zip([*self.start, self.latency], [*now, latency], strict=True):
            self.model.add_hint(variable, number)
