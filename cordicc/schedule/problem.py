"""The scheduling problem and its solution, as data.

Initiation interval 1: every operation has a unit of its own and takes new operands every cycle, so
only dependences constrain the starts and only FIFOs cost.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter

OUT = "out"
"""Stands for the operation in a sink that is an output: `("out", "theta")`."""

Sink = tuple[str, str]
"""The id of an operation and the name of one of its operand ports; or `OUT` and an output."""


class InfeasibleError(Exception):
    """No schedule keeps the limits; the problem itself is well formed."""


@dataclass(frozen=True, slots=True)
class Task:
    """An operation to be scheduled: its results are usable `latency` >= 0 cycles after its start."""

    id: str
    kind: str
    latency: int


@dataclass(frozen=True, slots=True)
class Value:
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
    """Operations and the values between them.  All outputs leave together."""

    operations: tuple[Task, ...]
    values: tuple[Value, ...]

    def check(self) -> None:
        """Raise ValueError if an id repeats or is unknown, a latency is negative, or a cycle exists."""
        tasks = {task.id: task for task in self.operations}
        _no_repeats("operation", (task.id for task in self.operations))
        _no_repeats("value", (value.name for value in self.values))
        _no_repeats("sink", (".".join(sink) for value in self.values for sink in value.consumers))
        if OUT in tasks:
            raise ValueError(f"operation id '{OUT}' is reserved for the outputs")
        for task in self.operations:
            if task.latency < 0:
                raise ValueError(f"operation '{task.id}' has latency {task.latency}")
        for value in self.values:
            if value.producer is not None and value.producer not in tasks:
                raise ValueError(f"value '{value.name}' comes from unknown operation '{value.producer}'")
            for taker in value.takers():
                if taker != OUT and taker not in tasks:
                    raise ValueError(f"value '{value.name}' goes to unknown operation '{taker}'")
        self.order()

    def edges(self) -> Iterator[tuple[str, str]]:
        """Yield (producer, taker) for every dependence between operations; pairs may repeat."""
        for value in self.values:
            if value.producer is not None:
                yield from ((value.producer, taker) for taker in value.takers() if taker != OUT)

    def order(self) -> tuple[Task, ...]:
        """Return the operations, each after those it depends on; ValueError if they form a cycle."""
        tasks = {task.id: task for task in self.operations}
        sorter: TopologicalSorter[str] = TopologicalSorter(dict.fromkeys(tasks, ()))
        for producer, taker in self.edges():
            sorter.add(taker, producer)
        try:
            return tuple(tasks[id] for id in sorter.static_order())
        except CycleError as error:
            raise ValueError(f"operations depend on one another: {' -> '.join(error.args[1])}") from None

    def earliest(self) -> Schedule:
        """Return the schedule that starts everything as early as possible (ASAP)."""
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

    `optimal` and `bounds` speak of "latency" and "fifo_words", each with the goals before it held.
    """

    start: Mapping[str, int]
    latency: int
    fifo_words: int
    optimal: Mapping[str, bool]
    bounds: Mapping[str, int]


def waits(problem: SchedulingProblem, start: Mapping[str, int], latency: int) -> dict[Sink, int]:
    """Return for every sink the cycles between its value's ready time and its use."""
    finish = {task.id: start[task.id] + task.latency for task in problem.operations}
    found: dict[Sink, int] = {}
    for value in problem.values:
        ready = 0 if value.producer is None else finish[value.producer]
        for sink in value.consumers:
            found[sink] = (latency if sink[0] == OUT else start[sink[0]]) - ready
    return found


def fifo_words(problem: SchedulingProblem, start: Mapping[str, int], latency: int) -> int:
    """Return the FIFO words: for each value the longest wait of its consumers, summed."""
    wait = waits(problem, start, latency)
    return sum(max(wait[sink] for sink in value.consumers) for value in problem.values if value.consumers)


def _no_repeats(what: str, ids: Iterable[str]) -> None:
    seen: set[str] = set()
    for id in ids:
        if id in seen:
            raise ValueError(f"{what} '{id}' occurs twice")
        seen.add(id)
