"""Sines and cosines as rotations, and sums of their products as rotated vectors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from cordicc.ir.graph import Graph, Value, factored
from cordicc.rewrite.exact.algebra import Algebra
from cordicc.rewrite.passes.base import NodeRule, PassContext, Ranges, Site, transform

_SATURATION = 20
_FIXED_LARGE = 4
"""Where cosh is 27, five bits on fixed point."""

_COORDINATES = {"cos": 1, "sin": 1, "cosh": -1, "sinh": -1}


@dataclass(frozen=True, slots=True)
class TrigonometricTerm:
    """factor * coefficient * cos t (or sin t), as found in the old graph; coefficient None is 1."""

    angle: Value
    m: int
    is_sine: bool
    factor: Fraction
    coefficient: Value | None


Component = tuple[Fraction, Value | None]
"""factor and coefficient, as in `TrigonometricTerm`; factor 0 for an absent component."""

_ABSENT: Component = (Fraction(0), None)


@dataclass(frozen=True, slots=True)
class RotationResult:
    """sign times one result of the rotation of (x, y)."""

    x: Component
    y: Component
    result: int
    sign: int

    @classmethod
    def of(cls, cosine: Component, sine: Component, m: int) -> RotationResult:
        """Return c cos t + s sin t as a result of a rotation by t.

        It is the first result for (c, -m s) and the second for (s, c).  Both results of one vector
        lead to the same choice: the component that sorts first becomes x, and x is positive.
        """
        first = (cosine, (-m * sine[0], sine[1]), 0)
        second = (sine, cosine, 1)
        x, y, result = min(first, second, key=lambda form: (_order(form[0]), form[0][0] * form[1][0] < 0))
        sign = -1 if x[0] < 0 else 1
        return cls((sign * x[0], x[1]), (sign * y[0], y[1]), result, sign)

    def vector(self) -> tuple[Component, Component]:
        """Return the vector to be rotated."""
        return self.x, self.y


def _order(component: Component) -> tuple[bool, Value, Fraction]:
    factor, coefficient = component
    return (factor == 0, coefficient or Value(-1), abs(factor))


Uses = dict[Value, RotationResult]
"""What is made of the cosine and sine of one angle: value of the old graph -> rotation result."""


@dataclass(frozen=True, slots=True)
class Rotations:
    """Turn sin, cos, tan, sinh, cosh, tanh, exp into rotations.

    The sine and cosine of one angle are one rotation of (1, 0).  Where all uses of an angle are the
    components of one vector, a cos t -+ b sin t, that vector is rotated itself and the products
    vanish; with several vectors that costs a CAU each, so it is done for the goal `latency` only.
    """

    name: str = "rotations"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph with rotations."""
        graph = transform(graph, _quotients(context.ranges(graph), floating=context.floating))
        chosen: dict[Value, tuple[Value, int, RotationResult]] = {}
        for (angle, m), uses in _collect(graph).items():
            if len({turned.vector() for turned in uses.values()}) == 1 or context.goal == "latency":
                chosen |= {value: (angle, m, turned) for value, turned in uses.items()}

        def rule(site: Site) -> tuple[Value, ...] | None:
            if Value(site.index) in chosen:
                return (_rotated(site, *chosen[Value(site.index)]),)
            builder, op = site.builder, site.node.op
            if op in _COORDINATES:
                one, zero = builder.const(1), builder.const(0)
                results = builder.apply("rotate", (one, zero, site.operands[0]), (_COORDINATES[op],))
                return (results[1 if op.startswith("sin") else 0],)
            if op == "exp":
                one = builder.const(1)
                return builder.apply("rotate", (one, one, site.operands[0]), (-1,))[:1]
            return None

        return transform(graph, rule)


def _quotients(ranges: Ranges, *, floating: bool) -> NodeRule:
    """Return the rule that writes tan and tanh, and sinh/cosh, as quotients of bounded numbers.

    Beyond +-20 tanh is +-1 within 2^-56, so its argument is held there before cosh can overflow.  On fixed
    point large functions leave few digits to small ones; there tanh z is (1 - e)/(1 + e) with the sign of
    z, e = exp(-2 |z|), if z may be large.
    """

    def large(angle: Value, most: int) -> bool:
        interval = ranges[angle.node][angle.result]
        return interval is None or interval.magnitude > most

    def rule(site: Site) -> tuple[Value, ...] | None:
        builder, graph, node = site.builder, site.graph, site.node
        if node.op == "div" and not floating:
            ratio = _hyperbolic_ratio(graph, node.operands)
            if ratio is None or not large(ratio[1], _FIXED_LARGE):
                return None
            return (builder.scale(ratio[0], _bounded_tanh(builder, site.new(ratio[1]))),)
        if node.op not in ("tan", "tanh"):
            return None
        (angle,) = site.operands
        suffix = "h" if node.op == "tanh" else ""
        if suffix and not floating and large(node.operands[0], _FIXED_LARGE):
            return (_bounded_tanh(builder, angle),)
        if suffix and large(node.operands[0], _SATURATION):
            least, most = builder.const(-_SATURATION), builder.const(_SATURATION)
            angle = builder.apply("max", (least, builder.apply("min", (most, angle))[0]))[0]
        sine = builder.apply(f"sin{suffix}", (angle,))[0]
        cosine = builder.apply(f"cos{suffix}", (angle,))[0]
        return builder.apply("div", (sine, cosine))

    return rule


