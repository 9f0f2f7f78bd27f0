"""What a pass is, and the walk that passes share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.ranges.forward import value_ranges
from cordicc.rewrite.exact.algebra import Algebra

Ranges = Sequence[tuple[Interval | None, ...]]
"""For each node an enclosure of each result; None for a result that no input gives a value."""


@dataclass(frozen=True, slots=True)
class PassContext:
    """What a pass may rest on besides the graph: the range of each input and the user's goal.

    `floating`: numbers have exponents, so that large values do not cost small ones their digits.
    `effort`: the work of a search, as a multiple of the usual.
    `careful`: digits are kept wherever a realisation can keep them, whatever it takes.
    """

    inputs: Mapping[str, Interval]
    goal: str = "processors"
    floating: bool = True
    effort: float = 1.0
    careful: bool = False

    def ranges(self, graph: Graph) -> Ranges:
        """Return enclosures of every result of every node."""
        return value_ranges(graph, self.inputs)


@dataclass(frozen=True, slots=True)
class Enclosed:
    """The nodes of a graph and their ranges."""

    graph: Graph
    ranges: Ranges

    def node(self, value: Value) -> Node:
        """Return the node that makes a value."""
        return self.graph.node(value)

    def range(self, value: Value) -> Interval | None:
        """Return the enclosure of a value."""
        return self.ranges[value.node][value.result]


class Pass(Protocol):
    """A pass: valid graph in, valid graph out, the same outputs with the same meaning."""

    @property
    def name(self) -> str:
        """The name for `--print-after`."""
        ...

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the rewritten graph."""
        ...


@dataclass(frozen=True, slots=True)
class Site:
    """An operation under rewriting: its old graph, index and node, its new operands, the builder."""

    builder: Algebra
    graph: Graph
    index: int
    node: Node
    operands: tuple[Value, ...]
    results: list[tuple[Value, ...]]

    def new(self, old: Value) -> Value:
        """Return what became of a value of the old graph that stands before this operation."""
        return self.results[old.node][old.result]


NodeRule = Callable[[Site], "tuple[Value, ...] | None"]


def transform(graph: Graph, rule: NodeRule) -> Graph:
    """Rebuild a graph node by node.

    `rule` returns the new results of an operation, or None to copy it, simplified by the algebra.
    """
    new = Algebra()
    results: list[tuple[Value, ...]] = []
    for index, node in enumerate(graph.nodes):
        new.origin = node.origin
        operands = tuple(results[v.node][v.result] for v in node.operands)
        made = rule(Site(new, graph, index, node, operands, results))
        results.append(new.apply(node.op, operands, node.params) if made is None else made)
    return new.build({name: results[v.node][v.result] for name, v in graph.outputs.items()})
