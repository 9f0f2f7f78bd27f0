"""Each angle by its own circle equation, without the root that the equations take it from.

If cos t = c0 + c1 r and sin t = s0 + s1 r with r = sqrt(D) >= 0 over values without r, then
s1 cos t - c1 sin t = s1 c0 - c1 s0 holds without r.  As c^2 + s^2 = 1 for the other sign of r too,
c0 c1 + s0 s1 = 0, so B = s1 and A = -c1 have A cos t - B sin t = -r (c1^2 + s1^2) <= 0: the branch
is "+", and the second result of the unit is r (c1^2 + s1^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.exact.demands import nonzero_factors, proven
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Poly, TooLarge, monic
from cordicc.rewrite.exact.keys import ElementKey, Key
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.angles import SUMS, angles_of, is_angle
from cordicc.rewrite.rules.named_polynomials import name_of, text_of
from cordicc.rewrite.rules.rule import Given, Need, Rule
from cordicc.rewrite.rules.synthesis import Synthesis

_SHORT = 24
"""Terms of an equation, or of the components of a vector, that count as short."""

_LENGTHS = 12


@dataclass(frozen=True, slots=True)
class Circle:
    """The equation of an angle: B cos t + A sin t = C with branch "+"."""

    root: int
    A: Poly
    B: Poly
    C: Poly


def squared_lengths(store: Store) -> list[Element]:
    """Return the squares of the lengths of the vectors that circular units take, short and not constant."""
    found: dict[ElementKey, Element] = {}
    for node in store.algebra.nodes:
        if node.op not in ("vector", "implicit") or node.m != 1:
            continue
        x, y = (store.element(v) for v in node.operands[:2])
        if x is None or y is None or max(len(x.num) + len(x.den), len(y.num) + len(y.den)) > _SHORT:
            continue
        with suppress(TooLarge):
            square = store.field.add(store.field.mul(x, x), store.field.mul(y, y))
            if square.constant is None:
                found.setdefault(square.key, square)
    return list(found.values())[:_LENGTHS]


def circles(store: Store, angle: Value, lengths: Sequence[Element] = ()) -> list[Circle]:
    """Return the circle equations of an angle, one for each root that its rotor holds.

    Each is taken times one of `lengths`, squares that are positive, where that makes it shorter.
    """
    rotor = store.rotors.rotor(angle)
    if rotor is None:
        return []
    found = []
    for root in store.field.roots_of(*rotor):
        if store.field.radicands[root].is_constant():
            continue
        try:
            circle = _circle(store, rotor[0], rotor[1], root, lengths)
        except TooLarge:
            circle = None
        if circle is not None:
            found.append(circle)
    return found


def _circle(
    store: Store, cosine: Element, sine: Element, root: int, lengths: Sequence[Element]
) -> Circle | None:
    field = store.field
    # One denominator d: cos = (p0 + p1 r)/d, sin = (q0 + q1 r)/d; all is multiplied by d^2.
    common = cosine.den / cosine.den.gcd(sine.den) * sine.den
    p0, p1 = field.split(field.times(cosine.num, common / cosine.den), root)
    q0, q1 = field.split(field.times(sine.num, common / sine.den), root)
    if not (field.times(p0, p1) + field.times(q0, q1)).is_zero():
        return None
    B, A = field.times(q1, common), field.times(p1, common) * -1
    if A.is_zero() and B.is_zero():
        return None
    C = field.times(q1, p0) - field.times(p1, q0)
    if len(A) + len(B) + len(C) > _SHORT:
        A, B, C = shortest(store, (A, B, C), common, lengths)
    factor = A.gcd(B).gcd(C)
    if not factor.is_constant():
        sign = store.poly_sign(factor)
        if sign == 0:
            factor = _signed_part(store, factor)
        elif sign < 0:
            factor = factor * -1
        A, B, C = A / factor, B / factor, C / factor
    if any(field.half_angles.least_terms(poly) > LOOKUP_TERMS for poly in (A, B, C)):
        return None
    # Degrees of A, B and C in a tangent t decide the power of 1 + t^2 > 0 they are divided by.
    highest = [max(p.degrees()[i] for p in (A, B, C)) for i in range(len(A.degrees()))]
    shown = field.half_angles.displays([A, B, C], field.half_angles.half_degree(highest))
    if shown is None:
        return None
    A, B, C = shown
    scale = abs(monic(A if not A.is_zero() else B)[0])
    unit = field.number(1 / scale).num
    return Circle(root, A * unit, B * unit, C * unit)


def shortest(
    store: Store, equation: tuple[Poly, Poly, Poly], common: Poly, lengths: Sequence[Element]
) -> tuple[Poly, Poly, Poly]:
    """Return an equation times d^2 as one times a square of a length, if that is shorter.

    Roots hide common factors from the gcd of polynomials; a product with the right square shows them.
    """
    field = store.field
    best = sum(map(len, equation)), equation
    below = field.fraction(field.one, field.times(common, common))
    for length in lengths:
        with suppress(TooLarge):
            scale = field.mul(length, below)
            A, B, C = (field.mul(Element(part, field.one), scale) for part in equation)
            den = A.den / A.den.gcd(B.den) * B.den
            den = den / den.gcd(C.den) * C.den
            sign = store.poly_sign(den)
            den = den * sign if sign else field.times(den, den)
            scaled = [field.mul(part, Element(den, field.one)).num for part in (A, B, C)]
            size = sum(map(len, scaled))
            if size < best[0]:
                best = size, (scaled[0], scaled[1], scaled[2])
    return best[1]


def _signed_part(store: Store, factor: Poly) -> Poly:
    """Return the part of a common factor whose sign is known to be positive."""
    part = store.field.one
    for base, exponent in store.field.factors(factor)[1]:
        sign = store.poly_sign(base)
        part = part * (base * sign if sign else base**0) ** exponent
        if not sign:
            part = part * base ** (exponent // 2 * 2)
    return part


def realise(store: Store, A: Value, B: Value, C: Value) -> tuple[Value, ...]:
    """Return angle and second result of the implicit unit for an equation with branch "+"."""
    zero = store.const(0)

    def minus(value: Value) -> Value:
        return store.scale(Fraction(-1), value)

    sign_A, sign_B = store.range(A), store.range(B)
    # One coefficient: acos(C/B) or asin(C/A), whose principal values want it positive.
    if store.constant(A) == 0 and sign_B is not None and sign_B.hi < 0:
        # -|B| cos t = C with t = pi + acos(C/|B|), which is -acos(-C/|B|) modulo 2 pi
        return store.make("implicit", (zero, minus(B), minus(C)), (1, "-"))
    if store.constant(B) == 0 and sign_A is not None and sign_A.hi < 0:
        return store.make("implicit", (minus(A), zero, minus(C)), (1, "-"))
    return store.make("implicit", (A, B, C), (1, "+"))


def _add_circles(given: Given) -> None:
    """Add the circle equation of each angle and of each sum of angles, where its vector is never 0.

    Sums are those of the first realisation.
    """
    store, graph, moved = given.store, given.graphs[0], given.moved[0]
    angles = angles_of(store)
    synthesis = Synthesis(store)
    sums = [v for results in moved for v in results if store.node(v).op in SUMS and is_angle(store, v)]
    known = _kept_from_zero(store, graph, moved)
    lengths = squared_lengths(store)
    for angle in dict.fromkeys((*angles, *sums)):
        store.begin(store.node(angle).origin)
        for circle in circles(store, angle, lengths):
            CIRCLES.tell_of(store, angle, circle)
            try:
                values = [synthesis.polynomial(p) for p in (circle.A, circle.B, circle.C)]
                factors = nonzero_factors(store, values[:2])
                nonzero = proven(store, "implicit", values)[0]
                if not nonzero and (factors is None or not factors <= known):
                    continue
                made = realise(store, *values)
            except TooLarge:
                continue
            store.rotors.rotor(made[0])


def _kept_from_zero(store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]]) -> frozenset[Key]:
    """Return the polynomials that the conditions of a graph keep away from 0."""
    found: frozenset[Key] = frozenset()
    used = graph.used_results()
    for index in graph.live():
        node = graph.nodes[index]
        if node.op in ("vector", "implicit") and node.m == 1:
            if node.op == "vector" and Value(index, 1) not in used:
                continue
            found |= (
                nonzero_factors(store, [moved[v.node][v.result] for v in node.operands[:2]]) or frozenset()
            )
    return found


def _formulas(store: Store, angle: Value, circle: Circle) -> tuple[str, ...]:
    """Return how an angle got its own circle equation."""
    name = name_of(store, angle)
    root = f"w{circle.root}"
    A, B, C = (text_of(store, p) for p in (circle.A, circle.B, circle.C))
    radicand = store.field.display(Element(store.field.radicands[circle.root], store.field.one))
    known = "" if radicand is None else f" `{root} = sqrt({text_of(store, radicand)})`"
    return (
        f"the root{known} is in `cos({name}) = c0 + c1*{root}` and in `sin({name}) = s0 + s1*{root}`, "
        f"but not in `s1*cos({name}) - c1*sin({name}) = s1*c0 - c1*s0`",
        f"hence `{_linear(B, f'cos({name})', A, f'sin({name})')} = {C}`, branch +, "
        f"and the second result is a multiple of `{root}`",
    )


def _linear(first: str, u: str, second: str, v: str) -> str:
    """Return `first*u + second*v`."""
    terms = [_multiple(factor, of) for factor, of in ((first, u), (second, v)) if factor != "0"]
    return " + ".join(terms).replace("+ -", "- ")


def _multiple(factor: str, of: str) -> str:
    if factor in ("1", "-1"):
        return factor.removesuffix("1") + of
    return f"({factor})*{of}" if " " in factor else f"{factor}*{of}"


CIRCLES = Rule(
    name="circle equations",
    mathematics="s1 cos t - c1 sin t = s1 c0 - c1 s0 for cos t = c0 + c1 r, sin t = s0 + s1 r, r = sqrt(D)",
    apply=_add_circles,
    needs=frozenset({Need.GRAPHS}),
    formulas=_formulas,
)
