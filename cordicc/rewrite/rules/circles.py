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

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Poly, TooLarge, monic
from cordicc.rewrite.exact.keys import ElementKey
from cordicc.rewrite.exact.values import Store

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
        if node.op not in ("vector", "implicit") or node.params[0] != 1:
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
        A, B, C = _shortest(store, (A, B, C), common, lengths)
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


def _shortest(
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
