"""FIFO words in the constraint program, with what the linear relaxation and bounds on starts do not see.

Of entries: literals say which operations take a value as it is made ("direct"), and how the taps of a
value follow one another.  Slots are passed along these literals, so that conflicts over units show as
clauses.  An operation that has a unit to itself starts as soon as it can where that never costs a word.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

from cordicc.schedule.solver.cp_program import Program
from cordicc.schedule.solver.cuts import MOST_OPERATIONS, Ways, longest_ways, path_cuts
from cordicc.schedule.solver.scheduling_problem import OUT, TaskValue

if TYPE_CHECKING:
    from ortools.sat.python import cp_model

_INPUT = -1
"""Stands for the producer of an input."""


class FifoWords:
    """The words of each value in a program, `count`, and what is known of them."""

    def __init__(self, program: Program) -> None:
        self._program, self._weight = program, program.weight
        self._problem, self._net, self._space = program.problem, program.net, program.space
        self._model, self._index = program.model, program.index
        latency = self._space.latency
        self._fixed = latency[0] if latency[0] == latency[1] else None
        self._held: dict[tuple[str, str], cp_model.IntVar] = {}
        self._direct: dict[tuple[int, str], cp_model.IntVar] = {}
        self._at = program.at
        self._ways: Ways | None = None
        self._early: dict[int, list[int]] = {}
        taken = [value for value in self._problem.values if value.consumers]
        if self._problem.measure == "cycles":
            self.count: dict[str, Any] = {value.name: self._longest_wait(value) for value in taken}
            return
        self.count = {value.name: self._entries(value) for value in taken}
        self._cut_paths()
        for value in taken:
            self._add_direct(value)
        self._exclude()
        self._start_early()

    def early(self, start: Sequence[int]) -> list[int]:
        """Return a schedule of at most the same words in which operations start early where they may."""
        now = list(start)
        for index in self._net.order:
            if index in self._early:
                now[index] = max((self._ready(producer, now) for producer in self._early[index]), default=0)
        return now

    def _ready(self, producer: int, start: Sequence[Any]) -> Any:
        """Return when the values of a producer are there."""
        return 0 if producer == _INPUT else start[producer] + self._net.latency[producer]

    def _producer(self, value: TaskValue) -> int:
        return _INPUT if value.producer is None else self._index[value.producer]

    def _time(self, taker: str) -> Any:
        return self._program.latency if taker == OUT else self._program.start[self._index[taker]]

    def _longest_wait(self, value: TaskValue) -> Any:
        ready = self._ready(self._producer(value), self._program.start)
        hold = self._model.new_int_var(0, self._space.latency[1], f"words {value.name}")
        for taker in value.takers():
            self._model.add(hold >= self._time(taker) - ready)
        return hold

    def _entries(self, value: TaskValue) -> Any:
        """Return the entries of a value; a wait of w cycles up to a tap takes w / interval at least."""
        model, interval = self._model, self._net.interval
        ready = self._ready(self._producer(value), self._program.start)
        most = self._space.latency[1] // interval + 1
        takers = value.takers()
        for taker in takers:
            held = model.new_int_var(0, most, f"held {value.name} {taker}")
            model.add(interval * held >= self._time(taker) - ready)
            self._held[value.name, taker] = held
        if len(takers) == 1:
            return self._held[value.name, takers[0]]
        segments = self._segments(value, ready, most)
        for taker in takers:
            model.add(sum(segments) >= self._held[value.name, taker])
        return sum(segments)

    def _segments(self, value: TaskValue, ready: Any, most: int) -> list[Any]:
        """Return the entries between each tap of a value and the tap before it.

        A tap follows the value's own ready time or any tap that is not later; of taps at one time the
        later ones by number follow the earlier.  The fewest entries are those after the nearest, so the
        sum is that of the segments, and that no tap need follow two keeps the program small.
        """
        model, interval = self._model, self._net.interval
        takers = value.takers()
        follows: dict[tuple[int, int], cp_model.IntVar] = {}
        segments = []
        for i, taker in enumerate(takers):
            segment = model.new_int_var(0, most, f"segment {value.name} {taker}")
            choices = []
            for j in range(-1, len(takers)):
                if j == i:
                    continue
                before = ready if j < 0 else self._time(takers[j])
                literal = model.new_bool_var("")
                if j >= 0:
                    apart = 1 if j > i else 0
                    model.add(self._time(taker) >= before + apart).only_enforce_if(literal)
                model.add(interval * segment >= self._time(taker) - before).only_enforce_if(literal)
                follows[j, i] = literal
                choices.append(literal)
            model.add_exactly_one(choices)
            segments.append(segment)
        for i, j in combinations(range(len(takers)), 2):
            model.add_at_most_one([follows[i, j], follows[j, i]])
        return segments

    def _cut_paths(self) -> None:
        """Add the cuts on entries that the longest ways give, if the latency is known."""
        if self._program.lean or self._fixed is None or len(self._net.ids) > MOST_OPERATIONS:
            return
        self._ways = longest_ways(self._net, self._space.head, self._space.tail, self._fixed)
        for taps, entries in path_cuts(self._problem, self._net, self._ways):
            self._model.add(sum(self._held[tap] for tap in taps) >= entries)

    def _add_direct(self, value: TaskValue) -> None:
        """Add the literals of a value's takers, and what follows from the units that they need.

        n takers of a kind with c units start in ceil(n / c) cycles at least, each of which but the first
        costs an entry.
        """
        model = self._model
        source = self._producer(value)
        takers = value.takers()
        for taker in takers:
            if (source, taker) not in self._direct:
                self._direct[source, taker] = self._direct_literal(source, taker)
            model.add(self._held[value.name, taker] >= 1).only_enforce_if(~self._direct[source, taker])
        fewest = self._fewest_cycles(value)
        if fewest > 1:
            first = model.new_bool_var("")
            model.add_bool_or([*(self._direct[source, taker] for taker in takers), ~first])
            model.add(self.count[value.name] >= fewest - first)

    def _fewest_cycles(self, value: TaskValue) -> int:
        """Return in how many different cycles the takers of a value start at least."""
        kind, most = self._program.kind, self._program.most_units
        count = Counter(kind(self._index[taker]) for taker in value.takers() if taker != OUT)
        return max((-(-n // (most(kind) or n)) for kind, n in count.items()), default=0)

    def _direct_literal(self, source: int, taker: str) -> cp_model.IntVar:
        """Return the literal that an operation starts, or the outputs leave, when a source is ready."""
        model, interval = self._model, self._net.interval
        literal: cp_model.IntVar = model.new_bool_var("")
        ready = self._ready(source, self._program.start)
        model.add(self._time(taker) == ready).only_enforce_if(literal)
        if not self._at or (taker == OUT and self._fixed is None):
            return literal
        cycles = 0 if source == _INPUT else self._net.latency[source]
        if taker == OUT:
            assert self._fixed is not None
            if source != _INPUT:
                model.add_implication(literal, self._at[source][(self._fixed - cycles) % interval])
            return literal
        there = self._at[self._index[taker]]
        if source == _INPUT:
            model.add_implication(literal, there[0])
            return literal
        for place, here in enumerate(self._at[source]):
            then = there[(place + cycles) % interval]
            model.add_bool_or([~literal, ~here, then])
            model.add_bool_or([~literal, here, ~then])
        return literal

    def _exclude(self) -> None:
        """Keep apart what cannot be direct together.

        Of a kind with c units at most c operations take a source as it leaves; and sources that are never
        ready in one cycle are not both direct to one taker.
        """
        together: dict[tuple[int, str], list[cp_model.IntVar]] = {}
        sources: dict[str, list[int]] = {}
        for (source, taker), literal in self._direct.items():
            sources.setdefault(taker, []).append(source)
            if taker != OUT:
                kind = self._program.kind(self._index[taker])
                together.setdefault((source, kind), []).append(literal)
        for (_, kind), literals in together.items():
            most = self._program.most_units(kind)
            if most is not None and len(literals) > most:
                self._model.add(sum(literals) <= most)
        for taker, several in sources.items():
            for a, b in combinations(several, 2):
                if self._never_together(a, b):
                    self._model.add_at_most_one([self._direct[a, taker], self._direct[b, taker]])

    def _never_together(self, a: int, b: int) -> bool:
        """Tell whether two sources cannot be ready in the same cycle, as far as is easily seen."""
        if self._ways is not None:
            cycles = [self._net.latency[source] if source != _INPUT else 0 for source in (a, b)]
            i, j = (source if source != _INPUT else len(self._net.ids) for source in (a, b))
            if self._ways[i, j] + cycles[1] > cycles[0] or self._ways[j, i] + cycles[0] > cycles[1]:
                return True
        if _INPUT in (a, b) or self._net.kind[a] != self._net.kind[b]:
            return False
        # Operations of one unit start, and if they take equally long end, in different slots.
        return (
            self._program.most_units(self._program.kind(a)) == 1
            and self._net.latency[a] == self._net.latency[b]
        )

    def _start_early(self) -> None:
        """Start operations that have a unit to themselves as soon as they can.

        Earlier by d cycles, until an operand is direct, the wait of its operands shrinks by d each, and
        those of its result grow by d up to the first tap.  Where nothing else takes the operands, the
        words saved on the one that is then direct are at least those added.
        """
        inputs: dict[str, list[TaskValue]] = {}
        results: dict[str, list[TaskValue]] = {}
        for value in self._problem.values:
            for taker in value.takers():
                inputs.setdefault(taker, []).append(value)
            if value.producer is not None and value.consumers:
                results.setdefault(value.producer, []).append(value)
        for index, id in enumerate(self._net.ids):
            taken, made = inputs.get(id, []), results.get(id, [])
            fixed = self._space.first(index) == self._space.last(index)
            if not taken or fixed or not self._program.is_free(index) or len(made) > 1:
                continue
            if all(len(value.takers()) == 1 and self._saves(value, made) for value in taken):
                self._early[index] = [self._producer(value) for value in taken]
                self._model.add_bool_or([self._direct[source, id] for source in self._early[index]])

    def _saves(self, operand: TaskValue, results: Sequence[TaskValue]) -> bool:
        """Tell whether a word of an operand costs as much as one of each result, in every goal."""
        mine = self._weight[operand.name]
        return all(
            mine[k] >= weight for value in results for k, weight in enumerate(self._weight[value.name])
        )
