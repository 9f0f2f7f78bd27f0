"""Every value that a realisation may use, with what is known about it.

Values are nodes of one hash-consed builder.  Each has an enclosure, numbers on sample points and, where
it has one, an element of the field; equal elements make values equal.  An angle has a rotor besides:
its cosine and sine (m = 1), or hyperbolic cosine and sine (m = -1), as elements.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Node, Param, Value, factored
from cordicc.ir.meaning.doubles import results
from cordicc.ir.meaning.enclosures import result_ranges as enclose
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.roundings import SINGLE, Words, errors
from cordicc.rewrite.exact.algebra import ValueAlgebra
from cordicc.rewrite.exact.angle_rotors import Rotors
from cordicc.rewrite.exact.constants import Constants
from cordicc.rewrite.exact.elements import ElementFinder, long_parts
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Element, Field, Poly, TooLarge
from cordicc.rewrite.exact.keys import ElementKey, Key
from cordicc.rewrite.exact.polynomials import Polynomials
from cordicc.rewrite.exact.signs import Signs, is_square_sum, never_negative

_CLEARLY = 1e-6
"""A value of this size, beside the largest one on the samples, is no rounding error."""


class Store:
    """Values and facts about them; `make` adds an operation."""

    def __init__(
        self,
        field: Field,
        ranges: Mapping[str, Interval],
        samples: Mapping[str, Floats],
        words: Words = SINGLE,
    ) -> None:
        self.field = field
        self._words = words
        self.algebra = ValueAlgebra()
        self.reason: tuple[str, ...] = ()
        self.why: dict[int, tuple[str, ...]] = {}
        self.rests: dict[int, frozenset[str]] = {}
        self._inputs, self._samples = ranges, samples
        self._count = len(next(iter(samples.values())))
        self._ranges: list[tuple[Interval | None, ...]] = []
        self._numbers: list[tuple[Floats, ...]] = []
        self._errors: list[tuple[Floats, ...]] = []
        self._elements: list[tuple[Element | None, ...]] = []
        self._signs = Signs(field)
        self.polynomials = Polynomials()
        self.constants = Constants(field)
        self.rotors = Rotors(self.constants, self)
        self._finder = ElementFinder(self.constants, self.rotors, self._signs, self)
        self._parent: dict[Value, Value] = {}
        self._by_key: dict[ElementKey, Value] = {}
        self._by_shape: dict[object, Value] = {}
        self._opaque: dict[Value, Element] = {}
        self._opaque_generators: set[int] = set()
        self.opaque_left = 0
        self.turns: list[tuple[Value, Value]] = []
        self.angles: set[Value] = set()
        self.domains: dict[Value, list[Value]] = {}
        self.sizes: dict[tuple[Value, Value], Value] = {}
        self._square_sums: set[Key] = set()

    # -- building ---------------------------------------------------------------------------------

    def make(self, op: str, operands: Sequence[Value], params: Sequence[Param] = ()) -> tuple[Value, ...]:
        """Return the results of an operation, simplified; `reason` explains a new one."""
        before = len(self.algebra.nodes)
        made = self.algebra.apply(op, operands, params)
        for index in range(before, len(self.algebra.nodes)):
            self.why[index] = self.reason
            self._annotate(index)
            self.rests[index] = frozenset(self.field.touched)
        return made

    @contextmanager
    def explained(self, step: str) -> Iterator[None]:
        """Explain new operations by a further step, besides `reason`."""
        before = self.reason
        self.reason = (*before, step)
        try:
            yield
        finally:
            self.reason = before

    def begin(self, origin: str) -> None:
        """Start on what an equation asks for; facts that are used from here on are those of its nodes."""
        self.algebra.origin = origin
        self.field.touched.clear()

    def const(self, number: Fraction | int) -> Value:
        """Return a constant."""
        return self.make("const", (), (Fraction(number),))[0]

    def add(self, a: Value, b: Value) -> Value:
        """Return a + b."""
        return self.make("add", (a, b))[0]

    def mul(self, a: Value, b: Value) -> Value:
        """Return a b."""
        return self.make("mul", (a, b))[0]

    def scale(self, factor: Fraction, a: Value) -> Value:
        """Return factor * a."""
        if factor == 1:
            return a
        if factor == 0:
            return self.const(0)
        return self.make("cmul", (a,), (factor,))[0]

    def node(self, value: Value) -> Node:
        """Return the node that makes a value."""
        return self.algebra.nodes[value.node]

    def factored(self, value: Value) -> tuple[Fraction, Value]:
        """Return (k, v) with value = k v, all constant factors in k."""
        return factored(self.algebra.nodes, value)

    def range(self, value: Value) -> Interval | None:
        """Return the enclosure of a value."""
        return self._ranges[value.node][value.result]

    def numbers(self, value: Value) -> Floats:
        """Return a value on the samples."""
        return self._numbers[value.node][value.result]

    def error(self, value: Value) -> Floats:
        """Return a bound of the rounding error of a value on the samples, in roundings."""
        return self._errors[value.node][value.result]

    def element(self, value: Value) -> Element | None:
        """Return a value as an element of the field, if it is one."""
        return self._elements[value.node][value.result]

    def constant(self, value: Value) -> Fraction | None:
        """Return the number of a constant, else None."""
        return self.algebra.constant(value)

    def generator_value(self, index: int) -> Value | Fraction | None:
        """Return what computes a generator of the field, if something does."""
        if index in self.rotors.turned:
            angle, m, result = self.rotors.turned[index]
            return self.make("rotate", (self.const(1), self.const(0), angle), (m,))[result]
        return self._finder.values.get(index, self.constants.values.get(index))

    # -- equality ---------------------------------------------------------------------------------

    def find(self, value: Value) -> Value:
        """Return the representative of all values that are known to be equal to this one."""
        root = value
        while root in self._parent:
            root = self._parent[root]
        while value in self._parent:
            self._parent[value], value = root, self._parent[value]
        return root

    def union(self, a: Value, b: Value) -> None:
        """Record that two values are equal wherever the problem has a value."""
        a, b = self.find(a), self.find(b)
        if a != b:
            self._parent[max(a, b)] = min(a, b)

    def same_turn(self, angle: Value, total: Value) -> None:
        """Record that a sum of angles equals an angle modulo 2 pi."""
        self.turns.append((angle, total))
        todo = [angle, total]
        while todo:
            value = todo.pop()
            if value not in self.angles:
                self.angles.add(value)
                node = self.node(value)
                todo += node.operands if node.op in ("add", "sub", "neg") else ()

    def same_domain(self, angle: Value, other: Value) -> None:
        """Record that the unit of one angle has a value exactly where that of another has."""
        self.domains.setdefault(angle, []).append(other)

    def know_size(self, x: Value, y: Value, size: Value) -> None:
        """Note a value that is 0 exactly where the vector (x, y) is; a guard may take it."""
        self.sizes[x, y] = size

    def size(self, x: Value, y: Value) -> Value | None:
        """Return a value that is 0 exactly where the vector (x, y) is, if one is known."""
        legs = {self.find(x), self.find(y)}
        found = (size for vector, size in self.sizes.items() if {self.find(v) for v in vector} == legs)
        return next(found, None)

    def affine(self, poly: Poly) -> tuple[Value, Fraction, Fraction] | None:
        """Return (v, k, d) with poly = k v + d, if there is such a value; cosines and sines as displayed."""
        return self.polynomials.affine(poly)

    def know_square_sum(self, poly: Poly) -> None:
        """Note a polynomial that is a sum of squares, nowhere negative whatever the values are."""
        self._square_sums.add(Key(poly))

    def is_known_square_sum(self, poly: Poly) -> bool:
        """Tell whether a polynomial was found to be a sum of squares."""
        return Key(poly) in self._square_sums

    # -- signs ------------------------------------------------------------------------------------

    def sign(self, value: Value) -> int:
        """Return 1 if the value is never negative, -1 if never positive, 0 if neither is proven."""
        interval = self.range(value)
        if interval is not None and interval.lo >= 0:
            return 1
        if interval is not None and interval.hi <= 0:
            return -1
        if self._takes_both_signs(value):
            return 0
        if is_square_sum(self, value, 8):
            return 1
        element = self.element(value)
        return 0 if element is None else self.poly_sign(element.num) * self.poly_sign(element.den)

    def unconditional_sign(self, poly: Poly) -> int:
        """Return the sign of a polynomial for every input within its range, 0 if none is proven."""
        return self._signs.unconditional(poly)

    def _unconditional_sign(self, value: Value) -> int:
        """Return the sign of a value for every input within its range, from how it is made."""
        interval = self.range(value)
        if not self.is_total(value) or interval is None or self._takes_both_signs(value):
            return 0
        if interval.lo >= 0 or interval.hi <= 0:
            return 1 if interval.lo >= 0 else -1
        return 1 if is_square_sum(self, value, 8) else 0

    def is_total(self, value: Value) -> bool:
        """Tell whether a value exists for every input within its range."""
        todo, seen = [value], {value}
        while todo:
            current = todo.pop()
            node = self.node(current)
            # The norm of a vector exists without an angle.
            if node.definition.partial and not (node.op == "vector" and node.m == 1 and current.result == 0):
                return False
            fresh = set(node.operands) - seen
            todo += fresh
            seen |= fresh
        return True

    def _takes_both_signs(self, value: Value) -> bool:
        """Tell whether the samples leave no doubt, so that nothing need be looked for."""
        numbers = self.numbers(value)
        most, least = float(np.fmax.reduce(numbers)), float(np.fmin.reduce(numbers))
        return min(most, -least) > _CLEARLY * max(most, -least)

    def assume(self, difference: Element, relation: str, fact: str) -> None:
        """Rest on a fact about an element: = 0, > 0, >= 0, < 0 or <= 0."""
        if relation == "=" and difference.is_polynomial:
            self.field.relate(difference.num, fact)
        elif relation != "=":
            self._signs.assume(difference, 1 if relation in (">", ">=") else -1, fact)

    def poly_sign(self, poly: Poly) -> int:
        """Return the sign of a polynomial, as `sign` does, from what is known of equal values."""
        return self._signs.of(poly)

    # -- annotation -------------------------------------------------------------------------------

    def _annotate(self, index: int) -> None:
        node = self.algebra.nodes[index]
        width = len(node.definition.results)
        if node.op == "input":
            name = node.name
            self._ranges.append((self._inputs[name],))
            self._numbers.append((self._samples[name],))
            self._errors.append(self._words.steps(node, self._numbers[-1]))
        else:
            ranges = [self.range(v) for v in node.operands]
            known = [r for r in ranges if r is not None]
            self._ranges.append(
                enclose(node.op, node.params, known) if len(known) == len(ranges) else (None,) * width
            )
            operands = [self.numbers(v) for v in node.operands]
            made = results(node.op, node.params, operands, self._count)
            self._numbers.append(made)
            moved = [self.error(v) for v in node.operands]
            steps = self._words.steps(node, made)
            self._errors.append(errors(node.op, node.params, operands, moved, made, steps))
        self._elements.append((None,) * width)
        self._annotate_elements(index)
        for result in range(width):
            self._register(Value(index, result), node)

    def _annotate_elements(self, index: int) -> None:
        """Find the elements of a node's results; parts that make them too large become generators."""
        node = self.algebra.nodes[index]
        while True:
            self._elements[index] = (None,) * len(node.definition.results)
            try:
                self._elements[index] = self._finder.elements(index)
            except TooLarge:
                if self.simplified(index):
                    continue
            except ZeroDivisionError:
                pass
            return

    def simplified(self, index: int) -> bool:
        """Make long values that a node is made of generators of their own; tell whether there were any.

        What they are made of is no longer seen then, but what is found without it holds whatever they are.
        """
        values = sorted(long_parts(self, index))[: self.opaque_left]
        changed = {value.node for value in values}
        for value in values:
            self.opaque_left -= 1
            made = list(self._elements[value.node])
            made[value.result] = self._opaque.setdefault(self.find(value), self._finder.free(value))
            self._opaque_generators |= set(self.field.generators(self._opaque[self.find(value)].num))
            self._elements[value.node] = tuple(made)
        for later in range(min(changed, default=index), index):
            node = self.algebra.nodes[later]
            if not changed.isdisjoint(v.node for v in node.operands):
                changed.add(later)
                self.rotors.forget(later)
                self._annotate_elements(later)
            if later in changed:
                for result in range(len(node.definition.results)):
                    self._register(Value(later, result), node)
        return bool(values)

    def reopened(self, index: int) -> bool:
        """Find the elements of a node anew from simpler operands; tell whether they could be made simpler."""
        if not self.simplified(index):
            return False
        self._annotate_elements(index)
        return True

    def is_transparent(self, element: Element) -> bool:
        """Tell whether an element holds no value that was made a generator of its own."""
        degrees = element.num.degrees(), element.den.degrees()
        return not any(own[index] for own in degrees for index in self._opaque_generators)

    def _register(self, value: Value, node: Node) -> None:
        shape = (node.op, node.params, tuple(self.find(v) for v in node.operands), value.result)
        self.union(value, self._by_shape.setdefault(shape, value))
        element = self.element(value)
        if element is None or len(element.num) > LOOKUP_TERMS:
            return
        inside = self.range(node.operands[0]) if node.op == "abs" else None
        if inside is not None and inside.lo < 0 and never_negative(self, node.operands[0]):
            return  # equal but for rounding, against which the absolute value is taken
        self.union(value, self._by_key.setdefault(element.key, value))
        self._signs.know(element, self.sign(value), self._unconditional_sign(value))
        poly = self.field.display(element)
        if poly is not None:
            self.polynomials.register(value, poly)
