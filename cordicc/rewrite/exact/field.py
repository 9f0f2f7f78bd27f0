"""Exact algebra of scalars: fractions over inputs, cosines and sines, and square roots.

An element is num/den with polynomials over the rationals.  Generators are free ones, signs with square
1, and square roots r >= 0 with r^2 = radicand, each over the ones before it: a tower of quadratic
extensions.  Cosine and sine of an angle are fractions in one free generator, the tangent t of its half:
(1 - t^2)/(1 + t^2) and 2 t/(1 + t^2); the hyperbolic ones with -t^2.  The denominator holds free
generators only, is monic and coprime to the numerator, so equal elements have equal parts.  An equality
of elements is therefore a proof, wherever the denominators met on the way are not 0.

For arithmetic, `display` writes an element as a polynomial with cosines and sines as generators.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly_ctx

from cordicc.rewrite.exact.denominators import Denominators, Powers
from cordicc.rewrite.exact.half_angles import HalfAngles
from cordicc.rewrite.exact.keys import ElementKey, Key

Poly = Any
"""A polynomial of python-flint, `fmpq_mpoly`."""

Factors = tuple[Any, list[tuple[Poly, int]]]
"""A constant, and polynomials with their exponents."""

MOST_TERMS = 4_000
"""Terms of a numerator and a denominator together; larger elements are given up.  Twice as many may a
polynomial have whose squares of roots are still to be written out."""

_PRODUCT = 100_000
"""Products of terms in one multiplication."""

_SHORT = 16
"""Terms of relations that are divided by."""

_BITS = 4_000
"""Bits of the leading coefficient."""


LOOKUP_TERMS = 300
"""Terms of the longest polynomial that is looked up among those of other values."""


class TooLarge(Exception):
    """An element has outgrown the work that is spent on it, or the generators are used up."""


@dataclass(frozen=True)
class Element:
    """num/den, in lowest terms; `powers` are the factors of den by their numbers."""

    num: Poly
    den: Poly
    powers: Powers = ()

    @cached_property
    def key(self) -> ElementKey:
        """What is equal for equal elements."""
        return Key(self.num), Key(self.den)

    @property
    def is_polynomial(self) -> bool:
        """Whether the denominator is 1."""
        return bool(self.den.is_one())

    @property
    def is_zero(self) -> bool:
        """Whether it is 0."""
        return bool(self.num.is_zero())

    @property
    def constant(self) -> Fraction | None:
        """The number, if it is one."""
        if not (self.num.is_constant() and self.is_polynomial):
            return None
        return Fraction(0) if self.is_zero else rational(self.num.leading_coefficient())


def rational(number: Any) -> Fraction:
    """Return a number of python-flint as a Fraction."""
    return Fraction(int(number.numerator), int(number.denominator))


def square_root_of(number: Fraction) -> Fraction | None:
    """Return the root of a number that is the square of a rational, else None."""
    if number < 0:
        return None
    above, below = isqrt(number.numerator), isqrt(number.denominator)
    exact = above * above == number.numerator and below * below == number.denominator
    return Fraction(above, below) if exact else None


def _flint(number: Fraction) -> Any:
    return fmpq(number.numerator, number.denominator)


class Field:
    """The generators with their relations, and arithmetic on elements."""

    def __init__(self, free: int, pairs: int, roots: int, work: float = 1.0) -> None:
        """Reserve generators: `free` ones, sines and signs (`pairs`), and square roots.

        `work` multiplies the sizes up to which elements are calculated; `given_up` counts what outgrew them.
        """
        self._most_terms, self._most_products = int(MOST_TERMS * work), int(_PRODUCT * work)
        self.given_up = 0
        # Lexicographic, later roots first: r^2 - radicand has r^2 as its leading term.
        names = [
            *(f"r{i}" for i in reversed(range(roots))),
            *(f"s{i}" for i in reversed(range(pairs))),
            *(f"v{i}" for i in range(free)),
        ]
        self.context = fmpq_mpoly_ctx.get(names, Ordering.lex)
        self._gens = self.context.gens()
        self._roots_left = list(range(roots - 1, -1, -1))
        self._pairs_left = list(range(roots + pairs - 1, roots - 1, -1))
        self._free_left = list(range(roots + pairs, roots + pairs + free))
        self._relations: dict[int, Poly] = {}
        self.half_angles = HalfAngles(self.context)
        self._facts: dict[int, str] = {}
        self.touched: set[str] = set()
        self.definite: dict[Key, int] = {}
        self.radicands: dict[int, Poly] = {}
        self.one = self.context.constant(1)
        self.zero = self.context.constant(0)
        self._nothing = Element(self.zero, self.one)
        self._denominators = Denominators(self.one, self._multiplied)
        self._products: dict[frozenset[ElementKey], tuple[Element, frozenset[str]]] = {}
        self._displayed: dict[ElementKey, Poly | None] = {}
        self._factored: dict[Key, Factors] = {}
        self._squarefree: dict[Key, Factors] = {}

    def generator(self, index: int) -> Poly:
        """Return a generator as a polynomial."""
        return self._gens[index]

    def number(self, value: Fraction) -> Element:
        """Return a constant."""
        return Element(self.context.constant(_flint(value)), self.one)

    def free(self) -> int:
        """Return a new free generator."""
        if not self._free_left:
            raise self._outgrown()
        return self._free_left.pop(0)

    def pair(self, m: int) -> tuple[int, int, Element, Element]:
        """Return generators c and s with c^2 + m s^2 = 1 for display, and the elements they stand for."""
        if not self._pairs_left:
            raise self._outgrown()
        tangent, cosine, sine = self.free(), self.free(), self._pairs_left.pop(0)
        self._relations[sine] = self._gens[sine] ** 2 - m * (1 - self._gens[cosine] ** 2)
        self.half_angles.add(tangent, cosine, sine, m)
        t = self._gens[tangent]
        below = 1 + m * t**2
        # A hyperbolic tangent is less than 1, so 1 - t^2, 1 - t and 1 + t are positive.
        self.definite |= {Key(t**2 + 1): 1} if m == 1 else {Key(t**2 - 1): -1, Key(t - 1): -1, Key(t + 1): 1}
        return cosine, sine, self.fraction(1 - m * t**2, below), self.fraction(2 * t, below)

    def display(self, element: Element) -> Poly | None:
        """Return an element as a polynomial in cosines and sines, None if it has other denominators."""
        key = element.key
        if key not in self._displayed:
            polys = self.half_angles.displays([element.num], element.den)
            self._displayed[key] = None if polys is None else polys[0]
        return self._displayed[key]

    def relate(self, poly: Poly, fact: str = "") -> bool:
        """Take a polynomial for 0 if its leading term is a square of one free generator; tell whether.

        `touched` holds the facts that were used since it was cleared.
        """
        _, base = monic(poly)
        powers = base.monomial(0) if len(base) else ()
        index = next((i for i, power in enumerate(powers) if power), None)
        free = index is not None and index not in self._relations and powers[index] == sum(powers) == 2
        if index is None or not free or (base - self._gens[index] ** 2).degrees()[index]:
            return False
        if self._denominators.holds(index):
            return False
        self._relations[index] = base
        self._products.clear()
        if fact:
            self._facts[index] = fact
        return True

    def sign(self) -> int:
        """Return a new generator with square 1."""
        if not self._pairs_left:
            raise self._outgrown()
        index = self._pairs_left.pop(0)
        self._relations[index] = self._gens[index] ** 2 - 1
        return index

    def root(self, radicand: Poly) -> Element:
        """Return the non-negative root of a polynomial."""
        for index, known in self.radicands.items():
            ratio = Element(radicand, self.one) if known.is_zero() else self._ratio(radicand, known)
            number = None if ratio is None else square_root_of(ratio.constant or Fraction(-1))
            if number is not None:
                return Element(self._gens[index] * _flint(number), self.one)
        if not self._roots_left:
            raise self._outgrown()
        index = self._roots_left.pop(0)
        self.radicands[index] = radicand
        self._relations[index] = self._gens[index] ** 2 - radicand
        return Element(self._gens[index], self.one)

    def _ratio(self, a: Poly, b: Poly) -> Element | None:
        """Return a/b if it is a constant."""
        if len(a) != len(b) or any(a.monomial(i) != b.monomial(i) for i in (0, len(a) // 2, len(a) - 1)):
            return None
        factor = a.leading_coefficient() / b.leading_coefficient()
        return Element(self.context.constant(factor), self.one) if a == b * factor else None

    def reduce(self, poly: Poly) -> Poly:
        """Return a polynomial with no generator of a relation above the first power.  Raises TooLarge."""
        degrees = poly.degrees()
        for index in sorted(self._relations):
            if degrees[index] > 1:
                if len(poly) > 2 * self._most_terms:
                    raise self._outgrown()
                if index in self._facts:
                    self.touched.add(self._facts[index])
                poly = self._remainder(poly, index, degrees[index])
                degrees = poly.degrees()
        return poly

    def _remainder(self, poly: Poly, index: int, degree: int) -> Poly:
        relation = self._relations[index]
        if degree == 2 and len(relation) > min(len(poly), _SHORT):
            # Half the second derivative is the quotient; a division goes through the relation term by term.
            return poly - poly.derivative(index).derivative(index) * fmpq(1, 2) * relation
        return poly % relation

    def times(self, a: Poly, b: Poly) -> Poly:
        """Return the reduced product."""
        return self.reduce(self._multiplied(a, b))

    def _multiplied(self, a: Poly, b: Poly) -> Poly:
        if len(a) * len(b) > self._most_products:
            raise self._outgrown()
        return a * b

    def _outgrown(self) -> TooLarge:
        self.given_up += 1
        return TooLarge()

    def fraction(self, num: Poly, den: Poly) -> Element:
        """Return num/den, for a denominator of free generators.  Raises TooLarge."""
        if num.is_zero():
            return self._nothing
        powers = self._denominators.of(den)
        if powers is None:
            raise TooLarge
        return self._lowest(num / den.leading_coefficient(), powers, [index for index, _ in powers])

    def _lowest(self, num: Poly, powers: Powers, among: Sequence[int]) -> Element:
        """Return num over the product of some factors, of which those in `among` may go into num."""
        if num.is_zero():
            return self._nothing
        if among:
            num, powers = self._denominators.lowest(num, powers, among)
        den = self._denominators.product(powers)
        lead = num.leading_coefficient()
        bits = int(lead.numerator).bit_length() + int(lead.denominator).bit_length()
        if len(num) + len(den) > self._most_terms or bits > _BITS:
            raise self._outgrown()
        return Element(num, den, powers)

    def add(self, a: Element, b: Element) -> Element:
        """Return a + b."""
        if a.powers == b.powers:
            return self._lowest(a.num + b.num, a.powers, [index for index, _ in a.powers])
        first, second = dict(a.powers), dict(b.powers)
        whole = {i: max(first.get(i, 0), second.get(i, 0)) for i in sorted(first | second)}
        nums = []
        for num, own in ((a.num, first), (b.num, second)):
            missing = tuple((i, power - own.get(i, 0)) for i, power in whole.items() if power > own.get(i, 0))
            nums.append(self._multiplied(num, self._denominators.product(missing)))
        # A factor that is missing in one of them goes into one summand and not into the other.
        among = [i for i in whole if first.get(i) == second.get(i)]
        return self._lowest(nums[0] + nums[1], tuple(whole.items()), among)

    def scale(self, factor: Fraction, a: Element) -> Element:
        """Return factor * a."""
        return Element(a.num * _flint(factor), a.den, a.powers) if factor else self._nothing

    def sub(self, a: Element, b: Element) -> Element:
        """Return a - b."""
        return self.add(a, self.scale(Fraction(-1), b))

    def mul(self, a: Element, b: Element) -> Element:
        """Return a b.  Raises TooLarge."""
        if a.is_zero or b.is_zero:
            return self._nothing
        key = frozenset((a.key, b.key))
        if key not in self._products:
            before, self.touched = self.touched, set()
            try:
                product = self._product(a, b)
            finally:
                touched, self.touched = self.touched, before
            self._products[key] = product, frozenset(touched)
        product, facts = self._products[key]
        self.touched |= facts
        return product

    def _product(self, a: Element, b: Element) -> Element:
        first, second = dict(a.powers), dict(b.powers)
        num, below = self._denominators.lowest(a.num, b.powers, [i for i in second if i not in first])
        other, under = self._denominators.lowest(b.num, a.powers, [i for i in first if i not in second])
        total = dict(below)
        for index, power in under:
            total[index] = total.get(index, 0) + power
        powers = tuple(sorted(total.items()))
        product = self._multiplied(num, other)
        reduced = self.reduce(product)
        # Both are in lowest terms, so only a relation brings more of a factor into the numerator.
        return self._lowest(reduced, powers, [] if reduced is product else list(total))

    def inverse(self, a: Element) -> Element:
        """Return 1/a; the denominator is freed of roots and signs by conjugates.

        Raises ZeroDivisionError for 0.
        """
        if a.is_zero:
            raise ZeroDivisionError
        num, den = a.den, a.num
        for index in sorted(self._relations):
            if den.degrees()[index]:
                even, odd = self.split(den, index)
                conjugate = even - odd * self._gens[index]
                num, den = self.times(num, conjugate), self.times(den, conjugate)
        if den.is_zero():
            raise ZeroDivisionError
        return self.fraction(num, den)

    def div(self, a: Element, b: Element) -> Element:
        """Return a / b.  Raises ZeroDivisionError."""
        return self.mul(a, self.inverse(b))

    def factors(self, poly: Poly) -> Factors:
        """Return a constant and the irreducible factors of a polynomial with their exponents."""
        key = Key(poly)
        if key not in self._factored:
            self._factored[key] = poly.factor()
        return self._factored[key]

    def squarefree_factors(self, poly: Poly) -> Factors:
        """Return a constant and square-free factors of a polynomial with their exponents."""
        key = Key(poly)
        if key not in self._squarefree:
            self._squarefree[key] = poly.factor_squarefree()
        return self._squarefree[key]

    def split(self, poly: Poly, index: int) -> tuple[Poly, Poly]:
        """Return (p, q) with poly = p + q g for a generator g of a relation."""
        odd = poly.derivative(index)
        return poly - odd * self._gens[index], odd

    def generators(self, *polys: Poly) -> Iterator[int]:
        """Yield the generators that occur, in order."""
        degrees = [poly.degrees() for poly in polys]
        yield from (i for i in range(len(self._gens)) if any(d[i] > 0 for d in degrees))

    def roots_of(self, *elements: Element) -> list[int]:
        """Return the square roots that occur in elements."""
        found = self.generators(*(e.num for e in elements))
        return [index for index in found if index in self.radicands]


def monic(poly: Poly) -> tuple[Fraction, Poly]:
    """Return (k, p) with poly = k p and p monic; (0, 0) for 0."""
    if poly.is_zero():
        return Fraction(0), poly
    lead = poly.leading_coefficient()
    return rational(lead), poly / lead
