"""What is known never to be negative: by the ends of ranges, which are numbers of the inputs."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.plans import compiled
from tests.support.selection import quick

ONE_SIDE = """
inputs: {x: [-1e-10, 1e6], y: [1, 2], z: [1, 2]}
equations:
  - q = atan2(y*sqrt(x**2), x*z)
  - w = x/sqrt(x**2)
  - v = atan2(y, z*x/abs(x))
  - r = sqrt(max(x, 0))*y
  - s = log(z*abs(x)*sqrt(y))
"""

CANCELLED = """
inputs: {x: [-0.5, 0.5], y: [-1, 1]}
equations:
  - w0 = y/y + y
  - w1 = w0*x
  - solve: ["9*cos(w2) + 0.5*sin(w2) = 0.1", "w1*cos(w2) + x*sin(w2) = w1 + x"]
    for: w2
outputs: [w2]
"""


def plan_of(text: str, folder: Path, target: str):
    path = folder / "problem.yaml"
    path.write_text(text, encoding="utf-8")
    return compiled(path, target=target, certify=False)


@pytest.mark.parametrize("target", quick(["kinematic", "imscor24"], "kinematic"))
def test_a_range_that_is_hardly_negative_is_negative(target: str, tmp_path: Path) -> None:
    plan = plan_of(ONE_SIDE, tmp_path, target)
    found = plan.simulate({"x": np.array([-1e-10]), "y": np.ones(1), "z": np.ones(1)})
    assert found["valid"].all()
    wanted = {"q": 3 * np.pi / 4, "w": -1.0, "v": 3 * np.pi / 4, "r": 0.0, "s": np.log(1e-10)}
    for name, value in wanted.items():
        assert found[name][0] == pytest.approx(value, abs=1e-5), name


def test_a_value_without_a_range_has_no_sign(tmp_path: Path) -> None:
    plan = plan_of(CANCELLED, tmp_path, "kinematic")
    x, y = np.array([-0.3, 0.3]), np.array([0.2, 0.2])
    w1 = (1 + y) * x
    low = 9 * x - 0.5 * w1
    wanted = np.arctan2((9 * (w1 + x) - 0.1 * w1) / low, (0.1 * x - 0.5 * (w1 + x)) / low)
    found = plan.simulate({"x": x, "y": y})
    assert found["valid"].all()
    assert np.allclose(found["w2"], wanted, atol=1e-5)
