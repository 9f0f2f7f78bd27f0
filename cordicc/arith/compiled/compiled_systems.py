"""Number systems whose sums, products and conversions are compiled by numba, with the bits of the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cordicc.arith.numbers.fixed_point import ROUNDINGS, SHIFT_LIMIT, FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import BinaryPoint, NumberFormat, NumberSystem, Signal
from cordicc.base.arrays import Floats, Words

_COMPILED = ("add", "sub", "mul", "cmul")


def compiled_system(system: NumberSystem) -> NumberSystem:
    """Return the same number system, compiled where there is a form of it for that; needs numba."""
    if isinstance(system, SingleSystem):
        return CompiledSingle()
    if isinstance(system, FixedSystem):
        return CompiledFixed(system.width_bits, system.guard_bits, system.rounding)
    return system


@dataclass(frozen=True, slots=True)
class CompiledSingle(SingleSystem):
    """The number system of single precision."""

    def calculate(
        self, op: str, params: Mapping[str, Any], operands: Sequence[Signal], result: NumberFormat
    ) -> Words:
        """Execute an operation, as `SingleSystem.calculate` does."""
        from cordicc.arith.compiled import word_loops

        words = [np.asarray(operand.words) for operand in operands]
        if op not in _COMPILED or len({word.shape for word in words}) > 1:
            return SingleSystem.calculate(self, op, params, operands, result)
        if op == "cmul":
            words.append(self.constant(params["factor"]).words.reshape(1))
        made = np.empty(words[0].shape, dtype=np.float32)
        getattr(word_loops, op)(*words, made)
        return made


@dataclass(frozen=True, slots=True)
class CompiledFixedPoint(FixedPoint):
    """A fixed-point format."""

    def encode(self, values: Floats) -> Words:
        """Round values to words, as `FixedPoint.encode` does."""
        from cordicc.arith.compiled.word_loops import encode_fixed

        numbers = np.ascontiguousarray(values, dtype=np.float64)
        words = np.empty(numbers.shape, dtype=np.int64)
        encode_fixed(
            numbers.reshape(-1), 2.0**self.fraction_bits, self.rounded_from(self.fraction_bits), words
        )
        return words

    def decode(self, words: Words) -> Floats:
        """Return the values of words, as `FixedPoint.decode` does."""
        from cordicc.arith.compiled.word_loops import decode_fixed

        taken = np.ascontiguousarray(words, dtype=np.int64)
        numbers = np.empty(taken.shape)
        decode_fixed(taken.reshape(-1), self.ulp, self.invalid_word, numbers.reshape(-1))
        return numbers

    def rounded_from(self, fraction: int) -> tuple[int, int, int, int]:
        """Return the `word_loops.Rounding` of numbers of so many fraction bits."""
        down = fraction - self.fraction_bits
        return down, ROUNDINGS.index(self.rounding), self.largest_word, self.invalid_word


@dataclass(frozen=True, slots=True)
class CompiledFixed(FixedSystem):
    """A number system of fixed point."""

    def format(self, spec: BinaryPoint | None) -> FixedPoint:
        """Return the format that a plan states.  Raises ValueError."""
        return _compiled(FixedSystem.format(self, spec))

    def constant(self, text: str) -> Signal:
        """Read a decimal text, as `FixedSystem.constant` does."""
        words, format_ = FixedSystem.constant(self, text)
        assert isinstance(format_, FixedPoint)
        return Signal(words, _compiled(format_))

    def calculate(
        self, op: str, params: Mapping[str, Any], operands: Sequence[Signal], result: NumberFormat
    ) -> Words:
        """Execute an operation, as `FixedSystem.calculate` does."""
        taken = list(operands)
        if op == "cmul":
            factor = self.constant(params["factor"])
            taken.append(Signal(factor.words.reshape(1), factor.format))
        made = self._compiled(op, taken, result)
        return FixedSystem.calculate(self, op, params, operands, result) if made is None else made

    def _compiled(self, op: str, operands: Sequence[Signal], result: NumberFormat) -> Words | None:
        """Return the result of a sum or product of whole arrays that fits 64 bits, None for any other."""
        from cordicc.arith.compiled import word_loops

        assert isinstance(result, CompiledFixedPoint)
        words = [np.asarray(operand.words) for operand in operands]
        if op not in _COMPILED or words[0].ndim != 1 or (op != "cmul" and words[0].shape != words[1].shape):
            return None
        first, second = (each.format for each in operands)
        assert isinstance(first, FixedPoint)
        assert isinstance(second, FixedPoint)
        invalid = (first.invalid_word, second.invalid_word)
        sums = op in ("add", "sub")
        fractions = (first.fraction_bits, second.fraction_bits)
        fraction = max(fractions) if sums else sum(fractions)
        rounding = result.rounded_from(fraction)
        if rounding[0] >= SHIFT_LIMIT or (sums and not _fits(first, second)):
            return None
        made = np.empty(words[0].shape, dtype=np.int64)
        if sums:
            lifts = (fraction - fractions[0], fraction - fractions[1])
            function = word_loops.add_fixed if op == "add" else word_loops.sub_fixed
            function(words[0], words[1], lifts, invalid, rounding, made)
        else:
            word_loops.mul_fixed(words[0], words[1], invalid, rounding, made)
        return made


def _compiled(format_: FixedPoint) -> CompiledFixedPoint:
    return CompiledFixedPoint(format_.width_bits, format_.fraction_bits, format_.rounding)


def _fits(a: FixedPoint, b: FixedPoint) -> bool:
    """Tell whether words lifted to one scale, and their sum, stay below 2^62."""
    spread = abs(a.fraction_bits - b.fraction_bits)
    return spread + max(a.width_bits, b.width_bits) < SHIFT_LIMIT
