"""Samples near the border of the domain of equations, where errors are amplified most: a stretched arm, say."""

from __future__ import annotations

import numpy as np

from cordicc.base.arrays import Bools, Floats, Samples
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.doubles import screen
from cordicc.ir.sampling import Workspace

_PAIRS = 48
"""Ways from a sample inside to one outside, on each of which the border is looked for."""

_HALVINGS = 50
_DISTANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""How far from the border samples are taken, along the way, as shares of the input ranges."""


def border_samples(graph: Graph, workspace: Workspace, drawn: Samples) -> dict[str, Floats]:
    """Return samples of the domain at small distances from its border; none if it is not among those drawn.

    The same samples come of the same arguments.  Where inputs depend on one another there are none, as what
    is between two samples need not be one.

    Args:
        graph: the equations.
        workspace: the ranges of the inputs.
        drawn: samples inside and outside, float64 of shape (n,) for each input.
    """
    none = {name: np.empty(0) for name in drawn}
    if workspace.rows is not None or not drawn:
        return none
    defined = _defined(graph, drawn)
    inside, outside = np.flatnonzero(defined), np.flatnonzero(~defined)
    if not inside.size or not outside.size:
        return none
    names = list(drawn)
    columns = np.array([drawn[name] for name in names])
    generator = np.random.Generator(np.random.PCG64(3))
    start = columns[:, generator.choice(inside, _PAIRS)]
    end = columns[:, generator.choice(outside, _PAIRS)]
    spans = np.array([hi - lo for lo, hi in (workspace.ranges[name] for name in names)])[:, None]
    # Shares of the way: the first one inside, the second one outside.
    low, high = np.zeros(_PAIRS), np.ones(_PAIRS)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        ok = _defined(graph, dict(zip(names, start + (end - start) * middle, strict=True)))
        low, high = np.where(ok, middle, low), np.where(ok, high, middle)
    # The way in shares of the ranges, so that a distance means the same in all directions.
    with np.errstate(all="ignore"):
        steps = np.max(np.abs((end - start) / spans), axis=0, where=spans > 0, initial=0.0)
        shares = [low - distance / steps for distance in _DISTANCES]
    found = np.concatenate([start + (end - start) * share for share in shares], axis=1)
    kept = np.concatenate([share >= 0 for share in shares])
    points = {name: column[kept] for name, column in zip(names, found, strict=True)}
    kept = _defined(graph, points)
    return {name: column[kept] for name, column in points.items()}


def _defined(graph: Graph, samples: Samples) -> Bools:
    """Return which samples the equations have a value for, in double precision."""
    return screen(graph, samples)[1]
