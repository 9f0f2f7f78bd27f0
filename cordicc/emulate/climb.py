"""Points where a function is large, found by random steps uphill: a lower bound of its supremum."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.intervals import Interval

Floats = NDArray[np.float64]
Points = dict[str, Floats]

_LARGEST_STEP = 0.5
"""Of the range of a coordinate."""


def climb(
    ranges: Mapping[str, Interval],
    start: Mapping[str, Floats],
    height: Callable[[Points], Floats],
    *,
    climbers: int,
    rounds: int,
    seed: int = 2,
    octaves: int = 24,
    towards_poles: bool = False,
) -> tuple[Points, Floats]:
    """Return the highest points found and their heights, both of shape (climbers,), fewer if there are fewer.

    Args:
        ranges: of the coordinates.
        start: points to start from, of which the highest are taken.
        height: of points; -inf where there is none.
        climbers: points that climb at the same time.
        rounds: steps, each of a size drawn anew, from half of a range down to 2^-`octaves` of that.
        seed: of the random steps.
        octaves: see `rounds`.
        towards_poles: for a function that may grow without bound, perhaps at an end of a range where it has
            no value: steps double with success and halve without, and are reflected at the ends.
    """
    random = np.random.Generator(np.random.PCG64(seed))
    heights = height(dict(start))
    best = np.argsort(-heights, kind="stable")[:climbers]
    points = {name: column[best] for name, column in start.items()}
    heights = heights[best]
    size = np.full(best.size, _LARGEST_STEP)
    for turn in range(rounds):
        if not towards_poles:
            size = _LARGEST_STEP * 2.0 ** (-octaves * random.random(best.size))
        # Every other step moves a single coordinate, so that the others keep what they have reached.
        alone = random.integers(0, len(points), best.size) if turn % 2 else None
        moved = {}
        for at, (name, column) in enumerate(points.items()):
            lo, hi = ranges[name].lo, ranges[name].hi
            step = random.uniform(-1, 1, best.size) * size * (hi - lo)
            there = column + (step if alone is None else np.where(alone == at, step, 0.0))
            if towards_poles:
                there = np.where(there > hi, 2 * hi - there, np.where(there < lo, 2 * lo - there, there))
            moved[name] = np.clip(there, lo, hi)
        reached = height(moved)
        higher = reached > heights
        size = np.where(higher, np.minimum(2 * size, _LARGEST_STEP), size / 2)
        heights = np.where(higher, reached, heights)
        points = {name: np.where(higher, moved[name], column) for name, column in points.items()}
    return points, heights
