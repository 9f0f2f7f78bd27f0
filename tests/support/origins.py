"""What hand-made plans say of their origin: problem, target and options."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.ir.graph import Builder, Graph
from cordicc.plan.origin import PlanInput, PlanOutput, PlanProblem, PlanTarget
from cordicc.targets.target_file import load_target


def graph_of(inputs: Iterable[str], outputs: Iterable[str] = ()) -> Graph:
    """Return a graph that has the inputs, and the first of them, or 0, as each output."""
    builder = Builder()
    values = [builder.input(name) for name in inputs] or [builder.const(0)]
    return builder.build(dict.fromkeys(outputs, values[0]))


def problem_of(
    name: str,
    inputs: Mapping[str, tuple[float, float]],
    outputs: Iterable[str] = (),
    unit: str | None = None,
    **more: Any,
) -> PlanProblem:
    """Return the record of a problem of which little but the inputs' ranges and the outputs' names is known.

    `unit` is that of every input, `more` are other fields of the record.
    """
    outputs = tuple(outputs)
    fields: dict[str, Any] = {
        "program": graph_of(inputs, outputs),
        "inputs": tuple(PlanInput(each, float(lo), float(hi), unit) for each, (lo, hi) in inputs.items()),
        "outputs": tuple(PlanOutput(each) for each in outputs),
    }
    return PlanProblem(name, **(fields | more))


def target_of(arithmetic: Mapping[str, Any] | None = None, name: str = "kinematic") -> PlanTarget:
    """Return a target of 10 MHz without kinds of unit, by default with the arithmetic of "kinematic"."""
    return PlanTarget(name, 10e6, _kinematic() if arithmetic is None else Arithmetic.from_spec(arithmetic))


@cache
def _kinematic() -> Arithmetic:
    return load_target("kinematic").machine()
