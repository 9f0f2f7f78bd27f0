"""Words wide enough for the errors that a problem allows, where the target leaves their guard bits open."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.backends.labels import percent
from cordicc.base.diagnostics import Diagnostic, Severity, Unattainable
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanProblem
from cordicc.targets.sized import WIDEST_WORD_BITS, most_guard_bits

if TYPE_CHECKING:
    from cordicc.certify.certificate import Bound

PlanWith = Callable[[int, int], Plan]
"""Makes the plan for words of a width outside and a number of guard bits."""

_WIDER = 2
"""Bits by which words outside grow at a time."""


class TooInaccurate(Unattainable):
    """No words that the target may have keep an output's error within what the problem allows."""


def allowed_errors(problem: PlanProblem) -> dict[str, float]:
    """Return the `max_error` by output of a problem as plans record it, where there is one."""
    return {o.name: o.max_error for o in problem.outputs if o.max_error is not None}


def _bounds(plan: Plan, allowed: Mapping[str, float]) -> Mapping[str, Bound]:
    from cordicc.certify.plans import bounds_of  # most compilations need no bounds

    return bounds_of(plan, allowed)


def checked(plan: Plan) -> Plan:
    """Return a plan whose bounds are within the errors that its problem allows.

    Raises:
        TooInaccurate: they are not (E413).
    """
    allowed = allowed_errors(plan.problem)
    if not allowed:
        return plan
    bounds = _bounds(plan, allowed)
    if missed := _missed(bounds, allowed):
        raise _refusal(missed, allowed, f"the number format of target '{plan.target.name}' is fixed")
    return plan


def widened(plan: Plan, plan_with: PlanWith) -> Plan:
    """Return the plan with the narrowest words whose proven bounds are within the allowed errors.

    Words outside grow by two bits at a time, with as many guard bits as there is room for; of the first
    width that will do the fewest guard bits are taken, but words between operations never get narrower.

    Args:
        plan: the plan chosen without regard to allowed errors, the first candidate.
        plan_with: makes the other candidates.

    Raises:
        TooInaccurate: no width will do (E413).
    """
    allowed = allowed_errors(plan.problem)
    if not allowed or not _missed(_bounds(plan, allowed), allowed):
        return plan
    system = plan.arithmetic.system
    assert isinstance(system, FixedSystem)
    width, between = system.width_bits, system.operand_bits
    best: Mapping[str, Bound] = {}
    while width <= WIDEST_WORD_BITS:
        most = most_guard_bits(width)
        candidate = plan_with(width, most)
        best = _bounds(candidate, allowed)
        if not _missed(best, allowed):
            return _fewest_guard_bits(candidate, width, range(max(0, between - width), most), plan_with)
        width += _WIDER
    reason = f"words between operations have up to {WIDEST_WORD_BITS} bits"
    raise _refusal(_missed(best, allowed), allowed, reason)


def _fewest_guard_bits(plan: Plan, width: int, fewer: range, plan_with: PlanWith) -> Plan:
    """Return the plan of a width with the fewest guard bits, given one that will do, by bisection."""
    allowed = allowed_errors(plan.problem)
    least, most = fewer.start, fewer.stop
    while least < most:
        middle = (least + most) // 2
        candidate = plan_with(width, middle)
        if _missed(_bounds(candidate, allowed), allowed):
            least = middle + 1
        else:
            plan, most = candidate, middle
    return plan


def exceptions(plan: Plan) -> list[Diagnostic]:
    """Return a warning for each allowed error that is not proven for all of the default samples."""
    found = []
    for name, error in allowed_errors(plan.problem).items():
        bound, seen = plan.accuracy[name].bound, plan.accuracy[name].observed.max
        if bound is None or bound.share_of_samples == 1:
            continue
        message = (
            f"max_error {error:.3g} of '{name}' is proven for {percent(bound.share_of_samples)} of the "
            f"default samples, where {bound.where}"
        )
        if seen is not None and seen > error:
            message += f"; the largest error seen is {seen:.3g}"
        hint = "narrow the input ranges, away from where small errors of the inputs move the output far"
        found.append(Diagnostic("W417", message, None, hint, Severity.WARNING))
    return found


def _missed(bounds: Mapping[str, Bound], allowed: Mapping[str, float]) -> dict[str, Bound]:
    """Return the bounds that are larger than allowed."""
    return {
        name: bounds[name]
        for name, error in allowed.items()
        if (value := bounds[name].value) is None or value > error
    }


def _refusal(missed: Mapping[str, Bound], allowed: Mapping[str, float], reason: str) -> TooInaccurate:
    found = []
    for name, bound in missed.items():
        wanted = f"max_error {allowed[name]:.3g} of '{name}' cannot be met"
        if bound.value is None:
            found.append(Diagnostic("E413", f"{wanted}: {bound.reason}"))
        else:
            hint = f"the nearest that can be met is {bound.value:.3g}, {_where(bound)}"
            found.append(Diagnostic("E413", f"{wanted}: {reason}", hint=hint))
    return TooInaccurate(found)


def _where(bound: Bound) -> str:
    return "where " + " and ".join(p.text for p in bound.where) if bound.where else "for every valid sample"
