"""What is checked by evaluating: the domain of a problem."""

from __future__ import annotations

import numpy as np

from cordicc.base.arrays import Floats, Samples
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity, Source
from cordicc.frontend.poles import Poles, find_poles
from cordicc.ir.findings import example_of, place
from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import Problem, input_intervals
from cordicc.ir.ranges.forward import value_ranges
from cordicc.ir.sampling import DEFAULT_SEED, corners, draw

_DOMAIN_SAMPLES = 1_000
"""Samples on which inputs outside the domain are looked for."""

_FEWEST = 32
"""Samples on which they are looked for in any case."""

_WORK = 400_000
"""Operations that a check evaluates at the most; large problems are looked at in fewer samples."""


def _within(work: int, graph: Graph, samples: int) -> int:
    """Return the number of samples that keeps a check within its work, `_FEWEST` at the least."""
    return max(_FEWEST, min(samples, work // max(1, len(graph.nodes))))


def check_domain(problem: Problem, source: Source) -> list[Diagnostic]:
    """Look for inputs outside the domain of the equations, at random and at the corners of the ranges.

    Raises:
        InvalidInput: provably all of the range, or every row of the problem's samples, is outside.
    """
    samples, ends = _looked_at(problem)
    _check_hyperbolic_case(problem, source, samples)
    ranges = value_ranges(problem.graph, input_intervals(problem))
    nowhere = [
        n for n, results in zip(problem.graph.nodes, ranges, strict=True) if all(r is None for r in results)
    ]
    if nowhere:
        op = nowhere[0].op
        message = "no input meets the condition" if op == "guard" else f"'{op}' has no value for any input"
        raise InvalidInput([place(problem, source, nowhere[0].origin, "E320", message)])
    _, valid = reference_outputs(problem.graph, samples)
    if problem.samples is not None:
        poles = Poles()
    else:
        poles = find_poles(problem, source, {name: column[valid] for name, column in samples.items()}, ends)
    if bool(valid.all()):
        return list(poles.warnings)
    outside = int(np.argmin(valid))
    example = f"for example {example_of(samples, outside)}"
    if not valid.any() and problem.samples is not None:
        message = "every row of the samples is outside the domain of the equations"
        raise InvalidInput([Diagnostic("E321", message, None, example, source=source)])
    drawn = len(valid) - len(next(iter(ends.values()), ()))
    if poles.at_ends and valid[:drawn].all():
        beyond = {name: column[~valid] for name, column in samples.items()}
        if _culprits(problem, beyond) <= set(poles.at_ends):
            return list(poles.warnings)  # nothing but the very ends is outside
    share = int((~valid).sum()) / len(valid)
    (culprit,) = _culprits(problem, {name: column[outside : outside + 1] for name, column in samples.items()})
    first = "a condition" if culprit.op == "guard" else f"'{culprit.op}'"
    message = f"about {share:.1%} of the inputs are outside the domain of the equations, first at {first}"
    warning = place(problem, source, culprit.origin, "W320", message, example, Severity.WARNING)
    return [warning, *poles.warnings]


def _looked_at(problem: Problem) -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Return samples, drawn ones and then corners of the ranges, and the corners alone.

    All keep what is assumed, if any of those drawn does.  A problem with samples has no corners.
    """
    count = _within(_WORK, problem.graph, _DOMAIN_SAMPLES)
    drawn = draw(problem.workspace, count, DEFAULT_SEED)
    if problem.samples is not None:
        return drawn, {name: column[:0] for name, column in drawn.items()}
    ends = corners(problem.workspace.ranges)
    kept = problem.facts.only(drawn)
    if all(column.size for column in kept.values()):
        drawn, ends = kept, problem.facts.only(ends)
    return {name: np.concatenate([column, ends[name]]) for name, column in drawn.items()}, ends


def _culprits(problem: Problem, samples: Samples) -> set[Node]:
    """Return the first operations that samples outside the domain leave without a value.

    Operations that have a value everywhere come last: they can only fail by the size of the number.
    """
    nodes = problem.graph.nodes
    values, _ = reference_outputs(
        Graph(nodes, {str(index): Value(index) for index in range(len(nodes))}), samples
    )
    order = sorted(range(len(nodes)), key=lambda i: not nodes[i].definition.partial)
    lacking = np.array([np.isnan(values[str(index)]) for index in order])
    assert lacking.any(axis=0).all(), "no operation is undefined"
    return {nodes[order[first]] for first in lacking.argmax(axis=0).tolist()}


def _check_hyperbolic_case(problem: Problem, source: Source, samples: Samples) -> None:
    """Refuse a hyperbolic `solve` without a branch where a sample has two solutions, |B| > |A|."""
    for node in problem.graph.nodes:
        if node.op != "solve" or node.params != (-1, "none"):
            continue
        parts = Graph(problem.graph.nodes, {"A": node.operands[0], "B": node.operands[1]})
        coefficients, _ = reference_outputs(parts, samples)
        two = np.abs(coefficients["B"]) > np.abs(coefficients["A"])
        if two.any():
            message = "the equation has two solutions for some inputs and needs a branch"
            hint = f'for example {example_of(samples, int(np.argmax(two)))}; add branch: "+" or branch: "-"'
            raise InvalidInput([place(problem, source, node.origin, "E322", message, hint)])
