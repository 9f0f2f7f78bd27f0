"""A search for inputs with large errors: from the worst samples, uphill, in steps of every size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.emulate.histogram import angular
from cordicc.emulate.screening import screen
from cordicc.emulate.streaming import Outputs, Samples, Worst
from cordicc.ir.graph import Graph
from cordicc.ir.reference import evaluate

Floats = NDArray[np.float64]

_ROUNDS = 24
_MOVES = 64
_COARSEST, _FINEST = 2, 34
"""Steps are the range of an input times 2^-k; the finest are below the last place of every word."""


def climb(
    graph: Graph,
    is_angle: bool,
    output: str,
    ranges: Mapping[str, tuple[float, float]],
    starts: Sequence[Worst],
    simulate: Callable[[Samples], Outputs],
) -> Worst | None:
    """Return the sample with the largest error of an output that a search finds, None if it finds none.

    Each round tries `_MOVES` neighbours of every start at once, of which one input or all are moved by
    a random power of two of their range, and goes on from the best of each.  The errors that guide it are
    in double precision; the one returned is in high precision.  The inputs must be independent.
    """
    if not starts:
        return None
    names = list(ranges)
    lows, highs = (np.array([ranges[name][end] for name in names]) for end in (0, 1))
    best = np.array([[start.inputs[name] for name in names] for start in starts])
    best_error = _errors(graph, is_angle, output, names, best, simulate)
    generator = np.random.Generator(np.random.PCG64(0))
    for _ in range(_ROUNDS):
        shape = (len(best), _MOVES, len(names))
        steps = np.ldexp(highs - lows, -generator.integers(_COARSEST, _FINEST, shape).astype(np.int32))
        chosen = generator.integers(0, len(names) + 1, shape[:2])[:, :, None]
        moved = (chosen == np.arange(len(names))) | (chosen == len(names))
        signs = generator.integers(0, 2, shape) * 2 - 1
        tried = np.clip(best[:, None, :] + steps * signs * moved, lows, highs)
        errors = _errors(graph, is_angle, output, names, tried.reshape(-1, len(names)), simulate)
        errors = errors.reshape(shape[:2])
        top = errors.argmax(axis=1)
        rows = np.arange(len(best))
        better = errors[rows, top] > best_error
        best = np.where(better[:, None], tried[rows, top], best)
        best_error = np.where(better, errors[rows, top], best_error)
    return _confirmed(graph, is_angle, output, names, best, simulate)


def _errors(
    graph: Graph,
    is_angle: bool,
    output: str,
    names: list[str],
    points: Floats,
    simulate: Callable[[Samples], Outputs],
) -> Floats:
    """Return errors in double precision, -1 where a point is invalid in either."""
    inputs = {name: np.ascontiguousarray(points[:, at]) for at, name in enumerate(names)}
    values, defined = screen(graph, inputs)
    return _difference(values, defined, simulate(inputs), output, is_angle)


def _difference(
    values: Mapping[str, Floats],
    defined: NDArray[np.bool_],
    outputs: Mapping[str, NDArray[Any]],
    output: str,
    is_angle: bool,
) -> Floats:
    error = angular(outputs[output] - values[output], is_angle)
    return np.where(defined & outputs["valid"] & np.isfinite(error), error, -1.0)


def _confirmed(
    graph: Graph,
    is_angle: bool,
    output: str,
    names: list[str],
    points: Floats,
    simulate: Callable[[Samples], Outputs],
) -> Worst | None:
    """Return the point that is worst in high precision."""
    inputs = {name: np.ascontiguousarray(points[:, at]) for at, name in enumerate(names)}
    values, defined = evaluate(graph, inputs)
    errors = _difference(values, defined, simulate(inputs), output, is_angle)
    top = int(errors.argmax())
    if errors[top] < 0:
        return None
    return Worst(float(errors[top]), None, {name: float(column[top]) for name, column in inputs.items()})
