"""Lengths, angles of vectors, roots and logarithms as vectoring operations."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cordicc.ir.graph import Graph, Node, Value, factored
from cordicc.ir.meaning.exact import fold
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.algebra import Algebra
from cordicc.rewrite.passes.base import PassContext, Ranges, Site, transform
from cordicc.rewrite.passes.ratio import denominator, positive_ratio, ratio


@dataclass(frozen=True, slots=True)
class Vectorings:
    """Turn atan2, hypot, sqrt, atan, atanh, log and the 2x2 `solve_pair` into vectorings.

    The length and the angle of one vector come from one circular vectoring, in whatever order and
    with whatever signs the length has its components; sqrt(x^2 - y^2) is hyperbolic vectoring; any
    other root, and a logarithm, is hyperbolic vectoring in light-cone coordinates.
    """

    name: str = "vectorings"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
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


def _at(ranges: Ranges, value: Value | None) -> Interval | None:
    return None if value is None else ranges[value.node][value.result]


def _angle(builder: Algebra, x: Value, y: Value) -> Value:
    return builder.apply("vector", (x, y, builder.const(0)), (1, 1))[1]


@dataclass(frozen=True, slots=True)
class Leg:
    """A component factor * base of a vector in the old graph; base None is 1."""

    factor: Fraction
    base: Value | None

    @classmethod
    def of(cls, graph: Graph, value: Value) -> Leg:
        """Return a value as a component."""
        number = graph.constant(value)
        return cls(number, None) if number is not None else cls(*factored(graph.nodes, value))

    def build(self, site: Site) -> Value:
        """Return the component in the new graph."""
        base = site.builder.const(1) if self.base is None else site.new(self.base)
        return site.builder.scale(self.factor, base)


Legs = tuple[Leg, Leg]
Angles = dict[frozenset[tuple[Fraction, Value | None]], Legs]
"""The vectors (x, y) of which the graph takes the angle, by their components up to sign and order."""


def _key(legs: Legs) -> frozenset[tuple[Fraction, Value | None]]:
    return frozenset((abs(leg.factor), leg.base) for leg in legs)


def _angles(graph: Graph) -> Angles:
    found: Angles = {}
    for node in graph.nodes:
        if node.op == "atan2":
            y, x = (Leg.of(graph, v) for v in node.operands)
            found.setdefault(_key((x, y)), (x, y))
    return found


def _signed_square(graph: Graph, value: Value) -> tuple[int, Leg] | None:
    """Return (sign, x) if the value stands as sign * x^2: a multiple of a square, or a constant."""
    number = graph.constant(value)
    factor, base = (number, None) if number is not None else factored(graph.nodes, value)
    if base is not None:
        node = graph.node(base)
        if node.op != "mul" or node.operands[0] != node.operands[1]:
            return None
        base = node.operands[0]
    return (1 if factor >= 0 else -1), Leg(fold("sqrt", (), (abs(factor),)), base)


def _root(site: Site, angles: Angles) -> Value:
    """Return a length or a square root by the vectoring that fits."""
    graph, builder, node = site.graph, site.builder, site.node
    if node.op == "hypot":
        first, second = (Leg.of(graph, v) for v in node.operands)
        return _length(site, (first, second), angles)
    radicand = graph.node(node.operands[0])
    if radicand.op in ("add", "sub"):
        squares = [_signed_square(graph, v) for v in radicand.operands]
        if squares[0] is not None and squares[1] is not None:
            (sign, x), (other_sign, y) = squares[0], squares[1]
            other_sign = other_sign if radicand.op == "add" else -other_sign
            if sign > 0 and other_sign > 0:
                return _length(site, (x, y), angles)
            if sign != other_sign:
                x, y = (x, y) if sign > 0 else (y, x)
                return builder.apply("vector", (x.build(site), y.build(site), builder.const(0)), (-1, 1))[0]
        chained = _chained_length(site, radicand, angles)
        if chained is not None:
            return chained
    if radicand.op == "mul":
        return builder.apply("lightcone", [site.new(v) for v in radicand.operands])[0]
    return builder.apply("lightcone", (site.operands[0], builder.const(1)))[0]


def _length(site: Site, legs: Legs, angles: Angles) -> Value:
    """Return the length of a vector, from the vectoring whose angle is taken if there is one."""
    x, y = angles.get(_key(legs), legs)
    return site.builder.apply("vector", (x.build(site), y.build(site), site.builder.const(0)), (1, 1))[0]


def _chained_length(site: Site, radicand: Node, angles: Angles) -> Value | None:
    """Return sqrt(x^2 + y^2 + z^2) as the length of (sqrt(x^2 + y^2), z) if the first is there anyway."""
    if radicand.op != "add":
        return None
    graph, builder = site.graph, site.builder
    for pair, third in (radicand.operands, radicand.operands[::-1]):
        inner, last = graph.node(pair), _signed_square(graph, third)
        if inner.op != "add" or last is None or last[0] < 0:
            continue
        first, second = (_signed_square(graph, v) for v in inner.operands)
        if first is None or second is None or first[0] < 0 or second[0] < 0:
            continue
        if _key((first[1], second[1])) in angles:
            plane = _length(site, (first[1], second[1]), angles)
            return builder.apply("vector", (plane, last[1].build(site), builder.const(0)), (1, 1))[0]
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
