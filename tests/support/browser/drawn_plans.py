"""The plans whose pictures are looked at."""

from __future__ import annotations

from cordicc.plan.model import Plan
from tests.support import hand_plans as plans
from tests.support.hard_plans import ALL
from tests.support.paths import EXAMPLES
from tests.support.plans import planned

PLANS = [f"examples/{path.stem}" for path in sorted(EXAMPLES.glob("*.yaml"))]
PLANS += ["examples/quadruped_leg --ii 8", "random, 40 units", *(f"hard/{name}" for name in ALL)]


def plan_of(name: str) -> Plan:
    """Return one of the plans, those of problem files without accuracy figures."""
    kind, _, rest = name.partition("/")
    if name == "random, 40 units":
        return plans.puma(5, caus=14, small=28)
    if kind == "hard":
        return ALL[rest]
    stem, _, interval = rest.partition(" --ii ")
    return planned(EXAMPLES / f"{stem}.yaml", ii=int(interval or 1))
