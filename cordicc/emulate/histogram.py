"""Errors of one output, collected part by part: count, largest, rms, histogram, the worst samples."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Floats

ZERO = -1075
"""The bin of errors that are exactly 0."""

_HUGE, _PLACES = 2.0**500, 600
"""Errors from which squares may overflow, and the places by which such errors are shifted before."""


def angular(difference: Floats, is_angle: bool) -> Floats:
    """Return the size of differences; of angles in radians, modulo 2 pi."""
    error = np.abs(difference)
    if is_angle:
        turned = np.mod(error, math.tau)
        error = np.minimum(turned, math.tau - turned)
    return error


def worst_first(errors: Floats, samples: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return where the `count` largest errors are, the largest and of equal ones the first before others."""
    if errors.size > count:
        limit = np.partition(errors, errors.size - count)[errors.size - count]
        candidates = np.flatnonzero(errors >= limit)
    else:
        candidates = np.arange(errors.size)
    order = np.lexsort((samples[candidates], -errors[candidates]))[:count]
    return np.asarray(candidates[order])


@dataclass(frozen=True, slots=True)
class Worst:
    """A sample with a large error: its number from 1, None if a search found it, and its inputs."""

    error: float
    sample: int | None
    inputs: dict[str, float]


@dataclass(slots=True)
class Errors:
    """Errors seen so far; `worst` holds (error, number of the sample from 0), the largest first.

    Bin k of the histogram counts errors from 2^k to below 2^(k+1).
    """

    keep: int = 5
    count: int = 0
    squares: float = 0.0
    huge_squares: float = 0.0
    bins: Counter[int] = field(default_factory=Counter)
    worst: list[tuple[float, int]] = field(default_factory=list)

    def add(self, errors: Floats, samples: NDArray[np.int64], rank: bool = True) -> None:
        """Take errors, finite and at least 0, and the numbers of their samples, both of shape (n,).

        Unless told to `rank` them, they do not count among the worst.
        """
        if not errors.size:
            return
        self.count += errors.size
        if errors.max() < _HUGE:
            self.squares += float(np.square(errors).sum())
        else:
            self.huge_squares += float(np.square(np.ldexp(errors, -_PLACES)).sum())
        exponents = np.where(errors > 0, np.frexp(errors)[1] - 1, ZERO)
        found, counts = np.unique(exponents, return_counts=True)
        self.bins.update(dict(zip(found.tolist(), counts.tolist(), strict=True)))
        if rank:
            order = worst_first(errors, samples, self.keep)
            self.rank(zip(errors[order].tolist(), samples[order].tolist(), strict=True))

    def rank(self, found: Iterable[tuple[float, int]]) -> None:
        """Let errors and the numbers of their samples count among the worst."""
        self.worst = sorted([*self.worst, *found], key=lambda each: (-each[0], each[1]))[: self.keep]

    @property
    def largest(self) -> float | None:
        """The largest error, None if there was none."""
        return self.worst[0][0] if self.worst else None

    @property
    def rms(self) -> float | None:
        """The root of the mean square, None without samples."""
        if not self.count:
            return None
        if not self.huge_squares:
            return math.sqrt(self.squares / self.count)
        squares = self.huge_squares + math.ldexp(self.squares, -2 * _PLACES)
        return math.ldexp(math.sqrt(squares / self.count), _PLACES)

    def rows(self) -> list[tuple[float, int]]:
        """Return the histogram: lower end of each bin and its count, without gaps, 0 first if it occurs."""
        exponents = [exponent for exponent in self.bins if exponent != ZERO]
        rows = [(0.0, self.bins[ZERO])] if ZERO in self.bins else []
        if exponents:
            span = range(min(exponents), max(exponents) + 1)
            rows += [(math.ldexp(1.0, exponent), self.bins[exponent]) for exponent in span]
        return rows
