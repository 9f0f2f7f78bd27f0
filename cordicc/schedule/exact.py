"""The exact solver: the joint problem of starts, units and FIFO words as a constraint program (CP-SAT).

The start of an operation is interval * k + slot.  A kind of c units does at most c operations a slot, a
cumulative constraint on the slots; the same constraint on the starts is redundant, but carries bounds
from the dependences.  Which unit of its kind an operation gets does not matter here, so units are
interchangeable by construction; operations with the same kind, operands and takers start in order.

The search is deterministic: one configuration, one seed, limits in deterministic time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import TYPE_CHECKING, Any

from cordicc.schedule.cuts import MOST_OPERATIONS, longest_ways, path_cuts
from cordicc.schedule.goals import Goal
from cordicc.schedule.network import Network
from cordicc.schedule.problem import OUT, SchedulingProblem, Value

if TYPE_CHECKING:
    from ortools.sat.python import cp_model

_SEED = 1
_SEARCHES = ("core", "max_lp", "default_lp")
"""Of the solver's strategies those that prove most here; one more worker improves the best schedule."""
_BRIEF = 1.0
"""Deterministic time up to which several strategies would only prepare to search."""


@dataclass(frozen=True, slots=True)
class Work:
    """Limits of a search: deterministic time, and seconds as the emergency stop."""

    deterministic: float
    seconds: float | None = None


@dataclass(frozen=True, slots=True)
class Answer:
    """The best starts found, None if there are none; `bound` of the goal; whether the clock struck."""

    start: tuple[int, ...] | None
    latency: int
    bound: int
    proven: bool
    infeasible: bool
    struck: bool


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


