"""Conditions of a root or an arc cosine whose value is no longer needed survive the search."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cordicc.frontend.load import load_problem
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.rewrite.same_meaning import check_meaning
from tests.support.random_problems import (
    RandomProblem,
    Step,
    beside_borders,
    clear_validity,
    random_problem,
)
from tests.support.rewriting import problem_of, same_where, searched
from tests.support.selection import quick

ROUNDING = 1e-12

# Equations, ranges, outputs, and samples on both sides of the border.
CASES = {
    "a product of a root with itself": (
        "w1 = sqrt(y)*sqrt(y)\nw2 = atan2(y, x)",
        "x=0.1:0.3, y=-0.01:1.2",
        "w1, w2",
        {"x": [0.2, 0.2, 0.2], "y": [-0.005, -0.009, 0.5]},
    ),
    "the cosine of an arc cosine of a norm": (
        "w1 = cos(acos(hypot(y, 0.7)))",
        "y=0.1:0.72",
        "w1",
        {"y": [0.715, 0.7192, 0.5]},
    ),
    "the cosine of twice an arc cosine": (
        "w1 = cos(2*acos(hypot(y, x)))",
        "x=0:0.9, y=-0.5:0.5",
        "w1",
        {"x": [0.9, 0.88, 0.5], "y": [-0.5, 0.5, 0.1]},
    ),
    "a sum with what is always 1": (
        "w1 = cos(acos(hypot(y, 0.7)))\nw2 = cos(w1)**2 + sin(w1)**2",
        "y=0.1:0.9",
        "w1, w2",
        {"y": [0.2, 0.8, 0.7]},
    ),
    "a root beside a pair of equations": (
        "w1 = sqrt(y)*sqrt(y)\nw2 = atan2(0.1*x + y, cosh(x)*y - 0.1)",
        "x=-2:3, y=-pi:pi",
        "w1, w2",
        {"x": [1.0, 1.0, -1.5], "y": [-1.0, 1.0, -0.1]},
    ),
    "an arc cosine times what cancels": (
        "a = acos(x)\nq = a*(a - a) + y",
        "x=0.25:1.5, y=0.1:0.5",
        "q",
        {"x": [0.5, 1.2, 1.01], "y": [0.2, 0.2, 0.3]},
    ),
    "a root times another one's radicand": (
        "w1 = sqrt(x*y)*sqrt(y)",
        "x=-1:1, y=-1:1",
        "w1",
        {"x": [0.5, -0.5, 0.5, -0.5], "y": [0.5, -0.5, -0.5, 0.5]},
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_both_sides_of_a_border(tmp_path: Path, case: str) -> None:
    equations, inputs, outputs, samples = CASES[case]
    problem = problem_of(tmp_path, inputs, equations, outputs)
    same_where(problem, searched(problem).graph, samples)


@pytest.mark.parametrize("first", quick(range(0, 300, 10), 0))
def test_borders_of_random_problems(tmp_path: Path, first: int) -> None:
    for seed in range(first, first + 10):
        written = random_problem(seed)
        samples = beside_borders(written, 3)
        if not len(next(iter(samples.values()))):
            continue
        valid, clear = clear_validity(written, samples, ROUNDING)
        path = tmp_path / f"{seed}.yaml"
        path.write_text(written.text, encoding="utf-8")
        _, defined = reference_outputs(searched(load_problem(path).problem).graph, samples)
        np.testing.assert_array_equal(defined[clear], valid[clear], err_msg=written.text)


def test_what_is_clear_of_a_vector_that_rounding_hides() -> None:
    """A = B = x keeps its direction if both err alike; an implicit unit takes each to err by itself."""
    steps = (
        Step("w1", "solve", ("x", "x", "0", "-")),
        Step("w2", "plain", ("sqrt(w1)",)),
    )
    problem = RandomProblem(0, {"x": (0.0, 1.0)}, steps, ("w2",))
    valid, clear = clear_validity(problem, {"x": np.array([1e-6, 0.5])}, 1e-5)
    np.testing.assert_array_equal(valid, [False, False])
    np.testing.assert_array_equal(clear, [False, True])


def test_what_is_clear_where_two_conditions_contradict_each_other() -> None:
    """The angle is 0, which is not negative and has no inverse root; rounding may take it for either side."""
    steps = (
        Step("w1", "condition", ("y", "y", "y", "{t} < 0")),
        Step("w2", "plain", ("(sqrt(w1)*sqrt(w1))**-0.5",)),
    )
    problem = RandomProblem(0, {"y": (-1.0, 0.0)}, steps, ("w2",))
    valid, clear = clear_validity(problem, {"y": np.array([-0.9])}, 1e-6, tries=100)
    assert not valid
    assert not clear


def test_an_exact_border_of_two_conditions(tmp_path: Path) -> None:
    """The angle is 0, at which alone it is not positive and has a root, and which rounding misses."""
    path = tmp_path / "problem.yaml"
    path.write_text(
        "inputs: {x: [0.1, 2]}\nequations:\n"
        "  - solve: x*cos(q) + acos(0.7)*sin(q) = hypot(x, pi)*cos(atan2(pi, x))\n    for: q\n"
        "    branch: q < 0\n  - w = x + sqrt(q)\noutputs: [w]\n",
        encoding="utf-8",
    )
    problem = load_problem(path).problem
    graph = searched(problem).graph
    check_meaning(problem, graph)
    samples = {"x": np.array([0.3, 1.7])}
    found, valid = reference_outputs(graph, samples)
    assert valid.all()
    assert found["w"] == pytest.approx(samples["x"], abs=1e-12)
