"""The C model of every corpus problem: free of warnings and undefined behaviour, the emulator's bits."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.c_models import SANITIZED, adversarial, check, needs_compiler
from tests.support.corpus import EFFORT_CASES, LITTLE_CASES, PROBLEMS, inputs_of, problem_path
from tests.support.plans import planned
from tests.support.selection import quick

SOME = ("planar_2r", "puma560", "four_bar", "catenary", "lorentz_boost", "stanford_arm")
CASES = [(name, "fixed24", effort) for name, effort in EFFORT_CASES]
CASES += [(name, "kinematic", 1.0) for name in PROBLEMS]
CASES += [(name, target, 1.0) for target in ("krieger96", "imscor24") for name in SOME]
QUICK = [(name, "fixed24", effort) for name, effort in LITTLE_CASES] + [("planar_2r", "kinematic", 1.0)]


@needs_compiler
@pytest.mark.parametrize(("name", "target", "effort"), quick(CASES, *QUICK))
def test_same_bits_as_the_emulator(name: str, target: str, effort: float, tmp_path: Path) -> None:
    plan = planned(problem_path(name), target=target, effort=effort)
    workspace = inputs_of(name)
    more = adversarial(plan.problem, 1000, 1)
    near = {k: np.nextafter(v, np.inf) for k, v in workspace.items() if k in more}
    samples = {k: np.concatenate([workspace[k], near[k], more[k]]) for k in more}
    check(plan, samples, tmp_path, *SANITIZED)
