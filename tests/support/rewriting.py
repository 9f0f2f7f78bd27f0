"""Problems for tests of the search, and their comparison with what comes out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cordicc.frontend.load import load_problem
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import Problem, input_intervals
from cordicc.ir.well_formed import verify
from cordicc.rewrite.cheapest import Choice, cheapest
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import through_passes
from cordicc.rewrite.same_meaning import check_meaning
from cordicc.rewrite.search.costs import UNITS, Costs
from cordicc.targets.target_file import load_target

KINEMATIC = load_target("kinematic")


def problem_of(folder: Path, inputs: str, equations: str, outputs: str, rest: str = "") -> Problem:
    """Return a problem; inputs as "x=-2:2, y=0:1", equations one a line."""
    ranges = [item.split("=") for item in inputs.replace(" ", "").split(",")]
    lines = [f"  {name}: [{', '.join(span.split(':'))}]" for name, span in ranges]
    items = [f"  - {line.strip()}" if ": " not in line else line for line in equations.strip().splitlines()]
    text = "\n".join(["inputs:", *lines, rest, "equations:", *items, f"outputs: [{outputs}]", ""])
    path = folder / "problem.yaml"
    path.write_text(text, encoding="utf-8")
    return load_problem(path).problem


def certain(problem: Problem, goal: str = "processors", *, implicit: bool = True) -> Graph:
    """Return the realisation of the passes alone."""
    context = PassContext(input_intervals(problem), goal)
    return through_passes(problem.graph, context, implicit=implicit)


def searched(problem: Problem, goal: str = "processors", *, implicit: bool = True) -> Choice:
    """Return what the search makes of a problem, verified and compared with the equations."""
    graph = certain(problem, goal, implicit=implicit)
    costs = Costs.of(KINEMATIC, implicit=implicit)
    choice = cheapest(problem, graph, PassContext(input_intervals(problem), goal), costs)
    verify(choice.graph)
    check_meaning(problem, choice.graph)
    return choice


def units(graph: Graph) -> list[str]:
    """Return the CAU operations of a graph, sorted."""
    return sorted(node.op for node in graph.nodes if node.op in UNITS)


def multipliers(graph: Graph) -> int:
    """Return the products of two variables."""
    return sum(node.op == "mul" for node in graph.nodes)


def same_where(problem: Problem, graph: Graph, samples: dict[str, list[float]]) -> None:
    """Assert equal validity, and values equal modulo 2 pi, on chosen samples."""
    points = {name: np.array(column, dtype=float) for name, column in samples.items()}
    exact, defined = reference_outputs(problem.graph, points)
    values, valid = reference_outputs(graph, points)
    np.testing.assert_array_equal(valid, defined)
    for name in exact:
        difference = np.abs(exact[name] - values[name])[defined]
        if problem.output(name).is_angle:
            difference = np.minimum(difference, np.abs(difference - 2 * np.pi))
        assert np.all(difference <= 1e-9 * (1 + np.abs(exact[name][defined])))
