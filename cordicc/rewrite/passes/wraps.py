"""Drop the wrap of outputs that are principal values already."""

from __future__ import annotations

from dataclasses import dataclass

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.passes.base import PassContext, Site, transform

PRINCIPAL = ("atan2", "acos", "asin", "atan", "solve_pair")
INSIDE = 3.1415
"""A range within plus or minus this stays inside (-pi, pi] after rounding in every format."""


@dataclass(frozen=True, slots=True)
class DropWraps:
    """A principal value needs no wrap: the units never round an angle across +-pi.

    Runs first, while the functions whose definition bounds their value are still in sight.
    """

    name: str = "drop-wraps"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph with needless wraps gone."""
        ranges = context.ranges(graph)

        def rule(site: Site) -> tuple[Value, ...] | None:
            if site.node.op != "wrap":
                return None
            value = site.node.operands[0]
            made = graph.node(value)
            base = graph.node(made.operands[0]) if made.op == "neg" else made
            interval = ranges[value.node][value.result]
            inside = interval is not None and interval.magnitude <= INSIDE
            return site.operands if base.op in PRINCIPAL or inside else None

        return transform(graph, rule)
