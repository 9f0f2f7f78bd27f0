"""How many guard bits the values between operations get, where the target leaves it open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from cordicc.emulate import accuracy, functional, sampling
from cordicc.observation import DEFAULT_SEED, angles_of, exact, machine_of
from cordicc.plan import Plan
from cordicc.targets.sized import MOST_GUARD_BITS

_SAMPLES = 2_000
_GAIN = 1.1
"""More guard bits must lower the error by more than this to be worth them."""


def fewest_guard_bits(problem: Mapping[str, Any], plan_with: Callable[[int], Plan]) -> Plan:
    """Return the plan with the fewest guard bits that keeps the observed error of every output small.

    Small is within one ulp of the output's word, or, where the rounding of the inputs alone makes more
    than that, within a tenth of what the most guard bits give.

    Args:
        problem: the problem as plans record it.
        plan_with: makes the plan for a number of guard bits.
    """
    inputs = sampling.draw(problem, _SAMPLES, DEFAULT_SEED)
    reference = exact(problem, inputs)
    angles = angles_of(problem)

    def errors(plan: Plan) -> dict[str, float]:
        seen = accuracy.compare(reference, angles, functional.run(plan, machine_of(plan), inputs)).observed
        return {name: each.max or 0.0 for name, each in seen.items()}

    widest = plan_with(MOST_GUARD_BITS)
    least = errors(widest)
    for guard in range(MOST_GUARD_BITS):
        plan = plan_with(guard)
        allowed = {
            name: max(math.ldexp(1.0, -spec["fraction"]), _GAIN * least[name])
            for name, spec in plan.formats.outputs.items()
        }
        if all(error <= allowed[name] for name, error in errors(plan).items()):
            return plan
    return widest
