"""Tighter enclosures by subdivision.

Interval arithmetic takes operands for independent; where one variable reaches a value on several paths its
enclosure is too wide.  The variables of a *cut*, through which every path from the inputs passes, are
enclosed already; cutting their box into smaller ones and uniting the results removes the excess.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.ranges.forward import Enclosures, evaluated, refreshed

_LARGEST_CUT = 4
_CUTS = 4
_BOXES = 192
"""Variables of a cut, cuts to try for a value, boxes of one."""


@dataclass(frozen=True, slots=True)
class Tightness:
    """When an enclosure is tight: magnitudes up to `most`, and where `sign` is not 0, from `least` of it."""

    most: float
    sign: int = 0
    least: float = 0.0

    def excess(self, interval: Interval | None) -> float:
        """Return by what factor an enclosure misses the goal, at most 1 if it does not."""
        if interval is None:
            return 0.0
        over = interval.magnitude / self.most if self.most else interval.magnitude and math.inf
        if self.sign:
            end = interval.lo if self.sign > 0 else -interval.hi
            over = max(over, self.least / end if end > 0 else math.inf)
        return over


@dataclass(slots=True)
class Budget:
    """The operations that may still be evaluated."""

    left: int


def tightened(
    graph: Graph, enclosures: Enclosures, goals: Mapping[Value, Tightness], work: int
) -> Enclosures:
    """Return enclosures in which loose ones are tightened as far as worthwhile.

    Args:
        graph: any graph.
        enclosures: rigorous ones, from `value_ranges`.
        goals: by value, what is tight enough.
        work: the operations to evaluate at the most.
    """
    found = list(enclosures)
    budget = Budget(work)
    for value, goal in sorted(goals.items()):
        interval = found[value.node][value.result]
        if interval is None or goal.excess(interval) <= 1 or budget.left <= 0:
            continue
        better = _tightest(graph, found, value, goal, budget)
        if better is not None and better != interval:
            results = list(found[value.node])
            results[value.result] = interval.intersect(better)
            found[value.node] = tuple(results)
            refreshed(graph, graph.downstream(value.node), found)
    return found


def _tightest(
    graph: Graph, enclosures: Enclosures, value: Value, goal: Tightness, work: Budget
) -> Interval | None:
    best: Interval | None = None
    for variables, between in _cuts(graph, enclosures, value):
        box = tuple(i for v in variables if (i := enclosures[v.node][v.result]) is not None)
        interval = _subdivided(graph, between, variables, box, value, goal, work)
        if interval is not None:
            best = interval if best is None else best.intersect(interval)
            if goal.excess(best) <= 1:
                break
    return best


def _cuts(graph: Graph, enclosures: Enclosures, value: Value) -> list[tuple[list[Value], list[int]]]:
    """Return cuts of finite variables and what lies between, the smallest first, and of those the nearest.

    A cut grows backwards: its latest operation is replaced by that operation's operands.
    """
    cuts: list[tuple[list[Value], list[int]]] = []
    between = {value.node}
    front = set(graph.nodes[value.node].operands)
    while True:
        variables = sorted(v for v in front if graph.constant(v) is None)
        if len(between) > 1 and 0 < len(variables) <= _LARGEST_CUT and _finite(enclosures, variables):
            constants = [v.node for v in front if graph.constant(v) is not None]
            cuts.append((variables, sorted(between.union(constants))))
        latest = max((v.node for v in variables if graph.nodes[v.node].operands), default=None)
        if latest is None:
            return sorted(cuts, key=lambda cut: len(cut[0]))[:_CUTS]
        between.add(latest)
        front = {v for v in front if v.node != latest}.union(graph.nodes[latest].operands)


def _finite(enclosures: Enclosures, variables: Sequence[Value]) -> bool:
    intervals = [enclosures[v.node][v.result] for v in variables]
    return all(interval is not None and interval.finite for interval in intervals)


def _subdivided(
    graph: Graph,
    between: Sequence[int],
    variables: Sequence[Value],
    box: tuple[Interval, ...],
    value: Value,
    goal: Tightness,
    work: Budget,
) -> Interval | None:
    """Return the union of a value's enclosures over the parts of a box; the worst part is cut first.

    Every variable of the cut in turn, and of those the one that is widest for its box.
    """
    count = 0

    def part(pieces: tuple[Interval, ...]) -> tuple[float, int, tuple[Interval, ...], Interval | None]:
        nonlocal count
        count += 1
        work.left -= len(between)
        known: dict[Value, Interval | None] = dict(zip(variables, pieces, strict=True))
        interval = evaluated(graph, between, known, value)
        return (-goal.excess(interval), count, pieces, interval)

    heap = [part(box)]
    sizes = [interval.hi - interval.lo for interval in box]
    while -heap[0][0] > 1 and count < _BOXES and work.left > 0:
        _, _, pieces, _ = heapq.heappop(heap)
        widths = [(i.hi - i.lo) / size if size else 0.0 for i, size in zip(pieces, sizes, strict=True)]
        at = max(range(len(widths)), key=widths.__getitem__)
        chosen = pieces[at]
        middle = chosen.lo + (chosen.hi - chosen.lo) / 2
        for half in (Interval(chosen.lo, middle), Interval(middle, chosen.hi)):
            heapq.heappush(heap, part((*pieces[:at], half, *pieces[at + 1 :])))
    union: Interval | None = None
    for _, _, _, interval in heap:
        if interval is not None:
            union = interval if union is None else union.union(interval)
    return union
