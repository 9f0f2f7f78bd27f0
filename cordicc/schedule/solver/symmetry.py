"""Symmetries of a scheduling problem: exchanges of operations that change nothing.

An automorphism maps operations to operations and values to values and keeps kinds, latencies, cycles on a
unit, producers and takers; copies of a problem, and parts of one that are built alike, give rise to some.
They are found by colour refinement and individualisation (McKay and Piperno, "Practical graph isomorphism,
II", Journal of Symbolic Computation 60, 2014).

Of the schedules that they turn into one another one is enough: that whose starts, in the order of the
operations, are least.  If an automorphism leaves the operations before i alone and takes i to j, that one
has start(i) <= start(j); so all these inequalities hold together.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.scheduling_problem import OUT, SchedulingProblem, TaskValue

MOST_OPERATIONS = 600
"""Operations up to which symmetries are looked for."""
_MOST_REFINEMENTS = 400
"""Refinements in all, which bounds the time."""


@dataclass(frozen=True, slots=True)
class Exchange:
    """An automorphism: the image of each operation, and the first one that is not its own image."""

    image: tuple[int, ...]
    first: int


def exchanges(
    problem: SchedulingProblem,
    net: Network,
    kind: Callable[[int], Hashable],
    weight: Callable[[TaskValue], Hashable],
) -> tuple[Exchange, ...]:
    """Return automorphisms, by the first operation that they move.

    Args:
        problem: the operations and values.
        net: its network.
        kind: what tells operations of a latency apart, by index.
        weight: what tells values apart.
    """
    if len(net.ids) > MOST_OPERATIONS:
        return ()
    return tuple(_ImageSearch(problem, net, kind, weight).run())


def least(start: Sequence[int], found: Sequence[Exchange]) -> list[int]:
    """Return the schedule that keeps the order which the exchanges allow to ask for."""
    now = list(start)
    changed = True
    while changed:
        changed = False
        for exchange in found:
            if now[exchange.first] > now[exchange.image[exchange.first]]:
                now = [now[image] for image in exchange.image]
                changed = True
    return now


class _ImageSearch:
    """The graph of operations and values, in this order, and the work done."""

    def __init__(
        self,
        problem: SchedulingProblem,
        net: Network,
        kind: Callable[[int], Hashable],
        weight: Callable[[TaskValue], Hashable],
    ) -> None:
        self._count = len(net.ids)
        index = {id: i for i, id in enumerate(net.ids)}
        size = self._count + len(problem.values)
        self._before: list[list[int]] = [[] for _ in range(size)]
        self._after: list[list[int]] = [[] for _ in range(size)]
        labels: list[Hashable] = [
            ("operation", kind(i), net.latency[i], net.busy[i]) for i in range(self._count)
        ]
        for node, value in enumerate(problem.values, self._count):
            takers = value.takers()
            labels.append(("value", value.producer is None, OUT in takers, weight(value)))
            if value.producer is not None:
                self._join(index[value.producer], node)
            for taker in takers:
                if taker != OUT:
                    self._join(node, index[taker])
        names = {label: number for number, label in enumerate(dict.fromkeys(labels))}
        self._colours = [names[label] for label in labels]
        self._left = _MOST_REFINEMENTS

    def _join(self, a: int, b: int) -> None:
        self._after[a].append(b)
        self._before[b].append(a)

    def run(self) -> list[Exchange]:
        """Return exchanges of each operation with a later one, as far as the work goes."""
        found: list[Exchange] = []
        colours = self._refined(self._colours)
        for first in range(self._count):
            twins = [i for i in range(first + 1, self._count) if colours[i] == colours[first]]
            if not twins:
                continue
            here = self._refined(_marked(colours, first))
            for twin in twins:
                image = self._mapped(here, self._refined(_marked(colours, twin)))
                if image is not None:
                    found.append(Exchange(tuple(image[: self._count]), first))
                    break  # further ones would say little more: those of the image follow
            if self._left <= 0:
                break
            colours = here
        return found

    def _mapped(self, here: list[int], there: list[int]) -> list[int] | None:
        """Return an automorphism that maps colours to colours, leaving in place what it can."""
        while True:
            if self._left <= 0 or sorted(here) != sorted(there):
                return None
            cells: dict[int, list[int]] = {}
            for node, colour in enumerate(there):
                cells.setdefault(colour, []).append(node)
            several = next((node for node, colour in enumerate(here) if len(cells[colour]) > 1), None)
            if several is None:
                image = [cells[colour][0] for colour in here]
                return image if self._keeps_all(image) else None
            cell = cells[here[several]]
            # The first choice is kept: a wrong one costs an exchange, not correctness.
            target = several if several in cell else cell[0]
            here, there = self._refined(_marked(here, several)), self._refined(_marked(there, target))

    def _keeps_all(self, image: Sequence[int]) -> bool:
        return all(
            self._colours[node] == self._colours[other]
            and sorted([image[after] for after in self._after[node]]) == sorted(self._after[other])
            for node, other in enumerate(image)
        )

    def _refined(self, colours: Sequence[int]) -> list[int]:
        """Return the coarsest colouring within one in which equal colours have equal neighbours."""
        self._left -= 1
        now = list(colours)
        count = len(set(now))
        while True:
            signatures = [
                (
                    now[node],
                    tuple(sorted([now[other] for other in self._before[node]])),
                    tuple(sorted([now[other] for other in self._after[node]])),
                )
                for node in range(len(now))
            ]
            ranks = {signature: rank for rank, signature in enumerate(sorted(set(signatures)))}
            now = [ranks[signature] for signature in signatures]
            if len(ranks) == count:
                return now
            count = len(ranks)


def _marked(colours: Sequence[int], node: int) -> list[int]:
    """Return the colours with a new one for a node."""
    marked = list(colours)
    marked[node] = len(colours)
    return marked
