"""Other ways to an angle and from it: what they save, who stays valid, and that broken rules show."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cordicc.ir.graph import Value
from cordicc.ir.meaning.doubles import Results, all_results
from cordicc.rewrite.rules import circles, common_denominators, offsets, synthesis, vector_sums
from cordicc.rewrite.rules.principal_values import PRINCIPAL_VALUES
from cordicc.rewrite.rules.rule import Given
from cordicc.rewrite.search import start
from tests.support.rewriting import multipliers, problem_of, same_where, searched, units
from tests.support.stores import store_of_inputs

Patch = pytest.MonkeyPatch


def test_a_principal_value_as_a_vectoring(tmp_path: Path) -> None:
    equations = "r = sqrt(x**2 + y**2 + w**2)\ne = asin(w/r)\nz = acos(w/r)\na = atan2(y, x)"
    problem = problem_of(tmp_path, "x=-1:1, y=-1:1, w=-1:1", equations, "r, e, a")
    choice = searched(problem)
    assert units(choice.graph) == ["vector", "vector"]
    same_where(problem, choice.graph, {"x": [0.0, 0.5, -1.0], "y": [0.0, 0.0, 0.0], "w": [0.0, 0.5, 1.0]})


@pytest.mark.parametrize(("branch", "zero"), [("+", 0), ("-", 1)])
def test_principal_values_are_equal_and_not_only_modulo(branch: str, zero: int) -> None:
    made, given = store_of_inputs()
    size = made.make("abs", (given["x"],))[0]
    coefficients = [size, size]
    coefficients[zero] = made.const(0)
    unit = made.make("implicit", (*coefficients, given["c"]), (1, branch))
    before = len(made.algebra.nodes)
    PRINCIPAL_VALUES.run(Given(made))
    index = next(i for i in range(before, len(made.algebra.nodes)) if made.algebra.nodes[i].op == "vector")
    assert made.find(Value(index, 1)) == made.find(unit[0])
    np.testing.assert_allclose(made.numbers(Value(index, 1)), made.numbers(unit[0]), atol=1e-12)
    np.testing.assert_allclose(made.numbers(Value(index, 0)), made.numbers(size), rtol=1e-12)


@pytest.mark.parametrize(("branch", "zero"), [("-", 0), ("+", 1)])
def test_other_branches_are_no_principal_values(branch: str, zero: int) -> None:
    made, given = store_of_inputs()
    coefficients = [made.make("abs", (given["x"],))[0]] * 2
    coefficients[zero] = made.const(0)
    made.make("implicit", (*coefficients, given["c"]), (1, branch))
    before = len(made.algebra.nodes)
    PRINCIPAL_VALUES.run(Given(made))
    assert len(made.algebra.nodes) == before


def test_a_unit_vector_is_one_rotation(tmp_path: Path) -> None:
    equations = "n = hypot(x, y)\nu = x/n\nv = y/n"
    problem = problem_of(tmp_path, "x=0.2:2, y=0.2:2", equations, "n, u, v")
    choice = searched(problem)
    assert units(choice.graph) == ["rotate", "vector"]
    same_where(problem, choice.graph, {"x": [0.2, 1.0, 2.0], "y": [1.0, 0.2, 2.0]})


@pytest.mark.parametrize("equation", ["sin(t - pi/3)", "cos(0.4 - t)", "sin(1.1 - t)", "cos(t + 2)"])
def test_a_constant_offset_takes_no_rotation(tmp_path: Path, equation: str) -> None:
    problem = problem_of(
        tmp_path, "t=-3:3, k=0.1:1", f"a = k*{equation}\nb = k*sin(t)\nc = k*cos(t)", "a, b, c"
    )
    assert units(searched(problem).graph) == ["rotate"]


def test_the_direction_of_an_offset(tmp_path: Path, monkeypatch: Patch) -> None:
    problem = problem_of(tmp_path, "t=-3:3", "a = sin(t - 0.4)\nb = sin(t)", "a, b")
    searched(problem)
    sine = offsets.fold

    def other(op, params, operands):
        return -sine(op, params, operands) if op == "sin" else sine(op, params, operands)

    monkeypatch.setattr(offsets, "fold", other)
    with pytest.raises(AssertionError):
        searched(problem)


@pytest.mark.parametrize("sign", ["+", "-"])
def test_sum_of_the_angles_of_two_vectors(tmp_path: Path, sign: str) -> None:
    problem = problem_of(
        tmp_path, "x=-2:2, y=-2:2, u=-2:2, v=-2:2", f"t = atan2(y, x) {sign} atan2(v, u)", "t"
    )
    choice = searched(problem)
    assert units(choice.graph) == ["vector"]
    assert multipliers(choice.graph) == 3
    zeros = {"x": [0.0, 1.0, -1.0], "y": [0.0, 0.0, 0.0], "u": [1.0, 0.0, -1.0], "v": [0.0, 0.0, 0.5]}
    same_where(problem, choice.graph, zeros)


def test_the_sense_of_a_difference(tmp_path: Path, monkeypatch: Patch) -> None:
    problem = problem_of(tmp_path, "x=-2:2, y=-2:2, u=-2:2, v=-2:2", "t = atan2(y, x) - atan2(v, u)", "t")
    turned = vector_sums.turned
    monkeypatch.setattr(
        vector_sums,
        "turned",
        lambda made, one, other: turned(made, one, (other[0], made.make("neg", (other[1],))[0])),
    )
    with pytest.raises(AssertionError, match="rewriting changed"):
        searched(problem)


def test_a_quotient_by_a_tangent_is_one_quotient(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=0.1:2, y=0.1:2, w=0.1:1", "t = w/tan(atan2(y, x))", "t")
    choice = searched(problem)
    assert units(choice.graph) == ["vector"]
    same_where(problem, choice.graph, {"x": [0.1, 2.0], "y": [2.0, 0.1], "w": [0.5, 0.1]})


def test_an_angle_and_its_double_share_a_rotation(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "t=-3:3", "a = cos(t)\nb = sin(t/2)\nc = sin(3*t/2)", "a, b, c")
    assert units(searched(problem).graph) == ["rotate"]


@pytest.mark.parametrize(
    "equations", ["r = 1.4*cosh(h) - 1\nn = tanh(h/2)", "r = 1.01 - cos(h)\nn = sin(h/2)"]
)
def test_squares_of_half_angles_cancel_no_digits(tmp_path: Path, monkeypatch: Patch, equations: str) -> None:
    """2 e cosh^2 - (e + 1) would; (e - 1) + 2 e sinh^2 does not, nor 0.01 + 2 sin^2."""
    problem = problem_of(tmp_path, "h=-1:1", equations, "r, n")
    inputs = {"h": np.linspace(-1, 1, 401)}

    def moved() -> float:
        graph = searched(problem).graph
        output = graph.outputs["r"]
        exact = all_results(graph, inputs)[output.node][output.result]
        noise = np.random.default_rng(3)

        def rounded(_: object, __: object, made: Results) -> Results:
            return tuple(x * (1 + noise.uniform(-1e-6, 1e-6, x.shape)) for x in made)

        tries = [all_results(graph, inputs, rounded)[output.node] for _ in range(8)]
        return float(np.max([np.abs(each[output.result] / exact - 1) for each in tries]))

    error = moved()
    monkeypatch.setattr(synthesis, "CANCELS", 1e9)
    assert error < 1e-5
    assert 2 * error < moved()


def test_the_law_of_cosines_in_the_frame_of_a_hip(tmp_path: Path) -> None:
    equations = """
