"""Each mechanism of the search saves what it should, keeps the meaning, and keeps who is valid."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cordicc.frontend.load import load_problem
from cordicc.ir.graph import Builder, Value
from cordicc.ir.problem import input_intervals
from cordicc.rewrite.accuracy_gate import AccuracyGate
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.search.costs import Costs
from cordicc.rewrite.search.realisations import Realisations
from cordicc.targets.target_file import load_target
from tests.support.rewriting import certain, multipliers, problem_of, same_where, searched, units
from tests.support.selection import slow

TWO_LINKS = """
D = (x**2 + y**2 - 0.18)/0.18
q2 = acos(D)
q1 = atan2(y, x) - atan2(0.3*sin(q2), 0.3 + 0.3*cos(q2))
"""
COSTS = Costs.of(load_target("kinematic"), implicit=True)
EDGE = {"x": [0.0, 0.6, 0.0, 0.61, 0.2], "y": [0.0, 0.0, 0.6, 0.0, -0.3]}


def test_each_angle_by_its_own_circle_equation(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-0.5:0.5, y=-0.5:0.5", TWO_LINKS, "q1, q2")
    choice = searched(problem)
    assert units(choice.graph) == ["implicit", "implicit"]
    assert choice.proven
    same_where(problem, choice.graph, EDGE)
    assert any("q1" in step and "w" in step for steps in choice.steps.values() for step in steps)


def test_half_angle_form_is_one_implicit_unit(tmp_path: Path) -> None:
    equations = """
