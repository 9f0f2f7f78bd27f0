"""A plan read back: verified before anybody runs or draws it."""

from __future__ import annotations

from cordicc.certify.plans import StatedBounds
from cordicc.emulate import functional as functional_run
from cordicc.ir.sampling import DEFAULT_SEED, draw
from cordicc.ir.well_formed import verify as verify_graph
from cordicc.plan.consistency import check_formats, check_operations, check_problem, check_sizes
from cordicc.plan.file import contradiction
from cordicc.plan.model import Plan
from cordicc.plan.verify import verify as verify_plan


def check_plan(plan: Plan) -> Plan:
    """Return a plan that was read back, with its schedule, wiring and arithmetic verified.

    Raises:
        InvalidInput: the plan contradicts itself.
    """
    try:
        check_sizes(plan)
        check_problem(plan)
        check_operations(plan)
        verify_plan(plan)
        program = plan.problem.program
        verify_graph(program)
        inputs = {node.name for node in program.nodes if node.op == "input"}
        assert inputs == set(plan.problem.input_names), "the inputs of the program differ"
        assert set(program.outputs) == set(plan.outputs), "the outputs of the program differ"
        check_formats(plan)
        StatedBounds.of(plan)
        functional_run.run(plan, plan.arithmetic, draw(plan.problem.workspace, 1, DEFAULT_SEED))
    except (AssertionError, ArithmeticError, ValueError, LookupError, TypeError) as error:
        raise contradiction((str(error).splitlines() or ["malformed"])[0][:500]) from None
    return plan
