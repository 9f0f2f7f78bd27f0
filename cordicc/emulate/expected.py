"""A user's own answers beside those of a plan: which rows differ by more than they may."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Floats
from cordicc.base.diagnostics import Diagnostic, InvalidInput
from cordicc.emulate.histogram import Errors, angular, worst_first

Rows = Iterator[Mapping[str, Floats]]
Allowed = Callable[[Mapping[str, Floats]], Mapping[str, Floats]]
"""Returns, of samples valid in both, by output the largest difference of each."""

TOLERANCE = "tol_"
"""Before the name of an output: the column with the largest difference allowed, row by row."""


@dataclass(frozen=True, slots=True)
class ExpectedVerdict:
    """How a plan's outputs compare with expected ones.

    `differences` are by output, over rows valid in both; `beyond` counts the differences larger than
    allowed, by output; `validity` the rows valid in one alone; `wrong` lists (row from 1, output,
    simulated, expected, allowed), those first that exceed what is allowed the most.
    """

    rows: int
    differences: Mapping[str, Errors]
    beyond: Mapping[str, int]
    validity: int
    first_invalid: int | None
    wrong: tuple[tuple[int, str, float, float, float], ...]

    @property
    def agrees(self) -> bool:
        """Tell whether every row is as expected."""
        return not self.validity and not any(self.beyond.values())


def check_golden(
    inputs: Rows,
    expected: Rows,
    angles: Mapping[str, bool],
    allowed: Allowed,
    simulate: Callable[[Mapping[str, Floats]], Mapping[str, NDArray[Any]]],
    worst: int = 10,
) -> ExpectedVerdict:
    """Compare a plan's outputs with expected ones, part by part.

    Args:
        inputs: parts of the inputs.
        expected: parts of the same rows: outputs, nan where the row is invalid; perhaps `valid`, 0
            or 1, and `tol_<output>`.
        angles: by output compared, whether differences count modulo 2 pi.
        allowed: the largest differences where a row has none of its own.
        simulate: runs the plan.
        worst: how many differences to list.

    Raises:
        InvalidInput: the two have different numbers of rows.
    """
    differences = {name: Errors() for name in angles}
    beyond = dict.fromkeys(angles, 0)
    wrong: list[tuple[float, tuple[int, str, float, float, float]]] = []
    row = validity = 0
    first_invalid = None
    for part, answers in _paired(inputs, expected):
        outputs = simulate(part)
        ok, wanted = outputs["valid"].astype(bool), _expected_valid(answers, angles)
        apart = np.flatnonzero(ok != wanted)
        if apart.size and first_invalid is None:
            first_invalid = row + int(apart[0]) + 1
        validity += apart.size
        both = np.flatnonzero(ok & wanted)
        limits = allowed({name: column[both] for name, column in part.items()})
        for name, is_angle in angles.items():
            error = angular(outputs[name][both] - answers[name][both], is_angle)
            tolerance = answers.get(TOLERANCE + name)
            limit = limits[name] if tolerance is None else tolerance[both]
            differences[name].add(error, row + both)
            over = ~(error <= limit)
            beyond[name] += int(over.sum())
            with np.errstate(divide="ignore", invalid="ignore"):
                excess = np.where(over, error / limit, 0.0)
            for at in worst_first(excess, both, worst).tolist():
                if over[at]:
                    figures = (
                        float(outputs[name][both[at]]),
                        float(answers[name][both[at]]),
                        float(limit[at]),
                    )
                    wrong.append((float(excess[at]), (row + int(both[at]) + 1, name, *figures)))
        wrong = sorted(wrong, key=lambda each: (-each[0], each[1][:2]))[:worst]
        row += len(ok)
    listed = tuple(line for _, line in wrong)
    return ExpectedVerdict(row, differences, beyond, validity, first_invalid, listed)


def _paired(inputs: Rows, expected: Rows) -> Iterator[tuple[Mapping[str, Floats], Mapping[str, Floats]]]:
    row = 0
    while True:
        part, answers = next(inputs, None), next(expected, None)
        sizes = [0 if each is None else len(next(iter(each.values()))) for each in (part, answers)]
        if sizes[0] != sizes[1]:
            shorter = "inputs" if sizes[0] < sizes[1] else "expected outputs"
            message = f"there are only {row + min(sizes)} rows of {shorter}"
            raise InvalidInput([Diagnostic("E615", message)])
        if part is None or answers is None:
            return
        yield part, answers
        row += sizes[0]


def _expected_valid(answers: Mapping[str, Floats], angles: Mapping[str, bool]) -> NDArray[np.bool_]:
    """Return which rows have all their answers, and are not marked invalid."""
    valid = np.ones(len(next(iter(answers.values()))), dtype=bool)
    for name in angles:
        valid &= np.isfinite(answers[name])
    if "valid" in answers:
        valid &= answers["valid"] != 0
    return valid
