"""Constants of the graph as the square roots, cosines and sines that they were rounded from.

A constant of the graph is a rational; one that stands for an irrational number has 256 bits.  With such
a number taken for what it stands for, sqrt(3)^2 = 3 holds exactly.
"""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.meaning.exact import PI, fold
from cordicc.rewrite.exact.field import Element, Field, rational, square_root_of

Rotor = tuple[Element, Element]

_NEAR = Fraction(1, 1 << 200)
_LONG = 160
_SIMPLE = 1 << 100


def _simple(number: Fraction) -> Fraction | None:
    """Return the fraction of short terms that a constant of 256 bits stands for, if it does."""
    near = number.limit_denominator(_SIMPLE)
    close = abs(near - number) <= abs(number) / (1 << 230)
    return near if close and near.numerator.bit_length() < 120 else None


class Constants:
    """Finds the elements of constants, and remembers the numbers behind their generators."""

    def __init__(self, field: Field) -> None:
        self.field = field
        self.values: dict[int, Fraction] = {}
        self._known: list[tuple[Fraction, Element]] = []
        self._rotors: dict[tuple[Fraction, int], Rotor] = {}

    def number(self, number: Fraction) -> Element:
        """Return a constant; a rounded one as the square root or cosine that it stands for, if known."""
        field = self.field
        if number.denominator.bit_length() < _LONG:
            return field.number(number)
        square = _simple(number * number)
        if square is not None:
            root = self._root(square)
            return root if number > 0 else field.scale(Fraction(-1), root)
        for value, known in self._known:
            for ratio, base in ((number / value, known), (number * value, None)):
                factor = _simple(ratio)
                if factor is not None:
                    return field.scale(factor, base or field.inverse(known))
        return field.number(number)

    def _root(self, square: Fraction) -> Element:
        exact = square_root_of(square)
        if exact is not None:
            return self.field.number(exact)
        root = self.field.root(self.field.number(square).num)
        (index,) = self.field.generators(root.num)
        if index not in self.values:
            radicand = rational(self.field.radicands[index].leading_coefficient())
            self.values[index] = fold("sqrt", (), (radicand,))
        return root

    def rotor(self, number: Fraction, m: int) -> Rotor:
        """Return the rotor of a constant angle."""
        field = self.field
        if number == 0:
            return field.number(Fraction(1)), field.number(Fraction(0))
        quarters = number / (PI / 2)
        if m == 1 and abs(quarters - round(quarters)) < _NEAR:
            x, y = ((1, 0), (0, 1), (-1, 0), (0, -1))[round(quarters) % 4]
            return field.number(Fraction(x)), field.number(Fraction(y))
        if number < 0:
            cosine, sine = self.rotor(-number, m)
            return cosine, field.scale(Fraction(-1), sine)
        key = (number, m)
        if key not in self._rotors:
            names = ("cos", "sin") if m == 1 else ("cosh", "sinh")
            values = [fold(name, (), (number,)) for name in names]
            if m == 1 and _simple(values[0] ** 2) is not None:
                rotor = self.number(values[0]), self.number(values[1])
            else:
                c, s, *elements = field.pair(m)
                rotor = elements[0], elements[1]
                for index, value, element in zip((c, s), values, rotor, strict=True):
                    self.values[index] = value
                    self._known.append((value, element))
            self._rotors[key] = rotor
        return self._rotors[key]
