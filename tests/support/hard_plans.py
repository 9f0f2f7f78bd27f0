"""Plans that are hard on pictures and pages: shared units, hostile texts, nothing at all."""

from __future__ import annotations

from dataclasses import replace

from cordicc.plan.model import Operand, Operation, Plan
from cordicc.plan.origin import PlanEquation
from tests.support import hand_plans as plans
from tests.support.origins import problem_of

HOSTILE = "<script>alert('x')</script> & \"]]>\x00\n" + "W" * 300


def shared() -> Plan:
    """Two operations in flight on one unit at initiation interval 16."""
    plan = plans.wheel()
    moved = [
        replace(op, unit="standard1", start=op.start + 8, finish=op.finish + 8) if op.id == "o6" else op
        for op in plan.operations
    ]
    extra = Operation(
        "o7", "rotate", {"m": 1}, "standard", "circular rotation", "standard1", 20, 64, ("x", "y", "z"),
        (Operand("S"), Operand(constant="0"), Operand("S")), (None, None), "spare",
    )  # fmt: skip
    return replace(plan, operations=(*moved, extra), initiation_interval=16)


def hostile() -> Plan:
    plan = plans.planar()
    names = {"x": HOSTILE}
    operations = tuple(
        replace(
            op,
            mode=HOSTILE,
            equation=HOSTILE,
            operands=tuple(replace(o, value=names.get(o.value or "", o.value)) for o in op.operands),
        )
        for op in plan.operations
    )
    outputs = {HOSTILE: next(iter(plan.outputs.values())), "k": Operand(constant="1/3")}
    problem = problem_of(
        HOSTILE,
        {HOSTILE: (0, 1), "y": (0, 1)},
        outputs,
        HOSTILE,
        description=HOSTILE,
        equations=(PlanEquation(HOSTILE, HOSTILE),),
        constants=plan.problem.constants,
        warnings=(HOSTILE,),
    )
    return replace(
        plan,
        operations=operations,
        problem=problem,
        outputs=outputs,
        fifos=(),
    )


def empty() -> Plan:
    """A plan that only passes an input on."""
    return plans.Builder("wire", {"x": (0, 1)}).plan({"y": "x", "k": 0.5})


ALL = {
    "wheel": plans.wheel(), "planar": plans.planar(), "puma": plans.puma(), "shared": shared(),
    "hostile": hostile(), "empty": empty(),
}  # fmt: skip
