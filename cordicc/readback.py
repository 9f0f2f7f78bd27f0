"""A plan read back: verified before anybody runs or draws it."""

from __future__ import annotations

from cordicc.emulate import functional as functional_run
from cordicc.ir.sampling import DEFAULT_SEED, draw
from cordicc.plan.consistency import (
    check_formats,
    check_operations,
    check_problem,
    check_programs,
    check_sizes,
)
from cordicc.plan.file import BROKEN, contradiction
from cordicc.plan.model import Plan
from cordicc.plan.verify import verify as verify_plan


def check_plan(plan: Plan) -> Plan:
    """Return a plan that was read back, with its schedule, wiring and arithmetic verified.

    Raises:
        InvalidInput: the plan contradicts itself.
    """
    from cordicc.certify.plans import StatedBounds  # plans without bounds need no proofs

    try:
        check_sizes(plan)
        check_problem(plan)
        check_operations(plan)
        verify_plan(plan)
        check_programs(plan)
        check_formats(plan)
        StatedBounds.of(plan)
        functional_run.run(plan, plan.arithmetic, draw(plan.problem.workspace, 1, DEFAULT_SEED))
    except BROKEN as error:
        raise contradiction((str(error).splitlines() or ["malformed"])[0][:500]) from None
    return plan
