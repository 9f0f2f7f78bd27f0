"""Roots of squares: what they save, that validity stays, and that a broken rule shows."""

from pathlib import Path

import pytest

from cordicc.rewrite.rules import perfect_squares
from cordicc.rewrite.search import conditions
from tests.support.rewriting import problem_of, same_where, searched, units

VECTORS = "ax=-1:1, ay=-1:1, bx=-1:1, by=-1:1"
BETWEEN = "t = acos((ax*bx + ay*by)/(hypot(ax, ay)*hypot(bx, by)))"
CORNERS = {
    "ax": [0.0, 0.5, 0.5, 0.5, -0.25, 0.0],
    "ay": [0.0, 0.25, 0.25, 0.25, 0.5, 1.0],
    "bx": [0.5, 0.0, 0.5, -0.5, 0.5, 1.0],
    "by": [0.5, 0.0, 0.25, -0.25, 0.25, 0.0],
}


def test_the_angle_between_vectors_is_one_vectoring(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, VECTORS, BETWEEN, "t")
    graph = searched(problem).graph
    assert units(graph) == ["vector"]
    same_where(problem, graph, CORNERS)


def test_the_angle_between_vectors_has_no_sign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(perfect_squares, "absolute", lambda store, value: value)
    problem = problem_of(tmp_path, "ax=0.2:0.6, ay=0.2:0.5, bx=0.1:1, by=-1:-0.2", BETWEEN, "t")
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem).graph, {n: [abs(x) for x in c] for n, c in CORNERS.items()})


def test_an_angle_in_space_takes_one_root(tmp_path: Path) -> None:
    equation = "t = acos((ax*bx + ay*by + az*bz)/(sqrt(ax**2 + ay**2 + az**2)*sqrt(bx**2 + by**2 + bz**2)))"
    problem = problem_of(tmp_path, f"{VECTORS}, az=0.5:1, bz=0.5:1", equation, "t")
    graph = searched(problem).graph
    assert units(graph) == ["implicit", "lightcone"]
    same_where(problem, graph, CORNERS | {"az": [0.5] * 6, "bz": [0.75] * 6})


def test_an_oscillating_cylinder(tmp_path: Path) -> None:
    """The rest of the sine law is the other leg of the triangle."""
    equations = "s = sqrt(0.0109 + 0.006*cos(th))\np = asin(0.03*sin(th)/s)"
    problem = problem_of(tmp_path, "th=-3.1:3.1", equations, "s, p")
    graph = searched(problem).graph
    assert units(graph) == ["rotate", "vector"]
    same_where(problem, graph, {"th": [-3.1, -1.0, 0.0, 0.5, 3.1]})


@pytest.mark.parametrize("equation", ["a = sqrt(x**2 + 2*x*y + y**2)", "a = sqrt(4*x**2*y**2)"])
def test_the_root_of_a_square(tmp_path: Path, equation: str) -> None:
    problem = problem_of(tmp_path, "x=0.5:1.8, y=-1:1", equation, "a")
    graph = searched(problem).graph
    assert units(graph) == []
    same_where(problem, graph, {"x": [0.5, 1.0, 1.8], "y": [-1.0, -1.0, 0.0]})


def test_a_root_of_what_is_no_square_keeps_its_condition(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """x y < 0 has no root; a rule that took x y for a square would not know."""
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1", "a = sqrt(x*y)*sqrt(x*y)", "a")
    inputs = {"x": [0.5, -0.5, -0.5], "y": [0.5, -0.5, 0.5]}
    same_where(problem, searched(problem).graph, inputs)
    monkeypatch.setattr(conditions, "root_proven", lambda *_: True)
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem).graph, inputs)
