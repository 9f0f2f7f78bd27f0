"""What operations demand of their operands, and what ranges prove of it.

Factors of polynomials must not be 0, radicands must not be negative.  Polynomials are compared by their
irreducible factors: a sum of squares is positive where none of its factors is 0; a radicand keeps its sign
when squares are taken out.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from cordicc.ir.graph import Node, Value
from cordicc.rewrite.exact.field import Element, Poly, TooLarge, monic
from cordicc.rewrite.exact.keys import Key
from cordicc.rewrite.exact.radicands import under_root
from cordicc.rewrite.exact.values import Store

_TERMS = 300


@dataclass(frozen=True, slots=True)
class Demands:
    """What an operation demands: factors that are not 0, and radicands that are not negative.

    `square`: the radicand is a square, not negative whatever the values are.
    """

    nonzero: frozenset[Key] = field(default_factory=frozenset)
    radicands: frozenset[tuple[bool, frozenset[Key]]] = field(default_factory=frozenset)
    square: bool = False
    known: bool = True


def factors_of(store: Store, poly: Poly) -> frozenset[Key] | None:
    """Return the irreducible factors of a polynomial that is nowhere negative; None if it is too long."""
    if len(poly) > _TERMS:
        return None
    factors = (Key(monic(base)[1]) for base, _ in store.field.factors(poly)[1])
    return frozenset(factor for factor in factors if factor not in store.field.definite)


def zeros_of(store: Store, value: Value) -> frozenset[Key] | None:
    """Return irreducible factors of which one is 0 where a value is 0; None if they cannot be told.

    A root is 0 where its radicand is.
    """
    element = store.element(value)
    todo = [] if element is None else [element.num]
    found: set[Key] = set()
    while todo:
        poly = todo.pop()
        if len(poly) > _TERMS:
            return None
        for base, _ in store.field.factors(poly)[1]:
            root = store.field.radicands.get(next(store.field.generators(base)))
            if root is not None and len(base) == 1:
                todo.append(root)
            else:
                found.add(Key(monic(base)[1]))
    return frozenset(factor for factor in found if factor not in store.field.definite) or None


def radicand_of(store: Store, poly: Poly) -> tuple[bool, frozenset[Key]] | None:
    """Return the sign of the constant and the factors that decide the sign of a polynomial.

    Only signs count that hold for every input: others may rest on the condition that is in question.
    """
    if len(poly) > _TERMS:
        return None
    constant, factors = store.field.factors(poly)
    positive = constant > 0
    odd = []
    for base, exponent in factors:
        if exponent % 2 == 0:
            continue
        sign = store.unconditional_sign(base)
        if sign:
            positive = positive == (sign > 0)
        else:
            factor, normal = monic(base)
            positive = positive == (factor > 0)
            odd.append(Key(normal))
    return positive, frozenset(odd)


def is_square(store: Store, poly: Poly) -> bool:
    """Tell whether a polynomial is a square but for definite factors and sums of squares.

    Signs that are known do not count: they may rest on the condition that is in question.
    """
    if len(poly) > _TERMS:
        return False
    if store.is_known_square_sum(poly):
        return True
    constant, factors = store.field.factors(poly)
    sign = 1 if constant > 0 else -1
    for base, exponent in factors:
        if exponent % 2:
            factor, normal = monic(base)
            definite = 1 if _is_sum_of_squares(normal) else store.field.definite.get(Key(normal), 0)
            sign *= definite * (1 if factor > 0 else -1)
    return sign > 0


def _is_sum_of_squares(poly: Poly) -> bool:
    return all(factor > 0 and not any(power % 2 for power in powers) for powers, factor in poly.terms())


def circle_demands(store: Store, op: str, values: Sequence[Value]) -> Demands | None:
    """Return what a circular vectoring or implicit operation demands; None if it cannot be told.

    Without the radicand where that alone cannot be told.
    """
    nonzero = nonzero_factors(store, values[:2])
    if nonzero is None or op == "vector":
        return None if nonzero is None else Demands(nonzero)
    ring, radicand, square = store.field, None, False
    size, C = _square_sum(store, values[:2]), store.element(values[2])
    if size is not None and C is not None:
        with suppress(TooLarge):
            rest = ring.sub(size, ring.mul(C, C))
            inside = ring.times(rest.num, rest.den)
            radicand, square = radicand_of(store, inside), is_square(store, inside)
    return Demands(nonzero, frozenset() if radicand is None else frozenset([radicand]), square)


def root_demands(store: Store, node: Node, values: Sequence[Value]) -> Demands | None:
    """Return what the root of a hyperbolic vectoring of some values demands; None if it cannot be told."""
    x, y = (store.element(v) for v in values[:2])
    if x is None or y is None or node.op == "implicit":
        return None
    ring = store.field
    try:
        element = under_root(ring, node, (x, y))
        inside = ring.times(element.num, element.den)
        radicand = radicand_of(store, inside)
    except TooLarge:
        return None
    if radicand is None:
        return None
    return Demands(radicands=frozenset([radicand]), square=is_square(store, inside))


def nonzero_factors(store: Store, vector: Sequence[Value]) -> frozenset[Key] | None:
    """Return the factors that are not 0 where a vector is not; None if they cannot be told."""
    try:
        size = _square_sum(store, vector)
    except TooLarge:
        return None
    return None if size is None else factors_of(store, size.num)


def _square_sum(store: Store, vector: Sequence[Value]) -> Element | None:
    x, y = (store.element(v) for v in vector)
    if x is None or y is None:
        return None
    return store.field.add(store.field.mul(x, x), store.field.mul(y, y))


def proven(store: Store, op: str, operands: Sequence[Value]) -> tuple[bool, bool]:
    """Tell whether ranges prove a circular operation's vector to be non-zero, and its root real."""
    x, y = (store.range(v) for v in operands[:2])
    if x is None or y is None:
        return False, False
    nonzero = any(r.lo > 0 or r.hi < 0 for r in (x, y))
    if op == "vector":
        return nonzero, True
    C = store.range(operands[2])
    if C is None:
        return nonzero, False
    least = sum(min(abs(r.lo), abs(r.hi)) ** 2 for r in (x, y) if not r.lo <= 0 <= r.hi)
    # The margin covers the rounding of these few double operations.
    return nonzero, C.magnitude**2 <= least * (1 - 1e-12)


def holds(store: Store, value: Value, condition: str) -> bool:
    """Tell whether its range proves a condition of a guard, other than "any", on a value."""
    interval = store.range(value)
    if interval is None:
        return False
    if condition == "nonzero":
        return interval.lo > 0 or interval.hi < 0
    return interval.lo > 0 if condition == "positive" else interval.lo >= 0


def always_solvable(store: Store, operands: Sequence[Value]) -> bool:
    """Tell whether ranges prove |A| > |B| for the hyperbolic equation, which then has one solution."""
    A, B = (store.range(v) for v in operands[:2])
    if A is None or B is None or A.lo <= 0 <= A.hi:
        return False
    return B.magnitude < min(abs(A.lo), abs(A.hi))


def root_proven(store: Store, op: str, operands: Sequence[Value]) -> bool:
    """Tell whether ranges prove the radicand of a hyperbolic vectoring to be no less than 0."""
    x, y = (store.range(v) for v in operands[:2])
    if x is None or y is None:
        return False
    if op == "lightcone":
        return x.lo >= 0 and y.lo >= 0
    return not x.lo <= 0 <= x.hi and y.magnitude <= min(abs(x.lo), abs(x.hi))
