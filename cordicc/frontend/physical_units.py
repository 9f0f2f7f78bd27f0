"""Units: lengths of constants become metres, angles radians, and inputs whose ranges look like degrees."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction

from cordicc.base.diagnostics import Report
from cordicc.expressions.hints import UNITS
from cordicc.expressions.lexer import NUMBER
from cordicc.frontend.document.yamltree import NodeKind
from cordicc.frontend.scope import Text
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.exact import DEG, PI
from cordicc.ir.problem import InputSpec

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

_TURNED = ("sin", "cos", "tan")
_SUMS = ("add", "sub", "neg")

_MOST = 4 * math.pi
"""Radians: few angles in equations go through more than two turns either way, most in degrees do."""


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


def in_degrees(graph: Graph, inputs: Sequence[InputSpec]) -> list[InputSpec]:
    """Return the inputs of which only sines, cosines and tangents are used, beyond two turns."""
    turned = _turned(graph)
    return [i for i in inputs if i.name in turned and max(abs(i.lo), abs(i.hi)) > _MOST]


def _turned(graph: Graph) -> set[str]:
    """Return the inputs of which, or of sums with which, only sines, cosines and tangents are used."""
    other = set(graph.outputs.values())
    used: set[Value] = set()
    for index in reversed(range(len(graph.nodes))):
        node = graph.nodes[index]
        fine = node.op in _TURNED or (node.op in _SUMS and Value(index) not in other)
        used.update(node.operands)
        if not fine:
            other.update(node.operands)
    return {
        node.name
        for index, node in enumerate(graph.nodes)
        if node.op == "input" and Value(index) in used - other
    }
