"""Whether a realisation is as accurate as another one: how far rounding moves outputs and checks."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.doubles import Results, all_results
from cordicc.ir.meaning.roundings import SINGLE, Words
from cordicc.ir.ops import Level
from cordicc.ir.problem import Problem
from cordicc.rewrite.disturbances import Disturbances

_TRIES = 12
"""How often each sample is rounded."""

_WORSE = 8.0
"""How much more rounding may move an output at a sample than in the realisation of the passes."""

_USUAL = 4.0
"""How much it may move anywhere, of what is usual for the output."""

_FIT = 1.5
"""On fixed point, how much more it may move an output than that of inputs and outputs alone does."""

_FAR = 16.0
"""How much it moves a check too far, of what is usual and of what words that are rounded do at the sample."""


@dataclass(frozen=True, slots=True)
class RoundingEffect:
    """What rounding does to the outputs and checks of a realisation.

    Attributes:
        ratios: by name how far each sample is moved, compared with what is allowed.
        inaccurate: the name and the sample that are moved most, of those that are moved too far; None if
            none is.
        far: a check and a sample that are moved far: much further than is usual, and than rounded words
            alone would.  What is allowed may be as much: then only another way to the outputs does better.
        excessive: whether a check is moved by more than the largest that the problem states.
    """

    ratios: Mapping[str, Floats]
    inaccurate: tuple[str, int] | None
    far: tuple[str, int] | None
    excessive: bool


class AccuracyGate:
    """Judges realisations by how far rounding of every operation moves the outputs and checks at samples.

    Numbers with exponents are accurate enough in the realisation of the passes, and others are compared
    with it.  On fixed point that need not be so: what rounding of the inputs and outputs alone does, to which
    words have no alternative, is the measure for outputs there.  What is said of an output here holds for a
    check too, which depends on the outputs and the exact inputs, but for its measure: that is always the
    realisation of the passes.
    """

    def __init__(
        self,
        problem: Problem,
        graph: Graph,
        points: Mapping[str, Floats],
        hard: Mapping[str, Floats] | None = None,
        words: Words = SINGLE,
        coarsest: Words = SINGLE,
    ) -> None:
        """Judge by a realisation.

        Args:
            problem: the problem, for its checks, and for which outputs are angles.
            graph: the realisation.
            points: an array of shape (n,) for each input.
            hard: the same of further points, at which outputs may move as they like: checks alone are judged.
            words: how numbers are rounded at the least, by which outputs are judged.
            coarsest: how they are rounded at the most, by which checks are judged.
        """
        easy = len(next(iter(points.values()), ()))
        if hard is not None:
            points = {name: np.concatenate([column, hard[name]]) for name, column in points.items()}
        self._is_angle = {name: problem.output(name).is_angle for name in graph.outputs}
        self._checks = problem.check_graph
        self._limits = {check.name: float(check.max) for check in problem.checks if check.max is not None}
        self._points, self._words, self._coarsest = points, words, coarsest
        self._allowed, self._near = {}, {}
        values = all_results(graph, points)
        exact = self._results(graph, values, points)
        alone = self._of_words({name: exact[name] for name in graph.outputs})
        moved = self._moved(graph)
        for name, own in moved.items():
            least = np.nan_to_num(alone[name])
            # What is allowed of the largest numbers is any number.
            with np.errstate(over="ignore"):
                usual = max(float(np.median(own[:easy])), float(np.median(least[:easy])))
                self._allowed[name] = np.maximum(_WORSE * own, _USUAL * usual)
                if name in self._checks.outputs:
                    self._near[name] = _FAR * np.maximum(least, usual)
        if words.fixed:
            disturbances = Disturbances(words, graph, values)
            given = self._moved_by(graph, words, inputs_alone=True)
            for name, value in graph.outputs.items():
                with np.errstate(over="ignore"):
                    least = np.hypot(given[name], words.outside * disturbances.step(value.node, value.result))
                    self._allowed[name] = _FIT * np.maximum(least, np.median(least[:easy]))
        for name in graph.outputs:
            self._allowed[name][easy:] = np.inf

    def judged(self, graph: Graph) -> RoundingEffect:
        """Return how far rounding moves outputs and checks of a graph."""
        moved = self._moved(graph)
        ratios = _ratios(moved, self._allowed)
        excessive = any(bool(np.any(moved[name] > limit)) for name, limit in self._limits.items())
        return RoundingEffect(ratios, _farthest(ratios), _farthest(_ratios(moved, self._near)), excessive)

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
        words = self._coarsest if output in self._checks.outputs else self._words
        disturbances = Disturbances(words, graph, all_results(graph, self._points))
        columns = {value: column for column, value in enumerate(wanted)}
        numbers = iter(range(len(graph.nodes)))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            index = next(numbers)
            outside = [np.zeros_like(x) for x in made]
            inside = np.zeros_like(made[0])
            for r, step in enumerate(outside):
                column = columns.get(Value(index, r))
                if column is not None and node.op != "implicit":
                    step[column] = 1.0
                elif column is not None:
                    # The residual of an equation moves its angle much further than rounding does, and away
                    # from a double root at that: beyond it there is no solution.
                    inside[column] = -1.0 if operands[2][column] > 0 else 1.0
            return disturbances.disturbed(index, node, operands, made, inside, outside)

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
        rounding = self._coarsest.rounding * self._coarsest.outside
        sizes = {name: np.full_like(x, rounding * np.max(np.abs(x))) for name, x in outputs.items()}
        steps = sizes | {name: rounding * np.abs(column) for name, column in self._points.items()}
        words = {**self._points, **outputs}
        exact = self._checked(words)
        moved = {name: np.zeros_like(value) for name, value in exact.items()}
        for name, step in steps.items() if exact else ():
            for check, value in self._checked(words | {name: words[name] + step}).items():
                with np.errstate(over="ignore"):
                    moved[check] = np.hypot(moved[check], value - exact[check])
        return sizes | moved

    def _moved(self, graph: Graph) -> dict[str, Floats]:
        """Return how far rounding moves each output and check, as a mean square."""
        moved = self._moved_by(graph, self._words)
        if self._coarsest != self._words and self._checks.outputs:
            coarsely = self._moved_by(graph, self._coarsest)
            moved |= {name: coarsely[name] for name in self._checks.outputs}
        return moved

    def _moved_by(self, graph: Graph, words: Words, *, inputs_alone: bool = False) -> dict[str, Floats]:
        """Return how far rounding to some words moves each output and check.

        Units err as they do: those that turn vectors by the vector's length, angles absolutely.
        """
        generator = np.random.Generator(np.random.PCG64(11))
        # Against its own exact values: whether they are those of the problem is not judged by samples.
        values = all_results(graph, self._points)
        exact = self._results(graph, values, self._points)
        disturbances = Disturbances(words, graph, values)
        numbers = iter(range(len(graph.nodes)))

        def rounded(node: Node, operands: Sequence[Floats], made: Results) -> Results:
            index = next(numbers)
            if inputs_alone and node.op != "input":
                return made
            inside = generator.uniform(-1, 1, made[0].shape) if node.op == "implicit" else made[0]
            outside = [generator.uniform(-1, 1, x.shape) for x in made]
            return disturbances.disturbed(index, node, operands, made, inside, outside)

        # All tries at once: each sample stands in the columns as often as it is tried.
        points = {name: np.tile(column, _TRIES) for name, column in self._points.items()}
        moved = {}
        for name, column in self._results(graph, all_results(graph, points, rounded), points).items():
            distance = self._distance(name, column.reshape(_TRIES, -1), exact[name])
            # A sample that rounding takes out of the domain lies at its edge and tells nothing.
            moved[name] = root_mean_square(np.nan_to_num(distance))
        return moved

    def _distance(self, output: str, found: Floats, exact: Floats) -> Floats:
        """Return how far values of an output are from exact ones, angles modulo 2 pi."""
        with np.errstate(invalid="ignore"):  # of what is beyond every double
            difference = np.abs(found - exact)
        angle = self._is_angle.get(output, False)
        return np.minimum(difference, np.abs(difference - 2 * np.pi)) if angle else difference


def _ratios(moved: Mapping[str, Floats], allowed: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return by name how far each sample is moved, compared with what is allowed."""
    return {
        name: np.divide(moved[name], limit, out=np.where(moved[name] > 0, np.inf, 0.0), where=limit > 0)
        for name, limit in allowed.items()
    }


def _farthest(ratios: Mapping[str, Floats]) -> tuple[str, int] | None:
    """Return the name and the sample whose ratio is largest, None if none is above 1."""
    worst, found = 1.0, None
    for name, column in ratios.items():
        sample = int(np.argmax(column))
        if column[sample] > worst:
            worst, found = float(column[sample]), (name, sample)
    return found


def root_mean_square(tries: Floats) -> Floats:
    """Return the mean square of each column, of which the squares alone may be beyond every double."""
    largest = np.max(tries, axis=0)
    scale = np.where(largest > 0, largest, 1.0)
    return np.asarray(scale * np.sqrt(np.mean((tries / scale) ** 2, axis=0)))
