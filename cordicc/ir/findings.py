"""What is found by evaluating a problem, told at its equation and with a sample in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cordicc.base.diagnostics import Diagnostic, Severity, Source, Span
from cordicc.ir.problem import Problem


def place(
    problem: Problem,
    source: Source,
    equation: str,
    code: str,
    message: str,
    hint: str | None = None,
    severity: Severity = Severity.ERROR,
) -> Diagnostic:
    """Return a diagnostic at the line on which the equation of a name starts."""
    line = next((e.line for e in problem.equations if e.target == equation), None)
    if line is None:
        return Diagnostic(code, message, None, hint, severity, source)
    text = source.line(line)
    span = Span(line, len(text) - len(text.lstrip(" -")) + 1, len(text) + 1)
    return Diagnostic(code, message, span, hint, severity, source)


def example_of(samples: Mapping[str, np.ndarray], index: int) -> str:
    """Return a sample in words."""
    return ", ".join(f"{name} = {column[index]:.6g}" for name, column in samples.items())
