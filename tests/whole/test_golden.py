"""Golden texts: graphs after each pass, summaries, and the picture in the README."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from cordicc.backends.pictures import datapath
from cordicc.cli.main import main
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled
from tests.support.selection import quick

CASES = {
    "wheel_beta.imscor24": ["wheel_beta.yaml", "--units", "standard", "--target", "imscor24"],
    "wheel_beta.krieger96": ["wheel_beta.yaml", "--target", "krieger96"],
    "wheel_beta.kinematic": ["wheel_beta.yaml"],
    "planar_2r.kinematic": ["planar_2r.yaml"],
    "quadruped_leg.latency": ["quadruped_leg.yaml", "--minimize", "latency"],
    "puma560.kinematic": ["puma560.yaml"],
}


@pytest.mark.parametrize("case", quick(CASES, *list(CASES)[:4]))
def test_passes_and_summary(case: str, golden, tmp_path: Path) -> None:
    file, *options = CASES[case]
    arguments = ["compile", str(EXAMPLES / file), "-o", str(tmp_path), "--print-after", "all", *options]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0
    golden(f"{case}.txt", result.stdout.replace(str(tmp_path), "DIR"))


def test_picture_of_the_readme(golden) -> None:
    plan = compiled(EXAMPLES / "wheel_beta.yaml", target="imscor24", units="standard")
    golden("../../../docs/wheel_beta_imscor24.svg", datapath.render(plan))
