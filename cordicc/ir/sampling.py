"""Samples of the inputs, drawn at random: all at once, or a part at a time with the same numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def draw(problem: Mapping[str, Any], count: int, seed: int) -> dict[str, Floats]:
    """Draw samples: rows of the problem's own samples if it has them, else uniform in the ranges.

    The generator is NumPy's PCG64 with the given seed, the inputs in order of declaration.
    """
    return next(draw_parts(problem, count, seed, count))


def draw_parts(problem: Mapping[str, Any], count: int, seed: int, part: int) -> Iterator[dict[str, Floats]]:
    """Draw the samples of `draw` in parts of at most `part`; at least one part, perhaps empty."""
    samples = problem.get("samples")
    names = [item["name"] for item in problem["inputs"]]
    # A double takes one step of the generator, so input k starts k * count steps after the first.
    generators = [
        np.random.Generator(np.random.PCG64(seed).advance(k * count)) for k in range(max(1, len(names)))
    ]
    for begin in range(0, max(1, count), max(1, part)):
        size = min(part, count - begin)
        if samples:
            own = {name: np.asarray(samples["columns"][name], dtype=np.float64) for name in names}
            rows = generators[0].integers(0, len(own[names[0]]), size)
            yield {name: column[rows] for name, column in own.items()}
            continue
        yield {
            item["name"]: _uniform(generator, float(item["lo"]), float(item["hi"]), size)
            for item, generator in zip(problem["inputs"], generators, strict=False)
        }


def _uniform(generator: np.random.Generator, lo: float, hi: float, size: int) -> Floats:
    share = generator.random(size)
    wide = not math.isfinite(hi - lo)
    return np.clip(hi * share + lo * (1 - share) if wide else lo + (hi - lo) * share, lo, hi)
