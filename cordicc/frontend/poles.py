"""Poles inside the ranges: inputs at which a denominator changes its sign."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cordicc.base.diagnostics import Diagnostic, Severity, Source
from cordicc.ir.findings import example_of, place
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import Problem

_HALVINGS = 60
_NEARLY_ZERO = 1e-9

_WORK = 2_000_000
"""Operations that halving evaluates at the most, over all denominators."""


def find_poles(problem: Problem, source: Source, samples: Mapping[str, np.ndarray]) -> list[Diagnostic]:
    """Return a warning for each denominator, cosine under a tangent included, that passes through 0.

    Random samples never meet such an input, as they are a null set; two samples with different signs
    show that it exists, and halving the line between them finds it, if the denominator does not jump.
    """
    suspects = [(node, _denominator(node)) for node in problem.graph.nodes if node.op in ("div", "tan")]
    suspects += [(n, n.operands[0]) for n in problem.graph.nodes if n.op == "pow" and n.exponent < 0]
    if not suspects:
        return []
    parts = Graph(problem.graph.nodes, {str(i): value for i, (_, value) in enumerate(suspects)})
    values, _ = reference_outputs(parts, samples)
    found = []
    left = _WORK
    for index, (node, value) in enumerate(suspects):
        signs = np.sign(_seen(node, values[str(index)]))
        if (signs > 0).any() and (signs < 0).any():
            graph = problem.graph.leading_to(value)
            left -= _HALVINGS * len(graph.nodes)
            if left < 0:
                found.append(_unfinished(problem, source, node))
                break
            ends = (int(np.argmax(signs > 0)), int(np.argmax(signs < 0)))
            pole = _halved(graph, node, [{n: float(c[end]) for n, c in samples.items()} for end in ends])
            if pole is not None:
                what = "a pole of tan" if node.op == "tan" else "a division by 0"
                message = f"the range of the inputs holds {what}"
                hint = f"near {example_of({n: np.array([x]) for n, x in pole.items()}, 0)}"
                found.append(place(problem, source, node.origin, "W321", message, hint, Severity.WARNING))
    return list(dict.fromkeys(found))


def _denominator(node: Node) -> Value:
    return node.operands[1] if node.op == "div" else node.operands[0]


def _seen(node: Node, values: np.ndarray) -> np.ndarray:
    """Return what must not be 0: the denominator, or the cosine of a tangent's angle."""
    return np.cos(values) if node.op == "tan" else values


def _unfinished(problem: Problem, source: Source, node: Node) -> Diagnostic:
    message = "denominators from here on are not looked at: the problem is large"
    return place(problem, source, node.origin, "W322", message, None, Severity.WARNING)


def _halved(graph: Graph, node: Node, ends: list[dict[str, float]]) -> dict[str, float] | None:
    """Return a point between two of different sign where the output of a graph is nearly 0, if any."""
    positive, negative = ends
    number = scale = 0.0
    for _ in range(_HALVINGS):
        middle = {name: (positive[name] + negative[name]) / 2 for name in positive}
        values, _ = reference_outputs(graph, {name: np.array([x]) for name, x in middle.items()})
        number = float(_seen(node, values["out"])[0])
        if np.isnan(number):
            return None
        scale = max(scale, abs(number))
        if number >= 0:
            positive = middle
        else:
            negative = middle
    return positive if abs(number) <= _NEARLY_ZERO * max(scale, 1e-300) else None
