"""Checks on what a plan delivers: in compile and simulate alike, in parts, beyond limits, without a value."""

import json
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.base.diagnostics import InvalidInput
from cordicc.emulate.checking import CheckTally
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.sampling import draw
from tests.support.command_line import run
from tests.support.plans import compiled

TEXT = """\
name: angle
inputs: {x: [-1.1, 0.9]}
equations: [q = acos(x), c = cos(q)]
outputs: [q]
checks:
  e: {value: c - x, max: 2e-7, unit: m}
  u: (c - x)/sqrt(x)
"""


def written(folder: Path, text: str = TEXT) -> Path:
    path = folder / "angle.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> cordicc.Plan:
    return compiled(written(tmp_path_factory.mktemp("checking")))


def test_figures_are_those_of_high_precision(plan: cordicc.Plan) -> None:
    inputs = draw(plan.problem.workspace, 10_000, 0)
    outputs = plan.simulate(inputs)
    valid = outputs["valid"]
    words = {"x": inputs["x"][valid], "q": outputs["q"][valid]}
    exact = {n: np.abs(v) for n, v in reference_outputs(plan.problem.check_program, words)[0].items()}
    seen, missing = plan.checks["e"], plan.checks["u"]
    assert seen.observed.max == pytest.approx(exact["e"].max(), rel=1e-6)
    assert seen.observed.rms == pytest.approx(np.sqrt(np.mean(exact["e"] ** 2)), rel=1e-6)
    assert seen.worst_input == {"x": words["x"][np.argmax(exact["e"])]}
    assert (seen.undefined, missing.undefined) == (0, np.isnan(exact["u"]).sum())
    assert missing.observed.max == pytest.approx(np.nanmax(exact["u"]), rel=1e-6)


def test_values_sample_by_sample(plan: cordicc.Plan) -> None:
    inputs = {"x": [-2.0, -0.5, 0.25]}
    outputs = plan.simulate(inputs)
    found = plan.check_values(inputs)
    assert np.isnan(found["e"]).tolist() == [True, False, False]
    assert np.isnan(found["u"]).tolist() == [True, True, False]
    assert found["e"][2] == pytest.approx(np.cos(outputs["q"][2]) - 0.25, abs=1e-15)
    moved = outputs | {"q": outputs["q"] + 0.1}
    assert abs(plan.check_values(inputs, moved)["e"][2]) > 0.09
    with pytest.raises(InvalidInput, match="'q' is missing"):
        plan.check_values(inputs, {"valid": outputs["valid"]})


def test_parts_add_up(plan: cordicc.Plan) -> None:
    inputs = draw(plan.problem.workspace, 1_000, 3)
    outputs = plan.simulate(inputs)
    whole, parts = CheckTally(plan.problem), CheckTally(plan.problem)
    whole.add(inputs, outputs)
    for part in (slice(0, 1), slice(1, 700), slice(700, 700), slice(700, None)):
        parts.add({"x": inputs["x"][part]}, {name: column[part] for name, column in outputs.items()})
    for name, record in whole.found.items():
        other = parts.found[name]
        assert (other.samples, other.undefined, other.beyond) == (record.samples, record.undefined, 0)
        assert other.worst == record.worst
        assert other.figures.observed.rms == pytest.approx(record.figures.observed.rms)


def test_a_limit_refuses_the_plan(tmp_path: Path) -> None:
    path = written(tmp_path, TEXT.replace("2e-7", "1e-8"))
    refused = run("compile", path, "-o", tmp_path / "out")
    assert refused.exit_code == 1
    assert not (tmp_path / "out").exists()
    assert "error[E416]: check 'e' is" in refused.stderr
    assert "beyond its max 1e-08 m" in refused.stderr
    assert ": x = " in refused.stderr


def test_a_limit_on_what_has_no_value_refuses_the_plan(tmp_path: Path) -> None:
    text = (
        "inputs: {x: [0.1, 0.5]}\nequations: ['q = sin(x)']\n"
        "checks:\n  e: {value: sqrt(-1 - q*q), max: 1e-6}\n"
    )
    refused = run("compile", written(tmp_path, text), "-o", tmp_path / "out")
    assert refused.exit_code == 1
    assert not (tmp_path / "out").exists()
    assert "error[E416]: check 'e' has a max, and no value in any of" in refused.stderr
    without = written(tmp_path, text.replace(", max: 1e-6", ""))
    assert "warning[W420]" in run("compile", without, "-o", tmp_path / "out").stderr


def test_simulate_shows_them_and_warns(plan: cordicc.Plan, tmp_path: Path) -> None:
    data = json.loads(plan.to_json())
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(data), encoding="utf-8")
    shown = run("simulate", file, "--random", 300)
    assert "check  largest" in shown.stdout
    assert "W419" not in shown.stderr
    told = json.loads(run("simulate", file, "--json").stdout)["checks"]
    assert {n: told["e"][n] for n in data["checks"]["e"]} == data["checks"]["e"]
    assert told["e"]["beyond"] == 0
    for stated in (data["problem"]["checks"][0], data["checks"]["e"]):
        stated["max"] = 1e-7
    data["checks"]["e"]["observed"] = {"max": 1e-8, "rms": 1e-8}
    file.write_text(json.dumps(data), encoding="utf-8")
    beyond = run("simulate", file)
    assert beyond.exit_code == 0
    assert "warning[W419]: check 'e' is" in beyond.stderr
    assert "warning[W420]: check 'u' has no value in" in beyond.stderr


def test_texts_tell_of_them(plan: cordicc.Plan, tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(plan.to_json(), encoding="utf-8")
    assert "c - x: largest" in run("explain", tmp_path / "plan.json").stdout
    assert "2.000e-07 m" in plan.report()
    other = written(tmp_path, TEXT.replace("2e-7", "3e-7"))
    assert run("check", other).stdout == "angle: 1 input, 2 equations, 1 output, 2 checks, no errors\n"
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "plan.json").write_text(compiled(other).to_json(), encoding="utf-8")
    different = run("diff", tmp_path / "plan.json", tmp_path / "other")
    assert different.exit_code == 1
    assert "check e" in different.stdout
    assert "max 3e-07" in different.stdout
