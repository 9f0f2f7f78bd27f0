"""What a plan records of its problem: enough to simulate and to judge it without the file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cordicc.base.diagnostics import Diagnostic
from cordicc.ir.problem import Problem
from cordicc.ir.text import print_graph

UNIT_PROGRAM = "unit_program"
"""Where a plan's problem holds the graph of its operations, with exact constants."""


def problem_data(problem: Problem, warnings: Sequence[Diagnostic]) -> dict[str, Any]:
    """Return the `problem` part of a plan, plain data, with the warnings that came up."""
    samples = problem.samples
    return {
        "name": problem.name,
        "description": problem.description,
        "inputs": [
            {"name": i.name, "lo": float(i.lo), "hi": float(i.hi), "unit": i.unit} for i in problem.inputs
        ],
        "constants": {name: float(value) for name, value in problem.constants.items()},
        "equations": [{"target": e.target, "text": e.text} for e in problem.equations],
        "outputs": [
            {
                "name": o.name,
                "angle": o.is_angle,
                "wrap": o.wrap,
                "max_error": None if o.max_error is None else float(o.max_error),
            }
            for o in problem.outputs
        ],
        "assumptions": [fact.text for fact in problem.assumptions],
        "program": print_graph(problem.graph),
        "samples": None
        if samples is None
        else {"columns": {name: list(column) for name, column in samples.columns.items()}},
        "warnings": [f"{w.code}: {w.message}" for w in warnings],
    }
