"""Implicit operations as chains of standard CAUs."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.exact.algebra import Algebra
from cordicc.rewrite.passes.base import PassContext, Site, transform

_SMALL = 2
"""The largest |sinh t| for which t is taken from an area tangent: there sinh t cosh t < 5."""


@dataclass(frozen=True, slots=True)
class StandardChains:
    """Expand every implicit operation, for targets or wishes without implicit CAUs.

    Circular, the paper's Fig. 2: vectoring of (B, A) gives R and psi, hyperbolic vectoring of (R, C)
    the root, vectoring of (C, root) with psi in its z input the angle; acos and asin need no first CAU.
    """

    name: str = "standard-chains"

    def apply(self, graph: Graph, context: PassContext) -> Graph:
        """Return the graph without implicit operations."""
        ranges = context.ranges(graph)

        def positive(site: Site, port: int) -> bool:
            value = site.node.operands[port]
            interval = ranges[value.node][value.result]
            return interval is not None and (interval.lo > 0 or graph.node(value).op == "abs")

        def small(site: Site) -> bool:
            """Tell whether |C| <= 2 |A| over the whole range."""
            A, C = (ranges[v.node][v.result] for v in (site.node.operands[0], site.node.operands[2]))
            if A is None or C is None or A.lo <= 0 <= A.hi:
                return False
            return C.magnitude <= _SMALL * min(abs(A.lo), abs(A.hi))

        def rule(site: Site) -> tuple[Value, ...] | None:
            if site.node.op != "implicit":
                return None
            m, branch = site.node.m, site.node.branch
            if m == -1 and site.builder.constant(site.operands[1]) == 0 and small(site):
                return _small_area_sine(site.builder, site.operands[0], site.operands[2])
            if m == -1:
                return _hyperbolic(site.builder, branch, *site.operands)
            A, B, C = site.operands
            return circular_chain(site.builder, branch, (A, positive(site, 0)), (B, positive(site, 1)), C)

        return transform(graph, rule)


def _vector(
    builder: Algebra, m: int, x: Value, y: Value, z: Value | None = None, sign: int = 1
) -> tuple[Value, ...]:
    return builder.apply("vector", (x, y, builder.const(0) if z is None else z), (m, sign))


def circular_chain(
    builder: Algebra, branch: str, sine: tuple[Value, bool], cosine: tuple[Value, bool], C: Value
) -> tuple[Value, ...]:
    """Return angle and rest; the coefficients A and B come with whether they cannot be negative."""
    (A, A_positive), (B, B_positive) = sine, cosine
    if builder.constant(A) == 0 and branch == "+" and B_positive:
        root = _vector(builder, -1, B, C)[0]
        return _vector(builder, 1, C, root)[1], root
    if builder.constant(B) == 0 and branch == "-" and A_positive:
        root = _vector(builder, -1, A, C)[0]
        return _vector(builder, 1, root, C)[1], root
    radius, psi = _vector(builder, 1, B, A)
    root = _vector(builder, -1, radius, C)[0]
    return _vector(builder, 1, C, root, psi, 1 if branch == "+" else -1)[1], root


def _small_area_sine(builder: Algebra, A: Value, C: Value) -> tuple[Value, ...]:
    """Return t = asinh(C/A) as atanh(C / sqrt(C^2 + A^2)), and the root.

    An error of the root moves t by its relative error times sinh t cosh t: none where t is small, as
    the logarithm would, but without limit where t is large.
    """
    root = _vector(builder, 1, C, A)[0]
    return _vector(builder, -1, root, builder.flip(C, A))[1], root


def _hyperbolic(builder: Algebra, branch: str, A: Value, B: Value, C: Value) -> tuple[Value, ...]:
    """Return t = log E, where p E^2 - 2 C E + q = 0 with p = B + A, q = B - A.

    With D = sqrt(C^2 - p q), s = sgn C and T = |C| + D the roots are T / (s p) and s q / T, without
    cancellation.  A root counts where it is positive; where both are, the branch picks, "+" the larger.
    """
    p, q = builder.add(B, A), builder.sub(B, A)
    if builder.constant(B) == 0:
        root = _vector(builder, 1, C, A)[0]
    elif builder.constant(A) == 0:
        root = _vector(builder, -1, C, B)[0]
    else:
        radicand = builder.sub(builder.mul(C, C), builder.mul(p, q))
        root = builder.apply("lightcone", (radicand, builder.const(1)))[0]
    total = builder.add(builder.apply("abs", (C,))[0], root)
    p, q = builder.flip(p, C), builder.flip(q, C)
    # Operands of select are (s, taken where s >= 0, taken where s < 0).
    if branch == "-":
        choose, at_zero, otherwise = builder.neg(q), (total, p), (q, total)
    else:
        choose, at_zero, otherwise = builder.neg(p), (q, total), (total, p)
    u, v = (builder.apply("select", (choose, a, b))[0] for a, b in zip(at_zero, otherwise, strict=True))
    angle = builder.scale(Fraction(2), builder.apply("lightcone", (u, v))[1])
    if branch == "none":
        both = builder.apply("min", (p, q))[0]
        angle = builder.guard(angle, builder.neg(both), "nonnegative")
    return angle, root
