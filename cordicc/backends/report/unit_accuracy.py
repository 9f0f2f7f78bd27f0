"""How far each operation of a plan may be off by itself, in words: the proven bounds of its unit."""

from __future__ import annotations

from cordicc.arith.kernels.step_errors import NoBoundError
from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.arith.unit.sizing import LAST_ROUNDING_ULP, internal_errors_ulp
from cordicc.plan.model import Plan
from cordicc.targets.target import CAU_KINDS, function_name

_EXACT = ("neg", "abs", "sign", "min", "max", "flip", "select", "guard")


def own_errors(plan: Plan) -> dict[str, str]:
    """Return, by operation, what is proven of its own error, given the words of its operands."""
    arithmetic = plan.arithmetic
    single = isinstance(arithmetic.system, SingleSystem)
    # A word of single precision has the sign besides its 24 bits.
    bits = arithmetic.system.operand_bits + single
    known: dict[tuple[str, str], str] = {}
    for operation in plan.operations:
        if operation.kind in CAU_KINDS:
            key = (operation.kind, function_name(operation.op, operation.m))
            if key not in known:
                known[key] = _cau_error(arithmetic, *key, bits)
    return {
        o.id: known[o.kind, function_name(o.op, o.m)]
        if o.kind in CAU_KINDS
        else "exact"
        if o.op in _EXACT
        else "rounded once, within 0.5 ulp of its result"
        for o in plan.operations
    }


def _cau_error(arithmetic: Arithmetic, kind: str, function: str, bits: int) -> str:
    try:
        errors = internal_errors_ulp(arithmetic.caus[kind], function, bits)
    except (KeyError, NoBoundError, ValueError):
        return "no bound for this unit"
    if "residual" in errors:
        residual = f"{errors['residual']:.2g} ulp of the operands"
        return f"its angle leaves a residual of at most {residual}, then is rounded"
    parts = [f"{name} within {error + LAST_ROUNDING_ULP:.3g} ulp" for name, error in errors.items()]
    return ", ".join(parts) + " of a word that holds the operands"
