"""The public corpus: every problem compiles, and simulates its workspace within its tolerance."""

import csv
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.base.diagnostics import InvalidInput
from cordicc.pipeline import Options, plan_file
from tests.support.paths import CORPUS

PROBLEMS = sorted(p.stem for p in CORPUS.glob("*.yaml") if not p.stem.startswith("rej_"))
REFUSED = sorted(p.stem for p in CORPUS.glob("rej_*.yaml"))
TARGETS = ("kinematic", "krieger96", "imscor24", "fixed24")


@cache
def compiled(name: str, target: str) -> cordicc.Plan:
    path = CORPUS / f"{name}.yaml"
    if target == "kinematic":
        return cordicc.compile(path)
    return cordicc.Plan.of(plan_file(path, Options(target)).plan)  # without the time of the accuracy figures


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def angles() -> dict[str, set[str]]:
    lines = (CORPUS / "angles.txt").read_text(encoding="utf-8").splitlines()
    return {line.split()[0]: set(line.split()[1:]) for line in lines if line}


def test_the_corpus_is_whole() -> None:
    assert len(PROBLEMS) == 31
    assert len(REFUSED) == 6


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("name", PROBLEMS)
def test_within_tolerance(name: str, target: str) -> None:
    plan = compiled(name, target)
    inputs = table(CORPUS / f"{name}.inputs.csv")
    expected = table(CORPUS / f"{name}.expected.csv")
    outputs = plan.simulate(inputs)
    assert outputs["valid"].all()
    for output in plan.outputs:
        error = np.abs(outputs[output] - expected[output])
        if output in angles()[name]:
            error = np.minimum(error, np.abs(error - math.tau))
        tolerance = expected[f"tol_{output}"]
        if output in plan.formats.outputs:  # fixed point: two ulp of the output's words if that is more
            tolerance = np.maximum(tolerance, 2 * math.ldexp(1.0, -plan.formats.outputs[output].fraction))
        worst = np.max(error / tolerance)
        assert worst <= 1, f"{output}: {worst:.3g} times the tolerance"


@pytest.mark.parametrize("target", ["kinematic", "imscor24", "fixed24"])
@pytest.mark.parametrize("name", PROBLEMS)
def test_cycle_accurate_gives_the_same_bytes(name: str, target: str) -> None:
    plan = compiled(name, target)
    inputs = table(CORPUS / f"{name}.inputs.csv")
    functional, clocked = plan.simulate(inputs), plan.simulate(inputs, cycle_accurate=True)
    assert list(functional) == list(clocked)
    for output in functional:
        assert functional[output].tobytes() == clocked[output].tobytes()


@pytest.mark.parametrize("name", PROBLEMS)
def test_outputs_that_are_angles(name: str) -> None:
    plan = compiled(name, "kinematic")
    found = {name for name, is_angle in plan.problem.angles.items() if is_angle}
    assert found == angles()[name]
    outputs = plan.simulate(table(CORPUS / f"{name}.inputs.csv"))
    for output in found:
        assert np.all((-math.pi < outputs[output]) & (outputs[output] <= math.pi))


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_a_place(name: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        cordicc.compile(CORPUS / f"{name}.yaml")
    assert caught.value.exit_status == 2
    assert all(d.span is not None for d in caught.value.diagnostics)