r = sqrt(x**2 + y**2 - w**2)
t = 2*atan((y - r)/(x + w))
"""
    problem = problem_of(tmp_path, "x=1:2, y=-1:1, w=-0.9:0.9", equations, "t")
    assert units(searched(problem).graph) == ["implicit"]


@pytest.mark.parametrize("sign", ["+", "-"])
def test_arc_tangent_and_arc_cosine_of_a_quotient(tmp_path: Path, sign: str) -> None:
    problem = problem_of(
        tmp_path, "x=-2:2, y=-2:2, w=-1:1", f"t = atan2(y, x) {sign} acos(w/hypot(x, y))", "t"
    )
    choice = searched(problem)
    assert units(choice.graph) == ["implicit"]
    same_where(problem, choice.graph, {"x": [0.0, 0.0, 1.0], "y": [0.0, 1.0, 0.5], "w": [0.5, 1.0, 1.0]})


@pytest.mark.parametrize("sign", ["+", "-"])
def test_arc_tangent_and_root_over_the_third_coefficient(tmp_path: Path, sign: str) -> None:
    equation = f"t = atan2(y, x) {sign} atan2(sqrt(x**2 + y**2 - w**2), w)"
    problem = problem_of(tmp_path, "x=1:2, y=-2:2, w=-0.9:0.9", equation, "t")
    assert units(searched(problem).graph) == ["implicit"]


def test_arc_sine_minus_angle(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=1:2, y=-2:2, w=-0.9:0.9", "t = asin(w/hypot(x, y)) - atan2(y, x)", "t")
    assert units(searched(problem).graph) == ["implicit"]


def test_second_result_stands_for_a_root(tmp_path: Path) -> None:
    equations = "p = asin((0.3*sin(t) - 0.1)/0.9)\ns = 0.3*cos(t) + 0.9*cos(p)"
    problem = problem_of(tmp_path, "t=-3:3", equations, "p, s")
    assert units(searched(problem).graph) == ["implicit", "rotate"]


def test_second_result_of_the_hyperbolic_unit(tmp_path: Path) -> None:
    equations = "u = asinh(x/2)\nc = 2*cosh(u)"
    problem = problem_of(tmp_path, "x=-2:2", equations, "u, c")
    assert len(units(searched(problem).graph)) == 1


def test_homogeneous_scaling_replaces_rotations(tmp_path: Path) -> None:
    equations = "q = atan2(y, x)\nt = atan2(v*cos(q) - w*sin(q), w*cos(q) + v*sin(q) + 1)"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, v=-1:1, w=-1:1", equations, "q, t")
    choice = searched(problem)
    assert units(choice.graph) == ["vector", "vector"]
    zeros = {"x": [0.0, 0.0, 1.0], "y": [0.0, 1.0, 0.0], "v": [1.0, 0.0, 0.0], "w": [0.0, 0.0, -1.0]}
    same_where(problem, choice.graph, zeros)


def test_a_denominator_of_unknown_sign_gives_its_sign(tmp_path: Path) -> None:
    equations = "t = atan2(x/w + 1, y/w)\ns = atan(x/(w + y))"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, w=-2:2", equations, "t, s")
    choice = searched(problem)
    assert units(choice.graph) == ["vector", "vector"]
    same_where(problem, choice.graph, {"x": [1.0, 1.0, 0.0], "y": [1.0, 1.0, 0.0], "w": [0.0, -1.0, -2.0]})


def test_tangents_leave_their_quotients(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=0.1:1", "r = 2/tan(x)\nt = atan(2/(r + 0.5))", "t")
    assert units(searched(problem).graph) == ["rotate", "vector"]


def test_angle_of_a_rotated_vector_is_a_sum(tmp_path: Path) -> None:
    equations = "q = atan2(y, x)\nt = atan2(y*cos(w) + x*sin(w), x*cos(w) - y*sin(w))"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, w=-3:3", equations, "q, t")
    choice = searched(problem)
    assert units(choice.graph) == ["vector"]
    same_where(problem, choice.graph, {"x": [0.0, -1.0], "y": [0.0, 0.0], "w": [1.0, 3.0]})


def test_quarter_turns_and_signs_in_sums(tmp_path: Path) -> None:
    equations = "q = atan2(y, x)\nt = atan2(cos(q)*cos(w) + sin(q)*sin(w), sin(q)*cos(w) - cos(q)*sin(w))"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, w=-3:3", equations, "q, t")
    assert units(searched(problem).graph) == ["vector"]


def test_inverse_functions_that_cancel(tmp_path: Path) -> None:
    equations = "t = atan2(sin(x), cos(x))\nu = 3*asinh(sinh(x/3))\nv = cosh(x/3)"
    problem = problem_of(tmp_path, "x=-3:3", equations, "t, u, v")
    assert units(searched(problem).graph) == ["rotate"]


def test_a_rounded_constant_is_what_it_stands_for(tmp_path: Path) -> None:
    equations = "a = sin(x)\nb = cos(x + 0.3)\nt = atan2(a, (b + a*sin(0.3))/cos(0.3))"
    problem = problem_of(tmp_path, "x=-3:3", equations, "t")
    assert units(searched(problem).graph) == []


def test_products_with_three_and_with_two_multipliers(tmp_path: Path) -> None:
    circular = "c = cos(w)\ns = sin(w)\np = x*c - y*s\nq = y*c + x*s\nk = y*c - x*s\nl = x*c + y*s"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, w=-3:3", circular, "p, q, k, l")
    assert multipliers(searched(problem).graph) == 4  # four products serve both senses
    hyperbolic = "c = cosh(w)\ns = sinh(w)\np = x*c - y*s\nq = y*c - x*s\nb = s/c"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, w=-1:1", hyperbolic, "p, q, b")
    assert multipliers(searched(problem).graph) == 2


def test_squares_are_shared(tmp_path: Path) -> None:
    equations = "f = sqrt((x + 1)**2 + (y - 1)**2 + 9)\ng = sqrt((x - 3)**2 + (y + 1)**2 + 9)"
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2", equations, "f, g")
    assert multipliers(certain(problem)) == 4
    assert multipliers(searched(problem).graph) == 1


FACTS = "assume:\n  - x**2 + y**2 + w**2 = 1\nsamples: rows.csv"


def test_facts_about_the_inputs(tmp_path: Path) -> None:
    generator = np.random.default_rng(1)
    rows = generator.normal(size=(60, 3))
    rows[:, 2] = np.clip(rows[:, 2], -1, 1)
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    text = "x,y,w\n" + "\n".join(",".join(repr(float(v)) for v in row) for row in rows)
    (tmp_path / "rows.csv").write_text(text + "\n", encoding="utf-8")
    equations = "r = sqrt(x**2 + y**2)\nt = atan2(r, w)\nu = atan2(y, x)\nv = x*cos(t) - w*sin(t)"
    known = problem_of(tmp_path, "x=-1:1, y=-1:1, w=-1:1", equations, "t, u, v", FACTS)
    unknown = problem_of(tmp_path, "x=-1:1, y=-1:1, w=-1:1", equations, "t, u, v", "samples: rows.csv")
    choice = searched(known)
    assert len(units(choice.graph)) < len(units(searched(unknown).graph))
    assert choice.facts == (known.assumptions[0].text,)
    assert any("rests on the fact" in step for steps in choice.steps.values() for step in steps)


ROWS = "x,y\n" + "\n".join(f"{0.1 * i + 0.5},0.25" for i in range(40)) + "\n"
SIGNED = "assume:\n  - x > 0\n  - y <= 1\nsamples: rows.csv"


@pytest.mark.parametrize(
    ("equations", "outputs", "told"),
    [
        ("t = sqrt(x**2*y**4 + x**2)\nu = x*sqrt(y**4 + 1)", "t, u", ("x > 0",)),
        ("t = sqrt(x**2*(y + 3))\nu = x*sqrt(y + 3)", "t, u", ("x > 0",)),
        ("t = atan2(y/x, 1)", "t", ("x > 0",)),
        ("t = y*cos(x)", "t", ()),
    ],
)
def test_the_facts_that_are_used_are_told(
    tmp_path: Path, equations: str, outputs: str, told: tuple[str, ...]
) -> None:
    (tmp_path / "rows.csv").write_text(ROWS, encoding="utf-8")
    problem = problem_of(tmp_path, "x=-5:5, y=-2:2", equations, outputs, SIGNED)
    assert searched(problem).facts == told


def test_without_implicit_units_chains_are_counted(tmp_path: Path) -> None:
    equations = "t = atan2(y, x) - acos(w/hypot(x, y))"
    problem = problem_of(tmp_path, "x=1:2, y=1:2, w=-0.5:0.5", equations, "t")
    graph = searched(problem, implicit=False).graph
    assert units(graph) == ["vector", "vector", "vector"]


@pytest.mark.parametrize("goal", [slow("processors"), "latency", slow("area")])
def test_goals_come_first(tmp_path: Path, goal: str) -> None:
    from cordicc.rewrite.search.costs import Costs, of_graph
    from tests.support.rewriting import KINEMATIC

    equations = "q = atan2(y, x)\np = v*cos(q) - w*sin(q)\nt = atan2(p, w + x)"
    problem = problem_of(tmp_path, "x=1:2, y=-2:2, v=1:2, w=1:2", equations, "q, t")
    costs = Costs.of(KINEMATIC, implicit=True)
    reached = {
        g: of_graph(searched(problem, g).graph, costs, goal)[0] for g in ("processors", "latency", "area")
    }
    assert reached[goal] == min(reached.values())


@pytest.mark.exhaustive(reason="compiles hundreds of equations to see a limit of the search")
def test_hundreds_of_equations_keep_the_certain_realisation(tmp_path: Path) -> None:
    lines = [
        "q0 = atan2(y, x)",
        *(f"q{i} = atan2(sin(q{i - 1}) + x, cos(q{i - 1}) + y)" for i in range(1, 200)),
    ]
    problem = problem_of(tmp_path, "x=1:2, y=1:2", "\n".join(lines), "q199")
    choice = searched(problem)
    assert not choice.searched
    assert choice.graph == certain(problem)


POINTS = {"x": np.linspace(1, 2, 50), "y": np.linspace(2, 1.01, 50)}


def test_rounding_decides_against_an_ill_conditioned_plan(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=1:2, y=1:2", "t = x - y\ns = x + y", "t, s")
    bad = problem_of(tmp_path, "x=1:2, y=1:2", "t = (x*10000 + x) - (y + x*10000)\ns = x + y", "t, s")
    gate = AccuracyGate(problem, certain(problem), POINTS)
    assert gate.judged(certain(problem)).inaccurate is None
    builder = Builder()
    x, y = builder.input("x"), builder.input("y")
    large = builder.emit("add", (builder.emit("mul", (x, builder.const(10000))), builder.const(0)))
    sums = builder.emit("add", (large, x)), builder.emit("add", (large, y))
    graph = builder.build({"t": builder.emit("sub", sums), "s": builder.emit("add", (x, y))})
    output, sample = gate.judged(graph).inaccurate or ("", 0)
    assert output == "t"
    blamed = gate.culprit(graph, output, sample, {Value(i, 0) for i in range(2, len(graph.nodes))})
    assert blamed in sums
    assert gate.culprit(graph, output, sample, {sums[1]}) == sums[1]
    assert gate.culprit(graph, output, sample, ()) is None
    assert gate.culprit(graph, "s", sample, set(sums)) is None, "they do not move this output"
    assert units(certain(bad)) == []


def test_the_gate_takes_an_output_that_is_0(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=1:2, y=1:2", "t = x - y\ns = x + y", "t, s")
    zero, rounded = (Builder() for _ in range(2))
    x, y = zero.input("x"), zero.input("y")
    nothing = zero.build({"t": zero.emit("sub", (x, x)), "s": zero.emit("add", (x, y))})
    gate = AccuracyGate(problem, nothing, POINTS)
    assert gate.judged(nothing).inaccurate is None
    x, y = rounded.input("x"), rounded.input("y")
    third = rounded.emit("cmul", (x,), (Fraction(1, 3),))
    rest = rounded.emit("sub", (x, rounded.emit("cmul", (third,), (Fraction(3),))))
    assert gate.judged(rounded.build({"t": rest, "s": rounded.emit("add", (x, y))})).inaccurate


@pytest.mark.parametrize(
    "file",
    [
        # The culprit is a rotation that the realisation of the passes needs.
        """
