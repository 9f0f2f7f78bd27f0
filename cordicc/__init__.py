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
    from cordicc.api import RunnablePlan as Plan
    from cordicc.api import check, compile, load_plan
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
    "CordiccError": "cordicc.base.diagnostics:CordiccError",
    "InvalidInput": "cordicc.base.diagnostics:InvalidInput",
    "Plan": "cordicc.api:RunnablePlan",
    "Problem": "cordicc.ir.problem:Problem",
    "Unattainable": "cordicc.base.diagnostics:Unattainable",
    "check": "cordicc.api:check",
    "compile": "cordicc.api:compile",
    "load_plan": "cordicc.api:load_plan",
}


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        module, _, inner = _HOMES[name].partition(":")
        return getattr(import_module(module), inner)
    raise AttributeError(f"module 'cordicc' has no attribute {name!r}")
