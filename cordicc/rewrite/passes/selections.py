"""Drop selections whose condition has one sign over all inputs, and max(s, 0) and |s| of sums of squares."""

from __future__ import annotations

from dataclasses import dataclass

from cordicc.ir.graph import Graph, Node, Value
from cordicc.rewrite.exact.signs import is_square_sum, stays_nonnegative
from cordicc.rewrite.passes.base import Enclosed, PassContext, Site, transform

_DEPTH = 8


@dataclass(frozen=True, slots=True)
class Selections:
    """select(s, a, b) is a where s >= 0 by its range or as a sum of squares, b where s < 0.

    max(s, c) with c <= 0, and |s|, are s where s is a sum of squares, which no rounding makes negative.
    """

    name: str = "selections"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph without selections that are decided."""
        known = Enclosed(graph, context.ranges(graph))

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


def _bounded(known: Enclosed, node: Node) -> int | None:
    """Return the operand that a maximum or an absolute value is, if it is a sum of squares."""
    numbers = [known.graph.constant(v) for v in node.operands]
    for at, value in enumerate(node.operands):
        others = numbers[:at] + numbers[at + 1 :]
        if all(n is not None and n <= 0 for n in others) and stays_nonnegative(known, value, _DEPTH):
            return at
    return None


def _same_domain(a: Node, b: Node) -> bool:
    """Tell whether two nodes are the two solutions of one equation, which exist together."""
    solutions = a.op == b.op == "solve" and {a.branch, b.branch} <= {"+", "-"}
    return solutions and a.m == b.m and a.operands == b.operands
