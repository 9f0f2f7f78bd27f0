"""Sums of squares multiplied out over values that several of them share, and roots by implicit units.

|p - q_i|^2 for many i holds the same products; multiplied out over inputs, products and sums that are
used more than once, they are made once.  sqrt(a^2 + w) needs no a^2: with B = (w/k + k)/2 and
C = (w/k - k)/2 it is sqrt(a^2 + B^2 - C^2), the second result of an implicit unit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from math import log2

import numpy as np

from cordicc.ir.graph import Graph, Value
from cordicc.rewrite.exact.field import TooLarge, square_root_of
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Need, Rule

Terms = dict[tuple[Value, ...], Fraction]
"""Coefficients by monomial: (), (a,) or (a, b) with a <= b."""

_LINEAR = ("add", "sub", "neg", "cmul", "shift")
_LEAST = 0.1
"""The least share of the largest root, on the samples, for which units with an absolute error serve."""

_MOST = 40
"""Longer sums are left as they are."""


def _add_squares(given: Given) -> None:
    """Add what the sums of products of each realisation are when multiplied out."""
    for graph, moved in zip(given.graphs, given.moved, strict=True):
        _add_squares_of(given.store, graph, moved)


def _add_squares_of(store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]]) -> None:
    """Add what the sums of products of a graph, whose nodes became `moved`, are when multiplied out."""
    squares = Squares(store, graph, moved)
    used = graph.used_results()
    roots = []
    for index in sorted(graph.live()):
        node = graph.nodes[index]
        store.begin(node.origin)
        operands = [moved[v.node][v.result] for v in node.operands]
        if node.op not in _LINEAR:
            for value in operands:
                squares.join(value)
        norm = node.op == "vector" and node.m == 1 and Value(index, 1) not in used
        if norm or (node.op == "lightcone" and Value(index, 1) not in used):
            roots.append(moved[index][0])
    squares.add_roots(roots)


class Squares:
    """Multiplies out; `moved` are the values of a graph, whose uses tell which sums are shared."""

    def __init__(self, store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]]) -> None:
        self._store = store
        live = graph.live()
        users = [
            (moved[v.node][v.result], index)
            for index in sorted(live)
            for v in set(graph.nodes[index].operands)
        ]
        counts: dict[Value, int] = {}
        for value, _ in users:
            counts[value] = counts.get(value, 0) + 1
        self._shared = {value for value, count in counts.items() if count > 1}

    def join(self, value: Value) -> None:
        """Add a sum, multiplied out."""
        if self._store.node(value).op not in ("add", "sub"):
            return
        terms = self.reduced(self._quadratic(value))
        if 1 < sum(len(m) == 2 for m in terms) <= _MOST:
            SQUARES.tell(self._store)
            self._store.union(value, self._sum(terms))

    def add_roots(self, roots: Sequence[Value]) -> None:
        """Add roots as second results of implicit units; most roots square the value that is left out."""
        store = self._store
        radicands = []
        for root in dict.fromkeys(roots):
            terms = self._radicand(root)
            terms = {} if terms is None else self.reduced(terms)
            if len(terms) <= _MOST and any(len(m) == 2 for m in terms):
                radicands.append((root, terms))
        counts = Counter(v for _, terms in radicands for v in _squared(terms))
        for root, terms in radicands:
            store.begin(store.node(root).origin)
            SQUARES.tell(store)
            store.union(root, store.make("lightcone", (self._sum(terms), store.const(1)))[0])
            squared = _squared(terms)
            if squared:
                self._add_root(root, *_without(terms, max(squared, key=lambda v: (counts[v], -v.node))))

    def _add_root(self, root: Value, base: Terms, rest: Terms) -> None:
        """Add the root of base^2 + rest as the second result of an implicit unit."""
        store = self._store
        size = np.abs(store.numbers(root))
        # The unit's error is one of B and C, not of the root: small roots would lose their digits.
        if all(not monomial for monomial in rest) or not np.nanmin(size) > _LEAST * np.nanmax(size):
            return
        SQUARES.tell(store, "root")
        own, w = self._sum(base), self._sum(rest)
        usual = float(np.nanmedian(np.abs(store.numbers(w))))
        if not usual > 0:
            return
        k = Fraction(2) ** round(log2(usual) / 2)
        scaled = store.scale(1 / (2 * k), w)
        B, C = store.add(scaled, store.const(k / 2)), store.add(scaled, store.const(-k / 2))
        # A = B = 0 means w = -k^2, and then the radicand is negative: no sample becomes invalid.
        store.union(root, store.make("implicit", (own, B, C), (1, "+"))[1])

    def _radicand(self, root: Value) -> Terms | None:
        """Return the square of a root as terms."""
        store = self._store
        node = store.node(root)
        if node.op == "lightcone":
            u, v = node.operands
            number = store.constant(v)
            if number is None:
                return _product(self._linear(u), self._linear(v))
            return _scaled(self._quadratic(u), number)
        if node.op != "vector" or node.m != 1:
            return None
        total: Terms = {}
        for value in node.operands[:2]:
            inner = store.node(value)
            square = (
                self._radicand(value) if value.result == 0 and inner.op in ("vector", "lightcone") else None
            )
            linear = self._linear(value)
            total = _sum(total, _product(linear, linear) if square is None else square)
        return total

    # -- terms ------------------------------------------------------------------------------------

    def _quadratic(self, value: Value) -> Terms:
        """Return a value as a sum of products."""
        node = self._store.node(value)
        if node.op == "mul":
            return _product(self._linear(node.operands[0]), self._linear(node.operands[1]))
        return self._combined(value, quadratic=True)

    def _linear(self, value: Value) -> Terms:
        """Return a value as a linear form of products, shared sums and results of units."""
        node = self._store.node(value)
        offset = any(self._store.constant(v) is not None for v in node.operands)
        if node.op in ("add", "sub") and value in self._shared and not offset:
            return {(value,): Fraction(1)}
        return self._combined(value, quadratic=False)

    def _combined(self, value: Value, *, quadratic: bool) -> Terms:
        """Return a value as what it is added up from."""
        store, node = self._store, self._store.node(value)
        expand = self._quadratic if quadratic else self._linear
        number = store.constant(value)
        if number is not None:
            return {(): number} if number else {}
        match node.op:
            case "add":
                return _sum(expand(node.operands[0]), expand(node.operands[1]))
            case "sub":
                return _sum(expand(node.operands[0]), expand(node.operands[1]), Fraction(-1))
            case "neg":
                return _scaled(expand(node.operands[0]), Fraction(-1))
            case "cmul":
                return _scaled(expand(node.operands[0]), node.factor)
            case "shift" if node.exponent.denominator == 1:
                return _scaled(expand(node.operands[0]), Fraction(2) ** int(node.exponent))
        return {(value,): Fraction(1)}

    def reduced(self, terms: Terms) -> Terms:
        """Return terms with the part that holds no input as a number, if it is one."""
        store = self._store
        part = {
            m: factor
            for m, factor in terms.items()
            if len(m) == 2 and not any(store.node(v).op == "input" for v in m)
        }
        if not part or len(part) > _MOST:
            return terms
        total = store.field.number(Fraction(0))
        with suppress(TooLarge):
            for (a, b), factor in part.items():
                first, second = store.element(a), store.element(b)
                if first is None or second is None:
                    return terms
                total = store.field.add(total, store.field.scale(factor, store.field.mul(first, second)))
            if total.constant is not None:
                rest = {m: factor for m, factor in terms.items() if m not in part}
                return _sum(rest, {(): total.constant})
        return terms

    def _sum(self, terms: Terms) -> Value:
        """Return a value; terms with factors of one size are added before they are scaled."""
        store = self._store
        groups: dict[Fraction, list[tuple[tuple[Value, ...], bool]]] = {}
        for monomial, factor in sorted(terms.items()):
            groups.setdefault(abs(factor), []).append((monomial, factor < 0))
        parts = []
        for size, members in groups.items():
            negative = members[0][1]
            total = self._monomial(members[0][0])
            for monomial, minus in members[1:]:
                total = store.make("add" if minus == negative else "sub", (total, self._monomial(monomial)))[
                    0
                ]
            parts.append(store.scale(-size if negative else size, total))
        while len(parts) > 1:
            pairs = [store.add(a, b) for a, b in zip(parts[::2], parts[1::2], strict=False)]
            parts = pairs + parts[2 * len(pairs) :]
        return parts[0] if parts else store.const(0)

    def _monomial(self, monomial: tuple[Value, ...]) -> Value:
        if not monomial:
            return self._store.const(1)
        return monomial[0] if len(monomial) == 1 else self._store.mul(*monomial)


def _squared(terms: Mapping[tuple[Value, ...], Fraction]) -> list[Value]:
    """Return the values whose squares have a rational square for a factor."""
    return [
        m[0] for m, factor in sorted(terms.items()) if len(m) == 2 and m[0] == m[1] and square_root_of(factor)
    ]


def _without(terms: Terms, own: Value) -> tuple[Terms, Terms]:
    """Return (A, w) with the terms equal to A^2 + w, A linear in a value that is squared."""
    scale = square_root_of(terms[own, own])
    assert scale is not None
    base: Terms = {(own,): scale}
    crossed = any(len(m) == 2 and own in m and m != (own, own) for m in terms)
    linear = terms.get((own,), Fraction(0))
    if linear and not crossed:
        base[()] = linear / (2 * scale)
    return base, _sum(terms, _product(base, base), Fraction(-1))


def _scaled(terms: Terms, factor: Fraction) -> Terms:
    return {m: factor * value for m, value in terms.items()} if factor else {}


def _sum(a: Terms, b: Terms, factor: Fraction = Fraction(1)) -> Terms:
    total = dict(a)
    for monomial, value in b.items():
        total[monomial] = total.get(monomial, Fraction(0)) + factor * value
    return {m: value for m, value in total.items() if value}


def _product(a: Terms, b: Terms) -> Terms:
    total: Terms = {}
    for first, p in a.items():
        total = _sum(total, {tuple(sorted((*first, *second))): p * q for second, q in b.items()})
    return total


SQUARES = Rule(
    name="squares multiplied out",
    mathematics="(p - q)^2 = p^2 - 2 p q + q^2, sqrt(a^2 + w) = sqrt(a^2 + B^2 - C^2), B, C = (w/k +- k)/2",
    apply=_add_squares,
    needs=frozenset({Need.GRAPHS}),
    words="multiplied out over values that are used more than once",
    cases={
        "root": "`sqrt(A**2 + w)` with `w = B**2 - C**2`: the second result for `B*cos(t) + A*sin(t) = C`",
    },
)
