"""Words wide enough for the errors that a problem allows, where the target leaves their guard bits open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Protocol

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.base.diagnostics import Diagnostic, Severity, Unattainable
from cordicc.base.text_tables import percent
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanProblem
from cordicc.targets.sized import WIDEST_WORD_BITS, most_guard_bits

PlanWith = Callable[[int, int], Plan]
"""Makes the plan for words of a width outside and a number of guard bits."""


class Condition(Protocol):
    """What must hold of a sample for a bound to hold."""

    @property
    def text(self) -> str:
        """The condition in words."""


class ProvenBound(Protocol):
    """What is proven of an output's error: a bound and where it holds, or None and the reason."""

    @property
    def value(self) -> float | None:
        """The bound, in the unit of the output."""

    @property
    def where(self) -> Sequence[Condition]:
        """The conditions under which it holds, all of them."""

    @property
    def reason(self) -> str | None:
        """Why there is no bound."""


BoundsOf = Callable[[Plan, Mapping[str, float]], Mapping[str, ProvenBound]]
"""Proves a bound of every output of a plan, given the errors that are allowed, by output."""

_WIDER = 2
"""Bits by which words outside grow at a time."""


class TooInaccurate(Unattainable):
    """No words that the target may have keep an output's error within what the problem allows.

    `excess`: how many times as large as allowed the nearest is that can be met.
    """

    def __init__(self, diagnostics: Sequence[Diagnostic], excess: float) -> None:
        super().__init__(diagnostics)
        self.excess = excess


def allowed_errors(problem: PlanProblem) -> dict[str, float]:
    """Return the `max_error` by output of a problem as plans record it, where there is one."""
    return {o.name: o.max_error for o in problem.outputs if o.max_error is not None}


def checked(plan: Plan, bounds_of: BoundsOf) -> Plan:
    """Return a plan whose bounds are within the errors that its problem allows.

    Raises:
        TooInaccurate: they are not (E413).
    """
    allowed = allowed_errors(plan.problem)
    if not allowed:
        return plan
    bounds = bounds_of(plan, allowed)
    if missed := _missed(bounds, allowed):
        raise _refusal(missed, allowed, f"the number format of target '{plan.target.name}' is fixed")
    return plan


def widened(plan: Plan, plan_with: PlanWith, bounds_of: BoundsOf) -> Plan:
    """Return the plan with the narrowest words whose proven bounds are within the allowed errors.

    Words outside grow by two bits at a time, with as many guard bits as there is room for; of the first
    width that will do the fewest guard bits are taken, but words between operations never get narrower.

    Args:
        plan: the plan chosen without regard to allowed errors, the first candidate.
        plan_with: makes the other candidates.
        bounds_of: proves bounds of a candidate.

    Raises:
        TooInaccurate: no width will do (E413).
    """
    allowed = allowed_errors(plan.problem)
    if not allowed or not _missed(bounds_of(plan, allowed), allowed):
        return plan
    system = plan.arithmetic.system
    assert isinstance(system, FixedSystem)
    width, between = system.width_bits, system.operand_bits
    best: Mapping[str, ProvenBound] = {}
    while width <= WIDEST_WORD_BITS:
        most = most_guard_bits(width)
        candidate = plan_with(width, most)
        best = bounds_of(candidate, allowed)
        if not _missed(best, allowed):
            fewer = range(max(0, between - width), most)
            return _fewest_guard_bits(candidate, fewer, partial(plan_with, width), bounds_of)
        width += _WIDER
    reason = f"words between operations have up to {WIDEST_WORD_BITS} bits"
    raise _refusal(_missed(best, allowed), allowed, reason)


def _fewest_guard_bits(
    plan: Plan, fewer: range, plan_with: Callable[[int], Plan], bounds_of: BoundsOf
) -> Plan:
    """Return the plan of a width with the fewest guard bits, given one that will do, by bisection."""
    allowed = allowed_errors(plan.problem)
    least, most = fewer.start, fewer.stop
    while least < most:
        middle = (least + most) // 2
        candidate = plan_with(middle)
        if _missed(bounds_of(candidate, allowed), allowed):
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


def _missed(bounds: Mapping[str, ProvenBound], allowed: Mapping[str, float]) -> dict[str, ProvenBound]:
    """Return the bounds that are larger than allowed."""
    return {
        name: bounds[name]
        for name, error in allowed.items()
        if (value := bounds[name].value) is None or value > error
    }


def _refusal(missed: Mapping[str, ProvenBound], allowed: Mapping[str, float], reason: str) -> TooInaccurate:
    found, excess = [], 1.0
    for name, bound in missed.items():
        excess = max(excess, math.inf if bound.value is None else bound.value / allowed[name])
        wanted = f"max_error {allowed[name]:.3g} of '{name}' cannot be met"
        if bound.value is None:
            found.append(Diagnostic("E413", f"{wanted}: {bound.reason}"))
        else:
            hint = f"the nearest that can be met is {bound.value:.3g}, {_where(bound)}"
            found.append(Diagnostic("E413", f"{wanted}: {reason}", hint=hint))
    return TooInaccurate(found, excess)


def _where(bound: ProvenBound) -> str:
    return "where " + " and ".join(p.text for p in bound.where) if bound.where else "for every valid sample"
