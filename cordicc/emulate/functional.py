"""Functional emulation: what the hardware computes, bit for bit, without its clock.

Also home of what both emulators share: the arithmetic they run on, and the way samples go in and out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from graphlib import TopologicalSorter
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cordicc.plan import Operand, Operation, Plan

Word = NDArray[Any]
"""An array of words of the target's number format, one per sample."""

Floats = NDArray[np.float64]
Outputs = dict[str, NDArray[Any]]

_BLOCK_SAMPLES = 8192
"""Enough to hide the cost of a NumPy call, few enough for the words to stay in the cache."""


class NumberFormat(Protocol):
    """How numbers become words."""

    def encode(self, values: Floats, /) -> Word:
        """Return the nearest words."""

    def decode(self, words: Word, /) -> Floats:
        """Return the numbers, nan for an invalid word."""

    def parse_constant(self, text: str, /) -> Any:
        """Return the scalar word of a constant in a plan."""


class Arithmetic(Protocol):
    """The bit-true arithmetic of a target.  Every word depends on the words of its own sample alone."""

    @property
    def format(self) -> NumberFormat:
        """Return the number format."""

    def execute(
        self, op: str, params: Mapping[str, Any], kind: str, operands: Sequence[Word], /
    ) -> tuple[Word, ...]:
        """Return the results of an operation on arrays of equal length."""


def run(plan: Plan, arithmetic: Arithmetic, inputs: Mapping[str, ArrayLike]) -> Outputs:
    """Return the outputs for arrays of input samples, and `valid`.

    `inputs` holds a one-dimensional array of doubles per input.  A sample is invalid if an input is
    not finite or outside its range, or an output is invalid; all its outputs are nan.  Raises
    ValueError for missing inputs and unequal lengths.
    """
    samples, in_range = prepare(plan, inputs)
    order = dependence_order(plan)
    outputs = {name: np.empty(in_range.size) for name in plan.outputs}
    for begin in range(0, in_range.size, _BLOCK_SAMPLES):
        block = slice(begin, begin + _BLOCK_SAMPLES)
        encoded = {name: arithmetic.format.encode(array[block]) for name, array in samples.items()}
        results = _evaluate(plan, order, arithmetic, encoded, in_range[block].size)
        for name, word in results.items():
            outputs[name][block] = arithmetic.format.decode(word)
    return deliver(outputs, in_range)


def _evaluate(
    plan: Plan, order: Sequence[Operation], arithmetic: Arithmetic, values: dict[str, Word], length: int
) -> dict[str, Word]:
    """Return the words of the outputs."""
    values = dict(values)

    def fetch(operand: Operand) -> Word:
        if operand.value is not None:
            return values[operand.value]
        return constant_word(arithmetic, operand, length)

    for operation in order:
        operands = [fetch(operand) for operand in operation.operands]
        results = arithmetic.execute(operation.op, operation.params, operation.kind, operands)
        for name, word in zip(operation.results, results, strict=True):
            if name is not None:
                values[name] = word
    return {name: fetch(operand) for name, operand in plan.outputs.items()}


def prepare(plan: Plan, inputs: Mapping[str, ArrayLike]) -> tuple[dict[str, Floats], NDArray[np.bool_]]:
    """Return the samples to encode and which of them are in range.

    `plan.problem["inputs"]` lists the inputs, `name`, `lo` and `hi`.
    Where a number is out of range its lower end takes its place: the sample is invalid anyway, and
    the arithmetic never sees what it need not hold.
    """
    ranges: dict[str, Mapping[str, float]] = {item["name"]: item for item in plan.problem["inputs"]}
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
        lo, hi = (ranges[name][end] for end in ("lo", "hi"))
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


def constant_word(arithmetic: Arithmetic, operand: Operand, length: int) -> Word:
    """Return a constant operand, once for each of `length` samples."""
    assert operand.constant is not None
    word = np.asarray(arithmetic.format.parse_constant(operand.constant))
    return np.full(length, word, dtype=word.dtype)


def dependence_order(plan: Plan) -> tuple[Operation, ...]:
    """Return the operations, each after those whose results it takes."""
    operations = {operation.id: operation for operation in plan.operations}
    maker = {name: operation.id for operation in plan.operations for name in operation.results if name}
    sorter: TopologicalSorter[str] = TopologicalSorter()
    for operation in plan.operations:
        taken = (operand.value for operand in operation.operands)
        sorter.add(operation.id, *(maker[name] for name in taken if name in maker))
    return tuple(operations[id] for id in sorter.static_order())
