"""Roots that may be small: on fixed point lengths take the place of sums of squares, validity stays."""

from pathlib import Path

import numpy as np
import pytest

from cordicc.ir.graph import Graph
from cordicc.ir.text import parse_graph
from cordicc.pipeline import most_accurate, rewrite
from cordicc.rewrite.accuracy_gate import AccuracyGate
from cordicc.rewrite.search.costs import Costs
from cordicc.targets.target_file import load_target
from tests.support.rewriting import KINEMATIC, multipliers, problem_of, same_where, units
from tests.support.selection import quick

FIXED = load_target("fixed24")
WORDS = Costs.of(FIXED, implicit=True).words
BOX = "x=-1:1, y=-1:1, z=-1:1"
POINTS = {
    "x": [0.0, 0.0, 1e-6, 0.5, -1.0, 0.0],
    "y": [0.0, 0.0, -1e-6, 0.25, 1.0, 0.0],
    "z": [0.0, 1e-7, 0.0, -0.5, 1.0, -1.0],
    "w": [0.0, 0.5, 1e-3, 1.0, 0.25, 0.0],
}

FORMS = {
    # name: inputs, equations, units on fixed24, multipliers there
    "squares": (BOX, "v = sqrt(x**2 + y**2 + z**2)", ["vector"] * 2, 0),
    "products": (BOX, "v = (x*x + (z*z + y*y))**0.5", ["vector"] * 2, 0),
    "chain": (BOX, "v = hypot(hypot(x, y), z)", ["vector"] * 2, 0),
    "square of a length": (BOX, "h = hypot(x, y)\nv = sqrt(h**2 + z**2)", ["vector"] * 2, 0),
    "never negative": (BOX, "v = sqrt(max(x**2 + y**2 + z**2, 0))", ["vector"] * 2, 0),
    "absolute value": (BOX, "v = sqrt(abs(x**2 + y**2 + z**2))", ["vector"] * 2, 0),
    "factors": (BOX, "v = sqrt(2*x**2 + y**2/3 + z**2)", ["vector"] * 2, 0),
    "differences": (BOX, "v = sqrt((x - 0.1)**2 + (y + z)**2 + (z + 0.2)**2/4)", ["vector"] * 2, 0),
    "less a square": (BOX, "v = sqrt(x**2 + y**2 - z**2/100)", ["vector"] * 2, 0),
    "weight": (f"{BOX}, w=0:1", "v = sqrt(x**2 + w*y**2)", ["lightcone", "vector"], 1),
    "weights": (
        "x=-1.5:1.5, y=-1.5:1.5, z=-90 deg:90 deg, w=-90 deg:90 deg",
        "v = sqrt(sin(x)**2 + cos(z)*cos(w)*sin(y)**2)",
        ["lightcone", "rotate", "rotate", "rotate", "rotate", "vector"],
        0,
    ),
    "angle": (f"{BOX}, w=-1:1", "v = atan2(sqrt(x**2 + y**2 + z**2), w)", ["vector"] * 3, 0),
    "multiplied out": (BOX, "v = sqrt(x**2 - 0.2*x + 0.01 + y**2 + 2*y*z + z**2)", ["vector"], 0),
    "law of cosines": (BOX, "v = sqrt(x**2 + y**2 - 2*x*y*cos(z))", ["rotate", "vector"], 0),
    "sine in disguise": (BOX, "v = sqrt(1 - cos(x)**2 + y**2 + z**2)", ["rotate", "vector", "vector"], 0),
    "chord": (BOX, "v = sqrt(2 - 2*cos(x))", ["rotate", "vector"], 0),
    "away from 0": ("x=0.5:1, y=0.5:1, z=0.5:1", "v = sqrt(x**2 + y**2 + z**2)", ["implicit"], 2),
}


QUICK = ("squares", "square of a length", "never negative", "weights", "law of cosines", "chord")


