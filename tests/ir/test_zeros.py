"""Ways to zeros of a value: where inputs are set, between signs, by a search; and where there is no zero."""

import numpy as np
import pytest

from cordicc.base.diagnostics import Source
from cordicc.frontend.load import parse_problem
from cordicc.ir.meaning.doubles import screen
from cordicc.ir.sampling import draw
from cordicc.ir.zeros import Approaches, approaches


def found(expression: str, x: str = "[-1, 1]") -> tuple[Approaches | None, np.ndarray]:
    """Return the ways to zeros of an expression of x, y in [-1, 2] and z, and its sizes at the zeros."""
    text = f"inputs: {{x: {x}, y: [-1, 2], z: [0, 1]}}\nequations: ['out = {expression}']\n"
    problem = parse_problem(Source("t.yaml", text)).problem
    graph = problem.graph.leading_to(problem.graph.outputs["out"])
    ways = approaches(graph, problem.workspace.ranges, draw(problem.workspace, 500, 0), 12, 20_000)
    if ways is None:
        return None, np.zeros(0)
    return ways, np.abs(screen(graph, ways.zeros)[0]["out"])


@pytest.mark.parametrize(
    ("expression", "most"),
    [
        ("x", 1e-15),
        ("x*y", 1e-15),
        ("hypot(x, y)", 1e-15),
        ("1 - x", 1e-15),
        ("cos(x*pi/2)", 1e-15),
        ("x - y", 1e-15),
        ("exp(x) - 1.3", 1e-15),
        ("hypot(x - 0.3, y - 0.7)", 1e-5),
        ("1 - sin(x + 0.8)", 1e-5),
    ],
)
def test_zeros(expression: str, most: float) -> None:
    ways, sizes = found(expression)
    assert ways is not None
    assert 1 <= sizes.size <= 12
    assert sizes.max() <= most
    assert len({*ways.zeros["z"].tolist()}) > 1  # what the value does not depend on stays as it is


@pytest.mark.parametrize("expression", ["x + 2", "x**2 + 1e-3", "sign(x) + 1/2", "2*z + 1"])
def test_no_zeros(expression: str) -> None:
    assert found(expression)[0] is None


def test_a_range_without_its_zero() -> None:
    assert found("x", "[1e-3, 1]")[0] is None


def test_points_on_the_ways() -> None:
    ways, _ = found("x")
    assert ways is not None
    points = ways.points(np.array([1.0, 0.5, 0.25]), 4)
    assert points["x"].shape == (12,)
    assert np.array_equal(points["x"].reshape(3, 4), np.outer([1, 0.5, 0.25], ways.starts["x"][:4]))
