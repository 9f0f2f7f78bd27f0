"""What is said of a `max_error` that is not proven for all samples."""

from pathlib import Path

import pytest

from cordicc.pipeline import Options, compile_file
from tests.support.selection import slow

LEG = """
inputs: {x: [0.02, 0.2], y: [0.02, 0.2]}
equations:
  - q = acos((x**2 + y**2 - 0.0325)/0.03)
outputs: {q: {max_error: %s}}
"""


@pytest.mark.parametrize(("error", "warned"), [("1e-5", True), slow(("3", False))])
def test_exceptions_are_told(tmp_path: Path, error: str, warned: bool) -> None:
    """Near the stretched and the folded leg the angle moves far with small errors."""
    (tmp_path / "p.yaml").write_text(LEG % error, encoding="utf-8")
    compiled = compile_file(tmp_path / "p.yaml", Options("fixed24", effort=0.1))
    found = [w for w in compiled.warnings if w.code == "W417"]
    share = compiled.plan.accuracy["q"].bound.share_of_samples
    assert bool(found) == (share < 1) == warned
    for warning in found:
        assert "max_error 1e-05 of 'q' is proven for 99" in warning.message
        assert f"W417: {warning.message}" in compiled.plan.problem.warnings
