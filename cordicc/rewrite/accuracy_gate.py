"""Whether a realisation is as accurate as another one: how far rounding moves outputs and checks."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.doubles import Results, all_results
from cordicc.ir.ops import Level
from cordicc.ir.problem import Problem
from cordicc.rewrite.disturbances import ROUNDING, disturbed

_TRIES = 12
"""How often each sample is rounded."""

_WORSE = 8.0
"""How much more rounding may move an output at a sample than in the realisation of the passes."""

_USUAL = 4.0
"""How much it may move anywhere, of what is usual for the output."""

_FAR = 16.0
"""How much it moves a check too far, of what is usual and of what words that are rounded do at the sample."""


class AccuracyGate:
    """Judges realisations by how far rounding of every operation moves the outputs and checks at samples.

    What is said of an output here holds for a check too, which depends on the outputs and the exact inputs.
    """

    def __init__(
        self,
        problem: Problem,
        graph: Graph,
        points: Mapping[str, Floats],
        hard: Mapping[str, Floats] | None = None,
        guard_bits: int | None = None,
    ) -> None:
        """Judge by a realisation that is accurate enough.

        Args:
            problem: the problem, for its checks, and for which outputs are angles.
            graph: the realisation.
            points: an array of shape (n,) for each input.
            hard: the same of further points, at which outputs may move as they like: checks alone are judged.
            guard_bits: of words between operations that have no exponents, so that an error is as large for
                all of them: checks are judged by such errors then.  None: words have exponents.
        """
        self._guard_bits = guard_bits
        easy = len(next(iter(points.values()), ()))
        if hard is not None:
            points = {name: np.concatenate([column, hard[name]]) for name, column in points.items()}
        self._is_angle = {name: problem.output(name).is_angle for name in graph.outputs}
        self._checks = problem.check_graph
        self._points = points
        self._allowed, self._near = {}, {}
        exact = self._results(graph, all_results(graph, points), points)
        words = self._of_words({name: exact[name] for name in graph.outputs})
        for name, moved in self._moved(graph).items():
            least = np.nan_to_num(words[name])
            usual = max(float(np.median(moved[:easy])), float(np.median(least[:easy])))
            with np.errstate(over="ignore"):
                self._allowed[name] = np.maximum(_WORSE * moved, _USUAL * usual)
                near = _FAR * np.maximum(least, usual)
            if name in self._checks.outputs:
                self._near[name] = near
            else:
                self._allowed[name][easy:] = np.inf

    def less_accurate(self, graph: Graph) -> tuple[str, int] | None:
        """Return an output and a sample that rounding moves too far in a graph, None if there is none.

        Of all outputs and samples those that are moved most, compared with what is allowed.
        """
        return self.judged(graph)[0]

    def judged(self, graph: Graph) -> tuple[tuple[str, int] | None, tuple[str, int] | None]:
        """Return what `less_accurate` does, and a check and a sample that rounding moves far.

        Far is much further than is usual, and than rounded words alone would. The realisation that is
        accurate enough may do so itself: then only another way to the outputs does better.
        """
        moved = self._moved(graph)
        return _farthest(moved, self._allowed), _farthest(moved, self._near)

    def culprit(self, graph: Graph, output: str, sample: int, among: Collection[Value]) -> Value | None:
        """Return the result whose rounding moves an output at a sample most, of some; None if none does."""
        results, moved = self._each_moves(graph, output, sample, among)
        if not results or not np.max(moved) > 0:
            return None
        if output in self._checks.outputs:
            # What a check tells of is how an angle is taken, and not how the numbers for it are written.
            units = np.array([graph.node(value).definition.level is Level.UNIT for value in results])
            if np.max(moved, where=units, initial=0.0) > np.max(moved) / _WORSE:
                moved = np.where(units, moved, 0.0)
        return results[int(np.argmax(moved))]

    def movers(self, graph: Graph, output: str, sample: int, among: Collection[Value]) -> list[Value]:
        """Return the results of units, of some, whose rounding moves an output far, the farthest first."""
        units = [value for value in among if graph.node(value).definition.level is Level.UNIT]
        results, moved = self._each_moves(graph, output, sample, units)
        order = np.argsort(-moved, kind="stable")
        return [results[at] for at in order if moved[at] > 0 and moved[at] >= moved[order[0]] / _WORSE]

    def _each_moves(
        self, graph: Graph, output: str, sample: int, among: Collection[Value]
    ) -> tuple[list[Value], Floats]:
        """Return results, of some those that are used, and how far each moves an output at a sample."""
        wanted = sorted(graph.used_results().intersection(among))
        guard_bits = self._guard_bits if output in self._checks.outputs else None
        columns = {value: column for column, value in enumerate(wanted)}
        numbers = iter(range(len(graph.nodes)))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            index = next(numbers)
            outside = [np.zeros_like(x) for x in made]
            inside = np.zeros_like(made[0])
            for r, step in enumerate(outside):
                column = columns.get(Value(index, r))
                if column is not None:
                    # The residual of an equation moves its angle much further than rounding does.
                    (inside if node.op == "implicit" else step)[column] = 1.0
            return disturbed(node, operands, made, inside, outside, guard_bits=guard_bits)

        # One column for each result, in which it alone is moved, and one in which none is.
        inputs = {name: np.full(len(wanted) + 1, column[sample]) for name, column in self._points.items()}
        found = self._results(graph, all_results(graph, inputs, rounded), inputs)[output]
        return wanted, np.nan_to_num(self._distance(output, found[:-1], found[-1]))

    def _results(
        self, graph: Graph, values: Sequence[Results], inputs: Mapping[str, Floats]
    ) -> dict[str, Floats]:
        """Return the outputs of a graph whose nodes have some results, and the checks."""
        outputs = {name: values[v.node][v.result] for name, v in graph.outputs.items()}
        return outputs | self._checked({**inputs, **outputs})

    def _checked(self, words: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the checks, given inputs and outputs; NaN where they have no value."""
        found = all_results(self._checks, words)
        values = {name: found[v.node][v.result] for name, v in self._checks.outputs.items()}
        return {name: np.where(np.isfinite(value), value, np.nan) for name, value in values.items()}

    def _of_words(self, outputs: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return how far outputs and checks move because words are rounded, whatever makes them."""
        sizes = {name: np.full_like(x, ROUNDING * np.max(np.abs(x))) for name, x in outputs.items()}
        steps = sizes | {name: ROUNDING * np.abs(column) for name, column in self._points.items()}
        words = {**self._points, **outputs}
        exact = self._checked(words)
        moved = {name: np.zeros_like(value) for name, value in exact.items()}
        for name, step in steps.items() if exact else ():
            for check, value in self._checked(words | {name: words[name] + step}).items():
                moved[check] = np.hypot(moved[check], value - exact[check])
        return sizes | moved

    def _moved(self, graph: Graph) -> dict[str, Floats]:
        """Return how far rounding moves each output and check, as a mean square."""
        moved = self._moved_by(graph, None)
        if self._guard_bits is not None and self._checks.outputs:
            fixed = self._moved_by(graph, self._guard_bits)
            moved |= {name: fixed[name] for name in self._checks.outputs}
        return moved

    def _moved_by(self, graph: Graph, guard_bits: int | None) -> dict[str, Floats]:
        """Return how far rounding to as many digits as single precision has moves each output and check.

        Units err as they do: those that turn vectors by the vector's length, angles absolutely.
        """
        generator = np.random.Generator(np.random.PCG64(11))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            inside = generator.uniform(-1, 1, made[0].shape) if node.op == "implicit" else made[0]
            outside = [generator.uniform(-1, 1, x.shape) for x in made]
            return disturbed(node, operands, made, inside, outside, guard_bits=guard_bits)

        # Against its own exact values: whether they are those of the problem is not judged by samples.
        exact = self._results(graph, all_results(graph, self._points), self._points)
        # All tries at once: each sample stands in the columns as often as it is tried.
        points = {name: np.tile(column, _TRIES) for name, column in self._points.items()}
        moved = {}
        for name, column in self._results(graph, all_results(graph, points, rounded), points).items():
            distance = self._distance(name, column.reshape(_TRIES, -1), exact[name])
            # A sample that rounding takes out of the domain lies at its edge and tells nothing.
            moved[name] = _mean_square(np.nan_to_num(distance))
        return moved

    def _distance(self, output: str, found: Floats, exact: Floats) -> Floats:
        """Return how far values of an output are from exact ones, angles modulo 2 pi."""
        difference = np.abs(found - exact)
        angle = self._is_angle.get(output, False)
        return np.minimum(difference, np.abs(difference - 2 * np.pi)) if angle else difference


def _mean_square(values: Floats) -> Floats:
    """Return the root of the mean square of each column; large values do not overflow."""
    largest = np.max(values, axis=0)
    shares = np.divide(values, largest, out=np.zeros_like(values), where=largest > 0)
    return np.asarray(largest * np.sqrt(np.mean(shares**2, axis=0)))


def _farthest(moved: Mapping[str, Floats], allowed: Mapping[str, Floats]) -> tuple[str, int] | None:
    """Return the name and the sample that are moved further than allowed, those that are so most."""
    worst, found = 1.0, None
    for name, limit in allowed.items():
        ratios = np.divide(moved[name], limit, out=np.where(moved[name] > 0, np.inf, 0.0), where=limit > 0)
        sample = int(np.argmax(ratios))
        if ratios[sample] > worst:
            worst, found = float(ratios[sample]), (name, sample)
    return found
