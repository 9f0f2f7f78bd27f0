"""Points on the way to where values of a graph are small: samples drawn at random do not come near.

The absolute error of a fixed-point word tells there, in a root most of all.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.doubles import all_results
from cordicc.ir.meaning.intervals import Interval

Points = Mapping[str, Floats]

_STARTS = 3
"""Points from which each value is followed downhill."""

_ROUNDS = 12
_SHARES = (1.0, 0.5, 0.25, 0.0625)
"""Of a Newton step: a root falls to 0 at the end of one, or at an edge of the domain in the middle."""

_STEPS = 10
_CLOSER = 0.25
"""Each step from a start to the smallest value found ends so much nearer to it than the one before."""

_DIFFERENCE = 2.0**-20
"""Of the range of an input, for slopes."""

_ROOTS = {"vector": 0, "lightcone": 0, "implicit": 1}
"""The results that are roots, 0 where other results are ill-conditioned."""


def roots_of(graph: Graph) -> list[Value]:
    """Return the results of a graph of unit operations that are square roots."""
    live = graph.live()
    return [
        Value(index, _ROOTS[node.op])
        for index, node in enumerate(graph.nodes)
        if index in live and node.op in _ROOTS and (node.op == "lightcone" or node.m != 0)
    ]


def towards_zero(
    graph: Graph, values: Sequence[Value], ranges: Mapping[str, Interval], start: Points
) -> dict[str, Floats]:
    """Return points on the way from some points to where each of some values is small, nearer and nearer.

    Args:
        graph: what the values are of.
        values: the values, one after the other.
        ranges: of the inputs, which must be independent.
        start: an array of shape (n,) for each input.
    """
    found: list[dict[str, Floats]] = [{name: np.zeros(0) for name in ranges}]
    for value in values:
        part = graph.leading_to(value)

        def size(points: Points, part: Graph = part) -> Floats:
            made = all_results(part, points)[part.outputs["out"].node][part.outputs["out"].result]
            return np.where(np.isfinite(made), np.abs(made), np.inf)

        sizes = size(start)
        nearest = np.argsort(sizes, kind="stable")[:_STARTS]
        begin = {name: np.asarray(start[name])[nearest] for name in ranges}
        end = _followed(size, ranges, begin)
        shares = _CLOSER ** np.arange(1, _STEPS + 1)[:, None]
        way = {n: (end[n] + shares * (begin[n] - end[n])).ravel() for n in ranges}
        held = np.isfinite(size(way))
        found.append({n: column[held] for n, column in way.items()})
    return {name: np.concatenate([each[name] for each in found]) for name in ranges}


def _followed(
    size: Callable[[Points], Floats], ranges: Mapping[str, Interval], begin: Points
) -> dict[str, Floats]:
    """Return where Newton steps with no worse end than begin lead from some points."""
    end, best = dict(begin), size(begin)
    for _ in range(_ROUNDS):
        slopes = {name: _slope(size, end, name, interval) for name, interval in ranges.items()}
        with np.errstate(all="ignore"):
            # In units of the ranges, so that the step is the shortest one.
            steepness = np.sum([np.square(slope) for slope in slopes.values()], axis=0)
            steps = {
                name: np.nan_to_num(_width(ranges[name]) * best * slope / steepness, posinf=0.0, neginf=0.0)
                for name, slope in slopes.items()
            }
        for share in _SHARES:
            there = {
                name: np.clip(end[name] - share * step, ranges[name].lo, ranges[name].hi)
                for name, step in steps.items()
            }
            reached = size(there)
            less = reached < best
            end = {name: np.where(less, there[name], column) for name, column in end.items()}
            best = np.where(less, reached, best)
    return end


def _slope(size: Callable[[Points], Floats], at: Points, name: str, interval: Interval) -> Floats:
    """Return the change of a size with an input, in units of the input's range; 0 where it has none."""
    step = _DIFFERENCE * _width(interval)
    less, more = (np.clip(at[name] + move, interval.lo, interval.hi) for move in (-step, step))
    with np.errstate(all="ignore"):
        slope = (size({**at, name: more}) - size({**at, name: less})) / (more - less) * _width(interval)
    return np.nan_to_num(slope, posinf=0.0, neginf=0.0)


def _width(interval: Interval) -> float:
    return interval.hi - interval.lo
