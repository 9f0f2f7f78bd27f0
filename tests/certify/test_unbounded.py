"""Unbounded intervals in proofs: 0 times infinity is 0, and NumPy has nothing to warn of."""

from pathlib import Path

import numpy as np
import pytest

from cordicc.certify.boxes import Boxes, times
from cordicc.pipeline import Options, compile_file
from cordicc.rewrite.accuracy_gate import root_mean_square

PROBLEM = """
inputs: {x: [-2, 2], y: [-2, 2], u: [-1, 1]}
equations:
  - r = sqrt(x**2 + y**2 + 0.1)
  - e = sqrt((u - x/r)**2 + (u - y/r)**2 + (u - 0.3/r)**2)
outputs: [e]
"""


def test_0_times_what_is_unbounded_is_0() -> None:
    size, error = np.array([0.0, np.inf, np.inf, 2.0]), np.array([np.inf, 0.0, 3.0, 0.5])
    assert times(size, error).tolist() == [0.0, 0.0, np.inf, 1.0]
    assert times(size, 0.0).tolist() == [0.0] * 4
    nothing = Boxes(np.array([-np.inf, 1.0]), np.array([np.inf, np.inf])).scaled(0.0)
    assert nothing.lo.tolist() == nothing.hi.tolist() == [0.0, 0.0]


def test_mean_squares_of_numbers_whose_squares_are_too_large() -> None:
    columns = np.array([[3e300, 0.0, 1e-300], [4e300, 0.0, 1e-300]])
    assert root_mean_square(columns) == pytest.approx([np.sqrt(12.5) * 1e300, 0.0, 1e-300])


@pytest.mark.exhaustive(reason="a proof takes seconds; that products are 0 is tried quickly")
def test_proofs_with_unbounded_margins_warn_of_nothing(tmp_path: Path) -> None:
    path = tmp_path / "problem.yaml"
    path.write_text(PROBLEM, encoding="utf-8")
    plan = compile_file(path, Options("fixed24")).plan
    assert plan.accuracy["e"].observed.max is not None
