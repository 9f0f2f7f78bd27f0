"""Functional emulation: what the hardware computes, bit for bit, without its clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from cordicc.arith.formats import Word
from cordicc.arith.machine import Arithmetic
from cordicc.emulate.stream import Outputs, constant_word, deliver, dependence_order, prepare
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
