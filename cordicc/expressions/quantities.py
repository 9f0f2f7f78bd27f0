"""Units that a number may have: lengths become metres, angles radians."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from cordicc.expressions.hints import UNITS
from cordicc.expressions.lexer import ExpressionError, Kind, Token
from cordicc.ir.meaning.exact import DEG, PI

LENGTHS = {
    "m": Fraction(1),
    "mm": Fraction(1, 1000),
    "cm": Fraction(1, 100),
    "um": Fraction(1, 1_000_000),
    "in": Fraction(254, 10_000),
}
ANGLES = {"rad": Fraction(1), "deg": DEG, "turn": 2 * PI}
FACTORS = LENGTHS | ANGLES
"""By unit, what one of it is in metres or radians."""

_LABELS = {
    "degs": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "turns": "turn", "radian": "rad",
    "radians": "rad", "inch": "in", "inches": "in", '"': "in", "µm": "um", "μm": "um", "metre": "m",
    "metres": "m", "meter": "m", "meters": "m", "millimetre": "mm", "millimetres": "mm", "millimeter": "mm",
    "millimeters": "mm", "centimetre": "cm", "centimetres": "cm", "centimeter": "cm", "centimeters": "cm",
}  # fmt: skip
"""What people call the units that numbers may have."""

_HINT = "lengths take m, mm, cm, um or in, angles rad, deg or turn"
_AFTER = (",", ")", "]", "=", "<", ">", "<=", ">=")


def base_unit(unit: str) -> str:
    """Return what numbers with a unit are converted to: `m` or `rad`."""
    return "m" if unit in LENGTHS else "rad"


def unit_meant(label: str) -> str | None:
    """Return the unit that a label means, None if it is none that numbers may have."""
    text = label.strip()
    for each in (text, text.lower()):
        unit = _LABELS.get(each, each)
        if unit in FACTORS:
            return unit
    return None


class Quantity(NamedTuple):
    """A number with a unit: its value in metres or radians, and its place, end exclusive."""

    value: Fraction
    unit: str
    start: int
    end: int


def quantity_at(tokens: Sequence[Token], at: int) -> Quantity | None:
    """Return the number with a unit that begins at a token, if nothing else of its side or argument follows.

    Raises ExpressionError for a unit that is not converted.
    """
    following = [*tokens[at : at + 3]]
    if len(following) < 3:
        return None
    number, unit, after = following
    if number.kind is not Kind.NUMBER or unit.kind is not Kind.NAME:
        return None
    if after.kind is not Kind.END and after.text not in _AFTER:
        return None
    if unit.text in FACTORS:
        return Quantity(number.number * FACTORS[unit.text], unit.text, number.start, unit.end)
    if unit.text in UNITS:
        raise ExpressionError("E223", f"unknown unit '{unit.text}'", unit.start, unit.end, _HINT)
    return None
