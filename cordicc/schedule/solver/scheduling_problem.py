"""The scheduling problem and its solution, as data.

A sample enters every `interval` cycles.  A pipelined unit takes one operation a cycle, and so one
operation for each slot, a cycle modulo the interval.  An operation may keep its unit for more cycles.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import accumulate, pairwise
from typing import Any, Literal

OUT = "out"
"""Stands for the operation in a sink that is an output: `("out", "theta")`."""

Sink = tuple[str, str]
"""The id of an operation and the name of one of its operand ports; or `OUT` and an output."""


Measure = Literal["entries", "cycles"]
"""How FIFO words are counted, see `SchedulingProblem`."""


class CyclicError(ValueError):
    """Operations depend on one another; `ring` names them, the first one again at the end."""

    def __init__(self, ring: tuple[str, ...]) -> None:
        super().__init__(f"operations depend on one another: {' -> '.join(ring)}")
        self.ring = ring


class InfeasibleError(Exception):
    """No schedule keeps the limits; the problem itself is well formed."""


@dataclass(frozen=True, slots=True)
class Task:
    """An operation to be scheduled: its results are usable `latency` >= 0 cycles after its start.

    Its unit takes no other operation for `busy` >= 1 cycles from the start on.
    """

    id: str
    kind: str
    latency: int
    busy: int = 1


@dataclass(frozen=True, slots=True)
class TaskValue:
    """What travels on a wire: made by the operation `producer`, or by None for an input.

    An input is there at cycle 0.  `consumers` are the operand ports and outputs that take it.
    """

    name: str
    producer: str | None
    consumers: tuple[Sink, ...]

    def takers(self) -> tuple[str, ...]:
        """Return the operations that take the value, `OUT` among them, in order and once each."""
        return tuple(dict.fromkeys(operation for operation, _ in self.consumers))


@dataclass(frozen=True, slots=True)
class SchedulingProblem:
    """Operations and the values between them.  All outputs leave together.

    `limits` gives the units of a kind; a kind that it lacks has as many as it takes.  The measure of
    FIFO words is either entries, the sum of ceil(cycles / interval) over the segments between
    consecutive taps of each value's delay, or cycles, the sum of each value's longest wait.
    """

    operations: tuple[Task, ...]
    values: tuple[TaskValue, ...]
    interval: int = 1
    limits: Mapping[str, int] = field(default_factory=dict)
    measure: Measure = "entries"

    def check(self) -> None:
        """Raise ValueError if the problem is malformed, InfeasibleError if a kind has too few units.

        Malformed: an id repeats or is unknown, a number is out of range, or operations form a cycle.
        """
        if self.interval < 1:
            raise ValueError(f"the initiation interval is {self.interval}")
        tasks = {task.id: task for task in self.operations}
        _no_repeats("operation", (task.id for task in self.operations))
        _no_repeats("value", (value.name for value in self.values))
        _no_repeats("sink", (".".join(sink) for value in self.values for sink in value.consumers))
        if OUT in tasks:
            raise ValueError(f"operation id '{OUT}' is reserved for the outputs")
        for task in self.operations:
            if task.latency < 0:
                raise ValueError(f"operation '{task.id}' has latency {task.latency}")
            if task.busy < 1:
                raise ValueError(f"operation '{task.id}' keeps its unit for {task.busy} cycles")
        for value in self.values:
            if value.producer is not None and value.producer not in tasks:
                raise ValueError(f"value '{value.name}' comes from unknown operation '{value.producer}'")
            for taker in value.takers():
                if taker != OUT and taker not in tasks:
                    raise ValueError(f"value '{value.name}' goes to unknown operation '{taker}'")
        self.order()
        longest = max((task.busy for task in self.operations), default=1)
        if longest > self.interval:
            raise InfeasibleError(
                f"an operation keeps its unit for {longest} cycles, more than the interval {self.interval}"
            )
        for kind, count in self.counts().items():
            limit = self.limits.get(kind, count)
            if limit < 0:
                raise ValueError(f"kind '{kind}' is limited to {limit} units")
            if limit < self.fewest(kind):
                raise InfeasibleError(
                    f"{count} operations of kind '{kind}' need {self.fewest(kind)} units "
                    f"at interval {self.interval}, more than {limit}"
                )

    def counts(self) -> dict[str, int]:
        """Return the number of operations of each kind."""
        return dict(Counter(task.kind for task in self.operations))

    def fewest(self, kind: str) -> int:
        """Return a number of units that the operations of a kind need at least, whatever their starts.

        It is the least where all keep their units equally long.
        """
        return fewest_units([task.busy for task in self.operations if task.kind == kind], self.interval)

    def limited(self, limits: Mapping[str, int]) -> SchedulingProblem:
        """Return the problem with other limits."""
        return replace(self, limits=dict(limits))

    def edges(self) -> Iterator[tuple[str, str]]:
        """Yield (producer, taker) for every dependence between operations; pairs may repeat."""
        for value in self.values:
            if value.producer is not None:
                yield from ((value.producer, taker) for taker in value.takers() if taker != OUT)

    def order(self) -> tuple[Task, ...]:
        """Return the operations, each after those it depends on; CyclicError if they form a cycle."""
        tasks = {task.id: task for task in self.operations}
        takers: dict[str, list[str]] = {id: [] for id in tasks}
        waiting = dict.fromkeys(tasks, 0)
        for producer, taker in self.edges():
            takers[producer].append(taker)
            waiting[taker] += 1
        ready = [id for id, count in waiting.items() if count == 0]
        for id in ready:
            for taker in takers[id]:
                waiting[taker] -= 1
                if waiting[taker] == 0:
                    ready.append(taker)
        if len(ready) < len(tasks):
            raise CyclicError(self._ring())
        return tuple(tasks[id] for id in ready)

    def graph(self) -> Any:
        """Return the dependences as a `networkx.DiGraph`; `cycles` of an edge is its producer's latency."""
        import networkx

        graph = networkx.DiGraph()
        graph.add_nodes_from(task.id for task in self.operations)
        cycles = {task.id: task.latency for task in self.operations}
        graph.add_edges_from((p, t, {"cycles": cycles[p]}) for p, t in self.edges())
        return graph

    def _ring(self) -> tuple[str, ...]:
        """Return operations that depend on one another, the first one again at the end."""
        import networkx

        ring = [producer for producer, _ in networkx.find_cycle(self.graph())]
        return (*ring, ring[0])

    def earliest(self) -> Schedule:
        """Return the schedule that starts everything as early as possible (ASAP), whatever the units."""
        before: dict[str, list[str]] = {task.id: [] for task in self.operations}
        for producer, taker in self.edges():
            before[taker].append(producer)
        start: dict[str, int] = {}
        finish: dict[str, int] = {}
        for task in self.order():
            start[task.id] = max((finish[id] for id in before[task.id]), default=0)
            finish[task.id] = start[task.id] + task.latency
        latency = max(finish.values(), default=0)
        words = fifo_words(self, start, latency)
        ordered = {task.id: start[task.id] for task in self.operations}
        return Schedule(ordered, latency, words, {"latency": True, "fifo_words": False}, {"latency": latency})


