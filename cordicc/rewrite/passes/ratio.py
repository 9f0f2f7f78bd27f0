"""Quotients seen through signs and constant factors, with the sign of the denominator settled."""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.graph import Graph, Value, factored
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.algebra import Algebra


def ratio(builder: Algebra, value: Value) -> tuple[Value, Value]:
    """Return numerator C and denominator B with value = C/B.

    B is the denominator of a quotient, else a positive constant: a product with a constant k counts
    as a division by 1/k, so that no multiplier is left.
    """
    factor, base = factored(builder.nodes, value)
    node = builder.nodes[base.node]
    if node.op == "div":
        return builder.scale(factor, node.operands[0]), node.operands[1]
    sign = Fraction(1 if factor > 0 else -1)
    return builder.scale(sign, base), builder.const(1 / abs(factor))


def denominator(graph: Graph, value: Value) -> Value | None:
    """Return the denominator that `ratio` would find in a graph, None if it is a constant."""
    node = graph.node(factored(graph.nodes, value)[1])
    return node.operands[1] if node.op == "div" else None


def positive_ratio(
    builder: Algebra, value: Value, interval: Interval | None
) -> tuple[Value, Value, Value | None]:
    """Return (C, B, s) with value = C/B and B >= 0; `interval` encloses the denominator.

    Where the interval does not settle the sign, a run-time selection does, and s is the denominator,
    which must not be 0; else s is None.
    """
    numerator, below = ratio(builder, value)
    number = builder.constant(below)
    if number is not None:
        sign = Fraction(1 if number > 0 else -1)
        return builder.scale(sign, numerator), builder.const(abs(number)), None
    if interval is not None and interval.lo > 0:
        return numerator, below, None
    if interval is not None and interval.hi < 0:
        return builder.neg(numerator), builder.neg(below), None
    return builder.flip(numerator, below), builder.apply("abs", (below,))[0], below
