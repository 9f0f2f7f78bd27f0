"""Whether a realisation is as accurate as another one: how far rounding moves the outputs at samples."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.doubles import Results, all_results
from cordicc.ir.meaning.roundings import errors
from cordicc.ir.problem import Problem

_TRIES = 12
"""How often each sample is rounded."""

_ROUNDING = 2.0**-24
"""Of single precision, relative to what an operation errs in."""

_WORSE = 8.0
"""How much more rounding may move an output at a sample than in the realisation of the passes."""

_USUAL = 4.0
"""How much it may move anywhere, of what is usual for the output."""


class AccuracyGate:
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
            moved[name] = root_mean_square(np.nan_to_num(distance))
        return moved

    def _distance(self, output: str, found: Floats, exact: Floats) -> Floats:
        """Return how far values of an output are from exact ones, angles modulo 2 pi."""
        difference = np.abs(found - exact)
        return (
            np.minimum(difference, np.abs(difference - 2 * np.pi)) if self._is_angle[output] else difference
        )


def root_mean_square(tries: Floats) -> Floats:
    """Return the mean square of each column, of which the squares alone may be beyond every double."""
    largest = np.max(tries, axis=0)
    scale = np.where(largest > 0, largest, 1.0)
    return np.asarray(scale * np.sqrt(np.mean((tries / scale) ** 2, axis=0)))


def _outputs(graph: Graph, values: Sequence[Results]) -> dict[str, Floats]:
    return {name: values[v.node][v.result] for name, v in graph.outputs.items()}


def _own_errors(node: Node, operands: Sequence[Floats], made: Results) -> list[Floats]:
    """Return how far an operation itself moves its results, in roundings."""
    own = errors(node.op, node.params, operands, [np.zeros_like(x) for x in operands], made)
    # An error without bound tells that the sample lies at an edge, and nothing else.
    return [np.nan_to_num(size, posinf=0.0) for size in own]