@dataclass(frozen=True, slots=True)
class Schedule:
    """Start cycles; `latency` is the cycle in which all outputs leave.

    `figures`, `bounds` and `optimal` speak of goals by name, "latency" and "fifo_words" among them: what
    was achieved, what no schedule undercuts that is as good in the goals before, and whether the two
    meet, here and in all goals before.  `struck`: the emergency stop ended a search.
    """

    start: Mapping[str, int]
    latency: int
    fifo_words: int
    optimal: Mapping[str, bool]
    bounds: Mapping[str, int]
    figures: Mapping[str, int] = field(default_factory=dict)
    struck: bool = False


def waits(problem: SchedulingProblem, start: Mapping[str, int], latency: int) -> dict[Sink, int]:
    """Return for every sink the cycles between its value's ready time and its use."""
    finish = {task.id: start[task.id] + task.latency for task in problem.operations}
    found: dict[Sink, int] = {}
    for value in problem.values:
        ready = 0 if value.producer is None else finish[value.producer]
        for sink in value.consumers:
            found[sink] = (latency if sink[0] == OUT else start[sink[0]]) - ready
    return found


def taps(problem: SchedulingProblem, start: Mapping[str, int], latency: int) -> dict[str, list[int]]:
    """Return for every value that is taken the distinct waits of its consumers, ascending."""
    wait = waits(problem, start, latency)
    return {v.name: sorted({wait[sink] for sink in v.consumers}) for v in problem.values if v.consumers}


def value_words(problem: SchedulingProblem, cycles: list[int]) -> int:
    """Return the FIFO words of a value whose consumers wait so many cycles, ascending."""
    if problem.measure == "cycles":
        return cycles[-1]
    return sum(-(-(b - a) // problem.interval) for a, b in pairwise([0, *cycles]))


def fifo_words(problem: SchedulingProblem, start: Mapping[str, int], latency: int) -> int:
    """Return the FIFO words of a schedule, by the problem's measure."""
    return sum(value_words(problem, cycles) for cycles in taps(problem, start, latency).values())


def fewest_units(busy: Iterable[int], interval: int) -> int:
    """Return a number of units that operations need at least which keep them for so many cycles each.

    By their sum, and by how many of the shortest a unit can do in an interval.  No one is beyond it.
    """
    cycles = sorted(busy)
    total = list(accumulate(cycles))
    on_one = sum(each <= interval for each in total)
    return max(-(-total[-1] // interval), -(-len(cycles) // on_one)) if cycles else 0


def _no_repeats(what: str, ids: Iterable[str]) -> None:
    seen: set[str] = set()
    for id in ids:
        if id in seen:
            raise ValueError(f"{what} '{id}' occurs twice")
        seen.add(id)