g = atan2(y, x)
r = hypot(x, y) - 0.05
d = hypot(r, w)
a = atan2(w, r) + acos((0.004 + d**2 - 0.01)/(0.13*d))
b = acos((0.0144 - d**2)/0.0132)
"""
    problem = problem_of(tmp_path, "x=0.12:0.15, y=-0.05:0.05, w=-0.08:-0.04", equations, "g, a, b")
    choice = searched(problem)
    assert units(choice.graph) == ["implicit", "implicit", "vector"]
    far = {"x": [0.12, 0.15], "y": [0.0, 0.05], "w": [-0.04, -0.08]}
    same_where(problem, choice.graph, far)


def test_a_shorter_equation_is_the_same_equation(tmp_path: Path, monkeypatch: Patch) -> None:
    equations = "r = hypot(x, y) - 0.2\nt = atan2(w, r) + acos((r**2 + w**2 + 1)/(3*hypot(r, w)))"
    problem = problem_of(tmp_path, "x=1:1.3, y=0.5:1, w=-0.4:0.4", equations, "t")
    assert units(searched(problem).graph) == ["implicit", "vector"]
    monkeypatch.setattr(circles, "shortest", lambda made, equation, common, lengths: equation)
    assert units(searched(problem).graph) != ["implicit", "vector"]


@pytest.mark.exhaustive(reason="three searches; what outgrows a field is left out in quick ones")
def test_values_that_outgrow_the_field_become_generators(tmp_path: Path, monkeypatch: Patch) -> None:
    monkeypatch.setattr("cordicc.rewrite.exact.field.MOST_TERMS", 40)
    equations = """
