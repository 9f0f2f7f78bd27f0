"""The integers of a plan's CORDIC units as plain data, on fixed point: what other hardware is made from."""

from __future__ import annotations

from typing import Any

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.unit.unit_integers import operation_data, shared_data, steps_name, unit_data
from cordicc.plan.model import Operand, Plan


def cordic_data(plan: Plan) -> dict[str, Any] | None:
    """Return constants, units by kind and operations by id; None on floating point.

    Raises ValueError if an operation, or a format, is none of the target's.
    """
    arithmetic = plan.arithmetic
    system = arithmetic.system
    if not isinstance(system, FixedSystem):
        return None

    def format_of(operand: Operand) -> FixedPoint:
        if operand.constant is None:
            return system.format(plan.formats.values.get(str(operand.value)))
        format_ = system.constant(operand.constant).format
        assert isinstance(format_, FixedPoint)
        return format_

    made = [operation for operation in plan.operations if operation.kind in arithmetic.caus]
    names: dict[str, set[str]] = {}
    for operation in made:
        names.setdefault(operation.kind, set()).add(steps_name(operation.op, operation.params))
    return {
        "constants": shared_data(),
        "units": {kind: unit_data(arithmetic.caus[kind], found) for kind, found in names.items()},
        "operations": {
            each.id: operation_data(
                arithmetic,
                each.kind,
                each.op,
                each.settings,
                [format_of(operand) for operand in each.operands],
            )
            for each in made
        },
    }


def difference(stated: Any, own: Any, path: str) -> tuple[str, Any, Any] | None:
    """Return the first place in which plain data differ, and what stands there; None if they do not."""
    if isinstance(stated, dict) and isinstance(own, dict):
        for key in sorted({*stated, *own}):
            if key not in stated or key not in own:
                return f"{path}.{key}", stated.get(key, "missing"), own.get(key, "missing")
            if (found := difference(stated[key], own[key], f"{path}.{key}")) is not None:
                return found
        return None
    return None if stated == own else (path, stated, own)
