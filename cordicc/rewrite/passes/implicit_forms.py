"""Equations B cos t + A sin t = C and the inverse functions that are cases of it."""

from __future__ import annotations

from dataclasses import dataclass

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.passes.base import PassContext, Site, transform
from cordicc.rewrite.passes.ratio import denominator, positive_ratio, ratio


@dataclass(frozen=True, slots=True)
class ImplicitForms:
    """Turn `solve`, `acos`, `asin`, `acosh`, `asinh` into implicit operations.

    acos(C/B) is A = 0 and asin(C/A) is B = 0, so the division vanishes.  The remaining coefficient
    is made positive, as the principal value needs it; the unit reports a zero one as invalid.
    """

    name: str = "implicit-forms"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph with implicit operations."""
        ranges = context.ranges(graph)

        def rule(site: Site) -> tuple[Value, ...] | None:
            builder, op = site.builder, site.node.op
            zero = builder.const(0)
            if op == "solve":
                return builder.apply("implicit", site.operands, site.node.params)[:1]
            if op in ("acos", "asin"):
                below = denominator(graph, site.node.operands[0])
                interval = None if below is None else ranges[below.node][below.result]
                target, coefficient, _ = positive_ratio(builder, site.operands[0], interval)
                if op == "acos":
                    return builder.apply("implicit", (zero, coefficient, target), (1, "+"))[:1]
                return builder.apply("implicit", (coefficient, zero, target), (1, "-"))[:1]
            if op in ("acosh", "asinh"):
                target, coefficient = ratio(builder, site.operands[0])
                if op == "acosh":
                    return builder.apply("implicit", (zero, coefficient, target), (-1, "+"))[:1]
                return builder.apply("implicit", (coefficient, zero, target), (-1, "none"))[:1]
            return None

        return transform(graph, rule)
