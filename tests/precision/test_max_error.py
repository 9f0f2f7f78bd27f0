"""`max_error` on real problems: the certified bound meets it, for a smaller one with wider words."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from ruamel.yaml import YAML

import cordicc
from tests.support.paths import ROOT

PROBLEMS = ("tests/whole/corpus/planar_2r", "tests/whole/corpus/scara", "examples/wheel_suspension")


@cache
def planned(folder: Path, name: str, error: float) -> cordicc.Plan:
    """Compile a problem with the same `max_error` on all outputs."""
    yaml = YAML(typ="safe")
    problem = yaml.load((ROOT / f"{name}.yaml").read_text(encoding="utf-8"))
    outputs = problem["outputs"]
    details = outputs if isinstance(outputs, dict) else dict.fromkeys(outputs)
    problem["outputs"] = {each: {**(given or {}), "max_error": error} for each, given in details.items()}
    path = folder / f"{Path(name).name}.yaml"
    with path.open("w", encoding="utf-8") as file:
        yaml.dump(problem, file)
    return cordicc.compile(path, target="fixed24")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("max_error")


def width(plan: cordicc.Plan) -> int:
    """Return the bits of the widest word between operations."""
    return max(each.width for each in plan.formats.values.values())


@pytest.mark.exhaustive(reason="compiles twice; tests/certify meets a max_error with wider words quickly")
@pytest.mark.parametrize("name", PROBLEMS)
def test_bounds_meet_what_is_demanded(folder: Path, name: str) -> None:
    coarse, fine = (planned(folder, name, error) for error in (1e-4, 1e-6))
    for plan, error in ((coarse, 1e-4), (fine, 1e-6)):
        for output in plan.outputs:
            bound = plan.accuracy[output].bound
            assert bound is not None
            assert bound.value <= error
            if not bound.conditions:
                assert plan.accuracy[output].observed.max <= bound.value
    assert width(fine) > width(coarse)
