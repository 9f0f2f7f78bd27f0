"""cordicc: a compiler from kinematic equations to CORDIC hardware plans.

    import cordicc
    plan = cordicc.compile("problem.yaml", target="kinematic")
    out = plan.simulate({"x": [0.3], "y": [0.1]})

The public names are loaded when they are first used, so that `cordicc --help` starts fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cordicc.api import Plan, check, compile, load_plan
    from cordicc.base.diagnostics import CordiccError, InvalidInput, Unattainable
    from cordicc.ir.problem import Problem

__version__ = "0.1.0"

__all__ = [
    "CordiccError",
    "InvalidInput",
    "Plan",
    "Problem",
    "Unattainable",
    "__version__",
    "check",
    "compile",
    "load_plan",
]

_HOMES = {
    "CordiccError": "cordicc.base.diagnostics",
    "InvalidInput": "cordicc.base.diagnostics",
    "Plan": "cordicc.api",
    "Problem": "cordicc.ir.problem",
    "Unattainable": "cordicc.base.diagnostics",
    "check": "cordicc.api",
    "compile": "cordicc.api",
    "load_plan": "cordicc.api",
}


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module 'cordicc' has no attribute {name!r}")