def minimise(
    problem: SchedulingProblem,
    net: Network,
    goal: Goal,
    space: Space,
    work: Work,
    hint: Sequence[int] | None = None,
    floor: int = 0,
) -> Answer:
    """Return starts that minimise a goal within a space; `floor` is a known lower bound of it."""
    from ortools.sat.python import cp_model

    program = _Program(problem, net, space)
    cost = program.cost(goal)
    program.model.add(cost >= floor)
    for earlier, figure in space.held:
        program.model.add(program.cost(earlier) <= figure)
    program.model.minimize(cost)
    if hint is not None:
        program.hint(hint)
    solver = cp_model.CpSolver()
    solver.parameters.random_seed = _SEED
    searches = _SEARCHES if work.deterministic > _BRIEF else ()
    solver.parameters.num_workers = len(searches) + 1
    solver.parameters.subsolvers.extend(searches)
    solver.parameters.interleave_search = True
    solver.parameters.max_deterministic_time = work.deterministic
    if work.seconds is not None:
        solver.parameters.max_time_in_seconds = work.seconds
    status = solver.solve(program.model)
    found = status in (cp_model.OPTIMAL, cp_model.FEASIBLE)
    proven = status in (cp_model.OPTIMAL, cp_model.INFEASIBLE)
    assert status != cp_model.MODEL_INVALID, program.model.validate()
    return Answer(
        start=tuple(solver.value(s) for s in program.start) if found else None,
        latency=solver.value(program.latency) if found else 0,
        bound=max(floor, -int(-solver.best_objective_bound // 1)) if status != cp_model.INFEASIBLE else floor,
        proven=proven,
        infeasible=status == cp_model.INFEASIBLE,
        struck=not proven and work.seconds is not None and solver.wall_time >= work.seconds,
    )


class _Program:
    """The constraint program of a problem in a space."""

    def __init__(self, problem: SchedulingProblem, net: Network, space: Space) -> None:
        from ortools.sat.python import cp_model

        self._problem, self._net, self._space = problem, net, space
        self._index = {id: index for index, id in enumerate(net.ids)}
        self.model = model = cp_model.CpModel()
        least, most = space.latency
        self.latency: cp_model.IntVar = model.new_int_var(least, most, "latency")
        self.start: list[cp_model.IntVar] = [
            model.new_int_var(h, most - t, f"start {id}")
            for id, h, t in zip(net.ids, space.head, space.tail, strict=True)
        ]
        for index, start in enumerate(self.start):
            for taker in net.after[index]:
                model.add(self.start[taker] >= start + net.latency[index])
            if least < most:
                model.add(self.latency >= start + space.tail[index])
        self.units: dict[str, Any] = {}
        self._slots: dict[int, cp_model.IntVar] = {}
        for kind, members in zip(net.kinds, net.members(), strict=True):
            if kind in space.units:
                self._share(kind, members, *space.units[kind])
        known = least == most and len(net.ids) <= MOST_OPERATIONS
        self._ways = longest_ways(net, space.head, space.tail, most) if known else None
        self._break_symmetry()
        self._words: dict[str, Any] | None = None
        self._held: dict[tuple[str, str], Any] = {}

    def _share(self, kind: str, members: Sequence[int], least: int, most: int) -> None:
        """Keep the operations of a kind within its units, slot by slot."""
        model, interval = self.model, self._net.interval
        units = least if least == most else model.new_int_var(least, most, f"units {kind}")
        self.units[kind] = units
        if least >= len(members):
            return
        slots = []
        for index in members:
            first, last = self._space.head[index], self._space.latency[1] - self._space.tail[index]
            name = self._net.ids[index]
            slot = model.new_int_var(0, interval - 1, f"slot {name}")
            k = model.new_int_var(first // interval, last // interval, f"k {name}")
            model.add(self.start[index] == interval * k + slot)
            slots.append(slot)
            self._slots[index] = slot
        if interval == 1:
            model.add(units >= len(members))
        elif most == 1:
            model.add_all_different(slots)
            model.add_all_different([self.start[index] for index in members])
        for times in (slots, [self.start[index] for index in members]) if most > 1 else ():
            pieces = [model.new_fixed_size_interval_var(time, 1, "") for time in times]
            model.add_cumulative(pieces, [1] * len(pieces), units)

    def _break_symmetry(self) -> None:
        twins: dict[tuple[Any, ...], list[int]] = {}
        seen: dict[int, list[tuple[str, tuple[str, ...]]]] = {}
        inputs: dict[int, list[str]] = {}
        for value in self._problem.values:
            if value.producer is not None:
                seen.setdefault(self._index[value.producer], []).append(("", value.takers()))
            for taker in value.takers():
                if taker != OUT:
                    inputs.setdefault(self._index[taker], []).append(value.name)
        for index in range(len(self.start)):
            key = (
                self._net.kind[index], self._net.latency[index],
                tuple(sorted(inputs.get(index, []))), tuple(sorted(seen.get(index, []))),
            )  # fmt: skip
            twins.setdefault(key, []).append(index)
        for group in twins.values():
            for a, b in pairwise(group):
                self.model.add(self.start[a] <= self.start[b])

    def cost(self, goal: Goal) -> Any:
        """Return the expression of a goal."""
        terms = [weight * self.units[kind] for kind, weight in goal.units.items() if kind in self.units]
        terms.append(goal.latency * self.latency)
        if goal.words:
            words = self._all_words()
            terms += [goal.word_weight(name) * count for name, count in words.items()]
        return sum(terms)

    def _all_words(self) -> dict[str, Any]:
        if self._words is None:
            self._words = {v.name: self._value_words(v) for v in self._problem.values if v.consumers}
            if self._problem.measure == "entries":
                self._cut()
                self._count_direct()
        return self._words

    def _value_words(self, value: Value) -> Any:
        ready: Any = 0
        if value.producer is not None:
            producer = self._index[value.producer]
            ready = self.start[producer] + self._net.latency[producer]
        takers = value.takers()
        times = [self.latency if id == OUT else self.start[self._index[id]] for id in takers]
        if self._problem.measure == "cycles":
            hold = self.model.new_int_var(0, self._space.latency[1], "")
            for time in times:
                self.model.add(hold >= time - ready)
            return hold
        interval = self._net.interval
        most = self._space.latency[1] // interval + 1
        for taker, time in zip(takers, times, strict=True):
            held = self.model.new_int_var(0, most, f"held {value.name} {taker}")
            self.model.add(interval * held >= time - ready)
            self._held[value.name, taker] = held
        if len(times) == 1:
            return self._held[value.name, takers[0]]
        return self._chain(value.name, ready, dict(zip(takers, times, strict=True)))

    def _chain(self, name: str, ready: Any, times: Mapping[str, Any]) -> Any:
        """Return the entries of all segments between the taps of a value, in the order of their times.

        Each tap has one tap before it, or none: a path through all taps, along which times ascend.
        """
        model, interval = self.model, self._net.interval
        most = self._space.latency[1] // interval + 1
        arcs = []
        entries = []
        for i, time in enumerate(times.values(), 1):
            arcs.append((i, 0, model.new_bool_var("")))
            segment = model.new_int_var(0, most, "")
            for j, before in enumerate([ready, *times.values()]):
                if i == j:
                    continue
                follows = model.new_bool_var("")
                arcs.append((j, i, follows))
                model.add(time >= before).only_enforce_if(follows)
                model.add(interval * segment >= time - before).only_enforce_if(follows)
            entries.append(segment)
        model.add_circuit(arcs)
        total = model.new_int_var(0, most * len(times), f"words {name}")
        model.add(total == sum(entries))
        for taker in times:
            model.add(total >= self._held[name, taker])
        return total

    def _cut(self) -> None:
        """Add the cuts on entries that the longest ways give."""
        if self._ways is not None:
            for taps, entries in path_cuts(self._problem, self._net, self._ways):
                self.model.add(sum(self._held[tap] for tap in taps) >= entries)

    def _count_direct(self) -> None:
        """Add what follows from the units that takers without a wait need.

        Of a kind with c units at most c operations take a source as it leaves, and n takers of a value
        start in ceil(n / c) cycles at least, each of which but the first costs an entry.
        """
        assert self._words is not None
        found: dict[tuple[int, str], cp_model.IntVar] = {}
        for value in self._problem.values:
            source = -1 if value.producer is None else self._index[value.producer]
            for taker in value.takers():
                if (source, taker) not in found:
                    found[source, taker] = self._direct(source, taker)
                self.model.add(self._held[value.name, taker] >= 1).only_enforce_if(~found[source, taker])
            fewest = self._fewest_cycles(value)
            if fewest > 1:
                first = self.model.new_bool_var("")
                self.model.add_bool_or([*(found[source, taker] for taker in value.takers()), ~first])
                self.model.add(self._words[value.name] >= fewest - first)
        together: dict[tuple[int, str], list[cp_model.IntVar]] = {}
        sources: dict[str, list[int]] = {}
        for (source, taker), literal in found.items():
            sources.setdefault(taker, []).append(source)
            if taker != OUT:
                together.setdefault((source, self._kind(self._index[taker])), []).append(literal)
        for (_, kind), literals in together.items():
            if (most := self._most_units(kind)) is not None and len(literals) > most:
                self.model.add(sum(literals) <= most)
        for taker, several in sources.items():
            for a, b in combinations(several, 2):
                if self._never_together(a, b):
                    self.model.add_at_most_one([found[a, taker], found[b, taker]])

    def _never_together(self, a: int, b: int) -> bool:
        """Tell whether two sources cannot be ready in the same cycle, as far as is easily seen."""
        if self._ways is not None:
            cycles = [self._net.latency[source] if source >= 0 else 0 for source in (a, b)]
            i, j = (source if source >= 0 else len(self.start) for source in (a, b))
            if self._ways[i, j] + cycles[1] > cycles[0] or self._ways[j, i] + cycles[0] > cycles[1]:
                return True
        if min(a, b) < 0 or self._net.kind[a] != self._net.kind[b]:
            return False
        # Operations of one unit start, and if they take equally long end, in different slots.
        return self._most_units(self._kind(a)) == 1 and self._net.latency[a] == self._net.latency[b]

    def _direct(self, source: int, taker: str) -> cp_model.IntVar:
        """Return the literal that an operation starts, or the outputs leave, when a source is ready."""
        literal: cp_model.IntVar = self.model.new_bool_var("")
        ready = self.start[source] + self._net.latency[source] if source >= 0 else 0
        time = self.latency if taker == OUT else self.start[self._index[taker]]
        self.model.add(time == ready).only_enforce_if(literal)
        return literal

    def _fewest_cycles(self, value: Value) -> int:
        """Return in how many different cycles the takers of a value start at least."""
        count = Counter(self._kind(self._index[taker]) for taker in value.takers() if taker != OUT)
        return max((-(-n // (self._most_units(kind) or n)) for kind, n in count.items()), default=0)

    def _kind(self, index: int) -> str:
        return self._net.kinds[self._net.kind[index]]

    def _most_units(self, kind: str) -> int | None:
        """Return the units that a kind may have, None if as many as it takes."""
        return self._space.units[kind][1] if kind in self._space.units else None

    def hint(self, start: Sequence[int]) -> None:
        """Start the search from a schedule."""
        net = self._net
        latency = max(self._space.latency[0], net.makespan(start))
        self.model.add_hint(self.latency, latency)
        for index, cycle in enumerate(start):
            self.model.add_hint(self.start[index], cycle)
            if index in self._slots:
                self.model.add_hint(self._slots[index], cycle % net.interval)
