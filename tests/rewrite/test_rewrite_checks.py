"""The choice of operations where checks say what outputs reach together."""

import re
from pathlib import Path

import numpy as np
import pytest

from cordicc.backends.text.explanation import explanation
from cordicc.backends.text.summary import explanation_text
from cordicc.base.diagnostics import Source
from cordicc.base.text_tables import plain
from cordicc.emulate.checking import CheckTally
from cordicc.frontend.load import load_problem, parse_problem
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.hard_samples import hard_samples
from cordicc.ir.meaning.doubles import results
from cordicc.ir.meaning.roundings import SINGLE
from cordicc.ir.problem import Problem, input_intervals
from cordicc.ir.sampling import draw
from cordicc.rewrite.accuracy_gate import AccuracyGate
from cordicc.rewrite.cheapest import Choice, cheapest
from cordicc.rewrite.disturbances import Disturbances
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.same_meaning import check_meaning
from cordicc.rewrite.search.costs import Costs
from cordicc.rewrite.search.realisations import Realisations
from cordicc.targets.target_file import load_target
from tests.support.corpus import problem_path
from tests.support.plans import compiled
from tests.support.rewriting import certain, problem_of, searched, units
from tests.support.selection import quick

HEAD = """
inputs: {x: [0.1, 0.6], y: [0, 0.3]}
outputs: [q1, q2]
equations:
"""
CHECKS = """
checks:
  px: 0.3*cos(q1) + 0.3*cos(q1 + q2) - x
  py: 0.3*sin(q1) + 0.3*sin(q1 + q2) - y
"""
FORMS = {
    "in sequence": """
  - q2 = acos((x**2 + y**2 - 0.18)/0.18)
  - q1 = atan2(y, x) - atan2(0.3*sin(q2), 0.3 + 0.3*cos(q2))
""",
    "by the elbow": """
  - solve: x*cos(q1) + y*sin(q1) = (x**2 + y**2)/0.6
    for: q1
    branch: "-"
  - q2 = atan2(y - 0.3*sin(q1), x - 0.3*cos(q1)) - q1
""",
    "side by side": """
  - q2 = acos((x**2 + y**2 - 0.18)/0.18)
  - solve: x*cos(q1) + y*sin(q1) = (x**2 + y**2)/0.6
    for: q1
    branch: "-"
""",
}
"""Equations of an arm of two links whose range holds stretched arms."""


def arm(form: str, checks: str = CHECKS, head: str = HEAD) -> Problem:
    return parse_problem(Source("arm.yaml", head + FORMS[form] + checks)).problem


def chosen(problem: Problem, target: str) -> Choice:
    """Return what the search makes of a problem for a target, compared with the equations."""
    loaded = load_target(target)
    costs = Costs.of(loaded, implicit=loaded.has_implicit)
    context = PassContext(input_intervals(problem), "processors", costs.floating)
    choice = cheapest(problem, certain(problem), context, costs)
    check_meaning(problem, choice.graph)
    return choice


def near_the_edge(plan) -> CheckTally:
    """Return the checks of a plan near borders and singular points."""
    workspace = plan.problem.workspace
    samples = hard_samples(plan.problem.program, workspace, draw(workspace, 2_000, 1))
    tally = CheckTally(plan.problem)
    tally.add(samples, plan.simulate(samples))
    assert tally.samples > 100
    return tally


@pytest.mark.parametrize("target", quick(["kinematic", "fixed24"], "fixed24"))
@pytest.mark.parametrize("form", quick(FORMS, "in sequence"))
def test_one_joint_follows_from_the_other(form: str, target: str) -> None:
    choice = chosen(arm(form), target)
    assert units(choice.graph) == ["implicit", "vector"]
    assert choice.turned_down
    assert not choice.proven


def test_without_checks_they_are_side_by_side() -> None:
    choice = searched(arm("in sequence", ""))
    assert units(choice.graph) == ["implicit", "implicit"]
    assert choice.proven
    assert not choice.turned_down


def test_far_from_the_edge_they_are_side_by_side() -> None:
    choice = searched(arm("in sequence", head=HEAD.replace("0.6]", "0.4]").replace("0.3]", "0.2]")))
    assert units(choice.graph) == ["implicit", "implicit"]
    assert not choice.turned_down


LOOP = """
inputs: {x: [0.2, 0.6], y: [0, 0.2]}
equations:
  - solve: rotate([0.35, 0], q1) + rotate([0.25, 0], q1 + q2) = [x, y]
    for: [q1, q2]
    branch: q2 > 0
outputs: [q1, q2]
"""


