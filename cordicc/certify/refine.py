"""The largest value of a function enclosed over boxes, by cutting the box in which it is largest."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.certify.boxes import Boxes
from cordicc.ir.meaning.intervals import Interval

_BATCH = 1536
"""Boxes evaluated at once: enough to hide the cost of a NumPy call."""

_NARROW = 1 / 8
"""Of the widest axis of a box, as shares of the whole box."""

Score = Callable[[Mapping[str, Boxes]], Floats]


@dataclass(frozen=True, slots=True)
class Search:
    """What is enough, and what may be spent: a value, and boxes to evaluate."""

    enough: float
    boxes: int


def largest(ranges: Mapping[str, Interval], names: Sequence[str], score: Score, search: Search) -> float:
    """Return an upper bound of a function over a box of inputs.

    Args:
        ranges: the box; only `names` are cut.
        names: inputs that the function depends on.
        score: an upper bound of the function for each of many boxes, -inf where there is nothing to bound.
        search: when to stop.
    """
    lo = np.array([[ranges[name].lo for name in names]], dtype=np.float64)
    hi = np.array([[ranges[name].hi for name in names]], dtype=np.float64)
    others = {name: each for name, each in ranges.items() if name not in names}

    def evaluated(low: Floats, high: Floats) -> Floats:
        boxes = {name: Boxes(low[:, i], high[:, i]) for i, name in enumerate(names)}
        boxes |= {n: Boxes(np.full(len(low), i.lo), np.full(len(low), i.hi)) for n, i in others.items()}
        return score(boxes)

    sizes = np.where(hi[0] > lo[0], hi[0] - lo[0], 1.0)
    scores = evaluated(lo, hi)
    spent = 1
    axes = np.flatnonzero(hi[0] > lo[0])
    while scores.size and scores.max() > search.enough and spent < search.boxes and axes.size:
        most = max(1, _BATCH // (2 * axes.size))
        worst = np.argsort(-scores, kind="stable")[:most]
        worst = worst[scores[worst] > search.enough]
        parts = _halves(lo[worst], hi[worst], axes)
        found = evaluated(*(part.reshape(-1, len(names)) for part in parts)).reshape(len(worst), axes.size, 2)
        spent += found.size
        pick = _best_axis(found, (hi[worst] - lo[worst])[:, axes] / sizes[axes])
        rows = np.arange(len(worst))
        kept = np.setdiff1d(np.arange(len(scores)), worst)
        lo = np.concatenate([lo[kept], parts[0][rows, pick].reshape(-1, len(names))])
        hi = np.concatenate([hi[kept], parts[1][rows, pick].reshape(-1, len(names))])
        # A part holds nothing that the whole does not.
        limited = np.minimum(found[rows, pick], scores[worst][:, None])
        scores = np.concatenate([scores[kept], limited.reshape(-1)])
        alive = scores > -np.inf
        lo, hi, scores = lo[alive], hi[alive], scores[alive]
    return float(scores.max()) if scores.size else -np.inf


def _halves(lo: Floats, hi: Floats, axes: np.ndarray) -> tuple[Floats, Floats]:
    """Return both halves of each box along each axis: lower and upper corners, (boxes, axes, 2, inputs)."""
    shape = (len(lo), axes.size, 2, lo.shape[1])
    low = np.broadcast_to(lo[:, None, None], shape).copy()
    high = np.broadcast_to(hi[:, None, None], shape).copy()
    for at, axis in enumerate(axes):
        middle = lo[:, axis] + (hi[:, axis] - lo[:, axis]) / 2
        high[:, at, 0, axis] = middle
        low[:, at, 1, axis] = middle
    return low, high


def _best_axis(found: Floats, widths: Floats) -> np.ndarray:
    """Return by box the axis whose halves have the least larger score, then sum; the widest among equals.

    One much narrower than the widest is not cut: what is to be gained may take cuts along several axes.
    """
    narrow = widths < _NARROW * widths.max(axis=1, keepdims=True)
    finite = np.clip(found, 0.0, 1e200)
    worse, sums = finite.max(axis=2), finite.sum(axis=2)
    order = np.lexsort((-widths, sums, worse, narrow), axis=1)
    return np.asarray(order[:, 0])
