"""A plan read back: verified before anybody runs or draws it."""

from __future__ import annotations

from cordicc.base.diagnostics import Diagnostic, InvalidInput
from cordicc.certify.plans import StatedBounds
from cordicc.emulate import functional as functional_run
from cordicc.emulate.observation import DEFAULT_SEED, machine_of
from cordicc.ir import sampling
from cordicc.ir.text import parse_graph
from cordicc.ir.well_formed import verify as verify_graph
from cordicc.plan.consistency import check_formats, check_operations, check_problem, check_sizes
from cordicc.plan.model import Plan
from cordicc.plan.verify import verify as verify_plan


def check_plan(plan: Plan, name: str) -> Plan:
    """Return a plan that was read back, with its schedule, wiring and arithmetic verified.

    Raises:
        InvalidInput: the plan contradicts itself.
    """
    try:
        check_sizes(plan)
        check_problem(plan)
        check_operations(plan)
        verify_plan(plan)
        program = parse_graph(plan.problem["program"], name)
        verify_graph(program)
        inputs = {str(node.params[0]) for node in program.nodes if node.op == "input"}
        assert inputs == {item["name"] for item in plan.problem["inputs"]}, "the inputs of the program differ"
        assert set(program.outputs) == set(plan.outputs), "the outputs of the program differ"
        arithmetic = machine_of(plan)
        check_formats(plan, arithmetic)
        StatedBounds.of(plan)
        functional_run.run(plan, arithmetic, sampling.draw(plan.problem, 1, DEFAULT_SEED))
    except (AssertionError, ArithmeticError, ValueError, LookupError, TypeError) as error:
        reason = (str(error).splitlines() or ["malformed"])[0][:500]
        message = f"the plan contradicts itself: {reason}"
        raise InvalidInput([Diagnostic("E603", message, hint="compile the problem again")]) from None
    return plan
