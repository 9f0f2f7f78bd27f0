"""Constants with a unit: lengths become metres, angles radians."""

from __future__ import annotations

import re
from fractions import Fraction

from cordicc.base.diagnostics import Report
from cordicc.expressions.hints import UNITS
from cordicc.expressions.lexer import NUMBER
from cordicc.frontend.document.yamltree import NodeKind
from cordicc.frontend.scope import Text
from cordicc.ir.meaning.exact import DEG, PI

LENGTHS = {
    "m": Fraction(1),
    "mm": Fraction(1, 1000),
    "cm": Fraction(1, 100),
    "um": Fraction(1, 1_000_000),
    "in": Fraction(254, 10_000),
}
ANGLES = {"rad": Fraction(1), "deg": DEG, "turn": 2 * PI}

_QUANTITY = re.compile(rf"\s*([-+]?)\s*({NUMBER})\s*([A-Za-z]+)\s*")
_HINT = "lengths take m, mm, cm, um or in, angles rad, deg or turn"


def unit_factor(text: Text, report: Report) -> tuple[str, Fraction] | None:
    """Return the number, as text, and the factor of a constant such as `400 mm`; None for any other.

    A unit that is not known is reported; its factor is 1.
    """
    match = _QUANTITY.fullmatch(text.node.value) if text.node.kind is NodeKind.SCALAR else None
    if match is None:
        return None
    sign, number, unit = match.groups()
    factor = (LENGTHS | ANGLES).get(unit)
    if factor is None:
        if unit not in UNITS:
            return None
        report.error("E223", f"unknown unit '{unit}'", text.span(match.span(3)), _HINT)
    return sign + number, factor or Fraction(1)
