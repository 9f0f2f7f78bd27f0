"""The public corpus: every problem compiles, and simulates its workspace within its tolerance."""

import math

import numpy as np
import pytest

import cordicc
from cordicc.base.diagnostics import InvalidInput
from tests.support.corpus import PROBLEMS, REFUSED, VARIED, angles, expected_of, inputs_of, problem_path
from tests.support.plans import compiled, planned
from tests.support.selection import quick

TARGETS = ("kinematic", "krieger96", "imscor24", "fixed24")
CASES = [(name, target) for target in TARGETS for name in PROBLEMS]
QUICK = [(name, "kinematic") for name in PROBLEMS]
QUICK += [("planar_2r", "krieger96"), ("planar_2r", "imscor24"), *((name, "fixed24") for name in VARIED)]
CLOCKED = [case for case in CASES if case[1] != "krieger96"]


def plan_of(name: str, target: str) -> cordicc.Plan:
    """Return a plan with accuracy figures on the default target only, since they take their time."""
    path = problem_path(name)
    return compiled(path) if target == "kinematic" else planned(path, target=target)


def test_the_corpus_is_whole() -> None:
    assert len(PROBLEMS) == 31
    assert len(REFUSED) == 6


@pytest.mark.parametrize(("name", "target"), quick(CASES, *QUICK))
def test_within_tolerance(name: str, target: str) -> None:
    plan = plan_of(name, target)
    inputs = inputs_of(name)
    expected = expected_of(name)
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


@pytest.mark.parametrize(
    ("name", "target"), quick(CLOCKED, *(case for case in CLOCKED if case in QUICK and case[0] in VARIED))
)
def test_cycle_accurate_gives_the_same_bytes(name: str, target: str) -> None:
    plan = plan_of(name, target)
    inputs = inputs_of(name)
    functional, clocked = plan.simulate(inputs), plan.simulate(inputs, cycle_accurate=True)
    assert list(functional) == list(clocked)
    for output in functional:
        assert functional[output].tobytes() == clocked[output].tobytes()


@pytest.mark.parametrize("name", PROBLEMS)
def test_outputs_that_are_angles(name: str) -> None:
    plan = plan_of(name, "kinematic")
    found = {name for name, is_angle in plan.problem.angles.items() if is_angle}
    assert found == angles()[name]
    outputs = plan.simulate(inputs_of(name))
    for output in found:
        assert np.all((-math.pi < outputs[output]) & (outputs[output] <= math.pi))


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_a_place(name: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        cordicc.compile(problem_path(name))
    assert caught.value.exit_status == 2
    assert all(d.span is not None for d in caught.value.diagnostics)
