"""Zeros of a value in the ranges of its inputs, looked for in double precision."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from cordicc.base.arrays import Bools, Floats, Samples
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.doubles import all_results

_MOST_MOVED = 8
"""Inputs of which each is moved alone."""

_EXACT, _CLOSE, _NEAR = 2.0**-40, 2.0**-30, 2.0**-20
"""Of the usual size: what counts as zero where an input is set, between two signs, and after a search."""

_HALVINGS = 60
_STEPS = 200
_LARGEST_STEP = 0.25


class Approaches(NamedTuple):
    """Ways to zeros: samples and, for each of them, a zero; both by input, arrays of shape (n,)."""

    starts: dict[str, Floats]
    zeros: dict[str, Floats]

    def points(self, shares: Floats, count: int) -> dict[str, Floats]:
        """Return the points at shares of the first `count` ways, from the zeros on."""
        with np.errstate(over="ignore", invalid="ignore"):  # of ranges as wide as all doubles
            return {
                name: (zero[:count] + shares[:, None] * (self.starts[name] - zero)[:count]).ravel()
                for name, zero in self.zeros.items()
            }


def approaches(
    graph: Graph,
    ranges: Mapping[str, tuple[float, float]],
    samples: Samples,
    count: int,
    work: int,
) -> Approaches | None:
    """Return ways from samples to zeros of the output "out" of a graph, None if no zero is found.

    Zeros are looked for where inputs are 0 or at an end of their range, one alone or all that the value
    depends on, the others as in the sample; between samples with different signs; and by a search.

    Args:
        graph: one output, "out".
        ranges: of all inputs.
        samples: a value for each input, of shape (n,).
        count: of ways at the most.
        work: operations on arrays that the search may take.
    """
    names = [node.name for node in graph.nodes if node.op == "input"]
    if not names:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        return _found(_Search(graph, names, ranges), samples, count, work // len(graph.nodes))


def _found(search: _Search, samples: Samples, count: int, steps: int) -> Approaches | None:
    """Return what a search finds, see `approaches`; `steps` are those of its last resort."""
    values = search.values(samples)
    usable = np.isfinite(values) & (values != 0)
    starts = {name: column[usable] for name, column in samples.items()}
    values = values[usable]
    if not values.size:
        return None
    size = float(np.median(np.abs(values)))
    found = [*search.set(starts, size, count), *search.between(starts, values, count)]
    found = found or [*search.descended(starts, size, count, steps)]
    if not found:
        return None
    # In turns, so that the first ways are some of every kind.
    turns = np.concatenate([np.arange(len(next(iter(way.starts.values())))) for way in found])
    order = np.argsort(turns, kind="stable")[:count]
    return Approaches(
        {name: np.concatenate([way.starts[name] for way in found])[order] for name in samples},
        {name: np.concatenate([way.zeros[name] for way in found])[order] for name in samples},
    )


class _Search:
    """Finds zeros of a graph that depends on some of the inputs."""

    def __init__(self, graph: Graph, names: list[str], ranges: Mapping[str, tuple[float, float]]) -> None:
        self._graph = graph
        self._names = names
        self._ranges = ranges

    def values(self, points: Samples) -> Floats:
        """Return the value at points."""
        out = self._graph.outputs["out"]
        results = all_results(self._graph, {name: points[name] for name in self._names})
        return results[out.node][out.result]

    def set(self, starts: Samples, size: float, count: int) -> Iterator[Approaches]:
        """Yield ways on which inputs change to 0 or to an end of their ranges."""
        alone = [[name] for name in self._names[:_MOST_MOVED]]
        together = [self._names] if len(self._names) > 1 else []
        starts = {name: column[:count] for name, column in starts.items()}
        for moved in (*alone, *together):
            for end in (None, 0, 1):
                goals = {name: 0.0 if end is None else self._ranges[name][end] for name in moved}
                if not all(self._ranges[n][0] <= goal <= self._ranges[n][1] for n, goal in goals.items()):
                    continue
                zeros = {
                    name: np.full_like(column, goals[name]) if name in goals else column
                    for name, column in starts.items()
                }
                good = np.abs(self.values(zeros)) <= _EXACT * size
                good &= np.logical_or.reduce([zeros[name] != starts[name] for name in moved])
                if good.any():
                    yield _chosen(starts, zeros, good)

    def between(self, starts: Samples, values: Floats, count: int) -> Iterator[Approaches]:
        """Yield ways to zeros on lines between samples with different signs."""
        above, below = np.flatnonzero(values > 0)[:count], np.flatnonzero(values < 0)[:count]
        ways = min(above.size, below.size)
        if not ways:
            return
        high = {name: column[above[:ways]] for name, column in starts.items()}
        low = {name: column[below[:ways]] for name, column in starts.items()}
        ends = np.maximum(values[above[:ways]], -values[below[:ways]])
        first = high
        for _ in range(_HALVINGS):
            middle = {name: (high[name] + low[name]) / 2 for name in high}
            up = self.values(middle) >= 0
            high = {name: np.where(up, middle[name], high[name]) for name in high}
            low = {name: np.where(up, low[name], middle[name]) for name in low}
        good = np.abs(self.values(high)) <= _CLOSE * ends  # else it jumps over 0
        if good.any():
            yield _chosen(first, high, good)

    def descended(self, starts: Samples, size: float, count: int, steps: int) -> Iterator[Approaches]:
        """Yield ways to points that a random search down the value's size ends at."""
        random = np.random.Generator(np.random.PCG64(5))
        first = {name: column[:count] for name, column in starts.items()}
        points, height = first, np.abs(self.values(first))
        step = np.full(height.size, _LARGEST_STEP)
        for _ in range(min(_STEPS, steps)):
            moved = dict(points)
            for name in self._names:
                lo, hi = self._ranges[name]
                moved[name] = points[name] + random.uniform(-1, 1, height.size) * step * (hi - lo)
                moved[name] = np.clip(moved[name], lo, hi)
            reached = np.abs(self.values(moved))
            lower = reached < height
            step = np.where(lower, np.minimum(2 * step, _LARGEST_STEP), step / 2**0.5)
            height = np.where(lower, reached, height)
            points = {name: np.where(lower, moved[name], column) for name, column in points.items()}
        good = height <= _NEAR * size
        if good.any():
            yield _chosen(first, points, good)


def _chosen(starts: Samples, zeros: Samples, good: Bools) -> Approaches:
    return Approaches(
        {name: column[good] for name, column in starts.items()},
        {name: column[good] for name, column in zeros.items()},
    )
