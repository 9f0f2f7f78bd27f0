"""A plan's proven bounds on the samples of a run: how many are inside, and whether any is beyond."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Samples
from cordicc.emulate.histogram import Worst, angular
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.reference import reference_outputs

MOST_BEYOND = 1000
"""Samples beyond a bound of which each is established in high precision; of more, no more are looked for."""

_NEAR = 1 - 2.0**-10
"""Share of a bound from which an error in double precision is looked at again."""


class ConditionalBounds(NamedTuple):
    """Bounds by output, and what tells, by output with a bound, which valid samples they hold for."""

    values: Mapping[str, float]
    inside: Callable[[Samples], Mapping[str, NDArray[np.bool_]]]


@dataclass(slots=True)
class Judged:
    """How an output's bound fares on valid samples: how many, those inside, those of them beyond; the worst.

    Beyond are those whose error in high precision exceeds the bound; counting them stops at `MOST_BEYOND`.
    """

    bound: float
    samples: int = 0
    inside: int = 0
    beyond: int = 0
    worst: Worst | None = None

    @property
    def share(self) -> float | None:
        """The share of samples inside, None without samples."""
        return self.inside / self.samples if self.samples else None

    def note(self, worst: Worst) -> None:
        """Count a sample beyond the bound."""
        self.beyond += 1
        if self.worst is None or worst.error > self.worst.error:
            self.worst = worst


class Part(NamedTuple):
    """Valid samples of a run: their numbers from 0, inputs, simulated outputs, errors by output.

    The errors are `precise`, or in double precision, not finite where that has no value.
    """

    numbers: NDArray[np.int64]
    inputs: Samples
    outputs: Mapping[str, NDArray[Any]]
    errors: Samples
    precise: bool


@dataclass(slots=True)
class Judgement:
    """Judges a run, part after part, by the equations as written."""

    graph: Graph
    angles: Mapping[str, bool]
    limits: ConditionalBounds
    found: dict[str, Judged] = field(init=False)

    def __post_init__(self) -> None:
        self.found = {name: Judged(value) for name, value in self.limits.values.items()}

    def add(self, part: Part) -> None:
        """Judge a part."""
        if not part.numbers.size:
            return
        held = self.limits.inside(part.inputs)
        for name, judged in self.found.items():
            judged.samples += part.numbers.size
            judged.inside += int(held[name].sum())
            errors = part.errors[name]
            if part.precise:
                over = held[name] & (errors > judged.bound)
            else:
                over = held[name] & ~(errors <= _NEAR * judged.bound)
            for at, error in self._established(name, part, np.flatnonzero(over)):
                sample = {n: float(column[at]) for n, column in part.inputs.items()}
                judged.note(Worst(error, int(part.numbers[at]) + 1, sample))

    def _established(self, name: str, part: Part, over: NDArray[np.int64]) -> list[tuple[int, float]]:
        """Return which of the samples are beyond the bound, and their errors in high precision."""
        judged = self.found[name]
        room = MOST_BEYOND - judged.beyond
        if part.precise:
            return [(int(at), float(part.errors[name][at])) for at in over[:room]]
        made: list[tuple[int, float]] = []
        for begin in range(0, over.size, MOST_BEYOND):
            if len(made) >= room:
                break
            rows = over[begin : begin + MOST_BEYOND]
            values, defined = reference_outputs(
                self.graph, {n: column[rows] for n, column in part.inputs.items()}
            )
            errors = angular(part.outputs[name][rows] - values[name], self.angles[name])
            beyond = np.flatnonzero(defined & (errors > judged.bound))
            made += [(int(rows[at]), float(errors[at])) for at in beyond]
        return made[:room]

    def add_found(self, name: str, worst: Worst) -> None:
        """Judge a valid sample that a search found, with its error in high precision."""
        if name not in self.found or worst.error <= self.found[name].bound:
            return
        held = self.limits.inside({n: np.array([number]) for n, number in worst.inputs.items()})
        if held[name][0]:
            self.found[name].note(worst)
