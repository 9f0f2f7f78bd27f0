"""Values that are nearly zero, such as how far results are from an equation.

They are evaluated in double precision where that tells them, in high precision where its rounding could show.
"""

from __future__ import annotations

import numpy as np

from cordicc.base.arrays import Bools, Floats, Samples
from cordicc.ir.effort import effort
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.doubles import value_of
from cordicc.ir.meaning.reference import reference_outputs

_WORK = 3_000_000
"""Products that evaluation in high precision may take as long as."""

_SHAKE = 2.0**-40
"""Relative size of the disturbances that show how far rounding moves a value."""

_ROUNDING = 2.0**-53
_TRIES = 2
_SAFETY = 8.0
"""How many times rounding may move a value as far as what tries of random disturbances show."""

_SHARE = 2.0**-20
"""The largest share of a value, or else of the largest, that its own rounding may have."""


def small_values(graph: Graph, inputs: Samples) -> dict[str, Floats]:
    """Return the outputs of a graph on samples, NaN where they have no value.

    They are right to a millionth of the largest.  Where rounding to double precision could be more, or a
    value is missing, samples are evaluated in high precision; of very many such samples the largest.

    Args:
        graph: operations with one result each.
        inputs: for each input of the graph a float64 array of shape (n,), taken as exact numbers.
    """
    count = len(next(iter(inputs.values()), np.zeros(1)))
    values = _evaluated(graph, inputs, count, None)
    if not count:
        return values
    generator = np.random.Generator(np.random.PCG64(5))
    moved = {name: np.zeros(count) for name in values}
    for _ in range(_TRIES):
        for name, shaken in _evaluated(graph, inputs, count, generator).items():
            with np.errstate(invalid="ignore", over="ignore"):
                moved[name] = np.fmax(moved[name], np.abs(shaken - values[name]))
    doubtful = np.zeros(count, dtype=bool)
    urgency = np.zeros(count)
    for name, value in values.items():
        own = _doubtful(np.abs(value), moved[name] * (_SAFETY * _ROUNDING / _SHAKE))
        doubtful |= own
        size = np.where(np.isfinite(value), np.abs(value), np.inf)
        urgency = np.maximum(urgency, np.where(own, size, 0.0))
    rows = np.flatnonzero(doubtful)
    most = max(1, _WORK // max(1, effort(graph)))
    rows = np.sort(rows[np.argsort(-urgency[rows], kind="stable")[:most]])
    if rows.size:
        precise, _ = reference_outputs(graph, {name: column[rows] for name, column in inputs.items()})
        for name, column in precise.items():
            values[name][rows] = column
    return values


def _doubtful(size: Floats, rounding: Floats) -> Bools:
    """Return which values may be off by too much for the largest of them, or are missing."""
    finite = np.isfinite(size)
    largest = float(np.max(size, where=finite, initial=0.0))
    known = rounding <= _SHARE * largest
    return np.asarray(~finite | ~known)


def _evaluated(
    graph: Graph, inputs: Samples, count: int, generator: np.random.Generator | None
) -> dict[str, Floats]:
    """Return the outputs in double precision; with a generator every result but the inputs is disturbed."""
    found: list[Floats] = []
    for node in graph.nodes:
        made = value_of(node, [found[v.node] for v in node.operands], inputs, count)
        if generator is not None and node.op != "input":
            with np.errstate(over="ignore"):
                made = made * (1 + _SHAKE * generator.uniform(-1, 1, count))
        found.append(made)
    return {name: found[v.node].copy() for name, v in graph.outputs.items()}
