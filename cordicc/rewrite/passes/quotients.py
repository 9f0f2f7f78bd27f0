"""Quotients by a variable as linear vectoring."""

from __future__ import annotations

from dataclasses import dataclass

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.passes.base import PassContext, Site, transform


@dataclass(frozen=True, slots=True)
class Quotients:
    """Turn each remaining quotient by a variable into linear vectoring."""

    name: str = "quotients"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph without functions."""

        def rule(site: Site) -> tuple[Value, ...] | None:
            if site.node.op != "div":
                return None
            above, below = site.operands
            return site.builder.apply("vector", (below, above, site.builder.const(0)), (0, 1))[1:]

        return transform(graph, rule)
