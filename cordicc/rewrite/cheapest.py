"""The realisation that is compiled: the search's, if it is cheaper and as accurate as that of the passes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.problem import Problem
from cordicc.ir.verify import verify
from cordicc.rewrite.base import Context
from cordicc.rewrite.conditioning import errors
from cordicc.rewrite.costs import Costs, of_graph
from cordicc.rewrite.filling import sample_points
from cordicc.rewrite.numeric import Floats, Results, evaluate
from cordicc.rewrite.passes import default_passes
from cordicc.rewrite.search import Realisations
from cordicc.rewrite.standard import StandardChains

_POINTS = 1000
_TRIES = 12
_ROUNDING = 2.0**-24
_WORSE = 8.0
"""How much more rounding may move an output at a sample than in the realisation of the passes."""

_USUAL = 4.0
"""How much it may move anywhere, of what is usual for the output."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A graph of unit operations, whether it is proven the cheapest alternative, each node's steps.

    `facts`: the texts of the assumptions that it rests on.
    """

    graph: Graph
    proven: bool = False
    searched: bool = False
    steps: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    facts: tuple[str, ...] = ()


def cheapest(problem: Problem, graph: Graph, context: Context, costs: Costs) -> Choice:
    """Return the cheapest realisation found for the goal of the context.

    Args:
        problem: the problem, for its samples and outputs.
        graph: the realisation of the passes in unit operations, kept where nothing better is found.
        context: the ranges of the inputs and the goal.
        costs: what operations cost.
    """
    bases = []
    for goal in ("processors", "latency"):
        base = problem.graph
        for step in default_passes(implicit=True):
            base = step.apply(base, replace(context, goal=goal))
        bases.append(base)
    points = sample_points(problem, bases, _POINTS)
    if points is None:
        return Choice(graph)
    least = of_graph(graph, costs, context.goal)
    # Fixed point has no digits to spare for products of denominators.
    for lift in (True, False) if costs.floating else (False,):
        realisations = Realisations(problem, context, bases, costs, lift=lift)
        found = realisations.best()
        if found is None:
            return Choice(graph)
        while found is not None:
            made = found.graph if costs.implicit else StandardChains().apply(found.graph, context)
            verify(made)
            if of_graph(made, costs, context.goal) >= least:
                return Choice(graph, proven=found.proven, searched=True)
            inaccurate = less_accurate(problem, graph, made, points)
            if inaccurate is None:
                steps = found.steps if costs.implicit else {}
                return Choice(made, found.proven, True, steps, found.facts)
            if costs.implicit:
                name, sample = inaccurate
                point = {each: column[sample : sample + 1] for each, column in points.items()}
                realisations.ban(found, culprit(made, name, point))
            found = realisations.best()
    return Choice(graph, searched=True)


def less_accurate(
    problem: Problem, graph: Graph, other: Graph, points: Mapping[str, Floats]
) -> tuple[str, int] | None:
    """Return an output and a sample that rounding moves much more in the other graph, None if there is none.

    Of all outputs and samples those that are moved most, compared with what they may be.
    """
    exact, first = _moved(problem, graph, points)
    _, second = _moved(problem, other, points)
    worst, found = 1.0, None
    for name, value in exact.items():
        usual = max(float(np.median(first[name])), _ROUNDING * float(np.max(np.abs(value))))
        ratios = second[name] / np.maximum(_WORSE * first[name], _USUAL * usual)
        sample = int(np.argmax(ratios))
        if ratios[sample] > worst:
            worst, found = float(ratios[sample]), (name, sample)
    return found


def culprit(graph: Graph, name: str, point: Mapping[str, Floats]) -> Value:
    """Return the result whose rounding moves an output at a sample most."""
    results = [
        Value(index, r)
        for index, node in enumerate(graph.nodes)
        if node.op not in ("input", "const")
        for r in range(len(node.definition.results))
    ]
    columns = {value: column for column, value in enumerate(results)}
    numbers = iter(range(len(graph.nodes)))

    def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
        index = next(numbers)
        own = _own_errors(node, operands, made)
        moved = []
        for r, (x, size) in enumerate(zip(made, own, strict=True)):
            column = columns.get(Value(index, r))
            step = np.zeros_like(x)
            if column is not None:
                step[column] = _ROUNDING * size[column]
            moved.append(x + step)
        return tuple(moved)

    # One column for each result, in which it alone is moved, and one in which none is.
    inputs = {name: np.full(len(results) + 1, column[0]) for name, column in point.items()}
    output = graph.outputs[name]
    found = evaluate(graph, inputs, rounded)[output.node][output.result]
    moved = np.nan_to_num(np.abs(found - found[-1]))
    return results[int(np.argmax(np.minimum(moved, np.abs(moved - 2 * np.pi))[:-1]))]


def _own_errors(node: Node, operands: Sequence[Floats], made: Results) -> list[Floats]:
    """Return how far an operation itself moves its results, in roundings."""
    own = errors(node.op, node.params, operands, [np.zeros_like(x) for x in operands], made)
    # An error without bound tells that the sample lies at an edge, and nothing else.
    return [np.nan_to_num(size, posinf=0.0) for size in own]


def _moved(
    problem: Problem, graph: Graph, points: Mapping[str, Floats]
) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return the outputs, and how far single precision moves each, as a mean square.

    Units err as they do: those that turn vectors by the vector's length, angles absolutely.
    """
    values = evaluate(graph, points)
    exact = {name: values[v.node][v.result] for name, v in graph.outputs.items()}
    generator = np.random.Generator(np.random.PCG64(11))

    def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
        sizes = _own_errors(node, operands, made)
        return tuple(
            x + size * generator.uniform(-_ROUNDING, _ROUNDING, x.shape)
            for x, size in zip(made, sizes, strict=True)
        )

    # All tries at once: each sample stands in the columns as often as it is tried.
    values = evaluate(graph, {name: np.tile(column, _TRIES) for name, column in points.items()}, rounded)
    moved = {}
    for name, value in graph.outputs.items():
        tries = values[value.node][value.result].reshape(_TRIES, -1)
        difference = np.abs(tries - exact[name])
        if problem.output(name).is_angle:
            difference = np.minimum(difference, np.abs(difference - 2 * np.pi))
        # A sample that rounding takes out of the domain lies at its edge and tells nothing.
        moved[name] = np.sqrt(np.mean(np.nan_to_num(difference) ** 2, axis=0))
    return exact, moved
