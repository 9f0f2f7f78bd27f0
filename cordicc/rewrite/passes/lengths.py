"""Lengths of vectors as vectorings: which components they have, and whose angle is taken besides.

A root of three squares and more has a choice: of their sum, or as the length of (length, component) and so
on.  On fixed point small components vanish in the sum of their squares, so that lengths are chained where a
root may be small: sqrt(x^2 + c y^2) is the length of (x, sqrt(c) y).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

from cordicc.ir.graph import Graph, Node, Value, factored
from cordicc.ir.meaning.exact import fold
from cordicc.rewrite.exact.signs import never_negative, stays_nonnegative
from cordicc.rewrite.exact.terms import terms_of
from cordicc.rewrite.passes.base import Enclosed, Site

_SMALL = 2.0**-10
"""A radicand is as accurate as its root's word, with guard bits, down to this share of the largest."""

_DEPTH = 8


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


def key_of(legs: Legs) -> frozenset[tuple[Fraction, Value | None]]:
    """Return what the vectors of one length have in common."""
    return frozenset((abs(leg.factor), leg.base) for leg in legs)


def angles_of_vectors(graph: Graph) -> Angles:
    """Return the vectors of which a graph takes the angle."""
    found: Angles = {}
    for node in graph.nodes:
        if node.op == "atan2":
            y, x = (Leg.of(graph, v) for v in node.operands)
            found.setdefault(key_of((x, y)), (x, y))
    return found


def signed_square(graph: Graph, value: Value) -> tuple[int, Leg] | None:
    """Return (sign, x) if the value stands as sign * x^2: a multiple of a square, or a constant."""
    number = graph.constant(value)
    factor, base = (number, None) if number is not None else factored(graph.nodes, value)
    if base is not None:
        node = graph.node(base)
        if node.op != "mul" or node.operands[0] != node.operands[1]:
            return None
        base = node.operands[0]
    return (1 if factor >= 0 else -1), Leg(fold("sqrt", (), (abs(factor),)), base)


def length(site: Site, legs: Legs, angles: Angles) -> Value:
    """Return the length of a vector, from the vectoring whose angle is taken if there is one."""
    x, y = angles.get(key_of(legs), legs)
    return site.builder.apply("vector", (x.build(site), y.build(site), site.builder.const(0)), (1, 1))[0]


def chained_length(site: Site, radicand: Node, angles: Angles) -> Value | None:
    """Return sqrt(x^2 + y^2 + z^2) as the length of (sqrt(x^2 + y^2), z) if the first is there anyway."""
    if radicand.op != "add":
        return None
    graph, builder = site.graph, site.builder
    for pair, third in (radicand.operands, radicand.operands[::-1]):
        inner, last = graph.node(pair), signed_square(graph, third)
        if inner.op != "add" or last is None or last[0] < 0:
            continue
        first, second = (signed_square(graph, v) for v in inner.operands)
        if first is None or second is None or first[0] < 0 or second[0] < 0:
            continue
        if key_of((first[1], second[1])) in angles:
            plane = length(site, (first[1], second[1]), angles)
            return builder.apply("vector", (plane, last[1].build(site), builder.const(0)), (1, 1))[0]
    return None


@dataclass(frozen=True, slots=True)
class SmallLengths:
    """Roots of sums of squares by chains of lengths, in which small components keep their digits.

    `angles` are the vectors whose angle is taken, `known` are the values of the graph with their ranges;
    `always`: of radicands too that are nowhere small.
    """

    angles: Angles
    known: Enclosed
    always: bool = False

    def root(self, site: Site, radicand: Value) -> Value | None:
        """Return the root of a sum of squares, weighted by what is never negative.

        Less other squares it is sqrt(P^2 - N^2) for two such lengths.  None if the radicand is another one,
        or nowhere small.
        """
        graph = site.graph
        node = graph.node(radicand)
        for value, other in (node.operands, node.operands[::-1]) if node.op == "max" else ():
            number = graph.constant(other)
            if number is not None and number <= 0 and self._never_negative(value):
                return self.root(site, value)
        terms = _merged_terms(graph, radicand)
        weights = {v for factors in terms for v in _halved(factors)[1]}
        if len(terms) < 2 or not all(terms.values()) or not all(self._never_negative(v) for v in weights):
            return None
        interval = self.known.range(radicand)
        if not self.always and (interval is None or interval.lo > _SMALL * interval.hi):
            return None
        signed = [
            {factors: abs(factor) for factors, factor in terms.items() if factor * sign > 0}
            for sign in (1, -1)
        ]
        if not signed[1]:
            return self._chain(site, signed[0])
        # With a constant not all of the squares can be small, and their lengths are no better.
        if not signed[0] or () in terms:
            return None
        positive, negative = (self._chain(site, part) for part in signed)
        return site.builder.apply("vector", (positive, negative, site.builder.const(0)), (-1, 1))[0]

    def _never_negative(self, value: Value) -> bool:
        return never_negative(self.known, value)

    def _chain(self, site: Site, terms: Mapping[tuple[Value, ...], Fraction]) -> Value:
        """Return the root of a sum of products of squares and weights; known vectors come first."""
        plain, rest = list[Leg](), list[Value]()
        for factors, factor in terms.items():
            roots, weights = _halved(factors)
            if not weights and len(roots) < 2:
                plain.append(Leg(fold("sqrt", (), (factor,)), roots[0] if roots else None))
            else:
                rest.append(self._weighted(site, factor, roots, weights))
        made = list[Value]()
        for pair in combinations(tuple(plain), 2):
            if key_of(pair) in self.angles and all(leg in plain for leg in pair):
                made.append(length(site, pair, self.angles))
                plain = [leg for leg in plain if leg not in pair]
        todo = [*made, *(leg.build(site) for leg in plain), *rest]
        while len(todo) > 1:
            zero = site.builder.const(0)
            todo = [*todo[2:], site.builder.apply("vector", (todo[0], todo[1], zero), (1, 1))[0]]
        return todo[0]

    def _weighted(
        self, site: Site, factor: Fraction, roots: Sequence[Value], weights: Sequence[Value]
    ) -> Value:
        """Return the root of a product of squares and of weights."""
        builder, total = site.builder, site.builder.const(1)
        for value in roots:
            total = builder.mul(total, site.new(value))
        if weights:
            *others, last = (self._size(site, value) for value in weights)
            first = builder.const(1)
            for value in others:
                first = builder.mul(first, value)
            total = builder.mul(total, builder.apply("lightcone", (last, first))[0])
        return builder.scale(fold("sqrt", (), (factor,)), total)

    def _size(self, site: Site, value: Value) -> Value:
        """Return a value that is never negative, whatever its rounding."""
        interval = self.known.range(value)
        positive = interval is not None and interval.lo > _SMALL * interval.hi
        if positive or stays_nonnegative(self.known, value, _DEPTH):
            return site.new(value)
        return site.builder.apply("abs", (site.new(value),))[0]


def _merged_terms(graph: Graph, value: Value) -> dict[tuple[Value, ...], Fraction]:
    """Return a value as a sum of products, each once, with its coefficient; nothing if it is long."""
    total: dict[tuple[Value, ...], Fraction] = {}
    for factor, factors in terms_of(graph.nodes, value) or ():
        key = tuple(sorted(factors))
        total[key] = total.get(key, Fraction(0)) + factor
    return total


def _halved(factors: Sequence[Value]) -> tuple[list[Value], list[Value]]:
    """Return (u, v) with a product equal to the square of the product of u times that of v."""
    counts = Counter(factors)
    return [v for v in counts for _ in range(counts[v] // 2)], [v for v in counts if counts[v] % 2]
