"""Enclosures of every value of a graph over the input ranges."""

from __future__ import annotations

from collections.abc import Mapping

from cordicc.arith.intervals import Interval, evaluate
from cordicc.ir.graph import Graph


def value_ranges(graph: Graph, inputs: Mapping[str, Interval]) -> list[tuple[Interval | None, ...]]:
    """Return, for each node, an outward-rounded enclosure of each of its results.

    None stands for a result that no input gives a value.
    """
    found: list[tuple[Interval | None, ...]] = []
    for node in graph.nodes:
        if node.op == "input":
            found.append((inputs[str(node.params[0])],))
            continue
        operands = [found[v.node][v.result] for v in node.operands]
        known = [interval for interval in operands if interval is not None]
        if len(known) < len(operands):
            found.append((None,) * len(node.definition.results))
        else:
            found.append(evaluate(node.op, node.params, known))
    return found
