"""Points on the way to where roots are small: ever nearer, inside the ranges, at edges of domains too."""

import numpy as np
import pytest

from cordicc.ir.graph import Graph
from cordicc.ir.meaning.doubles import all_results
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.text import parse_graph
from cordicc.ir.towards_zero import roots_of, towards_zero

RANGES = {"x": Interval(-1.0, 3.0), "y": Interval(-2.0, 2.0)}
LENGTH = "%2 = const[value=1/4]\n%3 = add(%0, %2)\n%4:2 = vector[m=1, sign=1](%3, %1, %2)\noutput v = %4#0\n"
EDGE = "%2 = const[value=2]\n%3 = sub(%2, %0)\n%4:2 = lightcone(%3, %2)\noutput v = %4#0\n"
AWAY = "%2 = const[value=5]\n%3 = add(%0, %2)\n%4:2 = vector[m=1, sign=1](%3, %1, %2)\noutput v = %4#0\n"


def graph_of(text: str) -> Graph:
    return parse_graph(f"%0 = input[name=x]\n%1 = input[name=y]\n{text}", "test")


def sizes(graph: Graph, points: dict[str, np.ndarray]) -> np.ndarray:
    value = graph.outputs["v"]
    return all_results(graph, points)[value.node][value.result]


@pytest.mark.parametrize(("text", "least"), [(LENGTH, 1e-5), (EDGE, 1e-2), (AWAY, 4.1)])
def test_points_come_near_what_is_smallest(text: str, least: float) -> None:
    graph = graph_of(text)
    generator = np.random.default_rng(4)
    start = {name: generator.uniform(r.lo, min(r.hi, 1.9), 50) for name, r in RANGES.items()}
    points = towards_zero(graph, roots_of(graph), RANGES, start)
    found = sizes(graph, points)
    assert np.isfinite(found).all()
    assert found.min() < least < found.max() or text == AWAY
    assert found.min() < sizes(graph, start).min() * 1.001
    assert all(
        (RANGES[n].lo <= column).all() and (column <= RANGES[n].hi).all() for n, column in points.items()
    )
    again = towards_zero(graph, roots_of(graph), RANGES, start)
    assert all((points[n] == again[n]).all() for n in RANGES)


def test_only_roots_that_are_used_are_followed() -> None:
    graph = graph_of("%2:2 = vector[m=0, sign=1](%0, %1, %1)\n%3:2 = lightcone(%0, %1)\noutput v = %2#1\n")
    assert roots_of(graph) == []
    points = towards_zero(graph, [], RANGES, {name: np.zeros(3) for name in RANGES})
    assert all(column.size == 0 for column in points.values())


def test_an_input_that_is_one_number_is_no_direction() -> None:
    ranges = {"x": Interval(0.5, 0.5), "y": RANGES["y"]}
    start = {"x": np.full(5, 0.5), "y": np.linspace(-2, 2, 5)}
    graph = graph_of(LENGTH)
    points = towards_zero(graph, roots_of(graph), ranges, start)
    assert (points["x"] == 0.5).all()
    assert sizes(graph, points).min() == pytest.approx(0.75)
