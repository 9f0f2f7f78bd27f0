"""Mutations: with the condition of a rule broken, the comparison with the equations fails."""

from pathlib import Path

import pytest

from cordicc.rewrite.exact import field
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules import circles, common_denominators
from cordicc.rewrite.search import options, realisations
from tests.support.rewriting import multipliers, problem_of, same_where, searched, units

SIGNS = "t = atan2(x/w + 1, y/w)\ns = atan(x/(w + y))"
BOX = "x=-2:2, y=-2:2, w=-2:2"
LINKS = """
D = (x**2 + y**2 - 0.18)/0.18
q2 = acos(D)
q1 = atan2(y, x) - atan2(0.3*sin(q2), 0.3 + 0.3*cos(q2))
"""
NO_WRAP = "t = 0.5*(atan2(y, x) - acos(w/hypot(x, y)))"
CANCELS = "u = sqrt(x)\nv = u**2 + y"
GROWS = "u = 1/x\nv = u*x + atan2(y, 1)"


def test_the_branch_of_a_circle_equation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, "x=0.1:0.4, y=-0.4:0.4", LINKS, "q1, q2")
    searched(problem)

    def other(store: Store, A, B, C):
        return store.make("implicit", (A, B, C), (1, "-"))

    # Its cosine and sine are no longer those that are wanted, so it is never taken for the angle.
    monkeypatch.setattr(circles, "realise", other)
    assert units(searched(problem).graph) != ["implicit", "implicit"]


def test_the_positive_coefficient_of_an_arc_cosine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, "x=-0.9:0.9", "t = atan2(-sqrt(1 - x**2), x)", "t")
    assert units(searched(problem).graph) == ["implicit"]
    monkeypatch.setattr(circles.Store, "range", lambda store, value: None)
    monkeypatch.setattr(
        circles, "realise", lambda store, A, B, C: store.make("implicit", (A, B, C), (1, "+"))
    )
    same_where(problem, searched(problem).graph, {"x": [-1.0, 0.0, 1.0]})


def test_the_sign_of_a_common_denominator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, BOX, SIGNS, "t, s")
    searched(problem)
    monkeypatch.setattr(common_denominators.Store, "sign", lambda store, value: 1)
    with pytest.raises(AssertionError):
        searched(problem)


def test_the_sign_of_a_square_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, BOX, "t = sqrt(x**2*y**4 + x**2)\nu = x*sqrt(y**4 + 1)", "t, u")
    searched(problem)
    monkeypatch.setattr(Store, "poly_sign", lambda store, poly: 1)
    with pytest.raises(AssertionError, match="rewriting changed"):
        searched(problem)


@pytest.mark.parametrize(("equations", "edge"), [(CANCELS, -1.0), (GROWS, 0.0)])
def test_conditions_of_what_cancels(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, equations: str, edge: float
) -> None:
    problem = problem_of(tmp_path, "x=-2:2, y=0:1", equations, "v")
    samples = {"x": [edge, 1.0], "y": [0.5, 0.5]}
    same_where(problem, searched(problem).graph, samples)
    monkeypatch.setattr(realisations, "requirements", lambda *given: [])
    with pytest.raises(AssertionError):
        same_where(problem, searched(problem).graph, samples)


def test_wraps_where_the_value_itself_is_wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, w=-0.1:0.1", NO_WRAP, "t")
    searched(problem)
    monkeypatch.setattr(options, "INSIDE", 100.0)
    with pytest.raises(AssertionError, match="rewriting changed"):
        searched(problem)


def test_a_root_stays_apart_from_its_negative(monkeypatch: pytest.MonkeyPatch) -> None:
    made = field.Field(2, 0, 2)
    x = made.generator(made.free())
    root = made.root(x)
    assert made.add(root, root).key != made.number(0).key
    monkeypatch.setattr(field, "square_root_of", abs)
    assert made.root(-x).key == root.key, "without the check of the ratio, sqrt(-x) is taken for sqrt(x)"


def test_a_vector_that_may_vanish_takes_no_circle_equation(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "y=-1:1, w=0:1", "t = atan2(y*sqrt(w), 1)", "t")
    graph = searched(problem).graph
    same_where(problem, graph, {"y": [0.0, 0.0, 1.0], "w": [0.0, 1.0, 0.0]})


def test_a_multiple_of_another_value(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    equations = "u = (x + y)**2\nv = 3*x**2 + 6*x*y + 3*y**2 + 5"
    problem = problem_of(tmp_path, "x=1:2, y=1:2", equations, "u, v")
    graph = searched(problem).graph
    assert multipliers(graph) == 1
    affine = Store.affine

    def without_constant(store: Store, poly):
        found = affine(store, poly)
        return None if found is None else (found[0], found[1], 0 * found[2])

    monkeypatch.setattr(Store, "affine", without_constant)
    with pytest.raises(AssertionError):
        searched(problem)
