"""Running a finished plan: the errors that are seen, whether samples are lost, and where."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.base.diagnostics import Diagnostic, Severity, Unattainable
from cordicc.emulate import accuracy
from cordicc.emulate import functional as functional_run
from cordicc.emulate.checking import CheckTally, beyond_limits, without_value
from cordicc.emulate.long_run import REFERENCE_SAMPLES, run_parts
from cordicc.emulate.ports import PortFormats, constant_signal, prepare
from cordicc.ir.effort import effort
from cordicc.ir.graph import Graph
from cordicc.ir.sampling import DEFAULT_SAMPLES, DEFAULT_SEED, draw
from cordicc.plan.model import Operation, Plan, dependence_order
from cordicc.plan.origin import PlanProblem, told
from cordicc.plan.stated_accuracy import OutputAccuracy, SeenErrors

REFERENCE_EFFORT = 3_000_000
"""Products that the comparison of a plan with its equations may take as long as: large problems are
compared in high precision on fewer samples."""

_LEAST_REFERENCE = 32


def observe(plan: Plan) -> tuple[Plan, list[Diagnostic]]:
    """Run a plan on the default samples and record the errors that were seen, and the checks.

    Samples that break what the problem assumes are left out.

    Raises:
        Unattainable: no sample that the equations can do survives in the target's number format, or a check
            is beyond its limit.
    """
    inputs = plan.problem.facts.only(draw(plan.problem.workspace, DEFAULT_SAMPLES, DEFAULT_SEED))
    warnings: list[Diagnostic] = []
    if not all(column.size for column in inputs.values()):
        warnings.append(_unobserved())
    outputs = functional_run.run(plan, plan.arithmetic, inputs)
    graph = plan.problem.program
    reference = reference_samples(graph)
    if reference < DEFAULT_SAMPLES:
        angles = plan.problem.angles
        report = run_parts(graph, angles, [inputs], lambda _: outputs, _ignored, _ignored, reference)
        comparison = report.comparison
        warnings.append(_few(reference, len(graph.nodes)))
    else:
        comparison = compare(plan, inputs, outputs)
    figures = {
        name: OutputAccuracy(SeenErrors(seen.max, seen.rms, seen.histogram))
        for name, seen in comparison.observed.items()
    }
    if comparison.lost_at is not None:
        lost = _lost(plan, inputs, comparison)
        if not comparison.valid:
            raise Unattainable([lost])
        warnings.append(lost)
    tally = CheckTally(plan.problem)
    tally.add(inputs, outputs)
    if refused := beyond_limits(tally, Severity.ERROR):
        raise Unattainable(refused)
    warnings += without_value(tally)
    checks = {name: record.figures for name, record in tally.found.items()}
    return with_warnings(replace(plan, accuracy=figures, checks=checks), warnings), warnings


def with_warnings(plan: Plan, warnings: Iterable[Diagnostic]) -> Plan:
    """Return a plan that records more warnings."""
    known = (*plan.problem.warnings, *map(told, warnings))
    return replace(plan, problem=replace(plan.problem, warnings=known))


def reference_samples(graph: Graph) -> int:
    """Return how many samples are compared with a graph of equations in high precision by default."""
    return min(REFERENCE_SAMPLES, max(_LEAST_REFERENCE, REFERENCE_EFFORT // max(1, effort(graph))))


def _ignored(_: object) -> None:
    pass


def _unobserved() -> Diagnostic:
    """Return the finding that no sample drawn from the ranges keeps what is assumed."""
    message = (
        f"no errors are observed: none of {DEFAULT_SAMPLES} samples from the ranges keeps what is assumed"
    )
    hint = "add rows of the true workspace with 'samples: FILE.csv'"
    return Diagnostic("W108", message, None, hint, Severity.WARNING)


def _few(samples: int, operations: int) -> Diagnostic:
    """Return the finding that a problem is too large for a comparison of all samples in high precision."""
    message = (
        f"the errors of {samples} samples alone are against high precision, the others against double "
        f"precision: the problem has {operations} operations"
    )
    hint = f"compare more with 'cordicc simulate PLAN --reference {DEFAULT_SAMPLES}'"
    return Diagnostic("W414", message, None, hint, Severity.WARNING)


def compare(plan: Plan, inputs: Mapping[str, Any], outputs: Mapping[str, Any]) -> accuracy.Comparison:
    """Compare simulated outputs with the equations as written."""
    return accuracy.compare(exact(plan.problem, inputs), plan.problem.angles, outputs)


def exact(problem: PlanProblem, inputs: Mapping[str, Any]) -> accuracy.ReferenceOutputs:
    """Return what the equations as written say of samples."""
    return accuracy.exact(problem.program, inputs)


def _lost(plan: Plan, inputs: Mapping[str, Any], comparison: accuracy.Comparison) -> Diagnostic:
    """Return the finding that samples leave the number format, with the first one and where it does."""
    assert comparison.lost_at is not None
    sample = {name: float(column[comparison.lost_at]) for name, column in inputs.items()}
    operation = first_invalid(plan, plan.arithmetic, sample)
    where = "" if operation is None else f": {operation.mode} in the equation of '{operation.equation}'"
    message = (
        f"{comparison.lost} of {comparison.samples} samples that the equations can do "
        f"leave the number format or the domain of a unit{where}"
    )
    example = "for example " + ", ".join(f"{name} = {number:.6g}" for name, number in sample.items())
    if comparison.valid:
        return Diagnostic("W410", message, None, f"they are marked invalid; {example}", Severity.WARNING)
    return Diagnostic("E410", message, None, f"narrow the input ranges, or use other units; {example}")


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
            operation.op,
            operation.settings,
            operation.kind,
            operands,
            formats.of_results(operation),
            operation.angle,
        )
        for name, signal in zip(operation.results, results, strict=True):
            if name is not None and signal is not None:
                signals[name] = signal
                if np.isnan(signal.values).any():
                    return operation
    return None
