"""The proven bounds of the corpus on fixed point: no sample inside is beyond, and nearly all are inside."""

import math
from pathlib import Path

import numpy as np
import pytest

from cordicc.certify.error_network import network
from cordicc.certify.own_bounds import inside
from cordicc.certify.plans import bounds_of
from cordicc.emulate import functional
from cordicc.emulate.observation import exact
from cordicc.ir import sampling
from tests.support.corpus import EFFORT_CASES, LITTLE_CASES, inputs_of, problem_path
from tests.support.plans import planned
from tests.support.selection import quick

LEAST_SHARE = 0.99
ROWS = 300
MANY = {"planar_2r": 10_000, "catenary": 10_000, "wrist_zyz": 10_000, "cable_winch": 10_000, "puma560": 2_000}


@pytest.mark.parametrize(("name", "effort"), quick(EFFORT_CASES, *LITTLE_CASES[::2]))
def test_no_sample_is_beyond_the_bound(name: str, effort: float) -> None:
    plan = planned(problem_path(name), target="fixed24", effort=effort)
    bounds = bounds_of(plan)
    net = network(plan)
    corpus = inputs_of(name)
    rows = MANY.get(name, ROWS) if effort == 1 else ROWS
    drawn = sampling.draw(plan.problem.workspace, rows, 11)
    points = {n: np.concatenate([corpus[n], drawn[n]]) for n in net.inputs}
    simulated = functional.run(plan, plan.arithmetic, points)
    values, defined = exact(plan.problem, points)
    for output, bound in bounds.items():
        assert bound.value is not None, bound.reason
        held = inside(net, {output: bound.where}, points)[output]
        assert held[: len(corpus[next(iter(corpus))])].mean() >= LEAST_SHARE
        error = np.abs(simulated[output] - values[output])
        if net.angles[output]:
            error = np.minimum(np.mod(error, math.tau), math.tau - np.mod(error, math.tau))
        counted = error[held & defined & simulated["valid"]]
        assert counted.max() <= bound.value


WRAPPED = """
inputs: {y: [0.3, 0.4], z: [-1.4, -1.3]}
equations:
  - v = atan2(sin(z), y + z) + acos(sin(z)/hypot(sin(z), y + z))
  - w = asin(v/4)
"""


@pytest.mark.parametrize("target", quick(["kinematic", "fixed24", "imscor24"], "fixed24"))
def test_an_angle_that_is_always_a_turn_off_has_a_bound(target: str, tmp_path: Path) -> None:
    path = tmp_path / "wrapped.yaml"
    path.write_text(WRAPPED, encoding="utf-8")
    plan = planned(path, target=target, effort=0.1)
    assert "wrap" in {operation.op for operation in plan.operations}
    bound = bounds_of(plan)["w"]
    assert bound.value is not None, bound.reason
    assert bound.value < 1e-6
    points = sampling.draw(plan.problem.workspace, 2_000, 3)
    values, _ = exact(plan.problem, points)
    assert np.abs(functional.run(plan, plan.arithmetic, points)["w"] - values["w"]).max() <= bound.value


@pytest.mark.parametrize("target", quick(["kinematic", "imscor24"], "kinematic"))
def test_a_quotient_as_an_angle_is_rounded_as_it_is(target: str, tmp_path: Path) -> None:
    """Its numerator and denominator are enclosed one by one, and a turn more or less is no matter."""
    path = tmp_path / "quotient.yaml"
    path.write_text("inputs: {x: [-6, 6]}\nequations: ['w = cos(sinh(x)/cosh(x))']\n", encoding="utf-8")
    plan = planned(path, target=target, effort=0.1)
    bound = bounds_of(plan)["w"]
    assert bound.value is not None, bound.reason
    assert bound.value < 2e-6
    points = sampling.draw(plan.problem.workspace, 2_000, 3)
    values, _ = exact(plan.problem, points)
    assert np.abs(functional.run(plan, plan.arithmetic, points)["w"] - values["w"]).max() <= bound.value
