"""The checks of a problem on the words that a plan delivers: how far they are from 0."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Floats, Samples
from cordicc.base.diagnostics import Diagnostic, Severity
from cordicc.emulate.histogram import Errors, Worst
from cordicc.emulate.ports import Outputs
from cordicc.ir.meaning.small_values import small_values
from cordicc.plan.origin import PlanProblem
from cordicc.plan.stated_accuracy import CheckFigures, SeenErrors

_HINT = (
    "allow more, narrow the ranges, write equations of which errors cancel, or take a target with more bits"
)

_UNDEFINED_HINT = "write it without divisions, roots and inverse functions where these end"


def check_values(
    problem: PlanProblem, inputs: Samples, outputs: Mapping[str, NDArray[Any]]
) -> dict[str, Floats]:
    """Return the value of every check of a problem, NaN where the sample is invalid or the check has none.

    Args:
        problem: the problem.
        inputs: the samples, float64 of shape (n,) for each input.
        outputs: what a plan delivered for them, and its `valid`.
    """
    if not problem.checks:
        return {}
    valid = np.asarray(outputs["valid"], dtype=bool)
    names = [*problem.input_names, *problem.angles]
    columns = {**inputs, **outputs}
    found = small_values(problem.check_program, {name: columns[name][valid] for name in names})
    values = {}
    for check in problem.checks:
        values[check.name] = np.full(valid.shape, np.nan)
        values[check.name][valid] = found[check.name]
    return values


@dataclass(slots=True)
class CheckedErrors:
    """What a check showed over valid samples: their number, those without a value, those beyond its limit."""

    limit: float | None
    samples: int = 0
    undefined: int = 0
    beyond: int = 0
    errors: Errors = field(default_factory=lambda: Errors(keep=1))
    worst: Worst | None = None

    @property
    def figures(self) -> CheckFigures:
        """Return what a plan states of it."""
        worst = None if self.worst is None else self.worst.inputs
        return CheckFigures(SeenErrors(self.errors.largest, self.errors.rms), self.undefined, worst)


@dataclass(slots=True)
class CheckTally:
    """Collects the checks of a run, part after part."""

    problem: PlanProblem
    samples: int = 0
    found: dict[str, CheckedErrors] = field(init=False)

    def __post_init__(self) -> None:
        self.found = {check.name: CheckedErrors(check.max) for check in self.problem.checks}

    def add(self, inputs: Samples, outputs: Outputs) -> None:
        """Take a part of a run."""
        valid = outputs["valid"].astype(bool)
        for name, value in check_values(self.problem, inputs, outputs).items():
            record = self.found[name]
            known = np.flatnonzero(np.isfinite(value))
            size = np.abs(value[known])
            record.samples += int(valid.sum())
            record.undefined += int(valid.sum()) - known.size
            if record.limit is not None:
                record.beyond += int((size > record.limit).sum())
            record.errors.add(size, self.samples + known)
            for error, number in record.errors.worst:
                if number >= self.samples:
                    sample = {n: float(inputs[n][number - self.samples]) for n in self.problem.input_names}
                    record.worst = Worst(error, number + 1, sample)
        self.samples += valid.size

    def watching(self, simulate: Callable[[Samples], Outputs]) -> Callable[[Samples], Outputs]:
        """Return what simulates a part and takes it."""

        def run(inputs: Samples) -> Outputs:
            outputs = simulate(inputs)
            self.add(inputs, outputs)
            return outputs

        return run


def beyond_limits(tally: CheckTally, severity: Severity) -> list[Diagnostic]:
    """Return a finding for each check with a value beyond its limit, with its worst sample.

    As an error it refuses the plan (E416), as a warning it tells of a run (W419).  A plan is refused too if
    a check with a limit has no value in any valid sample: nothing shows that it is kept.
    """
    error = severity is Severity.ERROR
    found = []
    for name, record in tally.found.items():
        if error and record.limit is not None and record.samples and record.undefined == record.samples:
            message = f"check '{name}' has a max, and no value in any of {record.samples} valid samples"
            found.append(Diagnostic("E416", message, None, _UNDEFINED_HINT, severity))
        if not record.beyond or record.worst is None:
            continue
        unit = f" {unit}" if (unit := tally.problem.check(name).unit) else ""
        worst = ", ".join(f"{n} = {number!r}" for n, number in record.worst.inputs.items())
        message = (
            f"check '{name}' is {record.worst.error:.3g}{unit} in sample {record.worst.sample}, beyond its "
            f"max {record.limit:.3g}{unit} as in {record.beyond} of {record.samples} valid samples: {worst}"
        )
        found.append(Diagnostic("E416" if error else "W419", message, None, _HINT, severity))
    return found


def without_value(tally: CheckTally) -> list[Diagnostic]:
    """Return a warning for each check that has no value in some valid samples."""
    found = []
    for name, record in tally.found.items():
        if record.undefined:
            message = f"check '{name}' has no value in {record.undefined} of {record.samples} valid samples"
            found.append(Diagnostic("W420", message, None, _UNDEFINED_HINT, Severity.WARNING))
    return found
