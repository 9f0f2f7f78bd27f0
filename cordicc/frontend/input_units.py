"""The units of inputs: labels that are those of the numbers or not, and ranges that look like degrees."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from cordicc.base.diagnostics import Report, Span
from cordicc.expressions.lexer import NUMBER
from cordicc.expressions.quantities import FACTORS, base_unit, unit_meant
from cordicc.frontend.document.yamltree import NodeKind, YamlNode
from cordicc.ir.graph import Graph, Value
from cordicc.ir.problem import InputSpec

_PLAIN = re.compile(r"[-+]?[0-9.]+")
_QUANTITY = re.compile(rf"\s*([-+]?\s*{NUMBER})\s*({'|'.join(FACTORS)})\s*")
_ANY_QUANTITY = re.compile(rf"(?<![\w.]){NUMBER}\s*({'|'.join(FACTORS)})(?!\w)")
_WITH_QUANTITIES = ("constants", "inputs", "equations", "outputs", "assume")

_TURNED = ("sin", "cos", "tan")
_SUMS = ("add", "sub", "neg")

_MOST = 4 * math.pi
"""Radians: few angles in equations go through more than two turns either way, most in degrees do."""


@dataclass(frozen=True, slots=True)
class _End:
    """An end of a range: its text, its value, and its number and unit as written if it is a quantity."""

    text: str
    value: Fraction
    number: float = 0.0
    unit: str = ""

    @classmethod
    def of(cls, node: YamlNode, value: Fraction) -> _End:
        text = " ".join(node.value.split())
        match = _QUANTITY.fullmatch(text)
        if match is None:
            return cls(text, value)
        return cls(text, value, float(match[1].replace(" ", "")), match[2])


@dataclass(slots=True)
class InputUnits:
    """Reads the labels of ranges, and warns of those that are not the unit of the numbers."""

    report: Report
    _unlabelled: set[str] = field(default_factory=set)
    """Inputs whose ranges are numbers without a hint at their unit."""
    _labelled: list[tuple[str, str, Span, tuple[_End, ...]]] = field(default_factory=list)
    """Name, unit, place of the label and ends of ranges in bare numbers that have the label of a unit."""

    def scale(
        self, name: str, label: YamlNode | None, ends: Sequence[YamlNode], values: Sequence[Fraction]
    ) -> Fraction | None:
        """Return what one of the unit is in metres or radians, if the label is that of the numbers.

        None: the label is nothing but a label; what is odd about it is reported.
        """
        written = tuple(_End.of(node, value) for node, value in zip(ends, values, strict=True))
        if label is None and all(_PLAIN.fullmatch(end.text) for end in written):
            self._unlabelled.add(name)
        units = [end.unit for end in written if end.unit]
        bare = [end for end in written if not end.unit and end.value]
        if units and bare and _taken_for(written, bare[0]):
            end = bare[0]
            base = base_unit(units[0])
            message = f"{end.text} in the range of '{name}' is in {base}, beside a number in {units[0]}"
            hint = f"write {end.text} {units[0]}, or {end.text} {base}"
            self.report.warning("W109", message, ends[written.index(end)].span, hint)
            return None
        unit = None if label is None else unit_meant(label.value)
        if label is None or unit is None:
            return None
        base, bases = base_unit(unit), {base_unit(each) for each in units}
        if units and not bare and bases == {base}:
            return FACTORS[unit]
        if bases - {base}:
            message = f"the range of '{name}' has other units than its label"
            self.report.warning("W106", message, label.span, f"write 'unit: {min(units)}'")
        elif base == "rad" != unit:
            self._warn_of_angle(name, unit, label.span, written)
        elif base != unit:
            self._labelled.append((name, unit, label.span, written))
        return None

    def _warn_of_angle(self, name: str, unit: str, place: Span, written: tuple[_End, ...]) -> None:
        if any("deg" in end.text or "pi" in end.text for end in written):
            hint = "the range is in radians: write 'unit: rad'"
        else:
            name_of = {"deg": "deg", "turn": "2*pi"}[unit]
            low, high = (_times(end.text, name_of) for end in written)
            hint = f"write the range as [{low}, {high}]"
        message = f"units are labels only: '{name}' is in radians, as are all angles"
        self.report.warning("W106", message, place, hint)

    def finish(
        self, root: YamlNode, program: Graph, inputs: Sequence[InputSpec], places: Mapping[str, Span]
    ) -> None:
        """Warn of what the whole file shows: bare numbers beside converted ones, and degrees."""
        for spec in in_degrees(program, [each for each in inputs if each.name in self._unlabelled]):
            low, high = shown(spec.lo), shown(spec.hi)
            message = f"the range of '{spec.name}' goes to {high if spec.hi > -spec.lo else low} radians"
            hint = f"if these are degrees, write [{low}*deg, {high}*deg]"
            self.report.warning("W106", message, places[spec.name], hint)
        if not self._labelled:
            return
        beside = {base_unit(unit): text for unit, text in _quantities(root)}
        for name, unit, place, written in self._labelled:
            base = base_unit(unit)
            if base not in beside:
                continue
            message = f"the range of '{name}' is in {base}, not in {unit}, beside '{beside[base]}'"
            hint = "a number with a unit is converted, one without is not: write "
            if all(_PLAIN.fullmatch(end.text) for end in written):
                hint += f"[{', '.join(f'{end.text} {unit}' for end in written)}]"
            else:
                hint += f"numbers with their unit, or 'unit: {base}'"
            self.report.warning("W109", message, place, hint)


def _taken_for(written: Sequence[_End], bare: _End) -> bool:
    """Tell whether a bare end is nearer to the other one as written than to what that is converted to.

    `[100 mm, 400]` is meant in millimetres throughout, `[100 mm, 0.4]` is not.
    """
    other = next(end for end in written if end.unit)
    if not other.value or FACTORS[other.unit] == 1:
        return False
    size = math.log(abs(bare.value))
    return abs(size - math.log(abs(other.number))) < abs(size - math.log(abs(other.value)))


def _times(text: str, factor: str) -> str:
    return f"{text}*{factor}" if _PLAIN.fullmatch(text) else f"({text})*{factor}"


def _quantities(root: YamlNode) -> Iterator[tuple[str, str]]:
    """Yield the numbers with a unit of a file, the last first: the unit and the text, with its key."""
    found: list[tuple[str, str]] = []
    todo = [("", value) for key, value in reversed(root.pairs) if key.value in _WITH_QUANTITIES]
    while todo:
        key, node = todo.pop()
        if node.kind is NodeKind.SCALAR:
            for match in _ANY_QUANTITY.finditer(node.value):
                found.append((match[1], f"{key}: {match[0]}" if key else match[0]))
        todo += [(name.value, value) for name, value in reversed(node.pairs)]
        todo += [(key, item) for item in reversed(node.items)]
    return reversed(found)


def shown(number: Fraction) -> str:
    """Return a number as diagnostics show it."""
    return f"{float(number):.12g}"


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
