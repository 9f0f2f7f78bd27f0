"""The plans whose pictures are looked at, each made once."""

from __future__ import annotations

from functools import cache

from cordicc import pipeline
from cordicc.pipeline import Options
from cordicc.plan.model import Plan
from cordicc.schedule.request import Limits
from tests.support import hand_plans as plans
from tests.support.hard_plans import ALL
from tests.support.paths import EXAMPLES

PLANS = [f"examples/{path.stem}" for path in sorted(EXAMPLES.glob("*.yaml"))]
PLANS += ["examples/quadruped_leg --ii 8", "random, 40 units", *(f"hard/{name}" for name in ALL)]


@cache
def plan_of(name: str) -> Plan:
    """Return one of the plans, those of problem files without accuracy figures."""
    kind, _, rest = name.partition("/")
    if name == "random, 40 units":
        return plans.puma(5, caus=14, small=28)
    if kind == "hard":
        return ALL[rest]
    stem, _, interval = rest.partition(" --ii ")
    options = Options(limits=Limits(initiation_interval=int(interval or 1)))
    return pipeline.plan_file(EXAMPLES / f"{stem}.yaml", options).plan