p = atan2(a + b*c, b - a*c)
x = d*cos(p) - e*sin(p) + a*b
y = d*sin(p) + e*cos(p) - b*c
t2 = acos((x**2 + y**2 - 2)/2)
t1 = atan2(y, x) - atan2(sin(t2), 1 + cos(t2))
"""
    box = "a=0.3:0.5, b=0.3:0.5, c=-0.2:0.2, d=0.6:0.8, e=0.1:0.3"
    problem = problem_of(tmp_path, box, equations, "p, t1, t2")
    assert "rotate" not in units(searched(problem).graph)[:-1]
    monkeypatch.setattr(start, "OPAQUE", 0)
    without = multipliers(searched(problem).graph)
    monkeypatch.setattr(start, "OPAQUE", 16)
    assert multipliers(searched(problem).graph) < without


def test_an_equation_is_not_made_of_itself(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, "x=0.1:2, y=-1:1", "a = hypot(x, y)*cos(atan2(y, x) + 0.3)", "a")
    assert units(searched(problem).graph) == []


def test_values_stay_far_from_overflow(tmp_path: Path) -> None:
    equations = "q = atan2(y, x)\nt = atan2(v*cos(q) - w*sin(q), w*cos(q) + v*sin(q) + 6e20)"
    problem = problem_of(tmp_path, "x=1e20:9e20, y=1e20:9e20, v=1e20:9e20, w=1e20:9e20", equations, "q, t")
    graph = searched(problem).graph
    points = {name: np.full(3, 5e20) for name in "xyvw"}
    assert max(float(np.max(np.abs(r))) for results in all_results(graph, points) for r in results) < 2.0**96


def test_lifted_outputs_are_fractions_of_their_values(monkeypatch: Patch) -> None:
    made, given = store_of_inputs()
    quotient = made.make("vector", (given["x"], given["c"], made.const(0)), (0, 1))[1]
    other = made.make("vector", (given["x"], given["t"], made.const(0)), (0, 1))[1]
    total = made.add(made.mul(quotient, other), made.scale(Fraction(2), other))
    before = len(made.algebra.nodes)
    common_denominators.Lifting(made, frozenset()).realise(total)
    last = Value(len(made.algebra.nodes) - 1, 1)
    assert last.node > before
    assert made.find(last) == made.find(total)
    np.testing.assert_allclose(made.numbers(last), made.numbers(total), rtol=1e-9)
