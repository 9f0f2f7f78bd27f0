"""Lengths, angles of vectors, roots and logarithms as vectoring operations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from cordicc.arith.intervals import Interval
from cordicc.ir.fold import fold
from cordicc.ir.graph import Graph, Node, Value
from cordicc.rewrite.algebra import Algebra
from cordicc.rewrite.base import Context, Site, transform
from cordicc.rewrite.ratio import denominator, positive_ratio, ratio

Legs = tuple[Value, Value]


@dataclass(frozen=True, slots=True)
class Vectorings:
    """Turn atan2, hypot, sqrt, atan, atanh, log and the 2x2 `solve_pair` into vectorings.

    The length and the angle of one vector come from one circular vectoring, in whatever order and
    with whatever signs the length has its components; sqrt(x^2 - y^2) is hyperbolic vectoring; any
    other root, and a logarithm, is hyperbolic vectoring in light-cone coordinates.
    """

    name: str = "vectorings"

    def apply(self, graph: Graph, context: Context) -> Graph:
        """Return the graph with vectorings."""
        ranges = context.ranges(graph)
        angles = _angles(graph)

        def rule(site: Site) -> tuple[Value, ...] | None:
            builder, operands = site.builder, site.operands
            match site.node.op:
                case "atan2":
                    return (_angle(builder, operands[1], operands[0]),)
                case "hypot" | "sqrt":
                    return (_root(site, angles),)
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


def _at(ranges: Sequence[tuple[Interval | None, ...]], value: Value | None) -> Interval | None:
    return None if value is None else ranges[value.node][value.result]


def _angle(builder: Algebra, x: Value, y: Value) -> Value:
    return builder.apply("vector", (x, y, builder.const(0)), (1, 1))[1]


def _base(graph: Graph, value: Value) -> tuple[Fraction, Value]:
    """Return sign and value without negation."""
    node = graph.node(value)
    return (Fraction(-1), node.operands[0]) if node.op == "neg" else (Fraction(1), value)


def _key(graph: Graph, legs: Legs) -> frozenset[Value]:
    return frozenset(_base(graph, leg)[1] for leg in legs)


def _angles(graph: Graph) -> dict[frozenset[Value], Legs]:
    """Return the vectors (x, y) of which the graph takes the angle, by their components."""
    found: dict[frozenset[Value], Legs] = {}
    for node in graph.nodes:
        if node.op == "atan2":
            y, x = node.operands
            found.setdefault(_key(graph, (x, y)), (x, y))
    return found


Leg = Value | Fraction


def _signed_square(graph: Graph, value: Value) -> tuple[int, Leg] | None:
    """Return (sign, x) if the value stands as sign * x^2: a product of equals, or a constant."""
    node = graph.node(value)
    if node.op == "mul" and node.operands[0] == node.operands[1]:
        return 1, node.operands[0]
    number = graph.constant(value)
    return None if number is None else (1 if number >= 0 else -1, fold("sqrt", (), (abs(number),)))


def _new(site: Site, leg: Leg) -> Value:
    return site.builder.const(leg) if isinstance(leg, Fraction) else site.new(leg)


def _root(site: Site, angles: dict[frozenset[Value], Legs]) -> Value:
    """Return a length or a square root by the vectoring that fits."""
    graph, builder, node = site.graph, site.builder, site.node
    if node.op == "hypot":
        return _length(site, node.operands[0], node.operands[1], angles)
    radicand = graph.node(node.operands[0])
    if radicand.op in ("add", "sub"):
        first, second = (_signed_square(graph, v) for v in radicand.operands)
        if first is not None and second is not None:
            second_sign = second[0] if radicand.op == "add" else -second[0]
            if first[0] > 0 and second_sign > 0:
                return _length(site, first[1], second[1], angles)
            if first[0] != second_sign:
                x, y = (first, second) if first[0] > 0 else (second, first)
                return builder.apply(
                    "vector", (_new(site, x[1]), _new(site, y[1]), builder.const(0)), (-1, 1)
                )[0]
        chained = _chained_length(site, radicand, angles)
        if chained is not None:
            return chained
    if radicand.op == "mul":
        return builder.apply("lightcone", [site.new(v) for v in radicand.operands])[0]
    return builder.apply("lightcone", (site.operands[0], builder.const(1)))[0]


def _length(site: Site, a: Leg, b: Leg, angles: dict[frozenset[Value], Legs]) -> Value:
    """Return sqrt(a^2 + b^2) from the vectoring whose angle is taken, if there is one."""
    builder = site.builder
    x, y = _new(site, a), _new(site, b)
    if isinstance(a, Value) and isinstance(b, Value):
        taken = angles.get(_key(site.graph, (a, b)))
        if taken is not None:
            x, y = (builder.scale(sign, site.new(v)) for sign, v in (_base(site.graph, leg) for leg in taken))
    return builder.apply("vector", (x, y, builder.const(0)), (1, 1))[0]


def _chained_length(site: Site, radicand: Node, angles: dict[frozenset[Value], Legs]) -> Value | None:
    """Return sqrt(x^2 + y^2 + z^2) as the length of (sqrt(x^2 + y^2), z) if the first is there anyway."""
    if radicand.op != "add":
        return None
    graph = site.graph
    for pair, third in (radicand.operands, radicand.operands[::-1]):
        inner, last = graph.node(pair), _signed_square(graph, third)
        if inner.op != "add" or last is None or last[0] < 0:
            continue
        first, second = (_signed_square(graph, v) for v in inner.operands)
        if (
            first is None
            or second is None
            or isinstance(first[1], Fraction)
            or isinstance(second[1], Fraction)
        ):
            continue
        if _key(graph, (first[1], second[1])) in angles:
            plane = _length(site, first[1], second[1], angles)
            zero = site.builder.const(0)
            return site.builder.apply("vector", (plane, _new(site, last[1]), zero), (1, 1))[0]
    return None


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
