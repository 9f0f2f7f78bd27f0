"""On fixed-point plans every unit stays within its own proven bound, on the operands it really gets."""

import math

import numpy as np
import pytest

from cordicc.arith.kernels.blocks import ZERO_EXPONENT
from cordicc.arith.unit.arithmetic import least_exponent
from cordicc.arith.unit.implicit_bounds import implicit_bound
from cordicc.arith.unit.unit_bounds import lightcone_bound, rotation_bound, vectoring_bound
from cordicc.emulate.ports import PortFormats, constant_signal, prepare
from cordicc.ir.graph import Builder, Value
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.plan.model import dependence_order
from tests.support.corpus import EFFORT_CASES, LITTLE_CASES, inputs_of, problem_path
from tests.support.plans import planned
from tests.support.selection import quick

ROWS = 50
SLACK = 2.0**-50
"""Of the float64 arithmetic of this test, relative to the numbers at hand."""


def exact(operation, operands):
    """Both results of an operation on exact operands, to float64."""
    builder = Builder()
    inputs = [builder.input(f"i{k}") for k in range(len(operands))]
    made = builder.emit(operation.op, inputs, tuple(operation.params.values()))
    graph = builder.build({f"r{k}": Value(made.node, k) for k in range(len(operation.results))})
    columns = {f"i{k}": column for k, column in enumerate(operands)}
    results, _ = reference_outputs(graph, columns)
    return [results[f"r{k}"] for k in range(len(operation.results))]


def place(unit, *operands, least=ZERO_EXPONENT):
    """The value of the last place of the block of some operands, of no less than the least exponent."""
    largest = np.max(np.abs(np.stack(operands)), axis=0)
    exponent = np.maximum(np.frexp(largest)[1], least + unit.operand_bits)
    return np.ldexp(1.0, exponent - unit.fraction_bits)


def allowed(unit, operation, operands, results, quarters, least):
    """The proven bound of each result before its rounding; of an implicit angle, of the residual."""
    m = operation.params.get("m")
    x, y = operands[:2]
    if operation.op == "rotate":
        bound = rotation_bound(unit, m, quarters)
        if m == 1:
            return [bound.error(np.hypot(x, y), place(unit, x, y, least=least))] * 2
        if m == 0:
            product = np.abs(x * operands[2])
            return [np.zeros_like(x), bound.error(product, place(unit, x)) + SLACK * np.abs(y)]
        return [bound.error(np.maximum(*map(np.abs, results)), place(unit, x, y))] * 2
    if operation.op == "implicit":
        A, B, C = operands
        solved = implicit_bound(unit, m)
        norm = np.hypot(A, B) if m == 1 else np.maximum(np.abs(C), results[1])
        last = place(unit, A, B, C)
        return [solved.residual.error(norm, last), solved.rest(norm, C, results[1], last)]
    bound = lightcone_bound(unit) if operation.op == "lightcone" else vectoring_bound(unit, m)
    if m == 0:
        return [np.zeros_like(x), bound.angle * np.abs(y / x) + SLACK * np.abs(operands[2])]
    norm = bound.norm.error(results[0], place(unit, x, y))
    return [norm, np.full_like(x, bound.angle)]


def residual(m, operands, angle):
    A, B, C = (np.asarray(v, dtype=np.longdouble) for v in operands)
    t = np.asarray(angle, dtype=np.longdouble)
    sine, cosine = (np.sin(t), np.cos(t)) if m == 1 else (np.sinh(t), np.cosh(t))
    slope = np.hypot(A, B) if m == 1 else np.abs(A * cosine) + np.abs(B * sine)
    return np.abs(B * cosine + A * sine - C).astype(float), slope.astype(float)


def check(operation, unit, operands, words, formats, quarters, least):
    valid = np.logical_and.reduce([~np.isnan(column) for column in (*operands, *words)])
    operands = [column[valid] for column in operands]
    words = [column[valid] for column in words]
    results = exact(operation, operands)
    bounds = allowed(unit, operation, operands, results, quarters, least)
    for port, (got, want, bound, format_) in enumerate(zip(words, results, bounds, formats, strict=True)):
        if format_ is None or not got.size:
            continue
        rounding = np.full(got.shape, format_.ulp / 2)
        if operation.params.get("m") == 1 and operation.op != "rotate" and format_.fraction_bits <= 29:
            # Beside pi a word is rounded towards 0.
            rounding[np.abs(want) > math.pi - format_.ulp] = format_.ulp
        if operation.op == "implicit" and port == 0:
            off, slope = residual(operation.params["m"], operands, got)
            assert np.all(off <= (bound + slope * rounding) * (1 + 1e-6) + SLACK)
        else:
            assert np.all(np.abs(got - want) <= bound + rounding + SLACK * (1 + np.abs(want)))


@pytest.mark.parametrize(("name", "effort"), quick(EFFORT_CASES, *LITTLE_CASES))
def test_every_unit_is_within_its_bound(name: str, effort: float) -> None:
    plan = planned(problem_path(name), target="fixed24", effort=effort)
    arithmetic = plan.arithmetic
    formats = PortFormats.of(plan, arithmetic)
    inputs = inputs_of(name)
    samples, _ = prepare(plan, {name: column[:ROWS] for name, column in inputs.items()})
    signals = formats.encode(samples)
    for operation in dependence_order(plan):
        operands = [
            constant_signal(arithmetic, operand, ROWS) if operand.value is None else signals[operand.value]
            for operand in operation.operands
        ]
        wanted = formats.of_results(operation)
        results = arithmetic.execute(
            operation.op, operation.params, operation.kind, operands, wanted, operation.angle
        )
        for result, signal in zip(operation.results, results, strict=True):
            if result is not None:
                signals[result] = signal
        if operation.kind in arithmetic.caus:
            words = [np.zeros(ROWS) if s is None else s.values for s in results]
            turned = (operation.op, operation.m) == ("rotate", 1)
            quarters = arithmetic.quarters(operation.kind, operands[2].format) if turned else None
            values = [s.values for s in operands]
            unit = arithmetic.caus[operation.kind]
            ends = [operand.format for operand in operands[:2]]
            least = least_exponent(*ends, unit.operand_bits) if turned else ZERO_EXPONENT
            check(operation, unit, values, words, wanted, quarters, least)