COUNTS = {"kinematic": 2, "fixed24": 2, "imscor24": 3}


@pytest.mark.parametrize("target", quick(COUNTS, "kinematic"))
def test_a_loop_closes_near_a_stretched_arm(target: str, tmp_path: Path) -> None:
    path = tmp_path / "loop.yaml"
    path.write_text(LOOP, encoding="utf-8")
    plan = compiled(path, target=target, certify=False)
    assert plan.processors()["total"] == COUNTS[target]
    assert all(record.errors.largest < 2e-6 for record in near_the_edge(plan).found.values())
    if not plan.selection.turned_down:
        return
    told = rf"turned down: rounding would move '{plan.selection.turned_down[0]}' too far from 0"
    assert told in explanation_text(plan)
    assert told in plain(explanation(plan))
    assert told.replace("'", "&#39;") in plan.report()


STRETCHED = {
    "planar_2r_solve": (
        2,
        {"x": "[0.15, 0.6]"},
        {"px": "L1*cos(q1) + L2*cos(q1 + q2) - x", "py": "L1*sin(q1) + L2*sin(q1 + q2) - y"},
    ),
    "planar_3r": (
        3,
        {"x": "[0.2, 0.45]", "y": "[-0.3, 0.3]"},
        {"px": "L1*cos(q1) + L2*cos(q1 + q2) + L3*cos(phi) - x", "phi": "sin(q1 + q2 + q3 - phi)"},
    ),
    "scara": (
        3,
        {"x": "[250, 640]", "y": "[-400, 400]"},
        {"px": "(D2*cos(q1) + D4*cos(q1 + q2) + D6*cos(q1 + q2 + q4) - x)/1000"},
    ),
    "anthropomorphic_3r": (
        3,
        {"px": "[0.12, 0.32]", "py": "[-0.3, 0.3]", "pz": "[0, 0.3]"},
        {
            "ex": "cos(q1)*(a2*cos(q2) + a3*cos(q2 + q3)) - px",
            "ez": "d1 + a2*sin(q2) + a3*sin(q2 + q3) - pz",
        },
    ),
}
"""Arms of the corpus by name: CAUs of the plan, ranges that hold stretched arms, checks."""


