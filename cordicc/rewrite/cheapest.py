"""The realisation that is compiled: the search's, if it is cheaper and as accurate as that of the passes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.doubles import Results, all_results
from cordicc.ir.meaning.roundings import errors
from cordicc.ir.problem import Problem
from cordicc.ir.well_formed import verify
from cordicc.rewrite.passes.base import Context
from cordicc.rewrite.passes.order import default_passes
from cordicc.rewrite.passes.standard_chains import StandardChains
from cordicc.rewrite.search.costs import Costs, of_graph
from cordicc.rewrite.search.realisations import Realisations
from cordicc.rewrite.search.start import sample_points

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
    gate = Gate(problem, graph, points)
    # Fixed point has no digits to spare for products of denominators.
    for lift in (True, False) if costs.floating else (False,):
        realisations = Realisations(problem, context, bases, costs, lift=lift)
        found, first = realisations.best(), True
        if found is None:
            return Choice(graph)
        while found is not None:
            made = found.graph if costs.implicit else StandardChains().apply(found.graph, context)
            verify(made)
            if of_graph(made, costs, context.goal) >= least:
                if first:
                    return Choice(graph, proven=found.proven, searched=True)
                break
            inaccurate = gate.less_accurate(made)
            if inaccurate is None:
                steps = found.steps if costs.implicit else {}
                return Choice(made, found.proven, True, steps, found.facts)
            # In chains of standard units results are no longer those of the search.
            among = realisations.may_be_banned(found) if costs.implicit else ()
            blamed = gate.culprit(made, *inaccurate, among) if among else None
            if blamed is not None:
                realisations.ban(found, blamed)
            found, first = realisations.best(), False
    return Choice(graph, searched=True)


class Gate:
    """Judges realisations by how far rounding of every operation moves the outputs at samples."""

    def __init__(self, problem: Problem, graph: Graph, points: Mapping[str, Floats]) -> None:
        """Judge by a realisation that is accurate enough.

        Args:
            problem: the problem, for which outputs are angles.
            graph: the realisation.
            points: an array of shape (n,) for each input.
        """
        self._is_angle = {name: problem.output(name).is_angle for name in graph.outputs}
        self._points = points
        self._allowed = {}
        sizes = {
            name: np.max(np.abs(value)) for name, value in _outputs(graph, all_results(graph, points)).items()
        }
        for name, moved in self._moved(graph).items():
            usual = max(float(np.median(moved)), _ROUNDING * float(sizes[name]))
            self._allowed[name] = np.maximum(_WORSE * moved, _USUAL * usual)

    def less_accurate(self, graph: Graph) -> tuple[str, int] | None:
        """Return an output and a sample that rounding moves too far in a graph, None if there is none.

        Of all outputs and samples those that are moved most, compared with what is allowed.
        """
        worst, found = 1.0, None
        for name, moved in self._moved(graph).items():
            allowed = self._allowed[name]
            ratios = np.divide(moved, allowed, out=np.where(moved > 0, np.inf, 0.0), where=allowed > 0)
            sample = int(np.argmax(ratios))
            if ratios[sample] > worst:
                worst, found = float(ratios[sample]), (name, sample)
        return found

    def culprit(self, graph: Graph, output: str, sample: int, among: Collection[Value]) -> Value | None:
        """Return the result whose rounding moves an output at a sample most, of some; None if none does."""
        results = sorted(among)
        columns = {value: column for column, value in enumerate(results)}
        numbers = iter(range(len(graph.nodes)))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            index = next(numbers)
            moved = []
            for r, (x, size) in enumerate(zip(made, _own_errors(node, operands, made), strict=True)):
                step = np.zeros_like(x)
                column = columns.get(Value(index, r))
                if column is not None:
                    step[column] = _ROUNDING * size[column]
                moved.append(x + step)
            return tuple(moved)

        # One column for each result, in which it alone is moved, and one in which none is.
        inputs = {name: np.full(len(results) + 1, column[sample]) for name, column in self._points.items()}
        found = _outputs(graph, all_results(graph, inputs, rounded))[output]
        moved = np.nan_to_num(self._distance(output, found[:-1], found[-1]))
        return results[int(np.argmax(moved))] if results and np.max(moved) > 0 else None

    def _moved(self, graph: Graph) -> dict[str, Floats]:
        """Return how far single precision moves each output, as a mean square.

        Units err as they do: those that turn vectors by the vector's length, angles absolutely.
        """
        generator = np.random.Generator(np.random.PCG64(11))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            return tuple(
                x + size * generator.uniform(-_ROUNDING, _ROUNDING, x.shape)
                for x, size in zip(made, _own_errors(node, operands, made), strict=True)
            )

        # Against its own exact values: whether they are those of the problem is not judged by samples.
        exact = _outputs(graph, all_results(graph, self._points))
        # All tries at once: each sample stands in the columns as often as it is tried.
        points = {name: np.tile(column, _TRIES) for name, column in self._points.items()}
        moved = {}
        for name, column in _outputs(graph, all_results(graph, points, rounded)).items():
            distance = self._distance(name, column.reshape(_TRIES, -1), exact[name])
            # A sample that rounding takes out of the domain lies at its edge and tells nothing.
            moved[name] = np.sqrt(np.mean(np.nan_to_num(distance) ** 2, axis=0))
        return moved

    def _distance(self, output: str, found: Floats, exact: Floats) -> Floats:
        """Return how far values of an output are from exact ones, angles modulo 2 pi."""
        difference = np.abs(found - exact)
        return (
            np.minimum(difference, np.abs(difference - 2 * np.pi)) if self._is_angle[output] else difference
        )


def _outputs(graph: Graph, values: Sequence[Results]) -> dict[str, Floats]:
    return {name: values[v.node][v.result] for name, v in graph.outputs.items()}


def _own_errors(node: Node, operands: Sequence[Floats], made: Results) -> list[Floats]:
    """Return how far an operation itself moves its results, in roundings."""
    own = errors(node.op, node.params, operands, [np.zeros_like(x) for x in operands], made)
    # An error without bound tells that the sample lies at an edge, and nothing else.
    return [np.nan_to_num(size, posinf=0.0) for size in own]
