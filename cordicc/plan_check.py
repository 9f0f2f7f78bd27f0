"""Check that a plan read back is made of operations that exist, with their ports and parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cordicc.ir.ops import BRANCHES, GUARD_CONDITIONS, OPS, Level
from cordicc.plan import Operation, Plan

_LARGEST_SHIFT = 4096

_ALLOWED = {
    "m": lambda p: type(p) is int and p in (1, 0, -1),
    "sign": lambda p: type(p) is int and p in (1, -1),
    "branch": lambda p: p in BRANCHES,
    "condition": lambda p: p in GUARD_CONDITIONS,
    "exponent": lambda p: type(p) is int and abs(p) <= _LARGEST_SHIFT,
    "factor": lambda p: isinstance(p, str),
}


def check_operations(plan: Plan) -> None:
    """Raise ValueError if an operation is unknown or is not of the form its definition asks for."""
    kinds: Mapping[str, Any] = plan.target["units"]
    for operation in plan.operations:
        _check(operation)
        if operation.kind not in kinds:
            raise ValueError(f"{operation.id}: the target has no unit of kind '{operation.kind}'")


def _check(operation: Operation) -> None:
    definition = OPS.get(operation.op)
    if definition is None or definition.level not in (Level.ARITHMETIC, Level.UNIT):
        raise ValueError(f"{operation.id}: no unit does '{operation.op}'")
    if operation.ports != definition.ports or len(operation.operands) != definition.arity:
        raise ValueError(f"{operation.id}: '{operation.op}' has the ports {', '.join(definition.ports)}")
    if len(operation.results) != len(definition.results):
        raise ValueError(f"{operation.id}: '{operation.op}' has {len(definition.results)} results")
    if set(operation.params) != set(definition.params):
        raise ValueError(f"{operation.id}: '{operation.op}' has other parameters")
    for name, param in operation.params.items():
        if not _ALLOWED[name](param):
            raise ValueError(f"{operation.id}: {name} = {param!r} is not allowed")
