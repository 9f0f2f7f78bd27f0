"""What both emulators share: the way samples go in and out, constants and the formats of words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cordicc.arith.numbers.formats import NumberFormat, Signal
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.base.arrays import Floats
from cordicc.plan.model import Operand, Operation, Plan

Outputs = dict[str, NDArray[Any]]
"""By output, float64 of shape (n,), and `valid`, which tells of each sample whether it has outputs."""


def prepare(plan: Plan, inputs: Mapping[str, ArrayLike]) -> tuple[dict[str, Floats], NDArray[np.bool_]]:
    """Return the samples to encode and which of them are in range.

    Where a number is out of range its lower end takes its place: the sample is invalid anyway, and
    the arithmetic never sees what it need not hold.
    """
    ranges = {item.name: (item.lo, item.hi) for item in plan.problem.inputs}
    missing = [name for name in ranges if name not in inputs]
    if missing:
        raise ValueError(f"missing inputs: {', '.join(missing)}")
    arrays = {name: np.asarray(inputs[name], dtype=np.float64) for name in ranges}
    shapes = {array.shape for array in arrays.values()} or {(1,)}
    shape = shapes.pop()
    if shapes or len(shape) != 1:
        raise ValueError("inputs must be one-dimensional arrays of equal length")
    in_range = np.ones(shape, dtype=np.bool_)
    samples: dict[str, Floats] = {}
    for name, array in arrays.items():
        lo, hi = ranges[name]
        inside = (lo <= array) & (array <= hi)
        samples[name] = np.where(inside, array, lo)
        in_range &= inside
    return samples, in_range


def deliver(outputs: Mapping[str, Floats], in_range: NDArray[np.bool_]) -> Outputs:
    """Return the outputs, nan where the sample is invalid, and `valid`."""
    valid = in_range.copy()
    for array in outputs.values():
        valid &= ~np.isnan(array)
    return {**{name: np.where(valid, array, np.nan) for name, array in outputs.items()}, "valid": valid}


def constant_signal(arithmetic: Arithmetic, operand: Operand, length: int) -> Signal:
    """Return a constant operand, once for each of `length` samples."""
    assert operand.constant is not None
    word, format_ = arithmetic.system.constant(operand.constant)
    return Signal(np.full(length, word, dtype=word.dtype), format_)


@dataclass(frozen=True, slots=True)
class PortFormats:
    """The number formats of a plan: of inputs and results by name, and of the outputs."""

    values: Mapping[str, NumberFormat]
    outputs: Mapping[str, NumberFormat]

    @classmethod
    def of(cls, plan: Plan, arithmetic: Arithmetic) -> PortFormats:
        """Return the formats that a plan states or its target implies.  Raises ValueError."""
        inputs = plan.problem.input_names
        results = [name for operation in plan.operations for name in operation.results if name is not None]
        find = arithmetic.system.format
        return cls(
            {name: find(plan.formats.values.get(name)) for name in (*inputs, *results)},
            {name: find(plan.formats.outputs.get(name)) for name in plan.outputs},
        )

    def of_results(self, operation: Operation) -> list[NumberFormat | None]:
        """Return the format of each result of an operation, None where nobody takes it."""
        return [None if name is None else self.values[name] for name in operation.results]

    def encode(self, samples: Mapping[str, Floats]) -> dict[str, Signal]:
        """Return the words of input samples."""
        return {name: Signal(self.values[name].encode(v), self.values[name]) for name, v in samples.items()}

    def leaving(self, output: str, signal: Signal) -> Floats:
        """Return the numbers of an output: its words rounded to the output's format, if that is another."""
        format_ = self.outputs[output]
        if format_ == signal.format:
            return signal.values
        return format_.decode(format_.encode(signal.values))


def as_words(plan: Plan, samples: Mapping[str, ArrayLike]) -> dict[str, Floats]:
    """Return the numbers that the words of samples stand for.

    Of an input that nothing uses, whose words need not hold its range, the number itself.
    """
    numbers, _ = prepare(plan, samples)
    words = PortFormats.of(plan, plan.arithmetic).encode(numbers)
    return {
        name: np.where(np.isnan(words[name].values), number, words[name].values)
        for name, number in numbers.items()
    }
