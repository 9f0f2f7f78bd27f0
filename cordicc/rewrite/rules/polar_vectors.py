"""Norm and angle of a vector in products and rotations: the vector itself, turned.

With r and t the norm and the angle of (x, y), (r, 0) turned by t + d is (x, y) turned by d: neither r nor t
is needed.  And (a x + b y)/r is a cos t + b sin t, without a quotient: a component of (a, -b), or of (b, a),
turned by t.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cordicc.ir.graph import Node, Value
from cordicc.ir.meaning.exact import fold
from cordicc.rewrite.exact.demands import proven
from cordicc.rewrite.exact.terms import Term, product_of, terms_of
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Rule


@dataclass(frozen=True, slots=True)
class _Vector:
    """A circular vectoring: the classes of its norm and its angle, and what it does."""

    index: int
    node: Node

    @property
    def legs(self) -> tuple[Value, Value]:
        """Return the components."""
        return self.node.operands[0], self.node.operands[1]


def _vectors(store: Store) -> list[_Vector]:
    return [
        _Vector(index, node)
        for index, node in enumerate(store.algebra.nodes)
        if node.op == "vector" and node.m == 1
    ]


def _add_turned_vectors(given: Given) -> None:
    """Add what norms turned by an angle and more are: their vectors, turned by what is left."""
    store = given.store
    by_angle: dict[Value, list[_Vector]] = {}
    for vector in _vectors(store):
        by_angle.setdefault(store.find(Value(vector.index, 1)), []).append(vector)
    products = _products(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "rotate" or node.m != 1:
            continue
        terms = _angle_terms(store, node.operands[2])
        for at, (sign, value) in enumerate(terms):
            for vector in by_angle.get(store.find(value), ()):
                store.begin(node.origin)
                rest = terms[:at] + terms[at + 1 :] + [(sign, vector.node.operands[2])]
                _add_turned(store, products, index, vector, sign * vector.node.sign, rest)


_Products = dict[Value, list[tuple[Value, Value]]]
"""By a factor the other factor and the product."""


def _products(store: Store) -> _Products:
    found: _Products = {}
    for index, node in enumerate(store.algebra.nodes):
        for factor, other in (node.operands, node.operands[::-1]) if node.op == "mul" else ():
            found.setdefault(store.find(factor), []).append((other, Value(index)))
    return found


def _add_turned(
    store: Store, products: _Products, index: int, vector: _Vector, sign: int, rest: list[tuple[int, Value]]
) -> None:
    """Add what a rotation by `sign` times the angle of a vector, and the rest, makes of its norm."""
    x, y, _ = store.algebra.nodes[index].operands
    if store.constant(x) == 1 and store.constant(y) == 0:
        for result in range(2):
            for other, product in products.get(store.find(Value(index, result)), ()):
                share = _per_norm(store, other, vector)
                if share is not None:
                    store.union(product, _turned(store, vector, sign, share, rest)[result])
        return
    for port, zero in ((x, y), (y, x)):
        share = _per_norm(store, port, vector) if store.constant(zero) == 0 else None
        if share is None:
            continue
        first, second = _turned(store, vector, sign, share, rest)
        if port == y:
            first, second = store.make("neg", (second,))[0], first
        store.union(Value(index, 0), first)
        store.union(Value(index, 1), second)


def _per_norm(store: Store, value: Value, vector: _Vector) -> Value | None:
    """Return a value divided by the norm of a vector, if the norm is a factor of it."""
    norm = store.find(Value(vector.index))
    factor, base = store.factored(value)
    if norm in (store.find(value), store.find(base)):
        return store.const(1 if store.find(value) == norm else factor)
    node = store.node(base)
    if node.op == "mul":
        for one, other in (node.operands, node.operands[::-1]):
            if store.find(one) == norm:
                return store.scale(factor, other)
    return None


def _turned(
    store: Store, vector: _Vector, sign: int, share: Value, rest: list[tuple[int, Value]]
) -> tuple[Value, Value]:
    """Return a vector, or for -1 its mirror image, times a share of it, turned by a sum of angles."""
    x, y = (store.mul(share, v) for v in vector.legs)
    y = y if sign == 1 else store.make("neg", (y,))[0]
    angle = store.const(0)
    for own, value in rest:
        angle = store.make("add" if own == 1 else "sub", (angle, value))[0]
    number = store.constant(angle)
    _name_size(store, vector)
    if number is None:
        made = store.make("rotate", (x, y, angle), (1,))
        return made[0], made[1]
    cosine, sine = (fold(name, (), (number,)) for name in ("cos", "sin"))
    first = store.make("sub", (store.scale(cosine, x), store.scale(sine, y)))[0]
    return first, store.add(store.scale(cosine, y), store.scale(sine, x))


def _name_size(store: Store, vector: _Vector) -> None:
    """Give guards a value that is 0 where a vector is, whose unit may no longer be there to tell it."""
    if not proven(store, "vector", vector.node.operands)[0]:
        x, y = (store.make("abs", (v,))[0] for v in vector.legs)
        # A sum would have a coarser word on fixed point.
        store.know_size(*vector.legs, store.make("max", (x, y))[0])


def _angle_terms(store: Store, value: Value) -> list[tuple[int, Value]]:
    """Return an angle modulo 2 pi as a sum of angles, each with its sign."""
    node = store.node(value)
    match node.op:
        case "neg":
            return [(-sign, v) for sign, v in _angle_terms(store, node.operands[0])]
        case "wrap":
            return _angle_terms(store, node.operands[0])
        case "add" | "sub":
            first, second = (_angle_terms(store, v) for v in node.operands)
            return first + ([(-sign, v) for sign, v in second] if node.op == "sub" else second)
    return [(1, value)]


TURNED_VECTORS = Rule(
    name="turned vectors",
    mathematics="(hypot(x, y), 0) turned by atan2(y, x) + d is (x, y) turned by d",
    apply=_add_turned_vectors,
    words="a norm turned by the angle of its vector and more: the vector, turned by what is left",
)


def _add_shares(given: Given) -> None:
    """Add sums of multiples of the components of a vector, divided by its norm, as rotations by its angle."""
    store = given.store
    norms: dict[Value, list[_Vector]] = {}
    for vector in _vectors(store):
        norms.setdefault(store.find(Value(vector.index)), []).append(vector)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        value = Value(index, 1) if node.op == "vector" and node.m == 0 else Value(index)
        found = _fraction(store, norms, value)
        if found is None:
            continue
        terms, norm = found
        for vector in norms[norm]:
            shares = _shares(store, terms, vector)
            if shares is not None:
                store.begin(node.origin)
                _add_share(store, value, vector, *shares)


def _fraction(
    store: Store, norms: Mapping[Value, Sequence[_Vector]], value: Value
) -> tuple[list[Term], Value] | None:
    """Return a numerator as a sum of products, and the class of the norm that it is divided by."""
    factor, factors = product_of(store.algebra.nodes, value)
    for at, part in enumerate(factors):
        node = store.node(part)
        if node.op != "vector" or node.m != 0 or part.result != 1:
            continue
        below, above, start = node.operands
        inner, base = store.factored(below)
        norm = store.find(base)
        terms = terms_of(store.algebra.nodes, above) if norm in norms and store.constant(start) == 0 else None
        if terms is not None:
            others = factors[:at] + factors[at + 1 :]
            return [(factor * k / inner, (*others, *own)) for k, own in terms], norm
    return None


def _shares(store: Store, terms: Sequence[Term], vector: _Vector) -> tuple[list[Term], list[Term]] | None:
    """Return (a, b) with the terms equal to a x + b y for the components of a vector, if they are."""
    legs = [store.factored(v) for v in vector.legs]
    shares: tuple[list[Term], list[Term]] = [], []
    for factor, factors in terms:
        for (own, leg), share in zip(legs, shares, strict=True):
            at = next((i for i, v in enumerate(factors) if store.find(v) == store.find(leg)), None)
            if at is not None:
                share.append((factor / own, factors[:at] + factors[at + 1 :]))
                break
        else:
            return None
    # Multiples by constants are cosine and sine of the angle alone, see `unit_vectors`.
    return shares if any(factors for share in shares for _, factors in share) else None


def _add_share(store: Store, value: Value, vector: _Vector, a: Iterable[Term], b: Iterable[Term]) -> None:
    """Make a value a cos t + b sin t for the angle t of a vector."""
    along, across = _built(store, a), _built(store, b)
    angle = store.make("vector", (*vector.legs, store.const(0)), (1, 1))[1]
    first = store.make("rotate", (along, store.make("neg", (across,))[0], angle), (1,))[0]
    store.union(value, first)
    store.union(value, store.make("rotate", (across, along, angle), (1,))[1])


def _built(store: Store, terms: Iterable[Term]) -> Value:
    total = store.const(0)
    for factor, factors in terms:
        product = store.const(1)
        for value in factors:
            product = store.mul(product, value)
        total = store.add(total, store.scale(factor, product))
    return total


SHARES_OF_NORMS = Rule(
    name="quotients by norms",
    mathematics="(a x + b y)/hypot(x, y) = a cos t + b sin t for t = atan2(y, x)",
    apply=_add_shares,
    words="multiples of the components of a vector, divided by its norm: a rotation by its angle",
)
