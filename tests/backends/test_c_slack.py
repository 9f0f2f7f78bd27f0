"""The C model of operations with a slack has the emulator's bits, beside the borders of their domains too."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cordicc.arith.numbers.slack import Slack
from cordicc.ir.ops import has_border
from cordicc.targets.target_file import load_target
from tests.support.c_models import Generator, check, needs_compiler
from tests.support.selection import quick

CASES: list[tuple[str, dict[str, Any], Slack]] = [
    ("implicit", {"m": 1, "branch": "+"}, Slack(0.02, 0.01)),
    ("implicit", {"m": 1, "branch": "-"}, Slack(0.003, 0.002, relative=True)),
    ("implicit", {"m": -1, "branch": "+"}, Slack(0.02, 0.01)),
    ("implicit", {"m": -1, "branch": "-"}, Slack(0.003, 0.002, relative=True)),
    ("vector", {"m": -1, "sign": 1}, Slack(0.02)),
    ("vector", {"m": -1, "sign": -1}, Slack(0.003, relative=True)),
    ("lightcone", {}, Slack(0.02)),
    ("guard", {"condition": "nonnegative"}, Slack(0.02)),
]
TARGETS = ["kinematic", "krieger96", "fixed24"]
ALL = [(case, target) for case in CASES for target in TARGETS]


@needs_compiler
@pytest.mark.parametrize(
    ("case", "target"),
    quick(
        ALL, (CASES[0], "fixed24"), (CASES[3], "kinematic"), (CASES[6], "fixed24"), (CASES[7], "kinematic")
    ),
    ids=lambda value: value if isinstance(value, str) else "-".join([value[0], *map(str, value[1].values())]),
)
def test_same_bits(case: tuple[str, dict[str, Any], Slack], target: str, tmp_path: Path) -> None:
    op, params, slack = case
    assert has_border(op, params)
    plan = Generator(load_target(target, guard_bits=3).arithmetic, 7).plan([(op, params)], 3)
    (operation,) = plan.operations
    plan = replace(plan, operations=(replace(operation, slack=slack),))
    rng = np.random.default_rng(1)
    taken = [operand.value for operand in operation.operands]
    samples = {}
    for item in plan.problem.inputs:
        # A few numbers, near one another, so that norms and targets meet.
        few = np.round(rng.uniform(item.lo, item.hi, 1500) * 8) / 8
        samples[item.name] = np.clip(
            few + rng.choice([0.0, 0.01, -0.01, 2.0**-9], few.size), item.lo, item.hi
        )
    first = samples[str(next(value for value in taken if value))]
    for column in list(samples.values())[1:]:
        column[::3] = np.clip(
            first[::3] * rng.choice([1, -1, 0], first[::3].size), column.min(), column.max()
        )
    check(plan, samples, tmp_path)
