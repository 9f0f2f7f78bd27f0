"""Where a sample leaves the number format or the domain of a unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.emulate.ports import PortFormats, constant_signal, prepare
from cordicc.plan.model import Operation, Plan, dependence_order


def first_invalid(plan: Plan, arithmetic: Arithmetic, sample: Mapping[str, float]) -> Operation | None:
    """Return the first operation that makes an invalid word from valid ones; None if none does."""
    samples, _ = prepare(plan, {name: np.array([number]) for name, number in sample.items()})
    formats = PortFormats.of(plan, arithmetic)
    signals = formats.encode(samples)
    for operation in dependence_order(plan):
        operands = [
            constant_signal(arithmetic, operand, 1) if operand.value is None else signals[operand.value]
            for operand in operation.operands
        ]
        results = arithmetic.execute(
            operation.op, operation.params, operation.kind, operands, formats.of_results(operation)
        )
        for name, signal in zip(operation.results, results, strict=True):
            if name is not None and signal is not None:
                signals[name] = signal
                if np.isnan(signal.values).any():
                    return operation
    return None
