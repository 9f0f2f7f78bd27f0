"""What is checked by evaluating: the domain of a problem, and that rewriting kept its meaning."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cordicc.arith.intervals import Interval
from cordicc.diagnostics import Diagnostic, InvalidInput, Severity
from cordicc.emulate import sampling
from cordicc.ir.graph import Graph
from cordicc.ir.problem import Problem
from cordicc.ir.ranges import value_ranges
from cordicc.ir.reference import evaluate
from cordicc.ir.text import print_graph

_DOMAIN_SAMPLES = 1_000
"""Samples on which inputs outside the domain are looked for."""

_PROBES = 24
"""Samples on which every rewriting is compared with the equations, besides its proofs."""


def input_intervals(problem: Problem) -> dict[str, Interval]:
    """Return an enclosure of each input's range."""
    return {
        spec.name: Interval(
            math.nextafter(float(spec.lo), -math.inf), math.nextafter(float(spec.hi), math.inf)
        )
        for spec in problem.inputs
    }


def problem_data(problem: Problem, warnings: Sequence[Diagnostic]) -> dict[str, Any]:
    """Return what a plan records of its problem: enough to simulate and to judge without the file."""
    samples = problem.samples
    return {
        "name": problem.name,
        "description": problem.description,
        "inputs": [
            {"name": i.name, "lo": float(i.lo), "hi": float(i.hi), "unit": i.unit} for i in problem.inputs
        ],
        "constants": {name: float(value) for name, value in problem.constants.items()},
        "equations": [{"target": e.target, "text": e.text} for e in problem.equations],
        "outputs": [
            {
                "name": o.name,
                "angle": o.is_angle,
                "wrap": o.wrap,
                "max_error": None if o.max_error is None else float(o.max_error),
            }
            for o in problem.outputs
        ],
        "program": print_graph(problem.graph),
        "samples": None
        if samples is None
        else {"columns": {name: list(column) for name, column in samples.columns.items()}},
        "warnings": [f"{w.code}: {w.message}" for w in warnings],
    }


def check_domain(problem: Problem) -> list[Diagnostic]:
    """Look for inputs outside the domain of the equations.

    Raises:
        InvalidInput: provably all of the range, or every row of the problem's samples, is outside.
    """
    samples = sampling.draw(problem_data(problem, []), _DOMAIN_SAMPLES, 0)
    _check_hyperbolic_case(problem, samples)
    ranges = value_ranges(problem.graph, input_intervals(problem))
    nowhere = [
        problem.graph.nodes[index] for index, results in enumerate(ranges) if all(r is None for r in results)
    ]
    if nowhere:
        line = next((e for e in problem.equations if e.target == nowhere[0].origin), None)
        message = f"'{nowhere[0].op}' in the equation of '{nowhere[0].origin}' has no value for any input"
        hint = None if line is None else f"line {line.line}: {line.text}"
        raise InvalidInput([Diagnostic("E320", message, hint=hint)])
    _, valid = evaluate(problem.graph, samples)
    if bool(valid.all()):
        return []
    example = _example(samples, int(np.argmin(valid)))
    if not valid.any() and problem.samples is not None:
        message = "every row of the samples is outside the domain of the equations"
        raise InvalidInput([Diagnostic("E321", message, hint=f"for example {example}")])
    outside = int((~valid).sum())
    message = f"{outside} of {len(valid)} samples of the inputs are outside the domain of the equations"
    return [Diagnostic("W320", message, None, f"for example {example}", Severity.WARNING)]


def _check_hyperbolic_case(problem: Problem, samples: Mapping[str, np.ndarray]) -> None:
    """Refuse a hyperbolic `solve` without a branch where a sample has two solutions, |B| > |A|."""
    for node in problem.graph.nodes:
        if node.op != "solve" or node.params != (-1, "none"):
            continue
        coefficients, _ = evaluate(
            Graph(problem.graph.nodes, {"A": node.operands[0], "B": node.operands[1]}), samples
        )
        two = np.abs(coefficients["B"]) > np.abs(coefficients["A"])
        if two.any():
            message = f"the equation of '{node.origin}' has two solutions for some inputs and needs a branch"
            hint = f"for example {_example(samples, int(np.argmax(two)))}; add branch: '+' or branch: '-'"
            raise InvalidInput([Diagnostic("E322", message, hint=hint)])


def _example(samples: Mapping[str, np.ndarray], index: int) -> str:
    return ", ".join(f"{name} = {column[index]:.6g}" for name, column in samples.items())


def check_meaning(problem: Problem, graph: Graph) -> None:
    """Assert that the rewritten graph computes what the equations say, on a few samples.

    Samples at which the equations themselves jump (a branch cut, the edge of the domain) prove
    nothing and are passed over: those that change under a perturbation of the inputs by 2^-40.
    """
    samples = sampling.draw(problem_data(problem, []), _PROBES, 1)
    exact, defined = evaluate(problem.graph, samples)
    nearby, still_defined = evaluate(
        problem.graph, {n: column * (1 + 2.0**-40) for n, column in samples.items()}
    )
    rewritten, kept = evaluate(graph, samples)

    def distance(a: np.ndarray, b: np.ndarray, is_angle: bool) -> np.ndarray:
        difference: np.ndarray = np.abs(a - b)
        wrapped: np.ndarray = np.minimum(difference, np.abs(difference - math.tau))
        return wrapped if is_angle else difference

    steady = defined == still_defined
    for output in problem.outputs:
        value, scale = exact[output.name], 1 + np.abs(exact[output.name])
        steady &= ~defined | (distance(value, nearby[output.name], output.is_angle) <= 1e-6 * scale)
    assert np.array_equal(defined[steady], kept[steady]), "rewriting changed which samples are valid"
    for output in problem.outputs:
        value, scale = exact[output.name], 1 + np.abs(exact[output.name])
        error = distance(value, rewritten[output.name], output.is_angle)
        assert np.all((error <= 1e-9 * scale)[steady & defined]), f"rewriting changed output {output.name}"
