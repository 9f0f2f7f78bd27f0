"""What is pi in the equations, by a sum or a multiple of rounded angles, is delivered as pi."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.plans import compiled
from tests.support.selection import quick


@pytest.mark.parametrize("target", quick(["kinematic", "imscor24", "krieger96", "fixed24"], "kinematic"))
@pytest.mark.parametrize(
    ("equations", "x"), [("w = 2*asin(x)", 1), ("w = acos(x), v = asin(x)", -1), ("w = 4*atan(x)", 1)]
)
def test_pi_is_not_its_negative(equations: str, x: float, target: str, tmp_path: Path) -> None:
    path = tmp_path / "problem.yaml"
    path.write_text(f"inputs: {{x: [-1, 1]}}\nequations: [{equations}]\n", encoding="utf-8")
    angle = compiled(path, target=target).simulate({"x": np.array([x])})["w"][0]
    assert 3.141592 < angle <= np.pi
