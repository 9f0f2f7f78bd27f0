"""The bounds of a plan: proven for it, written into it, and read back to judge samples."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cordicc.base.arrays import Bools, Floats
from cordicc.certify.certificate import Bound, certify
from cordicc.certify.error_network import ErrorNetwork, network
from cordicc.certify.own_bounds import inside, own_bounds
from cordicc.certify.predicates import OWN_BOUND, singular
from cordicc.certify.twins import twins
from cordicc.emulate import functional
from cordicc.ir.sampling import DEFAULT_SAMPLES, DEFAULT_SEED, draw
from cordicc.plan.model import Plan
from cordicc.plan.stated_accuracy import OutputAccuracy, Predicate, SeenErrors, StatedBound

_CHOOSING = 2_000
"""The first of the default samples, from which thresholds follow."""

OWN_SHARES = (0.5, 0.9, 0.99)
"""Of the default samples: a plan states within which own bounds so many of them are."""

EVERYWHERE = "every valid sample"


def default_samples(plan: Plan) -> dict[str, Floats]:
    """Return the default samples that keep what the problem assumes; if none does, all of them."""
    return plan.problem.facts.among(draw(plan.problem.workspace, DEFAULT_SAMPLES, DEFAULT_SEED))


def bounds_of(plan: Plan, wanted: Mapping[str, float] | None = None) -> dict[str, Bound]:
    """Return the proven bound of every output of a plan that holds its unit program.

    Args:
        plan: the plan.
        wanted: by output, a bound that suffices, see `certify`.
    """
    inputs = default_samples(plan)
    chosen = {name: column[:_CHOOSING] for name, column in inputs.items()}
    valid = functional.run(plan, plan.arithmetic, chosen)["valid"]
    net = network(plan)
    alike = twins(net, wanted or {})
    part = alike.representatives(net)
    allowed = {name: bound for name, bound in (wanted or {}).items() if name in part.outputs}
    proven = certify(part, {name: chosen[name] for name in part.inputs}, valid, allowed)
    return {output: alike.bound(output, proven) for output in net.outputs}


def with_bounds(plan: Plan, bounds: Mapping[str, Bound]) -> Plan:
    """Return an observed plan that states bounds, and how default samples fare.

    That is, for how many of them each bound holds, and which own bounds most of them have.
    """
    inputs = default_samples(plan)
    valid = functional.run(plan, plan.arithmetic, inputs)["valid"]
    kept = {name: column[valid] for name, column in inputs.items()}
    net = network(plan)
    # A proof takes what is assumed as exact; of rows that keep it roughly nothing is proven.
    exactly = plan.problem.facts.exactly(kept)
    held = inside(net, {name: bound.where for name, bound in bounds.items()}, kept)
    held = {name: where & exactly for name, where in held.items()}
    own = {
        name: np.where(exactly, found, np.inf) for name, found in own_bounds(net, list(bounds), kept).items()
    }
    accuracy = {
        name: _stated(figures.observed, bounds[name], held[name], own[name])
        for name, figures in plan.accuracy.items()
    }
    return replace(plan, accuracy=accuracy)


def _stated(seen: SeenErrors, bound: Bound, held: Bools, own: Floats) -> OutputAccuracy:
    """Return the record of an output, given for which samples its bound holds and their own bounds."""
    if bound.value is None:
        return OutputAccuracy(seen, None, bound.reason or "")
    ordered = np.sort(np.where(held, np.fmin(own, bound.value), own)).tolist()
    least = {str(share): ordered[math.ceil(share * len(ordered)) - 1] for share in OWN_SHARES if ordered}
    stated = StatedBound(
        value=bound.value,
        where=" and ".join(p.text for p in bound.where) or EVERYWHERE,
        share_of_samples=float(held.mean()) if held.size else 0.0,
        conditions=bound.where,
        own_bounds={share: value if math.isfinite(value) else None for share, value in least.items()},
    )
    return OutputAccuracy(seen, stated)


@dataclass(frozen=True, slots=True)
class StatedBounds:
    """The bounds that a plan states: by output, values and conditions under which they hold."""

    net: ErrorNetwork
    values: Mapping[str, float]
    conditions: Mapping[str, tuple[Predicate, ...]]

    @classmethod
    def of(cls, plan: Plan) -> StatedBounds | None:
        """Return the bounds of a plan that come with their conditions as data, None if it states none.

        Raises ValueError or LookupError for a condition that is none of the plan's operations.
        """
        values: dict[str, float] = {}
        conditions: dict[str, tuple[Predicate, ...]] = {}
        for name, figures in plan.accuracy.items():
            if figures.bound is not None and figures.bound.conditions is not None:
                values[name], conditions[name] = figures.bound.value, figures.bound.conditions
        if not values:
            return None
        net = network(plan)
        for name, wanted in conditions.items():
            possible = {step.id for step in net.upstream(name) if singular(step)}
            for condition in wanted:
                if condition.kind != OWN_BOUND and condition.operation not in possible:
                    raise ValueError(f"the bound of '{name}' has a condition on '{condition.operation}'")
        return cls(net, values, conditions)

    def inside(self, inputs: Mapping[str, Floats]) -> dict[str, Bools]:
        """Return, by output with a bound, which samples meet the conditions under which it holds.

        `inputs` are samples that are valid in the equations and in the simulation, float64 of shape (n,).
        """
        return inside(self.net, self.conditions, inputs)
