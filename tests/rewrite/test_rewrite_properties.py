"""Whatever the search finds for a random tree of angles and lengths means what the equations say."""

import random
from fractions import Fraction

import numpy as np
import pytest

from cordicc.ir.graph import Builder, Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import InputSpec, OutputSpec, Problem
from cordicc.ir.well_formed import verify
from cordicc.rewrite.cheapest import cheapest
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import through_passes
from cordicc.rewrite.search.costs import Costs, of_graph
from tests.support.rewriting import KINEMATIC
from tests.support.selection import quick

NAMES = ("x", "y", "w")
SHAKES = 8
POINTS = 24


class Trees:
    """Random angles and scalars of one graph."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.builder = Builder()
        self.inputs = [self.builder.input(name) for name in NAMES]

    def leaf(self) -> Value:
        value = self.random.choice(self.inputs)
        for _ in range(self.random.randint(0, 2)):
            number = self.builder.const(Fraction(self.random.randint(1, 8), 2))
            other = self.random.choice([*self.inputs, number])
            value = self.builder.emit(self.random.choice(["add", "sub", "mul"]), (value, other))
        return value

    def angle(self, depth: int) -> Value:
        if depth == 0:
            return self.random.choice(self.inputs)
        match self.random.choice(["atan2", "atan2", "solve", "arc", "sum", "sum", "neg"]):
            case "atan2":
                return self.builder.emit("atan2", (self.scalar(depth - 1), self.scalar(depth - 1)))
            case "solve":
                operands = [self.scalar(depth - 1) for _ in range(3)]
                return self.builder.emit("solve", operands, (1, self.random.choice("+-")))
            case "arc":
                return self.builder.emit(
                    self.random.choice(["acos", "asin", "atan"]), (self.scalar(depth - 1),)
                )
            case "sum":
                operands = (self.angle(depth - 1), self.angle(depth - 1))
                return self.builder.emit(self.random.choice(["add", "sub"]), operands)
            case _:
                return self.builder.emit("neg", (self.angle(depth - 1),))

    def scalar(self, depth: int) -> Value:
        if depth == 0:
            return self.leaf()
        emit = self.builder.emit
        match self.random.choice(["turned", "turned", "product", "hypot", "sum", "quotient", "leaf", "leaf"]):
            case "turned":
                a, b, angle = self.scalar(depth - 1), self.scalar(depth - 1), self.angle(depth - 1)
                products = emit("mul", (a, emit("cos", (angle,)))), emit("mul", (b, emit("sin", (angle,))))
                return emit("sub", products)
            case "product":
                function = emit(self.random.choice(["sin", "cos"]), (self.angle(depth - 1),))
                return emit("mul", (self.scalar(depth - 1), function))
            case "hypot":
                return emit("hypot", (self.scalar(depth - 1), self.scalar(depth - 1)))
            case "sum":
                return emit("add", (self.scalar(depth - 1), self.scalar(depth - 1)))
            case "quotient":
                return emit("div", (self.scalar(depth - 1), self.scalar(depth - 1)))
            case _:
                return self.leaf()

    def problem(self) -> Problem:
        outputs, specs = {}, []
        for index in range(self.random.randint(1, 2)):
            name, is_angle = f"o{index}", self.random.random() < 0.7
            value = self.angle(3) if is_angle else self.scalar(3)
            wrap = is_angle and self.random.random() < 0.5
            outputs[name] = self.builder.emit("wrap", (value,)) if wrap else value
            specs.append(OutputSpec(name, wrap, wrap))
        graph = self.builder.build(outputs)
        low = [Fraction(self.random.choice([-2, Fraction(1, 10)])) for _ in NAMES]
        inputs = tuple(InputSpec(name, lo, Fraction(2)) for name, lo in zip(NAMES, low, strict=True))
        return Problem("random", "", {}, inputs, (), tuple(specs), graph)


def samples(problem: Problem, seed: int) -> dict[str, np.ndarray]:
    """Return points of the box, a third of them on a coarse grid where conditions fail exactly."""
    generator = np.random.default_rng(seed)
    drawn = {}
    for spec in problem.inputs:
        lo, hi = float(spec.lo), float(spec.hi)
        grid = [x for x in (-1.0, 0.0, 0.5, 1.0, lo, hi) if lo <= x <= hi]
        drawn[spec.name] = np.concatenate([generator.uniform(lo, hi, 16), generator.choice(grid, 8)])
    return drawn


def steady(graph: Graph, points: dict[str, np.ndarray]) -> np.ndarray:
    """Tell where the equations themselves do not hang on rounding."""
    exact, defined = reference_outputs(graph, points)
    tiled = {name: np.tile(column, SHAKES) for name, column in points.items()}
    shaken, still = reference_outputs(graph, tiled, jitter=True)
    good = np.ones(POINTS, dtype=bool)
    for name in exact:
        with np.errstate(all="ignore"):
            near = np.abs(shaken[name] - np.tile(exact[name], SHAKES)) <= 1e-9 * (1 + np.abs(shaken[name]))
        agree = (still == np.tile(defined, SHAKES)) & (near | ~still)
        good &= agree.reshape(SHAKES, -1).all(axis=0) & ~(np.abs(exact[name]) > 1e9)
    return good


@pytest.mark.parametrize("seed", quick(range(40), *range(9)))
def test_random_trees_keep_their_meaning(seed: int) -> None:
    problem = Trees(seed).problem()
    ranges = {s.name: Interval(float(s.lo) - 1e-15, float(s.hi) + 1e-15) for s in problem.inputs}
    goal = ("processors", "latency", "area")[seed % 3]
    context = PassContext(ranges, goal)
    graph = through_passes(problem.graph, context, implicit=True)
    costs = Costs.of(KINEMATIC, implicit=True)
    choice = cheapest(problem, graph, context, costs)
    verify(choice.graph)
    assert of_graph(choice.graph, costs, goal) <= of_graph(graph, costs, goal)
    points = samples(problem, seed)
    exact, defined = reference_outputs(problem.graph, points)
    values, valid = reference_outputs(choice.graph, points)
    good = steady(problem.graph, points)
    np.testing.assert_array_equal(valid[good], defined[good])
    for name in exact:
        difference = np.abs(exact[name] - values[name])
        if problem.output(name).is_angle:
            difference = np.minimum(difference, np.abs(difference - 2 * np.pi))
        both = good & defined & valid
        assert np.all(difference[both] <= 1e-6 * (1 + np.abs(exact[name][both])))
