"""The shipped targets, and what a target file may not say."""

import pytest
from ruamel.yaml import YAML

from cordicc.base.diagnostics import InvalidInput
from cordicc.plan.origin import PlanTarget
from cordicc.targets.target import function_name
from cordicc.targets.target_file import load_target, shipped_targets, target_text
from tests.support.selection import slow


@pytest.mark.parametrize("name", shipped_targets())
def test_shipped_targets_load(name):
    target = load_target(name)
    assert target.name == name, f"{name}.yaml is of a target with another name"
    for unit in target.units.values():
        # On a chip latencies follow from circuits, which have no parts.
        assert unit.latency == sum(unit.stages.values()) or (target.device is not None and not unit.stages)
        iterative = name.startswith("serial") and unit.name == "standard"
        assert (unit.initiation_interval > 1) == iterative
    assert set(target.machine().caus) == set(target.units) & {"standard", "implicit"}
    assert PlanTarget.of(target).arithmetic.spec == target.arithmetic


@pytest.mark.parametrize(
    ("name", "cycles"), [("imscor24", 44), ("krieger96", 44), ("kinematic", 44), ("fixed24", 40)]
)
def test_stages_of_the_paper(name, cycles):
    target = load_target(name)
    assert (target.clock_hz, target.units["standard"].latency) == (10e6, cycles)


def test_implicit_units():
    assert not load_target("imscor24").has_implicit
    assert load_target("krieger96").units["implicit"].latency == 66
    assert load_target("kinematic").units["implicit"].latency == 48
    assert load_target("krieger96").machine().caus["implicit"].rule == "root-free"


def test_kinds_for_a_function():
    target = load_target("kinematic")
    assert target.kinds_for(function_name("rotate", -1)) == ("standard",)
    assert target.kinds_for(function_name("implicit", 1)) == ("implicit",)
    assert target.kinds_for("wrap") == ("add",)
    assert target.kinds_for("div") == ()


def message(path):
    with pytest.raises(InvalidInput) as caught:
        load_target(path)
    return str(caught.value)


def test_an_unknown_name_lists_the_shipped_ones():
    assert "E501" in message("nope")
    assert (
        "artix7, ecp5, fixed24, generic, ice40up, imscor24, kinematic, krieger96, serial16, serial24"
        in message("nope")
    )


def edited(tmp_path, edit):
    yaml = YAML(typ="safe", pure=True)
    data = yaml.load(target_text("kinematic").text)
    edit(data)
    path = tmp_path / "mine.yaml"
    with path.open("w") as file:
        yaml.dump(data, file)
    return path


@pytest.mark.parametrize(
    ("edit", "expected"),
    [
        (lambda d: d.update(colour=1), "the target has an unknown key 'colour'"),
        (lambda d: d.pop("clock_hz"), "the target lacks 'clock_hz'"),
        (lambda d: d.update(clock_hz=-1), "clock_hz must be a number from 1 to 1e+12"),
        (lambda d: d.update(clock_hz=float("inf")), "clock_hz must be a number from 1 to 1e+12"),
        (lambda d: d.update(clock_hz=10**400), "clock_hz must be a number from 1 to 1e+12"),
        (lambda d: d.update(clock_hz=1e-320), "clock_hz must be a number from 1 to 1e+12"),
        (lambda d: d.update(angle_unit="turn"), "angle_unit 'turn' is not supported yet"),
        (lambda d: d["units"]["mul"].update(initiation_interval=0), "must be an integer from 1 to 100000"),
        (lambda d: d["units"]["mul"].update(latency=10**400), "units.mul.latency must be an integer from 1"),
        (lambda d: d.update(name=3), "name must be text"),
        (lambda d: d.update(angle_unit="deg"), "angle_unit must be"),
        (lambda d: d.update(units=[]), "units must be a mapping"),
        (lambda d: d["units"].pop("mul"), "units lacks the kind 'mul'"),
        (lambda d: d["units"].update(gpu={}), "unknown unit kind 'gpu'"),
        (lambda d: d["units"].update(mul=3), "units.mul must be a mapping"),
        (lambda d: d["units"]["mul"].update(latency=0), "units.mul.latency must be an integer from 1"),
        (lambda d: d["units"]["mul"].update(latency=True), "units.mul.latency must be an integer from 1"),
        (lambda d: d["units"]["mul"].update(latency=5), "stages sum to 4 cycles, but the latency is 5"),
        (lambda d: d["units"]["mul"].update(functions=["sin"]), "cannot do 'sin'"),
        (lambda d: d["units"]["mul"].update(functions="mul"), "must be a list of names"),
        (lambda d: d["units"]["mul"].update(functions=[]), "functions is empty"),
        (lambda d: d["units"]["mul"].update(area="big"), "units.mul.area must be a number from 0"),
        (lambda d: d["units"]["standard"].pop("arithmetic"), "units.standard lacks 'arithmetic'"),
        (lambda d: d["units"]["implicit"]["arithmetic"].pop("rule"), "lacks the rule"),
        (
            lambda d: d["units"]["standard"]["arithmetic"].update(rule="root-free"),
            "has a rule, which implicit",
        ),
        (lambda d: d["units"]["standard"]["arithmetic"].update(mantissa_bits=99), "mantissa_bits must be"),
        (lambda d: d.update(format={"kind": "posit"}), "known: ieee-single, fixed-point"),
    ],
)
def test_a_bad_file_is_refused(tmp_path, edit, expected):
    text = message(edited(tmp_path, edit))
    assert expected in text
    assert "mine.yaml" in text


def test_all_mistakes_are_reported_together(tmp_path):
    def edit(data):
        data["colour"] = 1
        data["units"]["mul"]["area"] = -1

    assert message(edited(tmp_path, edit)).count("error[E504]") == 2


def test_mistakes_have_places(tmp_path):
    path = tmp_path / "mine.yaml"
    text = target_text("kinematic").text
    path.write_text(text.replace("clock_hz: 10000000", "clock_hz: " + "9" * 400, 1))
    line = text[: text.index("clock_hz:")].count("\n") + 1
    assert f"mine.yaml:{line}:11: error[E504]: clock_hz" in message(path)
    path.write_text(text.replace("area: 12.0", "are: 12.0", 1))
    found = message(path)
    line = text[: text.index("area: 12.0")].count("\n") + 1
    assert f"mine.yaml:{line}:10: error[E504]: units.mul has an unknown key 'are'" in found
    line = text[: text.index("  mul:")].count("\n") + 1
    assert f"mine.yaml:{line}:3: error[E504]: units.mul lacks 'area'" in found
    path.write_text("name: x\nclock_hz: [\n")
    assert "mine.yaml:3:1: error[E503]: not valid YAML" in message(path)


def test_many_mistakes_are_cut(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("".join(f"k{i}: 1\n" for i in range(2_000)))
    assert message(path).count("error[E504]") == 50


@pytest.mark.parametrize(
    "content",
    [
        *(b"a: [", b"- 1", b"", b"a: 1\na: 2", b"\xff\xfe", b"a: !!python/object:os.system x", b"*x"),
        *(b"a: b: c", b"? [1]\n: 2", b"x: 0x", b"\x00", b"units: &a {k: *a}", b"d: 2001-99-99"),
        slow(b"[" * 5000),
        b"a: " + b"x" * 300_000,
    ],
)
def test_a_file_that_is_no_target(tmp_path, content):
    path = tmp_path / "bad.yaml"
    path.write_bytes(content)
    assert "error[E50" in message(path)


def test_a_directory_is_no_target(tmp_path):
    assert "E501" in message(tmp_path)
