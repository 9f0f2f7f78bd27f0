"""Drop selections whose condition has one sign over all inputs, and max(s, 0) and |s| of sums of squares."""

from __future__ import annotations

from dataclasses import dataclass

from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.signs import is_square_sum
from cordicc.rewrite.passes.base import PassContext, Ranges, Site, transform

_DEPTH = 8


@dataclass(frozen=True, slots=True)
class _Enclosed:
    """The nodes of a graph and their ranges."""

    graph: Graph
    ranges: Ranges

    def node(self, value: Value) -> Node:
        """Return the node that makes a value."""
        return self.graph.node(value)

    def range(self, value: Value) -> Interval | None:
        """Return the enclosure of a value."""
        return self.ranges[value.node][value.result]


@dataclass(frozen=True, slots=True)
class Selections:
    """select(s, a, b) is a where s >= 0 by its range or as a sum of squares, b where s < 0.

    max(s, c) with c <= 0, and |s|, are s where s is a sum of squares, which no rounding makes negative.
    """

    name: str = "selections"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph without selections that are decided."""
        known = _Enclosed(graph, context.ranges(graph))

        def rule(site: Site) -> tuple[Value, ...] | None:
            if site.node.op in ("max", "abs"):
                kept = _bounded(known, site.node)
                return None if kept is None else (site.operands[kept],)
            if site.node.op != "select":
                return None
            condition, first, second = site.node.operands
            interval = known.range(condition)
            if is_square_sum(known, condition, _DEPTH):
                kept, dropped = 1, 2
            elif interval is not None and interval.hi < 0:
                kept, dropped = 2, 1
            else:
                return None
            # What is dropped may still decide who has a value.
            value = site.builder.guard(site.operands[kept], site.operands[0], "any")
            if not _same_domain(graph.node(first), graph.node(second)):
                value = site.builder.guard(value, site.operands[dropped], "any")
            return (value,)

        return transform(graph, rule)


def _bounded(known: _Enclosed, node: Node) -> int | None:
    """Return the operand that a maximum or an absolute value is, if it is a sum of squares."""
    numbers = [known.graph.constant(v) for v in node.operands]
    for at, value in enumerate(node.operands):
        others = numbers[:at] + numbers[at + 1 :]
        if all(n is not None and n <= 0 for n in others) and _never_below_zero(known, value, _DEPTH):
            return at
    return None


def _never_below_zero(known: _Enclosed, value: Value, depth: int) -> bool:
    """Tell whether a value is not negative however what it is made of is rounded."""
    node = known.node(value)
    match node.op:
        case "sqrt" | "hypot" | "abs":
            return True
        case "mul" if node.operands[0] == node.operands[1]:
            return True
        case "const":
            return node.number >= 0
        case "input":
            interval = known.range(value)
            return interval is not None and interval.lo >= 0
        case "cmul" if node.factor < 0:
            return False
        case "add" | "mul" | "cmul" | "shift":
            return depth > 0 and all(_never_below_zero(known, v, depth - 1) for v in node.operands)
    return False


def _same_domain(a: Node, b: Node) -> bool:
    """Tell whether two nodes are the two solutions of one equation, which exist together."""
    solutions = a.op == b.op == "solve" and {a.branch, b.branch} <= {"+", "-"}
    return solutions and a.m == b.m and a.operands == b.operands
