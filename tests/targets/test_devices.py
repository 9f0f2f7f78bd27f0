"""Targets that are chips: their devices, areas in look-up tables, and what may be asked for instead."""

import json
from pathlib import Path

import pytest

from cordicc.api import compile
from cordicc.base.diagnostics import InvalidInput
from cordicc.targets.device import DEVICES
from cordicc.targets.target_file import Asked, load_target, target_text
from tests.support.command_line import run
from tests.support.paths import ROOT

CHIPS = ("artix7", "ecp5", "generic", "ice40up")
PLANAR = ROOT / "examples" / "planar_2r.yaml"


@pytest.mark.parametrize("name", CHIPS)
def test_a_chip_has_a_device_and_areas_in_look_up_tables(name: str) -> None:
    target = load_target(name, 4)
    assert target.device is not None
    assert set(target.weights) == {"adder_bit", "dsp", "ram_bit"}
    area = {kind: unit.area for kind, unit in target.units.items()}
    assert area["implicit"] > area["standard"] > area["mul"] > area["add"] > 10
    assert load_target("fixed24", 4).units["standard"].area < 200  # adders of 32 bits
    bits = target.format["width"] + 4
    assert area["add"] == pytest.approx(2 * bits * target.weights["adder_bit"], abs=0.1)


def test_a_product_takes_the_blocks_of_its_words() -> None:
    with_blocks, without = load_target("ecp5", 4), load_target("generic", 4)
    assert with_blocks.units["mul"].area == 4 * with_blocks.weights["dsp"] + 2 * 28
    assert without.units["mul"].area == 13 * 28 * without.weights["adder_bit"]


def test_capacities() -> None:
    assert DEVICES["ecp5-85k"].capacity == {"lut": 83_640, "ff": 83_640, "dsp": 156, "ram_bits": 208 * 18_432}
    assert DEVICES["generic"].capacity == {}


@pytest.mark.parametrize(
    ("line", "instead", "expected"),
    [
        ("device: ecp5-85k", "device: moon", "device must be one of ecp5-85k, "),
        ("device: ecp5-85k", "device: [1]", "device must be one of ecp5-85k, "),
        ("dsp: 150", "dsp: x", "weights.dsp must be a number"),
        (", ram_bit: 0.02", "", "weights lacks 'ram_bit'"),
        ("ram_bit:", "rom_bit:", "weights has an unknown key 'rom_bit'"),
        ("weights: {adder_bit: 1.0, dsp: 150, ram_bit: 0.02}", "weights: 3", "weights must be a mapping"),
    ],
)
def test_what_a_target_may_not_say(line: str, instead: str, expected: str, tmp_path: Path) -> None:
    text = target_text("ecp5").text
    assert line in text
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(line, instead), encoding="utf-8")
    with pytest.raises(InvalidInput) as caught:
        load_target(path)
    assert expected in str(caught.value)


def test_another_width_and_clock() -> None:
    target = load_target("ecp5", 4, asked=Asked(18, 50e6))
    assert (target.format["width"], target.clock_hz) == (18, 50e6)
    assert target.units["standard"].latency < load_target("ecp5", 4).units["standard"].latency
    assert load_target("kinematic", asked=Asked(clock_hz=5e6)).clock_hz == 5e6
    with pytest.raises(InvalidInput, match="E506"):
        load_target("kinematic", asked=Asked(width_bits=18))
    with pytest.raises(InvalidInput, match="E505"):
        load_target("ecp5", asked=Asked(width_bits=500))


def test_the_command_takes_them(tmp_path: Path) -> None:
    options = ("--target", "ecp5", "--width", 16, "--clock", "40MHz", "-o", tmp_path, "--json")
    result = run("compile", PLANAR, *options)
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    assert data["clock_hz"] == 40e6
    assert (data["options"]["width"], data["options"]["clock"]) == (16, 40e6)
    assert data["formats"]["outputs"]["theta1"]["width"] == 16
    assert data["area"]["estimated"] is True
    assert 1_000 < data["area"]["lut"] < 50_000
    assert "--width 16 --clock 40000000.0" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_width_and_clock_that_cannot_be() -> None:
    refused = run("compile", PLANAR, "--width", 20)
    assert refused.exit_code == 2
    assert "error[E506]" in refused.stderr
    assert "--target fixed24, or leave out --width" in refused.stderr
    wrong = run("compile", PLANAR, "--target", "ecp5", "--clock", "5 furlongs")
    assert wrong.exit_code == 2
    assert "is not a positive number of hertz" in wrong.stderr


def test_a_plan_that_is_too_large_is_told() -> None:
    plan = compile(PLANAR, target="ice40up", width=20, certify=False)
    assert plan.estimate is not None
    assert plan.estimate.lut > 5_280
    assert any(text.startswith("W422: the plan is too large for iCE40UP5K") for text in plan.problem.warnings)


def test_a_plan_without_a_device_has_no_area() -> None:
    assert compile(PLANAR, target="fixed24", certify=False).area is None


def test_a_function_has_a_latency_of_its_own_where_no_unit_is_shared(tmp_path: Path) -> None:
    text = target_text("kinematic").text
    own = text.replace(
        "latency: 4\n    functions: [mul]", "latency: 4\n    latencies: {mul: 2}\n    functions: [mul]"
    )
    assert own != text
    (tmp_path / "own.yaml").write_text(own, encoding="utf-8")
    for interval, cycles in ((1, 2), (4, 4)):
        plan = compile(PLANAR, target=str(tmp_path / "own.yaml"), ii=interval, certify=False)
        assert {o.finish - o.start for o in plan.operations if o.kind == "mul"} == {cycles}
