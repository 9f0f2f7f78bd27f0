"""Words of a plan in Verilog: the formats that it states, and the ports of its core."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.backends.rtl.names import identifiers
from cordicc.expressions.quantities import base_unit, unit_meant
from cordicc.plan.model import Operand, Plan
from cordicc.plan.origin import PlanInput


@dataclass(frozen=True, slots=True)
class PortWord:
    """A port of the core.

    Attributes:
        name: in the plan.
        port: in Verilog.
        format: of its words.
        least: the least word that stands for a number.
        most: the largest.
        lo: the least number of an input's range; None of an output, and of an input whose every word will do.
        hi: the largest.
        unit: of its numbers, may be empty.
    """

    name: str
    port: str
    format: FixedPoint
    least: int
    most: int
    lo: float | None
    hi: float | None
    unit: str

    @property
    def width(self) -> int:
        """Bits of its words."""
        return self.format.width_bits

    @property
    def invalid(self) -> int:
        """The word that stands for no number, as an unsigned integer of its bits."""
        return 1 << (self.width - 1)

    @property
    def meaning(self) -> str:
        """What a word stands for, and the range of the number."""
        fraction = self.format.fraction_bits
        number = f"word / 2^{fraction}" if fraction > 0 else f"word * 2^{-fraction}" if fraction else "word"
        if self.lo is not None:
            number += f", {self.lo!r} to {self.hi!r}"
        return f"{number} {self.unit}".rstrip()

    @property
    def field_bytes(self) -> int:
        """Bytes of the field that it has in a stream."""
        return -(-self.width // 8)


@dataclass(frozen=True, slots=True)
class Ports:
    """The ports of a core that carry words, in the order of the plan."""

    inputs: tuple[PortWord, ...]
    outputs: tuple[PortWord, ...]

    @classmethod
    def of(cls, plan: Plan) -> Ports:
        """Return those of a plan."""
        words = WordFormats(plan)
        angles = plan.problem.angles
        names = identifiers([*plan.problem.input_names, *plan.outputs])
        return cls(
            tuple(_entering(item, names[item.name], words.held(item.name)) for item in plan.problem.inputs),
            tuple(
                _leaving(name, names[name], words.delivered(name), angles.get(name, False))
                for name in plan.outputs
            ),
        )


def _entering(item: PlanInput, port: str, format_: FixedPoint) -> PortWord:
    """Return the port of an input.  One that nothing uses may have a range that its words do not hold."""
    lo, hi = (int(word) for word in format_.encode(np.array([item.lo, item.hi])))
    if min(lo, hi) < -format_.largest_word:
        return _leaving(item.name, port, format_, False)
    unit = item.unit or ""
    if item.scale is not None and (meant := unit_meant(unit)) is not None:
        unit = base_unit(meant)
    return PortWord(item.name, port, format_, lo, hi, item.lo, item.hi, unit)


def _leaving(name: str, port: str, format_: FixedPoint, is_angle: bool) -> PortWord:
    largest = format_.largest_word
    return PortWord(name, port, format_, -largest, largest, None, None, "rad" if is_angle else "")


@dataclass(frozen=True, slots=True)
class WordFormats:
    """The formats of a plan's words."""

    plan: Plan

    def held(self, name: str) -> FixedPoint:
        """Return that of an input or a result."""
        return self._stated(self.plan.formats.values.get(name))

    def delivered(self, name: str) -> FixedPoint:
        """Return that of an output."""
        return self._stated(self.plan.formats.outputs.get(name))

    def of_operand(self, operand: Operand) -> FixedPoint:
        """Return that of what a port of a unit takes."""
        if operand.value is not None:
            return self.held(operand.value)
        assert operand.constant is not None
        format_ = self.plan.arithmetic.system.constant(operand.constant).format
        assert isinstance(format_, FixedPoint)
        return format_

    def _stated(self, point: BinaryPoint | None) -> FixedPoint:
        format_ = self.plan.arithmetic.system.format(point)
        assert isinstance(format_, FixedPoint)
        return format_
