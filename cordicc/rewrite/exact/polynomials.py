"""Values by their polynomials, up to a factor and a constant."""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import LOOKUP_TERMS, Poly, monic, rational
from cordicc.rewrite.exact.keys import Key

_SUM_TERMS = 40


class Polynomials:
    """Finds a value of which a polynomial is a multiple, plus a constant; cosines and sines as displayed.

    `sums` holds polynomials of a few terms, monic and without a constant, of which values are multiples but
    for constants, see `affine`; `multiples` values, as polynomials, that came after one that they are a
    multiple of.
    """

    def __init__(self) -> None:
        self.sums: list[Poly] = []
        self.multiples: list[tuple[Value, Poly]] = []
        self._known: dict[Key, tuple[Value, Fraction, Fraction]] = {}

    def register(self, value: Value, poly: Poly) -> None:
        """Note the polynomial of a value."""
        constant, factor, base = _parts(poly)
        key = Key(base)
        if factor and key in self._known:
            self.multiples.append((value, poly))
        elif factor:
            self._known[key] = (value, factor, constant)
            if 1 < len(poly) <= _SUM_TERMS:
                self.sums.append(base)

    def affine(self, poly: Poly) -> tuple[Value, Fraction, Fraction] | None:
        """Return (v, k, d) with poly = k v + d, if there is such a value."""
        if len(poly) > LOOKUP_TERMS:
            return None
        constant, factor, base = _parts(poly)
        found = self._known.get(Key(base))
        if found is None or factor == 0:
            return None
        value, its_factor, its_constant = found
        ratio = factor / its_factor
        return value, ratio, constant - ratio * its_constant


def _parts(poly: Poly) -> tuple[Fraction, Fraction, Poly]:
    """Return (d, k, p) with poly = k p + d, p monic without a constant."""
    ends = len(poly) > 0 and not any(poly.monomial(len(poly) - 1))
    constant = rational(poly.coefficient(len(poly) - 1)) if ends else Fraction(0)
    rest = poly - poly.coefficient(len(poly) - 1) if ends else poly
    factor, base = monic(rest)
    return constant, factor, base
