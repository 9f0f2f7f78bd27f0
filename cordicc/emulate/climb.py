"""Points where a function is large, found by random steps uphill: a lower bound of its supremum."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.meaning.intervals import Interval

Points = dict[str, Floats]

_LARGEST_STEP = 0.5
"""Of the range of a coordinate."""


Climb = Generator[Points, Floats, tuple[Points, Floats]]
"""A search: yields points, is sent their heights, returns the highest points and their heights."""


def climb(search: Climb, height: Callable[[Points], Floats]) -> tuple[Points, Floats]:
    """Return the highest points that a search finds and their heights.

    Args:
        search: see `climbing`.
        height: of points; -inf where there is none.
    """
    (found,) = climb_all([search], lambda points: [height(points[0])])
    return found


def climb_all(
    searches: Sequence[Climb], heights: Callable[[Sequence[Points]], Sequence[Floats]]
) -> list[tuple[Points, Floats]]:
    """Return what several searches of as many rounds find; their points are evaluated together.

    Args:
        searches: see `climbing`.
        heights: of the points of each search.
    """
    asked = [next(search) for search in searches]
    while True:
        answers = heights(asked)
        asked, found = [], []
        for search, answer in zip(searches, answers, strict=True):
            try:
                asked.append(search.send(answer))
            except StopIteration as end:
                found.append(end.value)
        if not asked:
            return found


def climbing(
    ranges: Mapping[str, Interval],
    start: Mapping[str, Floats],
    *,
    climbers: int,
    rounds: int,
    seed: int = 2,
    octaves: int = 24,
    towards_poles: bool = False,
) -> Climb:
    """Search for high points; both results are of shape (climbers,), fewer if there are fewer to start from.

    Args:
        ranges: of the coordinates.
        start: points to start from, of which the highest are taken.
        climbers: points that climb at the same time.
        rounds: steps, each of a size drawn anew, from half of a range down to 2^-`octaves` of that.
        seed: of the random steps.
        octaves: see `rounds`.
        towards_poles: for a function that may grow without bound, perhaps at an end of a range where it has
            no value: steps double with success and halve without, and are reflected at the ends.
    """
    random = np.random.Generator(np.random.PCG64(seed))
    heights = yield dict(start)
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
        reached = yield moved
        higher = reached > heights
        size = np.where(higher, np.minimum(2 * size, _LARGEST_STEP), size / 2)
        heights = np.where(higher, reached, heights)
        points = {name: np.where(higher, moved[name], column) for name, column in points.items()}
    return points, heights
