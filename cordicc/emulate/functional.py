"""Functional emulation: what the hardware computes, bit for bit, without its clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from cordicc.arith.formats import FloatArray, Signal
from cordicc.arith.machine import Arithmetic
from cordicc.emulate.stream import Formats, Outputs, constant_signal, deliver, dependence_order, prepare
from cordicc.plan import Operand, Operation, Plan

_BLOCK_SAMPLES = 8192
"""Enough to hide the cost of a NumPy call, few enough for the words to stay in the cache."""


def run(plan: Plan, arithmetic: Arithmetic, inputs: Mapping[str, ArrayLike]) -> Outputs:
    """Return the outputs for arrays of input samples, and `valid`.

    `inputs` holds a one-dimensional array of doubles per input.  A sample is invalid if an input is
    not finite or outside its range, or an output is invalid; all its outputs are nan.  Raises
    ValueError for missing inputs and unequal lengths.
    """
    samples, in_range = prepare(plan, inputs)
    order = dependence_order(plan)
    formats = Formats.of(plan, arithmetic)
    outputs = {name: np.empty(in_range.size) for name in plan.outputs}
    for begin in range(0, in_range.size, _BLOCK_SAMPLES):
        block = slice(begin, begin + _BLOCK_SAMPLES)
        part = {name: array[block] for name, array in samples.items()}
        for name, numbers in _evaluate(plan, order, arithmetic, formats, part, in_range[block].size).items():
            outputs[name][block] = numbers
    return deliver(outputs, in_range)


def _evaluate(
    plan: Plan,
    order: Sequence[Operation],
    arithmetic: Arithmetic,
    formats: Formats,
    samples: Mapping[str, FloatArray],
    length: int,
) -> dict[str, FloatArray]:
    """Return the numbers of the outputs."""
    values = formats.encode(samples)

    def fetch(operand: Operand) -> Signal:
        if operand.value is not None:
            return values[operand.value]
        return constant_signal(arithmetic, operand, length)

    for operation in order:
        operands = [fetch(operand) for operand in operation.operands]
        results = arithmetic.execute(
            operation.op, operation.params, operation.kind, operands, formats.of_results(operation)
        )
        for name, signal in zip(operation.results, results, strict=True):
            if name is not None and signal is not None:
                values[name] = signal
    return {name: formats.leaving(name, fetch(operand)) for name, operand in plan.outputs.items()}