@pytest.mark.parametrize("name", quick(FORMS, *QUICK))
def test_small_roots_are_lengths_on_fixed_point(name: str, tmp_path: Path) -> None:
    inputs, equations, wanted, products = FORMS[name]
    names = [item.split("=")[0].strip() for item in inputs.split(",")]
    used = ", ".join(i for i, n in zip(inputs.split(","), names, strict=True) if n in equations)
    problem = problem_of(tmp_path, used, equations, "v")
    choice = rewrite(problem, FIXED, implicit=True, goal="processors")
    assert units(choice.graph) == wanted
    assert multipliers(choice.graph) == products
    if name not in ("away from 0", "less a square"):
        same_where(problem, choice.graph, {n: POINTS[n] for n in names if n in equations})


def test_where_numbers_have_exponents_the_sum_of_squares_stays(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, BOX, "v = sqrt(x**2 + y**2 + z**2)", "v")
    choice = rewrite(problem, KINEMATIC, implicit=True, goal="processors")
    assert units(choice.graph) == ["lightcone"]


def test_a_length_that_is_there_is_taken_for_the_longer_one(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, BOX, "r = hypot(z, x)\nv = sqrt(x**2 + y**2 + z**2)", "r, v")
    choice = rewrite(problem, KINEMATIC, implicit=True, goal="processors")
    assert units(choice.graph) == ["vector", "vector"]
    assert multipliers(choice.graph) == 0


@pytest.mark.parametrize("target", [KINEMATIC, FIXED], ids=lambda target: target.name)
def test_the_most_accurate_realisation_takes_no_sum_of_squares(target, tmp_path: Path) -> None:
    inputs, equations, _, _ = FORMS["away from 0"]
    problem = problem_of(tmp_path, inputs, equations, "v")
    accurate = most_accurate(problem, target, implicit=True, goal="processors")
    assert units(accurate.graph) == ["vector", "vector"]


def test_the_factor_of_a_small_quotient_is_divided(tmp_path: Path) -> None:
    """(a x)/v with a and x small and v as small has no digits where a (x/v) has all."""
    equations = "v = hypot(x, y)\na = atan2(v, w)\nu = a*x/v"
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1, w=1:2", equations, "u")
    choice = rewrite(problem, FIXED, implicit=True, goal="processors")
    made = choice.graph
    divided = [node.operands[1] for node in made.nodes if node.op == "vector" and node.m == 0]
    assert all(made.node(value).op != "mul" for value in divided)
    same_where(problem, made, {n: POINTS[n] for n in ("x", "y")} | {"w": [1.0] * 6})


CHAIN = """
%0 = input[name=x]
%1 = input[name=y]
%2 = const[value=0]
%3:2 = vector[m=1, sign=1](%0, %1, %2)
output v = %3#0
"""
SUM = """
%0 = input[name=x]
%1 = input[name=y]
%2 = const[value=1]
%3 = mul(%0, %0)
%4 = mul(%1, %1)
%5 = add(%3, %4)
%6:2 = lightcone(%5, %2)
output v = %6#0
"""


def graph_of(text: str) -> Graph:
    return parse_graph(text.lstrip(), "test")


@pytest.mark.parametrize(("least", "accurate"), [(0.5, True), (1e-4, False)])
def test_the_gate_knows_the_words_of_fixed_point(least: float, *, accurate: bool, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1", "v = hypot(x, y)", "v")
    sizes = np.geomspace(least, 1, 60)
    points = {"x": 0.8 * sizes, "y": 0.6 * sizes}
    gate = AccuracyGate(problem, graph_of(CHAIN), points, words=WORDS)
    assert gate.judged(graph_of(CHAIN)).inaccurate is None
    assert (gate.judged(graph_of(SUM)).inaccurate is None) == accurate
    floating = AccuracyGate(problem, graph_of(CHAIN), points)
    assert floating.judged(graph_of(SUM)).inaccurate is None


def test_a_weight_keeps_its_sign_however_it_is_rounded(tmp_path: Path) -> None:
    """A cosine of up to 90 deg may come out a little below 0; one that is given may not."""
    weighted = "v = sqrt(x**2 + {}*y**2)"
    found = []
    for weight, ranges in (("cos(z)", "z=-90 deg:90 deg"), ("z", "z=0:1")):
        problem = problem_of(tmp_path, f"x=-1:1, y=-1:1, {ranges}", weighted.format(weight), "v")
        made = most_accurate(problem, FIXED, implicit=True, goal="processors").graph
        found.append(sum(node.op == "abs" for node in made.nodes))
    assert found == [1, 0]
