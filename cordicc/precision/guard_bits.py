"""How many guard bits the values between operations get, where the target leaves it open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.emulate import accuracy, functional
from cordicc.emulate.observation import exact
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.sampling import DEFAULT_SEED, draw
from cordicc.ir.towards_zero import roots_of, towards_zero
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanProblem

_SAMPLES = 2_000
_GAIN = 1.1
"""More guard bits must lower an error by more than this to be worth them."""

_SHARES = (0.5, 0.9, 0.99, 1.0)
"""Of the samples, by size of error: a few ill-conditioned ones must not hide what the others lose."""

_SMALL_GAIN = 2.0
"""The same where roots are small, which few samples are: there rounding alone makes errors differ more."""


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
    widest = plan_with(most)
    drawn = problem.facts.among(draw(problem.workspace, _SAMPLES, DEFAULT_SEED))
    judges = [
        _Judge(problem, angles, inputs, gain, widest)
        for inputs, gain in ((drawn, _GAIN), (_small_roots(problem, widest, drawn), _SMALL_GAIN))
        if len(next(iter(inputs.values()), ()))
    ]
    for guard in range(most):
        plan = plan_with(guard)
        if all(judge.accepts(plan) for judge in judges):
            return plan
    return widest


def _small_roots(problem: PlanProblem, plan: Plan, drawn: Mapping[str, Floats]) -> dict[str, Floats]:
    """Return samples on the way to where roots of a plan are small; of a problem's own samples none."""
    graph, workspace = plan.unit_program, problem.workspace
    if graph is None or workspace.rows is not None:
        return {name: np.zeros(0) for name in drawn}
    ranges = {name: Interval(lo, hi) for name, (lo, hi) in workspace.ranges.items()}
    return problem.facts.only(towards_zero(graph, roots_of(graph), ranges, drawn))


class _Judge:
    """Compares the errors of a plan on samples with those of the plan with the most guard bits."""

    def __init__(
        self,
        problem: PlanProblem,
        angles: Mapping[str, bool],
        inputs: Mapping[str, Floats],
        gain: float,
        widest: Plan,
    ) -> None:
        self._angles, self._inputs, self._gain = angles, inputs, gain
        self._reference = exact(problem, inputs)
        self._least = self._quantiles(widest)

    def _quantiles(self, plan: Plan) -> dict[str, Floats]:
        outputs = functional.run(plan, plan.arithmetic, self._inputs)
        found = accuracy.errors(self._reference, self._angles, outputs)
        return {name: np.quantile(error, _SHARES) if error.size else _NONE for name, error in found.items()}

    def accepts(self, plan: Plan) -> bool:
        """Tell whether a plan's errors are as small as words can make them."""
        seen = self._quantiles(plan)
        return all(
            np.all(seen[name] <= np.maximum(_ulp(plan, name), self._gain * self._least[name]))
            for name in self._angles
        )


def _ulp(plan: Plan, output: str) -> float:
    return math.ldexp(1.0, -plan.formats.outputs[output].fraction)


_NONE = np.zeros(len(_SHARES))
