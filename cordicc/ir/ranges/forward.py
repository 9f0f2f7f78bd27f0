"""Enclosures of every value of a graph over the input ranges."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.enclosures import result_ranges
from cordicc.ir.meaning.intervals import Interval

Enclosures = list[tuple[Interval | None, ...]]
"""For each node an enclosure of each result; None for a result that no input gives a value."""


def value_ranges(graph: Graph, inputs: Mapping[str, Interval]) -> Enclosures:
    """Return, for each node, an outward-rounded enclosure of each of its results.

    None stands for a result that no input gives a value.
    """
    found: Enclosures = []
    for node in graph.nodes:
        if node.op == "input":
            found.append((inputs[node.name],))
        else:
            found.append(_enclosed(node, found))
    return found


def refreshed(graph: Graph, nodes: Iterable[int], enclosures: Enclosures) -> None:
    """Evaluate nodes, in ascending order, anew in place; each keeps what it knew besides what it learns."""
    for index in nodes:
        made = _enclosed(graph.nodes[index], enclosures)
        enclosures[index] = tuple(
            None if new is None or old is None else old.intersect(new)
            for new, old in zip(made, enclosures[index], strict=True)
        )


def evaluated(
    graph: Graph, nodes: Iterable[int], known: Mapping[Value, Interval | None], wanted: Value
) -> Interval | None:
    """Enclose one value from known ones; `nodes`, ascending, are what lies between them."""
    found: dict[int, tuple[Interval | None, ...]] = {}

    def operand(value: Value) -> Interval | None:
        return known[value] if value in known else found[value.node][value.result]

    for index in nodes:
        node = graph.nodes[index]
        operands = [operand(value) for value in node.operands]
        if any(each is None for each in operands):
            found[index] = (None,) * len(node.definition.results)
        else:
            found[index] = result_ranges(node.op, node.params, operands)
    return operand(wanted)


def _enclosed(node: Node, enclosures: Enclosures) -> tuple[Interval | None, ...]:
    operands = [enclosures[v.node][v.result] for v in node.operands]
    if any(each is None for each in operands):
        return (None,) * len(node.definition.results)
    return result_ranges(node.op, node.params, operands)
