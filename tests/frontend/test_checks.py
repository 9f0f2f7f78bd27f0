"""Checks in problem files: what names mean in them, vectors, frames and branches, residuals of solves."""

import numpy as np
import pytest

from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.frontend.load import parse_problem
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.well_formed import verify


def load(text):
    loaded = parse_problem(Source("t.yaml", text))
    if loaded.problem.checks:
        verify(loaded.problem.check_graph)
    return loaded


def values(text, **words):
    """Return the checks of a problem at words of inputs and outputs."""
    graph = load(text).problem.check_graph
    return {name: column[0] for name, column in reference_outputs(graph, arrays(words))[0].items()}


def arrays(words):
    return {name: np.array([number]) for name, number in words.items()}


def names(text):
    return [check.name for check in load(text).problem.checks]


def test_an_output_is_what_was_delivered_and_other_names_follow_from_it():
    text = """
constants: {k: 2}
inputs: {x: [0, 1]}
equations: [d = k*x, q = acos(d/4), twin = acos(d/4), c = cos(q), same = x]
outputs: [q, same]
checks: {through: c - d/4, alike: twin - q, copied: same - x, constant: k*q}
"""
    found = values(text, x=0.5, q=1.0, same=0.75)
    assert found["through"] == pytest.approx(np.cos(1.0) - 0.25)
    # The equation of `twin` is over the input: that it equals `q` in the file is no matter.
    assert found["alike"] == pytest.approx(np.arccos(0.25) - 1.0)
    assert found["copied"] == 0.25
    assert found["constant"] == 2.0


def test_a_solved_name_is_solved_for_again():
    text = """
inputs: {x: [0.1, 0.9], y: [0.1, 0.4]}
equations:
  - q = asin(x)
  - solve: cos(t) = y + sin(q) - x
    for: t
    branch: "+"
outputs: [q]
checks: {e: cos(t) - y}
"""
    assert values(text, x=0.5, y=0.25, q=0.6)["e"] == pytest.approx(np.sin(0.6) - 0.5)


VECTORS = """
constants: {a: 0.4, b: 0.3}
inputs: {x: [0.3, 0.6], y: [0, 0.3]}
equations:
  - D = (x**2 + y**2 - a**2 - b**2)/(2*a*b)
  - q2 = acos(D)
  - q1 = atan2(y, x) - atan2(b*sin(q2), a + b*cos(q2))
  - vector: elbow = rotate([a, 0], q1)
  - dh: {frame: T, convention: standard, joints: [{theta: q1, a: a}, {theta: q2, a: b}]}
outputs: [q1, q2]
checks:
  px: {value: T_px - x, unit: m, max: 1 um}
  tip: elbow + rotate([b, 0], q1 + q2) - [x, y]
  reach: norm(elbow) - a
"""


def test_vectors_and_frames_are_those_of_equations():
    assert names(VECTORS) == ["px", "tip_x", "tip_y", "reach"]
    found = values(VECTORS, x=0.5, y=0.2, q1=0.3, q2=0.7)
    wanted = 0.4 * np.cos(0.3) + 0.3 * np.cos(1.0) - 0.5
    assert found["px"] == pytest.approx(wanted)
    assert found["tip_x"] == pytest.approx(wanted)
    assert found["tip_y"] == pytest.approx(0.4 * np.sin(0.3) + 0.3 * np.sin(1.0) - 0.2)
    assert found["reach"] == pytest.approx(0, abs=1e-15)


def test_what_is_said_of_a_check_is_kept():
    first, second, *_ = load(VECTORS).problem.checks
    assert (first.unit, float(first.max), first.text, first.asked) == ("m", 1e-6, "T_px - x", True)
    assert (second.unit, second.max) == (None, None)


def test_what_only_checks_use_is_no_output_and_no_warning():
    loaded = load(VECTORS)
    assert not loaded.warnings
    assert list(loaded.problem.graph.outputs) == ["q1", "q2"]
    assert not any(node.op == "sin" and node.origin == "T" for node in loaded.problem.graph.nodes)


LOOP = """
constants: {a: 0.4, b: 0.3}
inputs: {x: [0.3, 0.6], y: [0, 0.3]}
equations:
  - solve: rotate([a, 0], u) + rotate([b, 0], u + v) = [x, y]
    for: [u, v]
    branch: all
  - s = u + v
outputs: OUTPUTS
checks: {e: a*cos(u) + b*cos(s) - x}
"""


def test_a_check_is_there_for_each_branch():
    text = LOOP.replace("OUTPUTS", "[u, v]")
    assert names(text) == [
        "e_p", "e_m", "solve.u_p.v_p.1", "solve.u_p.v_p.2", "solve.u_m.v_m.1", "solve.u_m.v_m.2",
    ]  # fmt: skip
    words = {"x": 0.5, "y": 0.2, "u_p": 0.1, "v_p": 0.2, "u_m": 0.3, "v_m": 0.4}
    found = values(text, **words)
    assert found["e_m"] == pytest.approx(0.4 * np.cos(0.3) + 0.3 * np.cos(0.7) - 0.5)
    assert found["solve.u_p.v_p.2"] == pytest.approx(0.4 * np.sin(0.1) + 0.3 * np.sin(0.3) - 0.2)


def test_a_branch_that_is_not_delivered_has_no_check():
    assert names(LOOP.replace("OUTPUTS", "[u_m, v_m]")) == ["e_m", "solve.u_m.v_m.1", "solve.u_m.v_m.2"]


def test_residuals_are_left_side_minus_right_side():
    text = """
inputs: {x: [1, 2], y: [1, 2]}
equations:
  - k = x*y
  - solve: x*cos(t) + y*sin(t) = k/4
    for: t
    branch: "+"
  - solve: [cos(p) + x*sin(p) = y, x*cos(p) - sin(p) = k]
    for: p
  - solve: cosh(h) = x
    for: h
    branch: "+"
outputs: [t, p]
"""
    found = values(text, x=1.5, y=1.25, t=0.3, p=0.5)
    assert list(found) == ["solve.t", "solve.p.1", "solve.p.2"], "h is not delivered"
    assert found["solve.t"] == pytest.approx(1.5 * np.cos(0.3) + 1.25 * np.sin(0.3) - 1.875 / 4)
    assert found["solve.p.2"] == pytest.approx(1.5 * np.cos(0.5) - np.sin(0.5) - 1.875)
    assert not any(check.asked for check in load(text).problem.checks)


@pytest.mark.parametrize("section", ["checks:", "checks: {}", ""])
def test_there_need_be_none(section):
    assert not names(f"inputs: {{x: [0, 1]}}\nequations: [y = 2*x]\n{section}\n")


def test_a_name_has_as_many_branches_as_in_equations():
    solves = "".join(f"  - solve: cos(q{i}) = x\n    for: q{i}\n" for i in range(5))
    head = "branches: all\ninputs: {x: [0, 1]}\nequations:\n"
    text = f"{head}{solves}checks: {{e: q0 + q1 + q2 + q3 + q4}}\n"
    with pytest.raises(InvalidInput, match="'e' depends on more than 4 solves"):
        load(text)
