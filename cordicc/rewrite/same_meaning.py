"""Whether rewriting kept the meaning of a problem, besides its proofs: equations and result on samples."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping

import numpy as np

from cordicc.ir import sampling
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.problem import OutputSpec, Problem

_PROBES = 24
"""Samples on which the two are compared."""

_FEWEST = 2
"""Samples in any case."""

_SHAKES = 16
"""Disturbed evaluations that show whether a sample hangs on rounding."""

_CONDITIONED = {"guard": 1, "sqrt": 0, "log": 0}
"""The operand on whose sign it depends whether an operation has a value."""

_WORK = 50_000
"""Disturbed operations that are evaluated at the most; large problems are compared on fewer samples."""


def check_meaning(problem: Problem, graph: Graph) -> None:
    """Assert that the rewritten graph computes what the equations say, on a few samples.

    A sample at which the equations themselves jump (a branch cut, the edge of the domain) or hang on
    rounding proves nothing and is passed over: one whose results change when its inputs are moved by
    2^-40 or when every operation is disturbed by 2^-90, in any of `_SHAKES` tries.  So is one that breaks
    what the problem assumes, or with a number on the way that is too large for every format, or with a
    condition on a number that is 0 but for rounding: on both sides of it there may be no value.
    """
    fitting = _WORK // max(1, len(problem.graph.nodes)) // _SHAKES
    probes = max(_FEWEST, min(_PROBES, fitting))
    samples = sampling.draw(problem.workspace, probes, 1)
    exact, defined = reference_outputs(problem.graph, samples)
    moved = reference_outputs(problem.graph, {n: column * (1 + 2.0**-40) for n, column in samples.items()})
    tiled = {name: np.tile(column, _SHAKES) for name, column in samples.items()}
    values, valid = reference_outputs(problem.graph, tiled, jitter=True)
    shaken = [
        ({n: v.reshape(_SHAKES, -1)[i] for n, v in values.items()}, valid.reshape(_SHAKES, -1)[i])
        for i in range(_SHAKES)
    ]
    rewritten, kept = reference_outputs(graph, samples)
    # Rewriting may rest on what is assumed of the inputs, which rows of few digits keep roughly.
    steady = problem.facts.kept(samples) & problem.facts.exactly(samples)
    for value, still_defined in (moved, *shaken):
        steady &= defined == still_defined
        for output in problem.outputs:
            steady &= ~defined | _near(output, exact, value, 1e-6)
    if not np.array_equal(defined[steady], kept[steady]):
        # A number that no format holds has no value here, and rewriting goes by other numbers on the way.
        steady &= ~(_leaves_range(problem.graph, samples) | _leaves_range(graph, samples))
        steady &= ~_on_border(problem.graph, samples)
    assert np.array_equal(defined[steady], kept[steady]), "rewriting changed which samples are valid"
    for output in problem.outputs:
        agree = _near(output, exact, rewritten, 1e-9)
        assert np.all(agree[steady & defined]), f"rewriting changed output {output.name}"


def _leaves_range(graph: Graph, samples: Mapping[str, np.ndarray]) -> np.ndarray:
    """Tell for which samples some number on the way is beyond every double."""
    values = [
        Value(i, result)
        for i, node in enumerate(graph.nodes)
        for result in range(len(node.definition.results))
    ]
    columns, _ = reference_outputs(Graph(graph.nodes, {str(v): v for v in values}), samples)
    found: np.ndarray = np.any([np.abs(c) >= sys.float_info.max for c in columns.values()], axis=0)
    return found


def _on_border(graph: Graph, samples: Mapping[str, np.ndarray]) -> np.ndarray:
    """Tell for which samples a condition is on a number that is nothing but rounding."""
    found: np.ndarray = np.zeros(len(next(iter(samples.values()), ())), dtype=bool)
    wanted = {node.operands[_CONDITIONED[node.op]] for node in graph.nodes if node.op in _CONDITIONED}
    parts = Graph(graph.nodes, {str(value): value for value in wanted})
    exact, _ = reference_outputs(parts, samples)
    shaken, _ = reference_outputs(parts, samples, jitter=True)
    for name, column in exact.items():
        found |= (column != 0) & (np.abs(column) <= _SHAKES * np.abs(column - shaken[name]))
    return found


def _near(
    output: OutputSpec, exact: Mapping[str, np.ndarray], other: Mapping[str, np.ndarray], tolerance: float
) -> np.ndarray:
    """Tell where two values of an output agree relative to 1 + |value|; an angle modulo 2 pi."""
    value = exact[output.name]
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.abs(value - other[output.name])
        if output.is_angle:
            difference = np.minimum(difference, np.abs(difference - math.tau))
        near: np.ndarray = (difference <= tolerance * (1 + np.abs(value))) | (value == other[output.name])
    return near