def _hyperbolic_ratio(graph: Graph, operands: Sequence[Value]) -> tuple[Fraction, Value] | None:
    """Return f and z of a quotient f sinh(z)/cosh(z), None for any other."""
    (above, sine), (below, cosine) = (factored(graph.nodes, operand) for operand in operands)
    first, second = graph.node(sine), graph.node(cosine)
    if (first.op, second.op) != ("sinh", "cosh") or first.operands != second.operands:
        return None
    return above / below, first.operands[0]


def _bounded_tanh(builder: Algebra, angle: Value) -> Value:
    one = builder.const(1)
    (size,) = builder.apply("abs", (angle,))
    (e,) = builder.apply("exp", (builder.scale(Fraction(-2), size),))
    (above,), (below,) = builder.apply("sub", (one, e)), builder.apply("add", (one, e))
    (quotient,) = builder.apply("div", (above, below))
    return builder.apply("flip", (quotient, angle))[0]


def _term(graph: Graph, value: Value) -> TrigonometricTerm | None:
    """Return the value as a product with one sine or cosine, if it is one."""
    factor, value = factored(graph.nodes, value)
    node = graph.node(value)
    coefficient = None
    if node.op == "mul":
        trig = [graph.node(v).op in _COORDINATES for v in node.operands]
        if sum(trig) != 1:
            return None
        coefficient = node.operands[trig.index(False)]
        node = graph.node(node.operands[trig.index(True)])
    if node.op not in _COORDINATES:
        return None
    return TrigonometricTerm(
        node.operands[0], _COORDINATES[node.op], node.op.startswith("sin"), factor, coefficient
    )


def _collect(graph: Graph) -> dict[tuple[Value, int], Uses]:
    """Return the uses of each angle: sums of two terms, then products and bare functions outside them.

    Walks from the users down, so that a term counts where its outermost factor is.
    """
    uses: dict[tuple[Value, int], Uses] = defaultdict(dict)
    absorbed: dict[tuple[Value, int], set[int]] = defaultdict(set)
    users = graph.users()
    wanted = {v.node for v in graph.outputs.values()}
    for index in reversed(range(len(graph.nodes))):
        node = graph.nodes[index]
        if node.op in ("add", "sub"):
            a, b = (_term(graph, v) for v in node.operands)
            if a is None or b is None or (a.angle, a.m) != (b.angle, b.m) or a.is_sine == b.is_sine:
                continue
            sign = -1 if node.op == "sub" else 1
            parts = {a.is_sine: (a.factor, a.coefficient), b.is_sine: (sign * b.factor, b.coefficient)}
            uses[a.angle, a.m][Value(index)] = RotationResult.of(parts[False], parts[True], a.m)
            absorbed[a.angle, a.m].add(index)
            continue
        term = _term(graph, Value(index))
        if term is None:
            continue
        key = (term.angle, term.m)
        if index in wanted or any(user not in absorbed[key] for user in users[index]):
            component = (term.factor, term.coefficient)
            pair = (_ABSENT, component) if term.is_sine else (component, _ABSENT)
            uses[key][Value(index)] = RotationResult.of(*pair, term.m)
        absorbed[key].add(index)
    return uses


def _rotated(site: Site, angle: Value, m: int, turned: RotationResult) -> Value:
    """Build the rotation and return the result with its sign."""
    builder = site.builder

    def build(component: Component) -> Value:
        factor, coefficient = component
        return builder.scale(factor, builder.const(1) if coefficient is None else site.new(coefficient))

    operands = ((builder.const(0) if not part[0] else build(part)) for part in turned.vector())
    results = builder.apply("rotate", (*operands, site.new(angle)), (m,))
    return builder.scale(Fraction(turned.sign), results[turned.result])
