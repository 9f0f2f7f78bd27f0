"""Points where a function is large, found by random steps: a lower bound of its supremum."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cordicc.arith.intervals import Interval
from cordicc.certify.boxes import Floats

Points = dict[str, Floats]


def climb(
    ranges: Mapping[str, Interval],
    start: Mapping[str, Floats],
    height: Callable[[Points], Floats],
    *,
    climbers: int,
    rounds: int,
    seed: int = 2,
) -> tuple[Points, Floats]:
    """Return the highest points found and their heights.

    Args:
        ranges: of the coordinates.
        start: points to start from, of which the highest are taken.
        height: of points; -inf where there is none.
        climbers: points that climb at the same time.
        rounds: steps, from half of a range down to 2^-24 of it.
        seed: of the random steps.
    """
    random = np.random.Generator(np.random.PCG64(seed))
    heights = height(dict(start))
    best = np.argsort(-heights, kind="stable")[:climbers]
    points = {name: column[best] for name, column in start.items()}
    heights = heights[best]
    for turn in range(rounds):
        size = 0.5 * 2.0 ** (-24 * random.random(best.size))
        # Every other step moves a single coordinate, so that the others keep what they have reached.
        alone = random.integers(0, len(points), best.size) if turn % 2 else None
        moved = {}
        for at, (name, column) in enumerate(points.items()):
            step = random.uniform(-1, 1, best.size) * size * (ranges[name].hi - ranges[name].lo)
            step = step if alone is None else np.where(alone == at, step, 0.0)
            moved[name] = np.clip(column + step, ranges[name].lo, ranges[name].hi)
        reached = height(moved)
        higher = reached > heights
        heights = np.where(higher, reached, heights)
        points = {name: np.where(higher, moved[name], column) for name, column in points.items()}
    return points, heights
