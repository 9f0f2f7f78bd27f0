"""Functional emulation: what the hardware computes, bit for bit, without its clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cordicc.arith.compiled.compiled_cau import available, compiled_arithmetic, is_compiled
from cordicc.arith.numbers.formats import Signal
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.base.arrays import Floats
from cordicc.emulate.ports import Outputs, PortFormats, constant_signal, deliver, prepare
from cordicc.plan.model import Operand, Operation, Plan, dependence_order
from cordicc.targets.target import CAU_KINDS

_BLOCK_SAMPLES = 16384
"""Enough to hide the cost of a NumPy call, few enough for the words to stay in the cache."""

COMPILED_FROM = 20_000_000
"""Unit operations of a run from which loading compiled units pays."""

_PROBES = 256
"""Samples on which compiled units are compared with the others before they are used."""


def run(plan: Plan, arithmetic: Arithmetic, inputs: Mapping[str, ArrayLike]) -> Outputs:
    """Return the outputs for arrays of input samples, and `valid`.

    `inputs` holds a one-dimensional array of doubles per input.  A sample is invalid if an input is
    not finite or outside its range, or an output is invalid; all its outputs are nan.  Raises
    ValueError for missing inputs and unequal lengths.
    """
    samples, in_range = prepare(plan, inputs)
    return _run(plan, accelerated(plan, arithmetic, samples, in_range.size), samples, in_range)


def _run(
    plan: Plan, arithmetic: Arithmetic, samples: Mapping[str, Floats], in_range: NDArray[np.bool_]
) -> Outputs:
    order = dependence_order(plan)
    formats = PortFormats.of(plan, arithmetic)
    constants = _constants(plan, arithmetic)
    outputs = {name: np.empty(in_range.size) for name in plan.outputs}
    for begin in range(0, in_range.size, _BLOCK_SAMPLES):
        block = slice(begin, begin + _BLOCK_SAMPLES)
        part = {name: array[block] for name, array in samples.items()}
        length = in_range[block].size
        values = _values(order, arithmetic, formats, constants, part, length)
        for name, operand in plan.outputs.items():
            outputs[name][block] = formats.leaving(name, _fetched(operand, values, constants, length))
    return deliver(outputs, in_range)


def accelerated(plan: Plan, arithmetic: Arithmetic, samples: Mapping[str, Floats], total: int) -> Arithmetic:
    """Return the arithmetic with compiled units if that pays for `total` samples and numba is installed.

    The bits are the same, and the first of `samples` are run by both to see it.
    """
    caus = sum(operation.kind in CAU_KINDS for operation in plan.operations)
    if total * caus < COMPILED_FROM or not available() or is_compiled(arithmetic):
        return arithmetic
    machine = compiled_arithmetic(arithmetic)
    probes = prepare(plan, {name: column[:_PROBES] for name, column in samples.items()})
    expected, seen = _run(plan, arithmetic, *probes), _run(plan, machine, *probes)
    for name, column in expected.items():
        assert np.array_equal(column, seen[name], equal_nan=True), (
            f"compiled units give other bits for '{name}'; delete the __pycache__ of cordicc.arith"
        )
    return machine


def _constants(plan: Plan, arithmetic: Arithmetic) -> dict[str, Signal]:
    """Return the constant operands by their text, for a whole block."""
    operands = [operand for operation in plan.operations for operand in operation.operands]
    return {
        operand.constant: constant_signal(arithmetic, operand, _BLOCK_SAMPLES)
        for operand in (*operands, *plan.outputs.values())
        if operand.constant is not None
    }


def words(plan: Plan, arithmetic: Arithmetic, inputs: Mapping[str, ArrayLike]) -> dict[str, Signal]:
    """Return the words of every input and result, for arrays of equal length; nan is the invalid word."""
    samples = {name: np.asarray(inputs[name], dtype=np.float64) for name in plan.problem.input_names}
    length = max((array.size for array in samples.values()), default=1)
    formats, constants = PortFormats.of(plan, arithmetic), _constants(plan, arithmetic)
    return _values(dependence_order(plan), arithmetic, formats, constants, samples, length)


def _values(
    order: Sequence[Operation],
    arithmetic: Arithmetic,
    formats: PortFormats,
    constants: Mapping[str, Signal],
    samples: Mapping[str, Floats],
    length: int,
) -> dict[str, Signal]:
    """Return the words of inputs and results."""
    values = formats.encode(samples)
    for operation in order:
        operands = [_fetched(operand, values, constants, length) for operand in operation.operands]
        results = arithmetic.execute(
            operation.op,
            operation.settings,
            operation.kind,
            operands,
            formats.of_results(operation),
            operation.angle,
        )
        for name, signal in zip(operation.results, results, strict=True):
            if name is not None and signal is not None:
                values[name] = signal
    return values


def _fetched(
    operand: Operand, values: Mapping[str, Signal], constants: Mapping[str, Signal], length: int
) -> Signal:
    if operand.value is not None:
        return values[operand.value]
    assert operand.constant is not None
    taken, format_ = constants[operand.constant]
    return Signal(taken[:length], format_)
