"""The bounds of a plan: proven for it, written into it, and judged on samples."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.machine import Arithmetic
from cordicc.certify.certificate import Bound, certify
from cordicc.certify.network import network
from cordicc.certify.predicates import Predicate, inside
from cordicc.emulate import functional, sampling
from cordicc.ir.text import parse_graph
from cordicc.plan import Plan
from cordicc.record import UNIT_PROGRAM

SAMPLES = 10_000
"""Of which the plan states the share that is inside, with seed 0; thresholds follow from the first ones."""

_CHOOSING = 2_000

EVERYWHERE = "every valid sample"

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Judged:
    """An output's bound on samples: the share inside, and how many of those inside are beyond the bound."""

    share: float
    beyond: int


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


def inside_bounds(plan: Plan, inputs: Mapping[str, Floats]) -> dict[str, NDArray[np.bool_]]:
    """Return, by output with a bound, the samples that meet the conditions under which it holds.

    Args:
        plan: with bounds.
        inputs: float64 of shape (n,) by input, within the ranges.
    """
    stated = {n: figures["bound"] for n, figures in plan.accuracy.items() if figures["bound"] is not None}
    if not stated:
        return {}
    net = network(plan, parse_graph(plan.problem[UNIT_PROGRAM], "plan"))
    return {
        name: inside(net, name, tuple(Predicate(**condition) for condition in bound["conditions"]), inputs)
        for name, bound in stated.items()
    }


def judged(
    plan: Plan, inputs: Mapping[str, Floats], errors: Mapping[str, Floats], valid: NDArray[np.bool_]
) -> dict[str, Judged]:
    """Return how a plan's bounds fare on samples.

    Args:
        plan: with bounds.
        inputs: float64 of shape (n,) by input.
        errors: by output, |simulated - exact|, of angles modulo 2 pi.
        valid: samples valid in the equations and in the simulation; only these count.
    """
    found = {}
    kept = {name: column[valid] for name, column in inputs.items()}
    for name, held in inside_bounds(plan, kept).items():
        beyond = held & (errors[name][valid] > plan.accuracy[name]["bound"]["value"])
        found[name] = Judged(float(held.mean()) if held.size else 0.0, int(beyond.sum()))
    return found
