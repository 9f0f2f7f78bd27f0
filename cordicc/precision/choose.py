"""The number formats of a plan, and with them the plan: on fixed point a trial of each is judged."""

from __future__ import annotations

from collections.abc import Callable

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.base.diagnostics import Diagnostic
from cordicc.frontend.load import LoadedProblem
from cordicc.plan.assemble import assemble
from cordicc.plan.model import Plan, Selection
from cordicc.plan.origin import PlanOptions, PlanProblem
from cordicc.precision.allowed_error import BoundsOf, checked, widened
from cordicc.precision.binary_points import formats, magnitudes
from cordicc.precision.guard_bits import fewest_guard_bits
from cordicc.rewrite.cheapest import Choice
from cordicc.targets.sized import most_guard_bits
from cordicc.targets.target import Target

TargetWith = Callable[[int, int | None], Target]
"""Reads the target with so many guard bits and, if not None, with words of so many bits outside."""


def plan_with_formats(
    loaded: LoadedProblem,
    choice: Choice,
    target: Target,
    target_with: TargetWith,
    recorded: PlanOptions,
    bounds_of: BoundsOf,
    with_borders: Callable[[Plan], Plan],
) -> tuple[Plan, tuple[Diagnostic, ...]]:
    """Return the operations of a plan, not placed yet; on fixed point with a binary point for every value.

    Args:
        loaded: the problem and the warnings about it.
        choice: the graph of unit operations.
        target: the target as it is without guard bits, if it leaves them open.
        target_with: the same target with guard bits, where it leaves them open.
        recorded: what the plan records of the options.
        bounds_of: proves bounds of a plan; called where the problem allows an error.
        with_borders: gives operations what follows from the formats at the border of their domain.

    Returns:
        The plan and all warnings so far.

    Raises:
        TooInaccurate: no words that the target may have keep the errors within what the problem allows.
        Unattainable: a value grows past every number format.
    """
    warnings, graph, held = tuple(loaded.warnings), choice.graph, None
    words = target.machine().system
    if isinstance(words, FixedSystem):
        held = magnitudes(loaded.problem, loaded.source, graph)
        warnings = (*warnings, *held.warnings)
    record = PlanProblem.of(loaded.problem, warnings)

    def plan_for(target: Target) -> Plan:
        system, specs = target.machine().system, {}
        if held is not None and isinstance(system, FixedSystem):
            specs = formats(loaded.problem, loaded.source, held, graph, system)
        return assemble(
            graph,
            target,
            problem=record,
            options=recorded,
            formats=specs,
            steps=choice.steps,
            selection=Selection(
                choice.searched, choice.proven, choice.facts, choice.left_out, choice.turned_down
            ),
        )

    if not isinstance(words, FixedSystem) or not target.guard_is_open:
        return checked(with_borders(plan_for(target)), bounds_of), warnings
    # As many guard bits as the accuracy needs, and wider words if the problem allows less error than that.
    most = most_guard_bits(words.width_bits)
    plan = fewest_guard_bits(record, most, lambda guard: plan_for(target_with(guard, None)))
    plan = widened(
        with_borders(plan), lambda width, guard: with_borders(plan_for(target_with(guard, width))), bounds_of
    )
    return plan, warnings
