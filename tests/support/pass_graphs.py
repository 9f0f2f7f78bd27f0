"""Graphs of three inputs, and what the passes make of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cordicc.ir.graph import Builder, Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ops import Level
from cordicc.ir.text import parse_graph, print_graph
from cordicc.ir.well_formed import verify
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import default_passes

NAMES = ("x", "y", "w")


def rewritten(graph: Graph, goal: str = "processors", *, implicit: bool = True, reach: float = 2.0) -> Graph:
    """Return what the passes make of a graph, well formed after each; inputs are within +-reach."""
    context = PassContext({name: Interval(-reach, reach) for name in NAMES}, goal)
    for step in default_passes(implicit=implicit):
        graph = step.apply(graph, context)
        verify(graph)
        assert parse_graph(print_graph(graph)) == graph
    verify(graph, frozenset({Level.LEAF, Level.ARITHMETIC, Level.UNIT}))
    return graph


def assert_same(graph: Graph, samples: dict[str, np.ndarray]) -> None:
    """Compare a graph with its rewritings; values within rounding of 113 bits, validity exactly."""
    exact, defined = reference_outputs(graph, samples)
    for implicit in (True, False):
        for goal in ("processors", "latency"):
            value, valid = reference_outputs(rewritten(graph, goal, implicit=implicit), samples)
            np.testing.assert_array_equal(valid, defined)
            for name in exact:
                np.testing.assert_allclose(value[name][valid], exact[name][valid], rtol=1e-9, atol=1e-9)


def samples(count: int = 40, seed: int = 1) -> dict[str, np.ndarray]:
    """Return random inputs within +-2, a column of `count` numbers for each."""
    generator = np.random.default_rng(seed)
    return {name: generator.uniform(-2, 2, count) for name in NAMES}


def build(make: Callable[..., Value | dict[str, Value]]) -> Graph:
    """Return the graph of what `make` returns for a builder and the three inputs: one value or several."""
    builder = Builder()
    values = [builder.input(name) for name in NAMES]
    made = make(builder, *values)
    outputs = made if isinstance(made, dict) else {"out": made}
    return builder.build(outputs)
