"""Simulation of any number of samples in bounded memory, and its errors against the equations.

The high-precision reference is slow, so a long run has it for its first samples only.  The others are
screened in double precision, and those that look worst, or whose validity looks wrong, are then looked at
in high precision too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Floats, Samples
from cordicc.emulate.accuracy import Comparison, Observed
from cordicc.emulate.causes import Cause, Causes
from cordicc.emulate.fact_tally import FactTally
from cordicc.emulate.histogram import Errors, Worst, angular, worst_first
from cordicc.emulate.judging import ConditionalBounds, Judgement, Part
from cordicc.emulate.ports import Outputs
from cordicc.ir.effort import effort
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.sampling import DEFAULT_SAMPLES

REFERENCE_SAMPLES = DEFAULT_SAMPLES
"""Samples that are compared with the high-precision reference unless told otherwise, as many as are drawn."""

_SUSPECTS = 32
"""Worst screened samples of each output that are looked at in high precision."""

_DOUBTFUL = 1000
"""Samples of doubtful validity that are looked at in high precision in one run."""

_CLOSER_LOOKS = 3_000_000
"""Products that suspects and samples of doubtful validity may each take as long as, in high precision."""


@dataclass(frozen=True, slots=True)
class RunFindings:
    """What a run showed.

    `referenced` samples were compared in high precision, `screened` ones in double precision, which was
    at most `screening_error` from the reference, by output, where both were computed; None where none was.
    `judgement` says how the plan's bounds fare, if it states any.  `causes` say why samples have no value
    in the equations, of how many that is so, and which is the first, from 0.  `facts` says which samples
    break what the problem assumes; they count in nothing else but `samples`, `valid` and `causes`, and their
    largest errors are apart, in `unfounded`.
    """

    comparison: Comparison
    errors: Mapping[str, Errors]
    worst: Mapping[str, tuple[Worst, ...]]
    referenced: int
    screened: int
    screening_error: Mapping[str, float | None]
    judgement: Judgement | None
    causes: tuple[tuple[Cause, int, int], ...]
    facts: FactTally | None
    unfounded: Mapping[str, float | None]


@dataclass(slots=True)
class _Tally:
    """What a run has shown so far."""

    graph: Graph
    angles: Mapping[str, bool]
    reference: int
    judgement: Judgement | None = None
    facts: FactTally | None = None
    samples: int = 0
    valid: int = 0
    lost: int = 0
    gained: int = 0
    lost_at: int | None = None
    referenced: int = 0
    screened: int = 0
    doubtful: int = 0
    errors: dict[str, Errors] = field(default_factory=dict)
    gaps: dict[str, float | None] = field(default_factory=dict)
    unfounded: dict[str, float | None] = field(default_factory=dict)
    suspects: dict[str, list[tuple[float, int, dict[str, float], float]]] = field(default_factory=dict)
    known: dict[int, dict[str, float]] = field(default_factory=dict)
    causes: Causes = field(init=False)

    def __post_init__(self) -> None:
        self.causes = Causes(self.graph)

    def add(self, inputs: Samples, outputs: Outputs) -> None:
        """Compare a part of the run with the equations."""
        size = len(outputs["valid"])
        kept = np.ones(size, dtype=bool) if self.facts is None else self.facts.kept(inputs)
        exact = min(size, max(0, self.reference - self.samples))
        for part, precise in ((slice(0, exact), True), (slice(exact, size), False)):
            if part.start < part.stop:
                here = {name: column[part] for name, column in inputs.items()}
                made = {name: column[part] for name, column in outputs.items()}
                self._compare(here, made, kept[part], precise)

    def _compare(self, inputs: Samples, outputs: Outputs, kept: NDArray[np.bool_], precise: bool) -> None:
        simulated = outputs["valid"].astype(bool)
        values, defined, broken = self.causes.screened(inputs)
        if precise:
            screened, screenable = values, defined
            values, defined = reference_outputs(self.graph, inputs)
            self._measure(values, screened, defined & screenable)
            self.referenced += simulated.size
        else:
            self.screened += simulated.size
            defined = self._decide(inputs, defined, simulated)
        self.causes.count(broken, ~defined, self.samples)
        self._set_apart(outputs, values, defined & simulated & ~kept)
        both = defined & simulated & kept
        numbers = self.samples + np.flatnonzero(both)
        errors = {n: angular(outputs[n][both] - values[n][both], a) for n, a in self.angles.items()}
        if self.judgement is not None:
            exactly = np.ones(numbers.shape, dtype=bool)
            if self.facts is not None:
                exactly = self.facts.facts.exactly({n: column[both] for n, column in inputs.items()})
            judged = np.flatnonzero(both)[exactly]
            inside, made = ({n: column[judged] for n, column in each.items()} for each in (inputs, outputs))
            own = {name: error[exactly] for name, error in errors.items()}
            self.judgement.add(Part(numbers[exactly], inside, made, own, precise))
        for name, error in errors.items():
            known = np.isfinite(error)  # a doubtful sample may have no value in double precision
            self.errors[name].add(error[known], numbers[known], rank=precise)
            if not precise:
                self._suspect(name, error[known], numbers[known], inputs, outputs)
                continue
            for _, number in self.errors[name].worst:
                if number >= self.samples:
                    self.known[number] = {n: float(c[number - self.samples]) for n, c in inputs.items()}
        lost = np.flatnonzero(defined & ~simulated & kept)
        if lost.size and self.lost_at is None:
            self.lost_at = self.samples + int(lost[0])
        self.lost += lost.size
        self.gained += int((simulated & ~defined & kept).sum())
        self.valid += int(simulated.sum())
        self.samples += simulated.size

    def _set_apart(self, outputs: Outputs, values: Samples, broken: NDArray[np.bool_]) -> None:
        """Note the largest errors of samples that break what is assumed: they are no fault of the plan."""
        for name, is_angle in self.angles.items():
            error = angular(outputs[name][broken] - values[name][broken], is_angle)
            error = error[np.isfinite(error)]
            if error.size:
                self.unfounded[name] = max(self.unfounded[name] or 0.0, float(error.max()))

    def _measure(self, values: Samples, screened: Samples, both: NDArray[np.bool_]) -> None:
        """Note how far double precision is from the reference."""
        for name, is_angle in self.angles.items():
            gap = angular(values[name][both] - screened[name][both], is_angle)
            if gap.size:
                self.gaps[name] = max(self.gaps[name] or 0.0, float(gap.max()))

    def _decide(
        self, inputs: Samples, defined: NDArray[np.bool_], simulated: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Return which samples the equations can do, in high precision where that is in doubt."""
        most = min(_DOUBTFUL, self.closer_looks())
        doubt = np.flatnonzero(defined != simulated)[: max(0, most - self.doubtful)]
        if not doubt.size:
            return defined
        self.doubtful += doubt.size
        decided = defined.copy()
        decided[doubt] = reference_outputs(self.graph, {n: column[doubt] for n, column in inputs.items()})[1]
        return decided

    def _suspect(
        self, name: str, errors: Floats, numbers: NDArray[np.int64], inputs: Samples, outputs: Outputs
    ) -> None:
        """Keep the worst screened samples, with their inputs and the simulated output."""
        order = worst_first(errors, numbers, _SUSPECTS)
        found = self.suspects[name]
        for error, number in zip(errors[order].tolist(), numbers[order].tolist(), strict=True):
            at = number - self.samples
            sample = {each: float(column[at]) for each, column in inputs.items()}
            found.append((error, number, sample, float(outputs[name][at])))
        self.suspects[name] = sorted(found, key=lambda each: (-each[0], each[1]))[:_SUSPECTS]

    def settle(self) -> None:
        """Look at the suspects in high precision, the worst of each output first; they count as worst."""
        chosen: dict[int, dict[str, float]] = {}
        for place in range(_SUSPECTS):
            for suspects in self.suspects.values():
                if place < len(suspects) and len(chosen) < self.closer_looks():
                    chosen.setdefault(suspects[place][1], suspects[place][2])
        if not chosen:
            return
        rows = {number: row for row, number in enumerate(chosen)}
        names = next(iter(chosen.values()))
        inputs = {each: np.array([sample[each] for sample in chosen.values()]) for each in names}
        values, defined = reference_outputs(self.graph, inputs)
        for name, suspects in self.suspects.items():
            kept = [s for s in suspects if s[1] in rows and defined[rows[s[1]]]]
            difference = np.array([s[3] - values[name][rows[s[1]]] for s in kept])
            errors = angular(difference, self.angles[name]).tolist()
            self.errors[name].rank(zip(errors, (s[1] for s in kept), strict=True))
        self.known |= chosen

    def closer_looks(self) -> int:
        """Return how many samples may be looked at once more in high precision."""
        return max(1, _CLOSER_LOOKS // max(1, effort(self.graph)))

    def report(self) -> RunFindings:
        """Return what the run showed."""
        observed = {
            name: Observed(errors.largest, errors.rms, errors.worst[0][1] if errors.worst else None)
            for name, errors in self.errors.items()
        }
        worst = {
            name: tuple(Worst(error, number + 1, self.known[number]) for error, number in errors.worst)
            for name, errors in self.errors.items()
        }
        counts = (self.samples, self.valid, self.lost, self.gained, self.lost_at)
        comparison = Comparison(observed, *counts)
        return RunFindings(
            comparison,
            self.errors,
            worst,
            self.referenced,
            self.screened,
            self.gaps,
            self.judgement,
            self.causes.listed(),
            self.facts,
            self.unfounded,
        )


def run_parts(
    graph: Graph,
    angles: Mapping[str, bool],
    parts: Iterable[Samples],
    simulate: Callable[[Samples], Outputs],
    take: Callable[[Outputs], None],
    reached: Callable[[int], None],
    reference: int = REFERENCE_SAMPLES,
    limits: ConditionalBounds | None = None,
    facts: FactTally | None = None,
) -> RunFindings:
    """Simulate part after part and compare with the equations.

    Args:
        graph: the equations as written.
        angles: by output, whether its errors count modulo 2 pi.
        parts: the inputs, float64 of shape (n,), n any number.
        simulate: runs the plan on a part.
        take: gets the outputs of each part, in order.
        reached: is told how many samples are done.
        reference: how many samples, the first ones, are compared in high precision.
        limits: the bounds by which samples are judged.
        facts: what is assumed of the samples.
    """
    judgement = None if limits is None else Judgement(graph, angles, limits)
    tally = _Tally(graph, angles, reference, judgement, facts)
    for name in angles:
        tally.errors[name], tally.suspects[name] = Errors(), []
        tally.gaps[name] = tally.unfounded[name] = None
    for inputs in parts:
        outputs = simulate(inputs)
        take(outputs)
        tally.add(inputs, outputs)
        reached(tally.samples)
    tally.settle()
    return tally.report()
