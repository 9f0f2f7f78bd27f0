"""Samples of the inputs, drawn at random: all at once, or a part at a time with the same numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.base import elementary
from cordicc.base.arrays import Floats

DEFAULT_SAMPLES = 10_000
DEFAULT_SEED = 0
"""What is drawn unless told otherwise: the figures that a plan states are of these samples."""

_DECADES = 6
_CORNERS = 256
"""Corners of the ranges that are looked at besides."""


@dataclass(frozen=True, slots=True)
class Workspace:
    """Where samples are drawn from: the closed range of each input, in order of declaration.

    `rows` are the problem's own samples by input, equally many numbers each, None if it has none.
    """

    ranges: Mapping[str, tuple[float, float]]
    rows: Mapping[str, Sequence[float]] | None = None


def draw(workspace: Workspace, count: int, seed: int) -> dict[str, Floats]:
    """Draw samples: rows of the problem's own samples if it has them, else uniform in the ranges.

    The generator is NumPy's PCG64 with the given seed, the inputs in order of declaration.
    """
    return next(draw_parts(workspace, count, seed, count))


def draw_with_corners(workspace: Workspace, count: int) -> dict[str, Floats]:
    """Draw samples with the default seed, and corners of the ranges besides; of own samples rows alone."""
    samples = draw(workspace, count, DEFAULT_SEED)
    if workspace.rows is not None:
        return samples
    ends = corners(workspace.ranges)
    return {name: np.concatenate([column, ends[name]]) for name, column in samples.items()}


def draw_by_size(workspace: Workspace, count: int) -> dict[str, Floats]:
    """Draw samples whose sizes are spread evenly over the decades, down to `_DECADES` below the largest.

    Uniform samples of wide ranges are all large.  Of own samples there are none.
    """
    if workspace.rows is not None:
        return {name: np.empty(0) for name in workspace.ranges}
    generator = np.random.Generator(np.random.PCG64(DEFAULT_SEED + 1))
    found = {}
    for name, (lo, hi) in workspace.ranges.items():
        largest = max(abs(lo), abs(hi))
        least = max(lo, -hi, largest * 10.0**-_DECADES)
        # Of the side that a number has, so that a short one has small numbers too.
        below = generator.random(count) < (0.5 if lo < 0 < hi else float(hi <= 0))
        side = np.where(below, abs(lo), abs(hi))
        with np.errstate(divide="ignore", invalid="ignore"):  # of a range that is 0 alone
            share = np.clip(elementary.log(np.fmax(side, least) / least), 0.0, None)
            size = least * elementary.exp(share * generator.random(count))
        found[name] = np.clip(np.nan_to_num(np.where(below, -size, size)), lo, hi)
    return found


def corners(ranges: Mapping[str, tuple[float, float]]) -> dict[str, Floats]:
    """Return corners of the box of the ranges: all of up to `_CORNERS`, else as many random ones."""
    count = len(ranges)
    if 2**count <= _CORNERS:
        bits = (np.arange(2**count)[:, None] >> np.arange(count)) & 1
    else:
        bits = np.random.Generator(np.random.PCG64(0)).integers(0, 2, (_CORNERS, count))
    return {name: np.where(bits[:, i] == 1, hi, lo) for i, (name, (lo, hi)) in enumerate(ranges.items())}


def draw_parts(workspace: Workspace, count: int, seed: int, part: int) -> Iterator[dict[str, Floats]]:
    """Draw the samples of `draw` in parts of at most `part`; at least one part, perhaps empty."""
    names = list(workspace.ranges)
    # A double takes one step of the generator, so input k starts k * count steps after the first.
    generators = [
        np.random.Generator(np.random.PCG64(seed).advance(k * count)) for k in range(max(1, len(names)))
    ]
    for begin in range(0, max(1, count), max(1, part)):
        size = min(part, count - begin)
        if workspace.rows is not None:
            own = {name: np.asarray(workspace.rows[name], dtype=np.float64) for name in names}
            rows = generators[0].integers(0, len(own[names[0]]), size)
            yield {name: column[rows] for name, column in own.items()}
            continue
        yield {
            name: _uniform(generator, lo, hi, size)
            for (name, (lo, hi)), generator in zip(workspace.ranges.items(), generators, strict=False)
        }


def _uniform(generator: np.random.Generator, lo: float, hi: float, size: int) -> Floats:
    share = generator.random(size)
    wide = not math.isfinite(hi - lo)
    return np.clip(hi * share + lo * (1 - share) if wide else lo + (hi - lo) * share, lo, hi)
