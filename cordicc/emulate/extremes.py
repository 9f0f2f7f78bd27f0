"""A search for inputs with large errors: from the worst samples uphill."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Floats, Samples
from cordicc.emulate.climb import climb, climbing
from cordicc.emulate.histogram import Worst, angular
from cordicc.emulate.ports import Outputs
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.doubles import screen
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs

_FROM_EACH = 16
"""Climbers that start from each of the worst samples."""

_ROUNDS = 96
_OCTAVES = 33
"""The finest steps are below the last place of every word."""


def search(
    graph: Graph,
    is_angle: bool,
    output: str,
    ranges: Mapping[str, Interval],
    starts: Sequence[Worst],
    simulate: Callable[[Samples], Outputs],
) -> Worst | None:
    """Return the sample with the largest error of an output that a search finds, None if it finds none.

    The errors that guide it are in double precision; the one returned is in high precision.  The inputs
    must be independent.
    """
    if not starts:
        return None

    def heights(points: Samples, values: Samples, defined: NDArray[np.bool_]) -> Floats:
        outputs = simulate(points)
        error = angular(outputs[output] - values[output], is_angle)
        return np.where(defined & outputs["valid"] & np.isfinite(error), error, -np.inf)

    columns = {name: np.repeat([start.inputs[name] for start in starts], _FROM_EACH) for name in ranges}
    climbers = _FROM_EACH * len(starts)
    points, _ = climb(
        climbing(ranges, columns, climbers=climbers, rounds=_ROUNDS, octaves=_OCTAVES),
        lambda points: heights(points, *screen(graph, points)),
    )
    errors = heights(points, *reference_outputs(graph, points))
    top = int(errors.argmax())
    if not np.isfinite(errors[top]):
        return None
    return Worst(float(errors[top]), None, {name: float(column[top]) for name, column in points.items()})
