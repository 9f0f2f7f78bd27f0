"""Valid inequalities on FIFO entries at a fixed latency, which the linear relaxation lacks.

Along a path of values from operation a to operation b, latencies and waits add up to start(b) -
start(a), which is at least the longest way from a to b, latency and windows included.  A value whose
wait is w holds at least w / interval entries, so the entries along the path number at least
ceil((longest way - latencies on the path) / interval) (Chvatal-Gomory rounding).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.scheduling_problem import OUT, SchedulingProblem

_MOST_VALUES = 4
"""Values on a path; longer ones were found to add more rows than they tighten."""
MOST_OPERATIONS = 300
"""Operations up to which the longest ways between all of them are worth their time."""

Tap = tuple[str, str]
"""A value and the operation, or `OUT`, that takes it."""


Ways = np.ndarray[tuple[int, ...], np.dtype[np.int64]]
"""Longest ways between starts, from the row's operation to the column's; the origin and the end are last."""


def path_cuts(problem: SchedulingProblem, net: Network, way: Ways) -> Iterator[tuple[tuple[Tap, ...], int]]:
    """Yield taps and the least sum of the entries that samples wait in up to these taps.

    Only what does not follow from the cuts of shorter paths.
    """
    count = len(net.ids)
    origin, end = count, count + 1
    index = {id: i for i, id in enumerate(net.ids)} | {OUT: end}
    leaving: list[list[tuple[int, int, Tap]]] = [[] for _ in range(count + 2)]
    for value in problem.values:
        source = origin if value.producer is None else index[value.producer]
        cycles = 0 if value.producer is None else net.latency[source]
        leaving[source] += [(index[taker], cycles, (value.name, taker)) for taker in value.takers()]

    def entries(cycles: int) -> int:
        return max(0, -(-cycles // problem.interval))

    for source in range(count + 1):
        stack: list[tuple[int, int, tuple[Tap, ...], int]] = [(source, 0, (), 0)]
        while stack:
            node, cycles, taps, implied = stack.pop()
            for taker, own, tap in leaving[node]:
                path = (*taps, tap)
                least = entries(int(way[source, taker]) - cycles - own)
                known = implied + (entries(int(way[node, taker]) - own) if taps else 0)
                if least > known:
                    yield path, least
                if len(path) < _MOST_VALUES and taker != end:
                    stack.append((taker, cycles + own, path, max(least, known)))


def longest_ways(net: Network, head: Sequence[int], tail: Sequence[int], latency: int) -> Ways:
    """Return the longest ways at a latency, between windows given by heads and tails (Floyd, Warshall)."""
    count = len(net.ids)
    origin, end = count, count + 1
    way = np.full((count + 2, count + 2), np.iinfo(np.int64).min // 4, dtype=np.int64)
    np.fill_diagonal(way, 0)
    way[origin, end], way[end, origin] = latency, -latency
    way[origin, :count] = head
    way[:count, end] = tail
    for index in range(count):
        way[index, list(net.after[index])] = net.latency[index]
    for via in range(count + 2):
        np.maximum(way, way[:, via : via + 1] + way[via : via + 1, :], out=way)
    return way