inputs: {x: [0.1, 1.5], y: [0.2, 2], z: [-1, 1]}
equations:
  - e0 = cos(z + z)
  - e1 = e0*sin(z) + z*cos(e0)
  - e2 = cos(e1 + y)
  - e3 = atan2(e1*e1, e2)
outputs: [e3, e0]
""",
        # The cosine of an angle is looked at again once a part of it has become a generator.
        """
inputs: {x: [-1, 1], y: [-2, 2], z: [0.5, 0.7]}
equations:
  - e0 = z*cos(z) - x*sin(x)
  - e1 = e0/x
  - e2 = e0*sin(e1) + e0*cos(e0)
  - e3 = sqrt(e2*e0 - 0.1*e1)
outputs: [e1, e2, e3]
""",
    ],
)
def test_the_search_ends_with_a_plan(tmp_path: Path, file: str) -> None:
    (tmp_path / "p.yaml").write_text(file, encoding="utf-8")
    problem = load_problem(tmp_path / "p.yaml").problem
    same_where(problem, searched(problem).graph, {"x": [0.5], "y": [1.0], "z": [0.6]})


def test_a_ban_leaves_what_the_first_realisation_needs(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-0.5:0.5, y=-0.5:0.5", TWO_LINKS, "q1, q2")
    realisations = Realisations(problem, PassContext(input_intervals(problem)), [certain(problem)], COSTS)
    tried = []
    while (found := realisations.best()) is not None:
        tried.append(found)
        for value in realisations.may_be_banned(found):
            realisations.ban(found, value)
    assert len(tried) == 5
    assert not any(found.proven for found in tried[1:])
    same_where(problem, tried[-1].graph, EDGE)


def test_a_banned_result_is_made_by_something_else(tmp_path: Path) -> None:
    """The radius as the second result of an equation is not taken again once it is banned."""
    equations = "p = asin((0.3*sin(t) - 0.1)/0.9)\ns = 0.3*cos(t) + 0.9*cos(p)"
    problem = problem_of(tmp_path, "t=-3:3", equations, "p, s")
    realisations = Realisations(problem, PassContext(input_intervals(problem)), [certain(problem)], COSTS)
    first = realisations.best()
    (equation,) = (i for i, node in enumerate(first.graph.nodes) if node.op == "implicit")
    assert Value(equation, 1) in first.graph.used_results()
    realisations.ban(first, Value(equation, 1))
    second = realisations.best()
    for index, node in enumerate(second.graph.nodes):
        assert node.op != "implicit" or Value(index, 1) not in second.graph.used_results()
    same_where(problem, second.graph, {"t": [0.0, 1.0]})


def test_on_fixed_point_words_decide(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1, z=-1:1", "r = sqrt(x**2 + y**2 + z**2)", "r")
    builder = Builder()
    x, y, z = (builder.input(name) for name in "xyz")
    zero = builder.const(0)
    flat = builder.emit("vector", (x, y, zero), (1, 1))
    chain = builder.build({"r": builder.emit("vector", (flat, z, zero), (1, 1))})
    sizes = np.geomspace(1e-4, 1.0, 40)
    points = {"x": sizes, "y": -0.5 * sizes, "z": 0.25 * sizes}
    words = Costs.of(load_target("fixed24"), implicit=True).words
    squares = certain(problem)
    assert "mul" in {node.op for node in squares.nodes}
    gate = AccuracyGate(problem, squares, points, words=words, coarsest=words)
    assert (gate.judged(squares).inaccurate or ("", 1)) == ("r", 0), (
        "squares of small numbers have few digits"
    )
    assert gate.judged(chain).inaccurate is None
    assert AccuracyGate(problem, squares, points).judged(squares).inaccurate is None


def test_a_part_is_a_known_value_with_its_factor_and_constant(tmp_path: Path) -> None:
    """What is known is -r + x, and the polynomial p + (r - x)."""
    equations = """
r = sqrt(x)
w = atan2((x**2 - 2*x**3)/(x**2 - x**2*r), (2*x*x - x*r)/(x**2 - x**2*r))
"""
    problem = problem_of(tmp_path, "x=0.1:3", equations, "w")
    same_where(
        problem, searched(problem).graph, {"x": [0.2674894474032574, 0.3, 0.9, 1.1, 2.7523184816296764]}
    )
