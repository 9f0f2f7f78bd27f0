"""Mutations of the conditions of passes and of requirements: each broken condition shows."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cordicc.base.arrays import Floats
from cordicc.ir.meaning.exact import PI
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import Problem
from cordicc.rewrite.passes import implicit_forms, standard_chains, vectorings, wraps
from cordicc.rewrite.passes import ratio as quotients
from cordicc.rewrite.search import conditions
from tests.support.rewriting import problem_of, same_where, searched

BOX = "x=-2:2, y=-2:2, w=-2:2"
Patch = pytest.MonkeyPatch


def positive(*given: object) -> Interval:
    return Interval(0.5, 1.0)


def test_wraps_are_dropped_inside_the_circle_only(tmp_path: Path, monkeypatch: Patch) -> None:
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2", "t = 2*atan2(y, x)", "t")
    searched(problem)
    monkeypatch.setattr(wraps, "INSIDE", 100.0)
    edge = {"x": [-1.0, -1.0], "y": [0.5, -0.5]}
    with pytest.raises(AssertionError):
        # Values modulo 2 pi agree; the delivered one is outside (-pi, pi].
        assert abs(_delivered(problem, edge)).max() <= float(PI)


def _delivered(problem: Problem, samples: dict[str, list[float]]) -> Floats:
    points = {name: np.array(column) for name, column in samples.items()}
    return reference_outputs(searched(problem).graph, points)[0]["t"]


@pytest.mark.parametrize(
    ("equation", "module"),
    [
        ("t = acos(x/w)", implicit_forms),
        ("t = asin(x/w)", implicit_forms),
        ("t = atan(x/w)", vectorings),
    ],
)
def test_the_sign_of_a_denominator(tmp_path: Path, monkeypatch: Patch, equation: str, module: object) -> None:
    problem = problem_of(tmp_path, BOX, equation, "t")
    samples = {"x": [0.5, 0.5, 0.0], "y": [0.0, 0.0, 0.0], "w": [1.0, -1.0, -1.0]}
    same_where(problem, searched(problem).graph, samples)
    known = quotients.positive_ratio
    monkeypatch.setattr(
        module, "positive_ratio", lambda builder, value, interval: known(builder, value, positive())
    )
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem).graph, samples)


def test_a_denominator_that_may_be_zero(tmp_path: Path, monkeypatch: Patch) -> None:
    problem = problem_of(tmp_path, BOX, "t = atan(x/w)", "t")
    samples = {"x": [0.5, 0.0], "y": [0.0, 0.0], "w": [0.0, 1.0]}
    same_where(problem, searched(problem).graph, samples)
    known = quotients.positive_ratio
    monkeypatch.setattr(vectorings, "positive_ratio", lambda *given: (*known(*given)[:2], None))
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem).graph, samples)


@pytest.mark.parametrize("port", [0, 1])
def test_chains_of_one_coefficient_want_it_positive(tmp_path: Path, monkeypatch: Patch, port: int) -> None:
    left = ("w*sin(t)", "w*cos(t)")[port]
    equations = f'k = x\n  - solve: {left} = x\n    for: t\n    branch: "{"-+"[port]}"'
    problem = problem_of(tmp_path, BOX, equations, "t")
    samples = {"x": [0.5, 0.5], "y": [0.0, 0.0], "w": [1.0, -1.0]}
    same_where(problem, searched(problem, implicit=False).graph, samples)
    chain = standard_chains.circular_chain

    def broken(builder, branch, sine, cosine, C):
        return chain(builder, branch, (sine[0], True), (cosine[0], True), C)

    monkeypatch.setattr(standard_chains, "circular_chain", broken)
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem, implicit=False).graph, samples)


ALWAYS: list[tuple[str, Callable[..., object], str, str, dict[str, list[float]]]] = [
    (
        "proven",
        lambda *given: (True, True),
        "q = atan2(y, x)\nt = atan2(sin(q) + w*cos(q), cos(q) - w*sin(q)) - q",
        "t",
        {"x": [0.0, 1.0], "y": [0.0, 1.0], "w": [0.5, 0.5]},
    ),
    (
        "holds",
        lambda *given: True,
        "u = (x*w + y)/x\nv = u*x",
        "v",
        {"x": [0.0, 1.0], "y": [0.5, 0.5], "w": [0.5, 0.5]},
    ),
    (
        "root_proven",
        lambda *given: True,
        "u = sqrt(x)\nv = u**2 + y",
        "v",
        {"x": [-1.0, 1.0], "y": [0.5, 0.5], "w": [0.0, 0.0]},
    ),
]


@pytest.mark.parametrize(
    ("name", "broken", "equations", "output", "samples"), ALWAYS, ids=[case[0] for case in ALWAYS]
)
def test_what_proves_a_condition(
    tmp_path: Path,
    monkeypatch: Patch,
    name: str,
    broken: Callable[..., object],
    equations: str,
    output: str,
    samples: dict[str, list[float]],
) -> None:
    problem = problem_of(tmp_path, BOX, equations, output)
    same_where(problem, searched(problem).graph, samples)
    monkeypatch.setattr(conditions, name, broken)
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem).graph, samples)
