"""How many guard bits the values between operations get, where the target leaves it open."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from cordicc.emulate import accuracy, functional
from cordicc.emulate.observation import exact
from cordicc.ir.sampling import DEFAULT_SEED, draw
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanProblem

_SAMPLES = 2_000
_GAIN = 1.1
"""More guard bits must lower an error by more than this to be worth them."""

_SHARES = (0.5, 0.9, 0.99, 1.0)
"""Of the samples, by size of error: a few ill-conditioned ones must not hide what the others lose."""


def fewest_guard_bits(problem: PlanProblem, most: int, plan_with: Callable[[int], Plan]) -> Plan:
    """Return the plan with the fewest guard bits that keeps the observed errors of the outputs small.

    Small is within one ulp of the output's word, or, where the rounding of the inputs alone makes more
    than that, within a tenth of what the most guard bits give; for the quantiles `_SHARES` of the errors.
    An output with a `max_error` does not count: it says itself what is small, see `allowed_error.widened`.

    Args:
        problem: the problem as plans record it.
        most: the most guard bits to try.
        plan_with: makes the plan for a number of guard bits.
    """
    angles = {o.name: o.is_angle for o in problem.outputs if o.max_error is None}
    if not angles:
        return plan_with(0)
    inputs = problem.facts.among(draw(problem.workspace, _SAMPLES, DEFAULT_SEED))
    reference = exact(problem, inputs)

    def quantiles(plan: Plan) -> dict[str, NDArray[np.float64]]:
        outputs = functional.run(plan, plan.arithmetic, inputs)
        found = accuracy.errors(reference, angles, outputs)
        return {name: np.quantile(error, _SHARES) if error.size else _NONE for name, error in found.items()}

    widest = plan_with(most)
    least = quantiles(widest)
    for guard in range(most):
        plan = plan_with(guard)
        seen = quantiles(plan)
        if all(np.all(seen[name] <= np.maximum(_ulp(plan, name), _GAIN * least[name])) for name in angles):
            return plan
    return widest


def _ulp(plan: Plan, output: str) -> float:
    return math.ldexp(1.0, -plan.formats.outputs[output].fraction)


_NONE = np.zeros(len(_SHARES))
