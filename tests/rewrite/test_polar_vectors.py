"""Norms and angles in rotations and quotients: the vector itself is turned, and conditions are kept."""

from pathlib import Path

import pytest

from cordicc.ir.graph import Graph
from cordicc.rewrite.search.costs import of_graph
from tests.support.rewriting import KINEMATIC, Costs, multipliers, problem_of, same_where, searched, units

BOX = "x=-0.3:0.3, y=-0.3:0.3, c=-3:3"
AWAY = "x=0.1:0.3, y=-0.3:0.3, c=-3:3"
SHARES = "x=-1:1, y=-1:1, a=-1:1, b=-1:1"
POINTS = {
    "x": [0.0, 0.0, 0.3, -0.2, 0.0],
    "y": [0.0, 0.3, 0.0, 0.1, -0.1],
    "c": [1.0, 0.0, -3.0, 2.0, 0.5],
    "a": [0.5, -1.0, 0.0, 1.0, 0.25],
    "b": [-0.5, 0.0, 1.0, 1.0, 0.75],
}


def guards(graph: Graph) -> int:
    return sum(node.op == "guard" for node in graph.nodes)


def points_of(inputs: str) -> dict[str, list[float]]:
    return {name: POINTS[name] for name in (item.split("=")[0].strip() for item in inputs.split(","))}


@pytest.mark.parametrize(
    ("equations", "outputs"),
    [
        ("u = hypot(x, y)*cos(atan2(y, x) - c)\nv = hypot(x, y)*sin(atan2(y, x) - c)", "u, v"),
        ("u = sqrt(x**2 + y**2)*sin(c - atan2(y, x))", "u"),
        ("t = atan2(x, -y) + 0.3\nu = 2*hypot(y, x)*cos(t + c)\nv = 2*hypot(y, x)*sin(t + c)", "u, v"),
        (
            "r = hypot(x, y)\nt = atan2(y, x)\nu = r*cos(t)*cos(c) + r*sin(t)*sin(c)\n"
            "v = r*sin(t)*cos(c) - r*cos(t)*sin(c)",
            "u, v",
        ),
        ("u = x*cos(c) + y*sin(c)\nv = y*cos(c) - x*sin(c)", "u, v"),
    ],
    ids=["offset", "mirrored", "components exchanged", "angle of the norm", "plain"],
)
def test_a_norm_turned_by_its_angle_is_one_rotation(equations: str, outputs: str, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, BOX, equations, outputs)
    choice = searched(problem)
    assert units(choice.graph) == ["rotate"]
    assert multipliers(choice.graph) == 0
    # (0, 0) has no angle, where one is written: one guard says so, beside the rotation.
    assert guards(choice.graph) == ("atan2" in equations)
    latency = of_graph(choice.graph, Costs.of(KINEMATIC, implicit=True), "latency")[0]
    assert latency == KINEMATIC.units["standard"].latency or "0.3" in equations
    same_where(problem, choice.graph, points_of(BOX))


def test_no_guard_where_the_vector_is_never_0(tmp_path: Path) -> None:
    equations = "u = hypot(x, y)*cos(atan2(y, x) - c)\nv = hypot(x, y)*sin(atan2(y, x) - c)"
    choice = searched(problem_of(tmp_path, AWAY, equations, "u, v"))
    assert units(choice.graph) == ["rotate"]
    assert guards(choice.graph) == 0


def test_a_norm_turned_by_its_angle_alone_is_a_component(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1", "u = hypot(x, y)*cos(atan2(y, x))", "u")
    choice = searched(problem)
    assert units(choice.graph) == []
    same_where(problem, choice.graph, points_of("x=, y="))


def test_a_multiple_of_the_norm_takes_two_products(tmp_path: Path) -> None:
    equations = "u = a*hypot(x, y)*cos(atan2(y, x) - b)\nv = a*hypot(x, y)*sin(atan2(y, x) - b)"
    problem = problem_of(tmp_path, SHARES, equations, "u, v")
    choice = searched(problem)
    assert (units(choice.graph), multipliers(choice.graph)) == (["rotate"], 2)
    same_where(problem, choice.graph, points_of(SHARES))


@pytest.mark.parametrize(
    ("equations", "outputs"),
    [
        ("u = a*x/hypot(x, y)\nv = a*y/hypot(x, y)", "u, v"),
        ("u = a*(x/sqrt(y**2 + x**2))", "u"),
        ("i = 1/hypot(x, y)\nu = -2*x*a*i\nv = y*i*a", "u, v"),
        ("u = x*(a/hypot(x, y))\nv = y*(a/hypot(x, y))", "u, v"),
        ("u = (a*x + b*y)/hypot(x, y)\nv = (b*x - a*y)/hypot(x, y)", "u, v"),
        ("u = 3*a*x/hypot(3*x, y)\nv = a*y/hypot(3*x, y)", "u, v"),
    ],
    ids=["pair", "one", "reciprocal", "quotient first", "sums", "with a factor"],
)
def test_multiples_of_a_vector_by_its_norm_are_one_rotation(
    equations: str, outputs: str, tmp_path: Path
) -> None:
    names = "x=-1:1, y=-1:1, a=-1:1" + (", b=-1:1" if "b*" in equations else "")
    problem = problem_of(tmp_path, names, equations, outputs)
    choice = searched(problem)
    assert units(choice.graph) == ["rotate", "vector"]
    assert multipliers(choice.graph) == 0
    assert guards(choice.graph) == 0, "the vectoring itself refuses (0, 0)"
    same_where(problem, choice.graph, points_of(names))


def test_factors_that_are_divided_alike_share_a_quotient(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1, a=-1:1, b=-1:1", "u = a*x/b\nv = a*y/b", "u, v")
    choice = searched(problem)
    assert (units(choice.graph), multipliers(choice.graph)) == (["vector"], 2)
    assert guards(choice.graph) == 0, "any quotient by b refuses b = 0"
    same_where(problem, choice.graph, points_of("x=, y=, a=, b="))


def test_the_norm_of_a_vector_does_not_stand_for_its_angle(tmp_path: Path) -> None:
    """The norm, which is taken, has a value at (0, 0), and the angle, which no longer is, has none."""
    equations = "r = hypot(hypot(x, y), a)\nu = hypot(x, y)*sin(c - atan2(x, y))"
    names = f"{BOX}, a=-1:1"
    problem = problem_of(tmp_path, names, equations, "r, u")
    choice = searched(problem)
    assert units(choice.graph).count("rotate") == 1
    same_where(problem, choice.graph, points_of(names))


def test_two_conditions_on_one_value_are_one_guard(tmp_path: Path) -> None:
    problem = problem_of(
        tmp_path, "x=-1:1, a=-1:1, b=-1:1", "u = a*(x/x)\nv = b*(x/x)\nw = x*(a/x)", "u, v, w"
    )
    graph = searched(problem).graph
    assert units(graph) == []
    assert guards(graph) == 1
    same_where(problem, graph, points_of("x=, a=, b="))
