"""Whether a realisation is as accurate as another one: how far rounding moves the outputs at samples."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.doubles import Results, all_results
from cordicc.ir.meaning.roundings import SINGLE, Words, errors
from cordicc.ir.problem import Problem

_TRIES = 12
"""How often each sample is rounded."""

_WORSE = 8.0
"""How much more rounding may move an output at a sample than in the realisation of the passes."""

_USUAL = 4.0
"""How much it may move anywhere, of what is usual for the output."""

_FAR = 2.0**500
"""Stands for an infinite distance, as its square is a number."""

_FIT = 1.5
"""On fixed point, how much more it may move an output than that of inputs and outputs alone does."""


class AccuracyGate:
    """Judges realisations by how far rounding of every operation moves the outputs at samples.

    Numbers with exponents are accurate enough in the realisation of the passes, and others are compared
    with it.  On fixed point that need not be so: what rounding of the inputs and outputs alone does, to which
    words have no alternative, is the measure there.
    """

    def __init__(
        self, problem: Problem, graph: Graph, points: Mapping[str, Floats], words: Words = SINGLE
    ) -> None:
        """Judge by a realisation.

        Args:
            problem: the problem, for which outputs are angles.
            graph: the realisation.
            points: an array of shape (n,) for each input.
            words: how numbers are rounded.
        """
        self._is_angle = {name: problem.output(name).is_angle for name in graph.outputs}
        self._points, self._words = points, words
        self._allowed = {}
        results = all_results(graph, points)
        steps = _steps(graph, results, words)
        moved = self._moved(graph, inputs_alone=words.fixed)
        for name, value in graph.outputs.items():
            if words.fixed:
                last = words.rounding * words.outside * float(np.max(steps[value.node][value.result]))
                least = np.hypot(moved[name], last)
                self._allowed[name] = _FIT * np.maximum(least, np.median(least))
            else:
                largest = float(np.max(np.abs(results[value.node][value.result])))
                usual = max(float(np.median(moved[name])), words.rounding * largest)
                self._allowed[name] = np.maximum(_WORSE * moved[name], _USUAL * usual)

    def less_accurate(self, graph: Graph) -> tuple[str, int] | None:
        """Return an output and a sample that rounding moves too far in a graph, None if there is none.

        Of all outputs and samples those that are moved most, compared with what is allowed.
        """
        return worst_of(self.ratios(graph))

    def ratios(self, graph: Graph) -> dict[str, Floats]:
        """Return by output how far rounding moves each sample in a graph, compared with what is allowed."""
        found = {}
        for name, moved in self._moved(graph).items():
            allowed = self._allowed[name]
            found[name] = np.divide(moved, allowed, out=np.where(moved > 0, np.inf, 0.0), where=allowed > 0)
        return found

    def culprit(self, graph: Graph, output: str, sample: int, among: Collection[Value]) -> Value | None:
        """Return the result whose rounding moves an output at a sample most, of some; None if none does."""
        results = sorted(among)
        columns = {value: column for column, value in enumerate(results)}
        steps = _steps(graph, all_results(graph, self._points), self._words)
        numbers = iter(range(len(graph.nodes)))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            index = next(numbers)
            own = _own_errors(node, operands, made, steps[index] if self._words.fixed else None)
            moved = []
            for r, (x, size) in enumerate(zip(made, own, strict=True)):
                step = np.zeros_like(x)
                column = columns.get(Value(index, r))
                if column is not None:
                    step[column] = self._words.rounding * np.broadcast_to(size, x.shape)[column]
                moved.append(x + step)
            return tuple(moved)

        # One column for each result, in which it alone is moved, and one in which none is.
        inputs = {name: np.full(len(results) + 1, column[sample]) for name, column in self._points.items()}
        found = _outputs(graph, all_results(graph, inputs, rounded))[output]
        moved = np.nan_to_num(self._distance(output, found[:-1], found[-1]))
        return results[int(np.argmax(moved))] if results and np.max(moved) > 0 else None

    def _moved(self, graph: Graph, *, inputs_alone: bool = False) -> dict[str, Floats]:
        """Return how far rounding moves each output, as a mean square.

        Units err as they do: those that turn vectors by the vector's length, angles absolutely.
        """
        generator = np.random.Generator(np.random.PCG64(11))
        rounding = self._words.rounding
        # Against its own exact values: whether they are those of the problem is not judged by samples.
        results = all_results(graph, self._points)
        exact = _outputs(graph, results)
        steps = _steps(graph, results, self._words) if self._words.fixed else None
        numbers = iter(range(len(graph.nodes)))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            index = next(numbers)
            if inputs_alone and node.op != "input":
                return made
            own = _own_errors(node, operands, made, None if steps is None else steps[index])
            return tuple(
                x + size * generator.uniform(-rounding, rounding, x.shape)
                for x, size in zip(made, own, strict=True)
            )

        # All tries at once: each sample stands in the columns as often as it is tried.
        points = {name: np.tile(column, _TRIES) for name, column in self._points.items()}
        moved = {}
        for name, column in _outputs(graph, all_results(graph, points, rounded)).items():
            distance = self._distance(name, column.reshape(_TRIES, -1), exact[name])
            # A sample that rounding takes out of the domain lies at its edge and tells nothing.
            moved[name] = np.sqrt(np.mean(np.minimum(np.nan_to_num(distance), _FAR) ** 2, axis=0))
        return moved

    def _distance(self, output: str, found: Floats, exact: Floats) -> Floats:
        """Return how far values of an output are from exact ones, angles modulo 2 pi."""
        difference = np.abs(found - exact)
        return (
            np.minimum(difference, np.abs(difference - 2 * np.pi)) if self._is_angle[output] else difference
        )


def worst_of(ratios: Mapping[str, Floats]) -> tuple[str, int] | None:
    """Return the output and the sample whose ratio is largest, None if none is above 1."""
    worst, found = 1.0, None
    for name, column in ratios.items():
        sample = int(np.argmax(column))
        if column[sample] > worst:
            worst, found = float(column[sample]), (name, sample)
    return found


def _outputs(graph: Graph, values: Sequence[Results]) -> dict[str, Floats]:
    return {name: values[v.node][v.result] for name, v in graph.outputs.items()}


def _steps(graph: Graph, results: Sequence[Results], words: Words) -> list[Results]:
    """Return how far each result of each node is rounded, given all of them on all samples."""
    return [words.steps(node, made) for node, made in zip(graph.nodes, results, strict=True)]


def _own_errors(node: Node, operands: Sequence[Floats], made: Results, steps: Results | None) -> list[Floats]:
    """Return how far an operation itself moves its results, in roundings of their size or of given steps."""
    own = errors(
        node.op,
        node.params,
        operands,
        [np.zeros_like(x) for x in operands],
        made,
        SINGLE.steps(node, made) if steps is None else steps,
    )
    # An error without bound tells that the sample lies at an edge, and nothing else.
    return [np.nan_to_num(size, posinf=0.0) for size in own]
