"""Evaluation in balls: what it decides is what rounded numbers say, and it decides nothing at an edge."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cordicc.frontend.load import load_problem
from cordicc.ir.graph import Builder, Graph
from cordicc.ir.meaning import balls, reference
from cordicc.ir.ops import OPS, Level
from cordicc.ir.sampling import draw_with_corners
from tests.support.operations import cases, graph_of
from tests.support.paths import ROOT

PROBLEMS = sorted((ROOT / "examples").glob("*.yaml"))


def rounded(graph: Graph, inputs: dict[str, np.ndarray]) -> np.ndarray:
    count = len(next(iter(inputs.values())))
    return reference.rounded_outputs(graph, inputs, list(range(count)))


@pytest.mark.parametrize(("op", "params"), cases(Level.ARITHMETIC, Level.FUNCTION))
def test_the_same_doubles(op: str, params: tuple) -> None:
    """Bit for bit, over several magnitudes; most samples inside the domain are decided."""
    generator = np.random.default_rng(3)
    graph = graph_of(op, params)
    names = [f"x{i}" for i in range(OPS[op].arity)]
    for scale in (0.9, 4.0, 1e-3, 1e3):
        inputs = {name: generator.uniform(-scale, scale, 200) for name in names}
        results, decided = balls.ball_outputs(graph, inputs, 200)
        expected = rounded(graph, inputs)
        assert np.array_equal(results[:, decided], expected[:, decided], equal_nan=True)
        assert np.isnan(results[:, ~decided]).all()
        if scale == 0.9 and (op != "solve" or params[0] == 1):
            assert decided.mean() > 0.95  # outside the domain too


@pytest.mark.parametrize("path", PROBLEMS, ids=lambda p: p.stem)
def test_examples(path: Path) -> None:
    problem = load_problem(path).problem
    inputs = draw_with_corners(problem.workspace, 100)
    count = len(next(iter(inputs.values())))
    results, decided = balls.ball_outputs(problem.graph, inputs, count)
    assert np.array_equal(results[:, decided], rounded(problem.graph, inputs)[:, decided], equal_nan=True)
    assert decided.mean() > 0.9


OUTSIDE = {
    "sqrt": (-1.0, -1e-300),
    "asin": (-1.5, np.nextafter(1.0, 2.0)),
    "acos": (1.5, np.nextafter(1.0, 2.0)),
    "acosh": (0.5,),
    "atanh": (1.0, -1.0, 2.0),
    "log": (0.0, -1.0),
}
OPEN = {"exp": (1e6, 1e300), "cosh": (1e6,), "wrap": (np.inf, np.nan)}


@pytest.mark.parametrize("op", OUTSIDE)
def test_knows_what_is_outside_a_domain(op: str) -> None:
    """And what does not follow from it: the second output."""
    column = np.array(OUTSIDE[op])
    builder = Builder()
    x = builder.input("x0")
    graph = builder.build(
        {"out": builder.emit("neg", [builder.emit(op, [x])]), "twice": builder.emit("add", [x, x])}
    )
    results, decided = balls.ball_outputs(graph, {"x0": column}, len(column))
    assert decided.all()
    assert np.isnan(results[0]).all()
    assert np.array_equal(results[1], 2 * column)


@pytest.mark.parametrize("op", OPEN)
def test_leaves_huge_numbers_open(op: str) -> None:
    column = np.array(OPEN[op])
    results, decided = balls.ball_outputs(graph_of(op), {"x0": column}, len(column))
    assert not decided.any()
    assert np.isnan(results).all()


def test_knows_no_angle_and_poles() -> None:
    zero = {"x0": np.zeros(1), "x1": np.zeros(1)}
    for op in ("atan2", "div"):
        results, decided = balls.ball_outputs(graph_of(op), zero, 1)
        assert decided.all()
        assert np.isnan(results).all()
    point = {"x0": np.zeros(1), "x1": np.zeros(1), "x2": np.ones(1)}
    assert balls.ball_outputs(graph_of("solve", (1, "+")), point, 1)[1].all()
    assert not balls.ball_outputs(graph_of("solve", (-1, "none")), point, 1)[1].any()


def test_leaves_differences_of_equals_open() -> None:
    """1/3 + 1/3 - 2/3 is zero, but no ball can know it; its sign decides nothing."""
    builder = Builder()
    x = builder.input("x")
    third = builder.emit("cmul", [x], (Fraction(1, 3),))
    twice = builder.emit("cmul", [x], (Fraction(2, 3),))
    rest = builder.emit("sub", [builder.emit("add", [third, third]), twice])
    graph = builder.build({"out": builder.emit("select", [rest, x, third])})
    column = {"x": np.array([1.0, 5.0])}
    _, decided = balls.ball_outputs(graph, column, 2)
    assert not decided.any()
    values, valid = reference.reference_outputs(graph, column)
    assert valid.all()
    assert np.array_equal(values["out"], column["x"])


def test_ties() -> None:
    """No error radius tells on which side of a tie a number is; without a radius, the even double is next."""
    exact = graph_of("mul")
    inputs = {"x0": np.array([1 + 2.0**-52, 1 + 3 * 2.0**-52]), "x1": np.array([1.5, 1.5])}
    results, decided = balls.ball_outputs(exact, inputs, 2)
    assert decided.all()
    assert np.array_equal(results[0], inputs["x0"] * inputs["x1"])
    builder = Builder()
    fifth = builder.const(Fraction(1, 5))
    graph = builder.build({"out": builder.emit("div", [builder.input("x"), fifth])})
    column = {"x": np.array([1 + 2.0**-51, 1 + 2.0**-52])}
    assert balls.ball_outputs(graph, column, 2)[1].tolist() == [False, True]
    assert reference.reference_outputs(graph, column)[0]["out"].tolist() == (5 * column["x"]).tolist()


def test_gives_up_where_nothing_is_decided() -> None:
    column = np.full(1000, 1e6)
    column[500:] = 0.5
    _, decided = balls.ball_outputs(graph_of("exp"), {"x0": column}, 1000)
    assert not decided.any()


def test_unit_operations_are_left_to_rounded_numbers() -> None:
    graph = graph_of("lightcone")
    assert not balls.ball_outputs(graph, {"x0": np.ones(2), "x1": np.ones(2)}, 2)[1].any()


def test_goes_on_without_what_hangs_on_a_missing_result() -> None:
    """Each output has its value where nothing on its own way is outside a domain."""
    builder = Builder()
    x, y = builder.input("x"), builder.input("y")
    root, log = builder.emit("sqrt", [x]), builder.emit("log", [y])
    outputs = {
        "root": builder.emit("add", [root, y]),
        "log": builder.emit("mul", [log, x]),
        "both": builder.emit("sub", [root, log]),
        "none": builder.emit("mul", [x, y]),
    }
    graph = builder.build(outputs)
    columns = {"x": np.array([1.0, -1.0, 1.0, -1.0]), "y": np.array([2.0, 2.0, -2.0, -2.0])}
    results, decided = balls.ball_outputs(graph, columns, 4)
    assert decided.all()
    assert np.isnan(results).tolist() == [
        [False, True, False, True],
        [False, False, True, True],
        [False, True, True, True],
        [False, False, False, False],
    ]
    assert np.array_equal(results, rounded(graph, columns), equal_nan=True)


def test_sums_and_products_take_balls_of_any_width() -> None:
    """A difference of equals goes on into a product, whose double is known for all that."""
    builder = Builder()
    x = builder.input("x")
    third, twice = (builder.emit("cmul", [x], (Fraction(n, 3),)) for n in (1, 2))
    rest = builder.emit("sub", [builder.emit("add", [third, third]), twice])
    graph = builder.build({"out": builder.emit("add", [builder.emit("mul", [rest, x]), x])})
    column = {"x": np.array([1.0, 5.0])}
    results, decided = balls.ball_outputs(graph, column, 2)
    assert decided.all()
    assert np.array_equal(results[0], column["x"])
    _, decided = balls.ball_outputs(graph, {"x": np.array([1e200])}, 1)
    assert not decided.any(), "products that may be too large for a double are looked at"
