"""Samples where errors are amplified most: near the border of the domain, and near vectors without direction.

A stretched arm is at a border; where a wrist is straight the angles of its joints are those of no vector.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Bools, Floats, Samples
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.doubles import all_results, screen
from cordicc.ir.sampling import Workspace

_PAIRS = 48
"""Ways from a sample inside to one outside, on each of which the border is looked for."""

_HALVINGS = 50
_DISTANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""How far from there samples are taken, in shares of the input ranges."""

_STARTS = 3
"""Samples from which a vector of length 0 is looked for: those at which it is shortest."""

_STEPS = 20
_STRIDE = 1e-7
"""Of derivatives, in shares of the input ranges."""

_MOST = 2_000
"""Operations times vectors: of large problems only some vectors are looked at."""

_NOTHING = 1e-9
"""The length of a vector, beside what is usual for it, that counts as 0."""

Points = NDArray[np.float64]
"""Samples as shares of the input ranges, of shape (inputs, n)."""


def hard_samples(graph: Graph, workspace: Workspace, drawn: Samples) -> dict[str, Floats]:
    """Return samples of the domain at small distances from its border and from singular ones.

    The same samples come of the same arguments.  Where inputs depend on one another there are none, as what
    is between two samples need not be one.

    Args:
        graph: the equations.
        workspace: the ranges of the inputs.
        drawn: samples inside and outside, float64 of shape (n,) for each input.
    """
    if workspace.rows is not None or not drawn:
        return {name: np.empty(0) for name in drawn}
    box = _Box(graph, workspace)
    points = box.shares(drawn)
    defined = box.defined(points)
    found = [_near_border(box, points, defined)]
    found += [_near_zero(box, points[:, defined], vector) for vector in _vectors(graph)]
    together = np.concatenate(found, axis=1)
    return box.samples(together[:, box.defined(together)])


class _Box:
    """A graph over the box of its input ranges, each from 0 to 1."""

    def __init__(self, graph: Graph, workspace: Workspace) -> None:
        self.graph = graph
        self.names = list(workspace.ranges)
        self.low = np.array([lo for lo, _ in workspace.ranges.values()])[:, None]
        self.span = np.array([hi - lo for lo, hi in workspace.ranges.values()])[:, None]

    def shares(self, samples: Samples) -> Points:
        """Return samples as points; an input that has one value is at 0."""
        columns = np.array([samples[name] for name in self.names]) - self.low
        shares: Points = np.divide(columns, self.span, out=np.zeros_like(columns), where=self.span > 0)
        return shares

    def samples(self, points: Points) -> dict[str, Floats]:
        """Return points as samples."""
        columns = np.clip(self.low + points * self.span, self.low, self.low + self.span)
        return dict(zip(self.names, columns, strict=True))

    def defined(self, points: Points) -> Bools:
        """Return at which points the equations have a value, in double precision."""
        return screen(self.graph, self.samples(points))[1]

    def values(self, points: Points, values: Sequence[Value]) -> Points:
        """Return values of the graph at points, of shape (values, n)."""
        found = all_results(self.graph, self.samples(points))
        return np.array([found[value.node][value.result] for value in values])


def _near_border(box: _Box, points: Points, defined: Bools) -> Points:
    """Return points at small distances from the border, on ways from points inside to points outside."""
    inside, outside = np.flatnonzero(defined), np.flatnonzero(~defined)
    if not inside.size or not outside.size:
        return points[:, :0]
    generator = np.random.Generator(np.random.PCG64(3))
    start = points[:, generator.choice(inside, _PAIRS)]
    way = points[:, generator.choice(outside, _PAIRS)] - start
    # Shares of the way: the first one inside, the second one outside.
    low, high = np.zeros(_PAIRS), np.ones(_PAIRS)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        ok = box.defined(start + way * middle)
        low, high = np.where(ok, middle, low), np.where(ok, high, middle)
    return _on_the_way_back(start + way * low, start)


def _on_the_way_back(end: Points, start: Points) -> Points:
    """Return points at small distances from ends, towards where the ways to them start."""
    way = start - end
    length = np.max(np.abs(way), axis=0)
    steps = [(distance, length >= distance) for distance in _DISTANCES]
    return np.concatenate([(end + way * (d / np.fmax(length, d)))[:, far] for d, far in steps], axis=1)


def _vectors(graph: Graph) -> list[tuple[Value, Value]]:
    """Return the vectors whose angles equations take."""
    taken = [(n.op, n.operands) for n in graph.nodes if n.op == "atan2" or (n.op == "solve" and n.m == 1)]
    pairs = dict.fromkeys((operands[0], operands[1]) for _, operands in taken)
    varying = [pair for pair in pairs if any(graph.constant(value) is None for value in pair)]
    return varying[: _MOST // max(1, len(graph.nodes))]


def _near_zero(box: _Box, points: Points, vector: tuple[Value, Value]) -> Points:
    """Return points at small distances from ones at which a vector is 0, by Newton's method."""
    if not points.shape[1]:
        return points
    length = np.hypot(*box.values(points, vector))
    start = points[:, np.argsort(length, kind="stable")[:_STARTS]]
    here = start
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            here = np.clip(here + _step(box, here, vector), 0.0, 1.0)
        close = np.hypot(*box.values(here, vector)) <= _NOTHING * np.median(length)
    return _on_the_way_back(here[:, close], start[:, close])


def _step(box: _Box, points: Points, vector: tuple[Value, Value]) -> Points:
    """Return the shortest step after which a vector is 0, to first order; none where it has no value."""
    inputs, count = points.shape
    moved = [points, *(points + _STRIDE * np.eye(inputs)[:, [k]] for k in range(inputs))]
    values = box.values(np.concatenate(moved, axis=1), vector).reshape(2, inputs + 1, count)
    slopes = (values[:, 1:] - values[:, :1]) / _STRIDE
    steps = np.zeros_like(points)
    for at in range(count):
        if np.isfinite(values[:, :, at]).all():
            steps[:, at] = -np.linalg.pinv(slopes[:, :, at]) @ values[:, 0, at]
    return steps
