"""Where a sample leaves the number format or the domain of a unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cordicc.arith.machine import Arithmetic
from cordicc.emulate.stream import constant_word, dependence_order, prepare
from cordicc.plan import Operation, Plan


def first_invalid(plan: Plan, arithmetic: Arithmetic, sample: Mapping[str, float]) -> Operation | None:
    """Return the first operation that makes an invalid word from valid ones; None if none does."""
    samples, _ = prepare(plan, {name: np.array([number]) for name, number in sample.items()})
    words = {name: arithmetic.format.encode(column) for name, column in samples.items()}
    for operation in dependence_order(plan):
        operands = [
            constant_word(arithmetic, operand, 1) if operand.value is None else words[operand.value]
            for operand in operation.operands
        ]
        results = arithmetic.execute(operation.op, operation.params, operation.kind, operands)
        for name, word in zip(operation.results, results, strict=True):
            if name is not None:
                words[name] = word
                if np.isnan(arithmetic.format.decode(word)).any():
                    return operation
    return None
