"""Plans whose units take an operation every so many cycles only."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ruamel.yaml import YAML

import cordicc
from cordicc.base.diagnostics import Unattainable
from cordicc.emulate.cycle import MachineError, run
from cordicc.ir.sampling import draw
from cordicc.plan.file import dump
from cordicc.plan.verify import verify
from cordicc.targets.target_file import target_text
from tests.support.paths import EXAMPLES

BUSY = {"standard": 44, "implicit": 48, "mul": 4}


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The default target with units that are busy for as long as an operation takes."""
    data = YAML(typ="safe", pure=True).load(target_text("kinematic").text)
    for kind, cycles in BUSY.items():
        data["units"][kind]["initiation_interval"] = cycles
    path = tmp_path_factory.mktemp("target") / "iterative.yaml"
    with path.open("w") as file:
        YAML(typ="safe", pure=True).dump(data, file)
    return path


@pytest.fixture(scope="module")
def plan(target: Path) -> cordicc.Plan:
    return cordicc.compile(EXAMPLES / "planar_2r.yaml", target=str(target), ii=100, effort=0.1)


def test_one_operation_at_a_time(plan: cordicc.Plan) -> None:
    verify(plan)
    busy = {unit.kind: unit.initiation_interval for unit in plan.units}
    assert busy == {kind: BUSY.get(kind, 1) for kind in busy}
    for unit in plan.units:
        slots = [
            (operation.start + later) % 100
            for operation in plan.operations
            if operation.unit == unit.id
            for later in range(unit.initiation_interval)
        ]
        assert len(set(slots)) == len(slots)


def test_clock_by_clock(plan: cordicc.Plan) -> None:
    samples = draw(plan.problem.workspace, 20, 0)
    there, here = run(plan, plan.arithmetic, samples), plan.simulate(samples)
    for name, column in here.items():
        np.testing.assert_array_equal(there[name], column)


def test_the_machine_sees_a_unit_that_is_busy(plan: cordicc.Plan) -> None:
    units = tuple(replace(unit, initiation_interval=101) for unit in plan.units)
    with pytest.raises(MachineError, match="is busy as o"):
        run(replace(plan, units=units), plan.arithmetic, draw(plan.problem.workspace, 3, 0))


def test_verify_sees_a_unit_that_is_busy(plan: cordicc.Plan) -> None:
    shared = next(unit for unit in plan.units if len(unit.control) > 1)
    longer = replace(shared, initiation_interval=99)
    units = tuple(longer if unit is shared else unit for unit in plan.units)
    with pytest.raises(AssertionError, match=f"share slot .* of {shared.id}"):
        verify(replace(plan, units=units))


def test_the_file(plan: cordicc.Plan, tmp_path: Path) -> None:
    text = dump(plan)
    (tmp_path / "plan.json").write_text(text, encoding="utf-8")
    assert dump(cordicc.load_plan(tmp_path / "plan.json")) == text
    data = json.loads(text)
    stated = {unit["kind"]: unit.get("initiation_interval") for unit in data["units"]}
    assert stated == {kind: BUSY.get(kind) for kind in stated}


def test_an_interval_that_is_too_short(target: Path) -> None:
    with pytest.raises(Unattainable, match="is more than a unit of kind standard can take") as raised:
        cordicc.compile(EXAMPLES / "planar_2r.yaml", target=str(target), ii=40, effort=0.1)
    (found,) = raised.value.diagnostics
    assert found.code == "E406"
    assert found.hint == "the least that can be met is --ii 44"