@pytest.mark.parametrize("name", quick(STRETCHED, "anthropomorphic_3r"))
@pytest.mark.parametrize("target", quick(["kinematic", "fixed24"], "kinematic"))
def test_arms_reach_their_points_with_as_many_units(name: str, target: str, tmp_path: Path) -> None:
    count, ranges, checks = STRETCHED[name]
    text = problem_path(name).read_text(encoding="utf-8")
    for item, ends in ranges.items():
        text = re.sub(rf"(?m)^  {item}: \[.*$", f"  {item}: {ends}", text)
    text += "checks:\n" + "".join(f'  {item}: "{value}"\n' for item, value in checks.items())
    (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    plan = compiled(tmp_path / f"{name}.yaml", target=target, certify=False)
    assert plan.processors()["total"] == count
    found = near_the_edge(plan).found
    assert all(found[check].errors.largest < 1e-6 for check in checks)


WRIST = """
inputs: {al: [-1, 1], be: [-0.8, 0.8], ga: [-1, 1]}
equations:
  - vector: a1 = rotate(rotate(rotate([1, 0, 0], x, ga), y, be), z, al)
  - vector: a2 = rotate(rotate(rotate([0, 1, 0], x, ga), y, be), z, al)
  - vector: a3 = rotate(rotate(rotate([0, 0, 1], x, ga), y, be), z, al)
  - q4 = atan2(a3_y, a3_x)
  - q5 = atan2(hypot(a3_x, a3_y), a3_z)
  - q6 = atan2(cos(q4)*a1_y - sin(q4)*a1_x, cos(q4)*a2_y - sin(q4)*a2_x)
  - vector: b1 = rotate(rotate(rotate([1, 0, 0], z, q6), y, q5), z, q4)
  - vector: b2 = rotate(rotate(rotate([0, 1, 0], z, q6), y, q5), z, q4)
outputs: [q4, q5, q6]
checks: {first: b1 - a1, second: b2 - a2}
"""


@pytest.mark.exhaustive(reason="searches twice for a wrist; a smaller arm is judged on fixed point quickly")
def test_errors_on_fixed_point_are_as_large_for_short_vectors(tmp_path: Path) -> None:
    path = tmp_path / "wrist.yaml"
    path.write_text(WRIST, encoding="utf-8")
    problem = load_problem(path).problem
    floating, fixed = (chosen(problem, target) for target in ("kinematic", "fixed24"))
    assert len(units(fixed.graph)) > len(units(floating.graph))
    assert fixed.turned_down
    assert not floating.turned_down


@pytest.mark.exhaustive(reason="runs plans of a wrist close to where it is straight")
@pytest.mark.parametrize("target", ["kinematic", "fixed24"])
def test_a_straight_wrist_turns_the_hand_as_it_should(target: str, tmp_path: Path) -> None:
    path = tmp_path / "wrist.yaml"
    path.write_text(WRIST, encoding="utf-8")
    plan = compiled(path, target=target, certify=False)
    source = np.random.default_rng(2)
    for bend in (1e-2, 1e-4, 1e-6):
        samples = {
            name: source.uniform(-1, 1, 400) * (1 if name == "al" else bend) for name in ("al", "be", "ga")
        }
        tally = CheckTally(plan.problem)
        tally.add(samples, plan.simulate(samples))
        assert tally.found["first_x"].samples > 300
        assert all(record.errors.largest < 2e-6 for record in tally.found.values())


def test_results_of_an_equation_go_together_when_they_are_disturbed() -> None:
    """Near a double root the angle moves far, and the second result with it."""
    node = Node("implicit", (1, "+"), (Value(0), Value(1), Value(2)))
    A, B, C = np.full(3, 0.3), np.full(3, 0.4), 0.5 - np.array([1e-3, 1e-6, 1e-7])
    exact = results(node.op, node.params, (A, B, C), 3)
    disturbances = Disturbances(SINGLE, Graph((), {}), ())
    angle, rest = disturbances.disturbed(0, node, (A, B, C), exact, np.ones(3), [np.zeros(3)] * 2)
    assert np.all(np.abs(angle - exact[0]) > SINGLE.rounding)
    # Both are those of an equation whose right side is as far off as its rounding.
    moved = B * np.cos(angle) + A * np.sin(angle)
    assert np.allclose(moved - C, 0.5 * SINGLE.rounding, rtol=1e-5)
    assert np.allclose(B * np.sin(angle) - A * np.cos(angle), rest, rtol=1e-9)


def test_the_gate_tells_of_angles_that_miss_together() -> None:
    problem = arm("in sequence")
    drawn = draw(problem.workspace, 2_000, 0)
    hard = hard_samples(problem.graph, problem.workspace, drawn)
    easy = {name: np.linspace(0.1, 0.3, 50) for name in drawn}
    gate = AccuracyGate(problem, certain(problem), easy, hard)
    given = gate.judged(certain(problem))
    assert (given.inaccurate, given.far) == (None, None)
    apart = arm("side by side", "")
    effect = gate.judged(certain(apart))
    inaccurate, far = effect.inaccurate, effect.far
    assert inaccurate is not None
    assert far is not None
    assert {inaccurate[0], far[0]} <= {"px", "py"}
    assert inaccurate[1] >= 50, "it is a hard sample"
    assert gate.movers(certain(apart), *inaccurate, certain(apart).used_results())


def test_what_should_follow_from_a_unit_is_found_and_banned() -> None:
    problem = arm("in sequence")
    costs = Costs.of(load_target("kinematic"), implicit=True)
    around = Realisations(problem, PassContext(input_intervals(problem)), [certain(problem)], costs)
    found = around.best()
    assert found is not None
    nodes = {value: found.graph.node(value) for value in found.graph.used_results()}
    q1, q2 = (
        next(value for value, node in nodes.items() if (node.op, node.origin) == ("implicit", name))
        for name in ("q1", "q2")
    )
    assert around.apart(found, q2) == {q1}
    assert around.apart(found, q1) == set()
    assert around.ban(found, q1)
    assert around.apart(found, q2) == set()
    again = around.best()
    assert again is not None
    assert units(again.graph) != units(found.graph)


def test_the_only_way_is_not_banned(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-3:3", "c = cos(x)", "c")
    costs = Costs.of(load_target("kinematic"), implicit=True)
    around = Realisations(problem, PassContext(input_intervals(problem)), [certain(problem)], costs)
    found = around.best()
    assert found is not None
    cosine = found.graph.outputs["c"]
    assert cosine in around.may_be_banned(found, needed=True) - around.may_be_banned(found)
    assert not around.ban(found, cosine)
    assert around.best() is not None
