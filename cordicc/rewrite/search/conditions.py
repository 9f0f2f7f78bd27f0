"""Which inputs a realisation must refuse: the conditions of the operations it replaces.

A condition is proven over the whole range, or met by an operation that has it too, or kept by a guard.
Polynomials are compared by their irreducible factors: a sum of squares is positive where none of its
factors is 0; a radicand keeps its sign when squares are taken out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from cordicc.ir.graph import Graph, Param, Value
from cordicc.rewrite.exact.field import Element, Poly, TooLarge, monic
from cordicc.rewrite.exact.keys import Key
from cordicc.rewrite.exact.radicands import under_root
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.search.options import Alternatives, Option

_TERMS = 300


@dataclass(frozen=True, slots=True)
class Requirement:
    """A condition: (class, option) pairs that meet it, else a guard of a class, if there is one."""

    met_by: tuple[tuple[int, int], ...]
    subject: int | None
    condition: str


@dataclass(frozen=True, slots=True)
class Facts:
    """What an operation demands: factors that are not 0, and radicands that are not negative.

    `square`: the radicand is a square, not negative whatever the values are.
    """

    nonzero: frozenset[Key] = field(default_factory=frozenset)
    radicands: frozenset[tuple[bool, frozenset[Key]]] = field(default_factory=frozenset)
    square: bool = False
    known: bool = True

    def __or__(self, other: Facts) -> Facts:
        return Facts(
            self.nonzero | other.nonzero, self.radicands | other.radicands, self.known and other.known
        )


def factors_of(store: Store, poly: Poly) -> frozenset[Key] | None:
    """Return the irreducible factors of a polynomial that is nowhere negative; None if it is too long."""
    if len(poly) > _TERMS:
        return None
    factors = (Key(monic(base)[1]) for base, _ in store.field.factors(poly)[1])
    return frozenset(factor for factor in factors if factor not in store.field.definite)


def radicand_of(store: Store, poly: Poly) -> tuple[bool, frozenset[Key]] | None:
    """Return the sign of the constant and the factors that decide the sign of a polynomial."""
    if len(poly) > _TERMS:
        return None
    constant, factors = store.field.factors(poly)
    positive = constant > 0
    odd = []
    for base, exponent in factors:
        if exponent % 2 == 0:
            continue
        sign = store.poly_sign(base)
        if sign:
            positive = positive == (sign > 0)
        else:
            factor, normal = monic(base)
            positive = positive == (factor > 0)
            odd.append(Key(normal))
    return positive, frozenset(odd)


def _is_square(store: Store, poly: Poly) -> bool:
    """Tell whether a polynomial is a square but for definite factors and sums of squares.

    Signs that are known do not count: they may rest on the condition that is in question.
    """
    if len(poly) > _TERMS:
        return False
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


def circle_facts(store: Store, op: str, values: Sequence[Value]) -> Facts | None:
    """Return what a circular vectoring or implicit operation demands; None if it cannot be told.

    Without the radicand where that alone cannot be told.
    """
    nonzero = nonzero_factors(store, values[:2])
    if nonzero is None or op == "vector":
        return None if nonzero is None else Facts(nonzero)
    ring, radicand, square = store.field, None, False
    size, C = _square_sum(store, values[:2]), store.element(values[2])
    if size is not None and C is not None:
        with suppress(TooLarge):
            rest = ring.sub(size, ring.mul(C, C))
            inside = ring.times(rest.num, rest.den)
            radicand, square = radicand_of(store, inside), _is_square(store, inside)
    return Facts(nonzero, frozenset() if radicand is None else frozenset([radicand]), square)


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


def requirements(
    store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]], choice: Alternatives
) -> list[Requirement]:
    """Return the conditions of a graph, whose nodes became the values `moved`, over the alternatives."""
    used = graph.used_results()
    offers = _offers(store, choice)
    found: list[Requirement] = []
    for index in sorted(graph.live()):
        node = graph.nodes[index]
        if node.definition.partial:
            results = tuple(v for r, v in enumerate(moved[index]) if Value(index, r) in used)
            operands = tuple(moved[v.node][v.result] for v in node.operands)
            found += _of_node(store, choice, offers, node.op, node.params, operands, results)
    return list(dict.fromkeys(found))


_Offers = list[tuple[int, Option, Facts]]


def _offers(store: Store, choice: Alternatives) -> _Offers:
    """Return, for each option that is a CAU, what it demands of its operands."""
    offers: _Offers = []
    for number, option in enumerate(choice.options):
        if option.op not in ("vector", "implicit", "lightcone"):
            continue
        values = store.algebra.nodes[option.node].operands
        facts = None
        if option.op == "lightcone" or option.params[0] == -1:
            facts = _root_facts(store, option.op, option.params, values)
        elif option.params[0] == 1:
            facts = circle_facts(store, option.op, values)
        offers.append((number, option, facts or Facts(known=False)))
    return offers


def _root_facts(store: Store, op: str, params: Sequence[Param], values: Sequence[Value]) -> Facts | None:
    """Return what the root of a hyperbolic vectoring demands."""
    x, y = (store.element(v) for v in values[:2])
    if x is None or y is None or op == "implicit":
        return None
    ring = store.field
    try:
        element = under_root(ring, op, params, (x, y))
        inside = ring.times(element.num, element.den)
        radicand = radicand_of(store, inside)
    except TooLarge:
        return None
    if radicand is None:
        return None
    return Facts(radicands=frozenset([radicand]), square=_is_square(store, inside))


def _of_node(
    store: Store,
    choice: Alternatives,
    offers: _Offers,
    op: str,
    params: Sequence[Param],
    operands: Sequence[Value],
    results: Sequence[Value],
) -> Iterable[Requirement]:
    alike = [other for v in results for other in store.domains.get(v, ())]
    wanted = [choice.class_of(v) for v in (*results, *alike)]
    same = tuple(
        (k, number)
        for number, option, _ in offers
        if option.op == op and (not params or option.params[0] == params[0])
        for k in wanted
        if any(k in result for result in option.results)
    )
    if op == "guard":
        subject, condition = operands[1], str(params[0])
        if condition != "any" and not _holds(store, subject, condition):
            subject = _numerator(store, choice, subject) if condition == "nonzero" else subject
            yield Requirement((), choice.class_of(subject), condition)
        return
    if op == "vector" and params[0] == 0:
        if not _holds(store, operands[0], "nonzero"):
            subject = _numerator(store, choice, operands[0])
            yield Requirement(same, choice.class_of(subject), "nonzero")
        return
    if op in ("vector", "implicit") and params[0] == 1:
        angle = results and results[0].result == (1 if op == "vector" else 0)
        angle = angle or any(v.result == 1 for v in results) or op == "implicit"
        if angle:
            yield from _circular(store, offers, op, operands, same)
        return
    if op == "implicit" and _always_solvable(store, operands):
        return
    facts = _root_facts(store, op, params, operands)
    angle_used = any(v.result == 1 for v in results)
    if facts is not None and not angle_used:
        if facts.square or _root_proven(store, op, operands):
            return
        (radicand,) = facts.radicands
        met = {*same, *_offering(offers, lambda other: radicand in other.radicands)}
        yield Requirement(tuple(sorted(met)), None, "nonnegative")
        return
    yield Requirement(same, None, "any")


def _numerator(store: Store, choice: Alternatives, value: Value) -> Value:
    """Return a value that is 0 where this one is: its numerator, if something makes that, else itself."""
    element = store.element(value)
    if element is None or element.is_polynomial:
        return value
    poly = store.field.display(Element(element.num, store.field.one))
    found = None if poly is None else store.affine(poly)
    if found is None or found[2] != 0 or choice.class_of(found[0]) not in choice.providers:
        return value
    return found[0]


def _circular(
    store: Store, offers: _Offers, op: str, operands: Sequence[Value], same: tuple[tuple[int, int], ...]
) -> Iterable[Requirement]:
    nonzero, real = proven(store, op, operands)
    facts = circle_facts(store, op, operands)
    if facts is None or (op == "implicit" and not facts.radicands and not real):
        if not (nonzero and real):
            yield Requirement(same, None, "any")
        return
    for factor in () if nonzero else sorted(facts.nonzero):
        met = {*same, *_offering(offers, lambda other, f=factor: f in other.nonzero)}  # type: ignore[misc]
        yield Requirement(tuple(sorted(met)), None, "nonzero")
    if op == "implicit" and not real and not facts.square:
        (radicand,) = facts.radicands
        met = {*same, *_offering(offers, lambda other: radicand in other.radicands)}
        yield Requirement(tuple(sorted(met)), None, "nonnegative")


def _offering(offers: _Offers, test: Callable[[Facts], bool]) -> Iterable[tuple[int, int]]:
    """Yield (class, option) for the options whose demands pass a test; the class is that of the result."""
    for number, option, facts in offers:
        if facts.known and test(facts):
            result = 1 if option.op == "vector" and option.params[0] == 1 else 0
            yield from ((k, number) for k in option.results[result])


def _holds(store: Store, value: Value, condition: str) -> bool:
    interval = store.range(value)
    if interval is None:
        return False
    if condition == "nonzero":
        return interval.lo > 0 or interval.hi < 0
    return interval.lo > 0 if condition == "positive" else interval.lo >= 0


def _always_solvable(store: Store, operands: Sequence[Value]) -> bool:
    """Tell whether ranges prove |A| > |B| for the hyperbolic equation, which then has one solution."""
    A, B = (store.range(v) for v in operands[:2])
    if A is None or B is None or A.lo <= 0 <= A.hi:
        return False
    return B.magnitude < min(abs(A.lo), abs(A.hi))


def _root_proven(store: Store, op: str, operands: Sequence[Value]) -> bool:
    x, y = (store.range(v) for v in operands[:2])
    if x is None or y is None:
        return False
    if op == "lightcone":
        return x.lo >= 0 and y.lo >= 0
    return not x.lo <= 0 <= x.hi and y.magnitude <= min(abs(x.lo), abs(x.hi))
