"""The public corpus: every problem compiles, and simulates its workspace within its tolerance."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.base.diagnostics import InvalidInput
from tests.support.corpus import (
    LITTLE,
    PROBLEMS,
    REFUSED,
    VARIED,
    angles,
    expected_of,
    inputs_of,
    problem_path,
)
from tests.support.plans import compiled, planned
from tests.support.selection import quick

PLANS: dict[str, Callable[[Path], cordicc.Plan]] = {
    "default": compiled,
    "little effort": partial(planned, effort=0.01),
    "krieger96": partial(planned, target="krieger96"),
    "imscor24": partial(planned, target="imscor24"),
    "fixed24": partial(planned, target="fixed24"),
    "fixed24, little effort": partial(planned, target="fixed24", effort=LITTLE),
}
"""How a plan is made; with little effort searches stop early, and what comes out computes the same.

Accuracy figures take their time, so there are some by default only.
"""

SOON = "fixed24, little effort"
CASES = [(name, how) for how in PLANS for name in (VARIED if how == SOON else PROBLEMS)]
CLOCKED = [case for case in CASES if case[1] != "krieger96"]
LARGE = ("franka_panda_q7", "humanoid_leg_6dof", "puma560", "puma560_solve", "stanford_arm", "stewart_legs")
"""Problems whose plans take seconds even so; tests of examples run arms of six joints quickly."""

SMALL = [name for name in PROBLEMS if name not in LARGE]
FEW = [(name, how) for how in ("little effort", SOON) for name in VARIED]
MORE = [(name, "little effort") for name in SMALL if name not in VARIED]
MORE += [("planar_2r", how) for how in ("krieger96", "imscor24")]


def test_the_corpus_is_whole() -> None:
    assert len(PROBLEMS) == 31
    assert len(REFUSED) == 6


@pytest.mark.parametrize(("name", "how"), quick(CASES, *FEW, *MORE))
def test_within_tolerance(name: str, how: str) -> None:
    plan = PLANS[how](problem_path(name))
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


@pytest.mark.parametrize(("name", "how"), quick(CLOCKED, *FEW))
def test_cycle_accurate_gives_the_same_bytes(name: str, how: str) -> None:
    plan = PLANS[how](problem_path(name))
    inputs = inputs_of(name)
    functional, clocked = plan.simulate(inputs), plan.simulate(inputs, cycle_accurate=True)
    assert list(functional) == list(clocked)
    for output in functional:
        assert functional[output].tobytes() == clocked[output].tobytes()


@pytest.mark.parametrize("name", quick(PROBLEMS, *SMALL))
def test_outputs_that_are_angles(name: str) -> None:
    plan = PLANS["little effort"](problem_path(name))
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
