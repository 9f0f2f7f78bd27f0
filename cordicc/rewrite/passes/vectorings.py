"""Lengths, angles of vectors, roots and logarithms as vectoring operations."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.algebra import Algebra
from cordicc.rewrite.passes.base import Enclosed, PassContext, Ranges, Site, transform
from cordicc.rewrite.passes.lengths import (
    Angles,
    Leg,
    SmallLengths,
    angles_of_vectors,
    chained_length,
    length,
    signed_square,
)
from cordicc.rewrite.passes.ratio import denominator, positive_ratio, ratio


@dataclass(frozen=True, slots=True)
class Vectorings:
    """Turn atan2, hypot, sqrt, atan, atanh, log and the 2x2 `solve_pair` into vectorings.

    The length and the angle of one vector come from one circular vectoring, in whatever order and
    with whatever signs the length has its components; sqrt(x^2 - y^2) is hyperbolic vectoring; any
    other root, and a logarithm, is hyperbolic vectoring in light-cone coordinates.  On fixed point a sum of
    squares that may be small is a chain of lengths.
    """

    name: str = "vectorings"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph with vectorings."""
        ranges = context.ranges(graph)
        angles = angles_of_vectors(graph)
        small = context.careful or not context.floating
        lengths = SmallLengths(angles, Enclosed(graph, ranges), always=context.careful) if small else None

        def rule(site: Site) -> tuple[Value, ...] | None:
            builder, operands = site.builder, site.operands
            match site.node.op:
                case "atan2":
                    return (_angle(builder, operands[1], operands[0]),)
                case "hypot" | "sqrt":
                    return (_root(site, angles, lengths),)
                case "atan":
                    below = denominator(graph, site.node.operands[0])
                    return (_arctangent(builder, operands[0], _at(ranges, below)),)
                case "atanh":
                    above, below_ = ratio(builder, operands[0])
                    return builder.apply("vector", (below_, above, builder.const(0)), (-1, 1))[1:]
                case "log":
                    logarithm = builder.apply("lightcone", ratio(builder, operands[0]))[1]
                    return (builder.scale(Fraction(2), logarithm),)
                case "solve_pair":
                    return (_pair(builder, operands),)
            return None

        return transform(graph, rule)


def _at(ranges: Ranges, value: Value | None) -> Interval | None:
    return None if value is None else ranges[value.node][value.result]


def _angle(builder: Algebra, x: Value, y: Value) -> Value:
    return builder.apply("vector", (x, y, builder.const(0)), (1, 1))[1]


def _root(site: Site, angles: Angles, lengths: SmallLengths | None) -> Value:
    """Return a length or a square root by the vectoring that fits, or by chains of lengths if given."""
    graph, builder, node = site.graph, site.builder, site.node
    if node.op == "hypot":
        first, second = (Leg.of(graph, v) for v in node.operands)
        return length(site, (first, second), angles)
    radicand = graph.node(node.operands[0])
    if radicand.op in ("add", "sub"):
        squares = [signed_square(graph, v) for v in radicand.operands]
        if squares[0] is not None and squares[1] is not None:
            (sign, x), (other_sign, y) = squares[0], squares[1]
            other_sign = other_sign if radicand.op == "add" else -other_sign
            if sign > 0 and other_sign > 0:
                return length(site, (x, y), angles)
            if sign != other_sign:
                x, y = (x, y) if sign > 0 else (y, x)
                return builder.apply("vector", (x.build(site), y.build(site), builder.const(0)), (-1, 1))[0]
        chained = chained_length(site, radicand, angles)
        if chained is not None:
            return chained
    chain = None if lengths is None else lengths.root(site, node.operands[0])
    if chain is not None:
        return chain
    if radicand.op == "mul":
        return builder.apply("lightcone", [site.new(v) for v in radicand.operands])[0]
    return builder.apply("lightcone", (site.operands[0], builder.const(1)))[0]


def _arctangent(builder: Algebra, value: Value, interval: Interval | None) -> Value:
    """Return atan(C/B) as the angle of the vector (B, C), turned into the right half plane."""
    above, below, nonzero = positive_ratio(builder, value, interval)
    angle = _angle(builder, below, above)
    return angle if nonzero is None else builder.guard(angle, nonzero, "nonzero")


def _pair(builder: Algebra, operands: tuple[Value, ...]) -> Value:
    """Return the angle of the solution (c, s) of the 2x2 system by Cramer's rule, without dividing.

    Both components are multiplied by |determinant|, which must not be 0.
    """
    A1, B1, C1, A2, B2, C2 = operands

    def minor(a: Value, b: Value, c: Value, d: Value) -> Value:
        return builder.sub(builder.mul(a, d), builder.mul(b, c))

    determinant = minor(B1, A1, B2, A2)
    cosine, sine = minor(C1, A1, C2, A2), minor(B1, C1, B2, C2)
    x, y = builder.flip(cosine, determinant), builder.flip(sine, determinant)
    return builder.guard(_angle(builder, x, y), determinant, "nonzero")
