"""Poles of the equations: inputs in the ranges, their ends included, near which values grow without bound."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.base.arrays import Floats, Samples
from cordicc.base.diagnostics import Diagnostic, Severity, Source
from cordicc.ir.findings import example_of, place
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.doubles import all_results
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import Problem

_HALVINGS = 60
_NEARLY_ZERO = 1e-9

_WORK = 500_000
"""Operations that halving evaluates at the most, over all suspects."""

_STEP = 2.0**-50
"""Of the end of a range: a few roundings of it."""

_STEPS = (0, 1, 16, -1, -16)
"""Steps from an end at which it is looked at, first towards the inside, then out of the range."""

_INSIDE = 3
"""Of them, the end itself included."""

_NOISE = 16.0
"""Times what rounding makes of a number, what is no number."""

_NOTHING = 2.0**-40
"""Of the width of a range, what is no distance from 0."""

_CONFIRMED = 8
"""Corners at which a pole is looked for in high precision."""


@dataclass(frozen=True, slots=True)
class _Suspect:
    """An operation with a pole where `seen`, of one of its operands, is 0; the pole in words."""

    node: Node
    value: Value
    seen: Callable[[Floats], Floats]
    pole: str


@dataclass(frozen=True, slots=True)
class Poles:
    """Warnings of poles, and the operations that have one at an end of a range."""

    warnings: tuple[Diagnostic, ...] = ()
    at_ends: tuple[Node, ...] = ()


def find_poles(problem: Problem, source: Source, samples: Samples, corners: Samples) -> Poles:
    """Return a warning for each operation with a pole in the ranges of the inputs.

    Random samples never meet such an input, as they are a null set.  Two samples with different signs of a
    denominator show that it exists, and halving the line between them finds it, if the denominator does not
    jump.  At an end of a range it shows in the steps around the end, on whichever side of the pole the
    rounding of the end falls.

    Args:
        problem: the equations.
        source: their file.
        samples: inputs for which all equations have a value.
        corners: of the box of the ranges.
    """
    suspects = _suspects(problem.graph)
    if not suspects:
        return Poles()
    parts = Graph(problem.graph.nodes, {str(i): suspect.value for i, suspect in enumerate(suspects)})
    values, _ = reference_outputs(parts, samples)
    around = _Around.of(problem, corners)
    seen = [suspect.seen(values[str(index)]) for index, suspect in enumerate(suspects)]
    sizes = [_median_size(column) for column in seen]
    near = [np.empty(0)] * len(suspects) if around is None else around.screened(suspects, sizes)
    found, at_ends = [], []
    left = _WORK
    for index, suspect in enumerate(suspects):
        signs = np.sign(seen[index])
        both = bool((signs > 0).any() and (signs < 0).any())
        if not both and not near[index].size:
            continue
        graph = problem.graph.leading_to(suspect.value)
        left -= _HALVINGS * len(graph.nodes)
        if left < 0:
            found.append(_unfinished(problem, source, suspect.node))
            break
        pole, verb = None, "holds"
        if both:
            ends = (int(np.argmax(signs > 0)), int(np.argmax(signs < 0)))
            pole = _halved(graph, suspect, [{n: float(c[end]) for n, c in samples.items()} for end in ends])
        if pole is None and around is not None:
            pole, verb = around.confirmed(graph, suspect, near[index]), "ends at"
            at_ends += [] if pole is None else [suspect.node]
        if pole is not None:
            message = f"the range of the inputs {verb} {suspect.pole}"
            hint = f"near {_in_words(problem, pole)}"
            origin = suspect.node.origin
            found.append(place(problem, source, origin, "W321", message, hint, Severity.WARNING))
    return Poles(tuple(dict.fromkeys(found)), tuple(at_ends))


def _in_words(problem: Problem, pole: dict[str, float]) -> str:
    """Return a pole in words: what halving leaves of 0 is 0."""
    ranges = problem.workspace.ranges
    at = {n: 0.0 if abs(x) < _NOTHING * (ranges[n][1] - ranges[n][0]) else x for n, x in pole.items()}
    return example_of({name: np.array([x]) for name, x in at.items()}, 0)


def _median_size(column: Floats) -> float:
    """Return the magnitude that half of some numbers exceed, one of them; 0 without any."""
    return float(np.sort(np.abs(column))[column.size // 2]) if column.size else 0.0


def _suspects(graph: Graph) -> list[_Suspect]:
    found = []
    for node in graph.nodes:
        match node.op:
            case "div":
                found.append(_Suspect(node, node.operands[1], _itself, "a division by 0"))
            case "pow" if node.exponent < 0:
                found.append(_Suspect(node, node.operands[0], _itself, "a division by 0"))
            case "tan":
                found.append(_Suspect(node, node.operands[0], np.cos, "a pole of tan"))
            case "log":
                found.append(_Suspect(node, node.operands[0], _itself, "a pole of log"))
            case "atanh":
                found.append(_Suspect(node, node.operands[0], lambda x: 1 - np.abs(x), "a pole of atanh"))
    return found


def _itself(values: Floats) -> Floats:
    return values


def _unfinished(problem: Problem, source: Source, node: Node) -> Diagnostic:
    message = "denominators from here on are not looked at: the problem is large"
    return place(problem, source, node.origin, "W322", message, None, Severity.WARNING)


@dataclass(frozen=True, slots=True)
class _Around:
    """Points around the corners of the ranges: for each of `_STEPS` all corners, moved by it."""

    problem: Problem
    points: dict[str, Floats]
    corners: int

    @classmethod
    def of(cls, problem: Problem, corners: Samples) -> _Around | None:
        """Return the points around corners, None if there are no corners."""
        count = len(next(iter(corners.values()), ()))
        if not count:
            return None
        points = {}
        for name, (lo, hi) in problem.workspace.ranges.items():
            ends = corners[name]
            inside = np.where(ends == lo, 1.0, -1.0) if lo < hi else np.zeros(count)
            with np.errstate(over="ignore", invalid="ignore"):  # of ranges as wide as all doubles
                step = _STEP * np.where(ends == 0, hi - lo, np.abs(ends)) * inside
                points[name] = np.concatenate([ends + times * step for times in _STEPS])
        return cls(problem, points, count)

    def screened(self, suspects: Sequence[_Suspect], sizes: Sequence[float]) -> list[np.ndarray]:
        """Return, for each suspect, the corners that double precision does not tell from a pole.

        `sizes` are those that what is seen of the suspects has elsewhere.
        """
        results = all_results(self.problem.graph, self.points)
        found = []
        for suspect, size in zip(suspects, sizes, strict=True):
            with np.errstate(invalid="ignore"):
                seen = suspect.seen(results[suspect.value.node][suspect.value.result])
            steps = seen.reshape(len(_STEPS), self.corners)
            found.append(np.flatnonzero(_touched(steps, 2.0**-40 * size)))
        return found

    def confirmed(self, graph: Graph, suspect: _Suspect, near: np.ndarray) -> dict[str, float] | None:
        """Return the first corner at which a suspect has a pole beside inputs that have values, if any."""
        for corner in near[:_CONFIRMED].tolist():
            at = {name: column[corner :: self.corners] for name, column in self.points.items()}
            values, _ = reference_outputs(graph, at)
            rounded, _ = reference_outputs(graph, at, jitter=True)
            _, valid = reference_outputs(self.problem.graph, at)
            seen, again = suspect.seen(values["out"]), suspect.seen(rounded["out"])
            # What the rounding of operands to 90 bits makes is no number.
            noise = np.abs(seen - again).max() if np.isfinite([seen, again]).all() else 0.0
            if valid[:_INSIDE].any() and _touched(seen[:, None], _NOISE * noise)[0]:
                return {name: float(column[0]) for name, column in at.items()}
        return None


def _touched(steps: Floats, nothing: float) -> np.ndarray:
    """Return whether numbers on the way over an end, of shape (steps, n), show a 0 there.

    They do if the smallest of them is as good as `nothing`, or no more than what the steps make of it, which
    are roundings of the end.
    """
    size = np.where(np.isfinite(steps), np.abs(steps), np.inf).min(axis=0)
    high = np.where(np.isfinite(steps), steps, -np.inf).max(axis=0)
    low = np.where(np.isfinite(steps), steps, np.inf).min(axis=0)
    return np.asarray(np.isfinite(size) & ((size <= nothing) | (size <= high - low)))


def _halved(graph: Graph, suspect: _Suspect, ends: list[dict[str, float]]) -> dict[str, float] | None:
    """Return a point between two of different sign where the output of a graph is nearly 0, if any."""
    positive, negative = ends
    number = scale = 0.0
    for _ in range(_HALVINGS):
        middle = {name: (positive[name] + negative[name]) / 2 for name in positive}
        values, _ = reference_outputs(graph, {name: np.array([x]) for name, x in middle.items()})
        number = float(suspect.seen(values["out"])[0])
        if np.isnan(number):
            return None
        scale = max(scale, abs(number))
        if number >= 0:
            positive = middle
        else:
            negative = middle
    return positive if abs(number) <= _NEARLY_ZERO * max(scale, 1e-300) else None
