"""The bounds of a plan: proven for it, written into it, and read back to judge samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.machine import Arithmetic
from cordicc.certify.boxes import Boxes, Floats
from cordicc.certify.certificate import Bound, certify
from cordicc.certify.network import Network, network
from cordicc.certify.predicates import OWN_BOUND, Predicate, inside, meets, singular
from cordicc.certify.sweep import forward
from cordicc.emulate import functional, sampling
from cordicc.ir.text import parse_graph
from cordicc.plan import Plan
from cordicc.record import UNIT_PROGRAM

SAMPLES = 10_000
"""Of which the plan states the share that is inside, with seed 0; thresholds follow from the first ones."""

_CHOOSING = 2_000

EVERYWHERE = "every valid sample"

_BLOCK_SAMPLES = 8192
"""Samples judged at once: enough to hide the cost of a NumPy call, few enough to need little memory."""


def bounds_of(plan: Plan, wanted: Mapping[str, float] | None = None) -> dict[str, Bound]:
    """Return the proven bound of every output of a plan that holds its unit program.

    Args:
        plan: the plan.
        wanted: by output, a bound that suffices, see `certify`.
    """
    inputs = sampling.draw(plan.problem, SAMPLES, 0)
    chosen = {name: column[:_CHOOSING] for name, column in inputs.items()}
    arithmetic = Arithmetic.from_spec(plan.target["arithmetic"])
    valid = functional.run(plan, arithmetic, chosen)["valid"]
    return certify(network(plan, parse_graph(plan.problem[UNIT_PROGRAM], "plan")), chosen, valid, wanted)


def with_bounds(plan: Plan, bounds: Mapping[str, Bound]) -> Plan:
    """Return an observed plan that states bounds, and of how many default samples they hold."""
    inputs = sampling.draw(plan.problem, SAMPLES, 0)
    valid = functional.run(plan, Arithmetic.from_spec(plan.target["arithmetic"]), inputs)["valid"]
    kept = {name: column[valid] for name, column in inputs.items()}
    net = network(plan, parse_graph(plan.problem[UNIT_PROGRAM], "plan"))
    accuracy = {}
    for name, figures in plan.accuracy.items():
        bound = bounds[name]
        share = float(inside(net, name, bound.where, kept).mean()) if valid.any() else 0.0
        accuracy[name] = {**figures, **_spec(bound, share)}
    return replace(plan, accuracy=accuracy)


def _spec(bound: Bound, share: float) -> dict[str, Any]:
    if bound.value is None:
        return {"bound": None, "bound_reason": bound.reason}
    return {
        "bound": {
            "value": bound.value,
            "where": " and ".join(p.text for p in bound.where) or EVERYWHERE,
            "conditions": [p.spec() for p in bound.where],
            "share_of_samples": share,
        }
    }


@dataclass(frozen=True, slots=True)
class StatedBounds:
    """The bounds that a plan states: by output, values and conditions under which they hold."""

    net: Network
    values: Mapping[str, float]
    conditions: Mapping[str, tuple[Predicate, ...]]

    @classmethod
    def of(cls, plan: Plan) -> StatedBounds | None:
        """Return the bounds of a plan that come with their conditions as data, None if it states none.

        Raises ValueError or LookupError for a condition that is none of the plan's operations.
        """
        bounds = {name: figures["bound"] for name, figures in plan.accuracy.items()}
        stated = {
            name: bound for name, bound in bounds.items() if bound is not None and "conditions" in bound
        }
        if not stated:
            return None
        net = network(plan, parse_graph(plan.problem[UNIT_PROGRAM], "plan"))
        conditions = {n: tuple(Predicate(**c) for c in bound["conditions"]) for n, bound in stated.items()}
        for name, wanted in conditions.items():
            possible = {step.id for step in net.upstream(name) if singular(step)}
            for condition in wanted:
                if condition.kind != OWN_BOUND and condition.operation not in possible:
                    raise ValueError(f"the bound of '{name}' has a condition on '{condition.operation}'")
        return cls(net, {name: float(bound["value"]) for name, bound in stated.items()}, conditions)

    def inside(self, inputs: Mapping[str, Floats]) -> dict[str, NDArray[np.bool_]]:
        """Return, by output with a bound, which samples meet the conditions under which it holds.

        `inputs` are samples that are valid in the equations and in the simulation, float64 of shape (n,).
        """
        count = len(next(iter(inputs.values()))) if inputs else 1
        found = {name: np.ones(count, dtype=bool) for name in self.values}
        for begin in range(0, count if any(self.conditions.values()) else 0, _BLOCK_SAMPLES):
            block = slice(begin, begin + _BLOCK_SAMPLES)
            points = {name: Boxes(inputs[name][block], inputs[name][block]) for name in self.net.inputs}
            made = forward(self.net, self.net.steps, points, {})
            for name, conditions in self.conditions.items():
                if conditions:
                    found[name][block] = meets(self.net, name, conditions, made)
        return found
