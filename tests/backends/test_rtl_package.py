"""The folder `rtl/` as text: files, names, headers, vectors; without a simulator."""

import csv
import json
import re
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from ruamel.yaml import YAML

import cordicc
from cordicc.base.diagnostics import InvalidInput, Unattainable
from tests.support.command_line import run
from tests.support.hardware import REACH, SUMS
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled, planned


def plan_of(folder: Path, text: str, interval: int = 1) -> cordicc.Plan:
    (folder / "problem.yaml").write_text(text, encoding="utf-8")
    return compiled(folder / "problem.yaml", target="fixed24", ii=interval, certify=False, effort=0.05)


@pytest.fixture(scope="module")
def reach(tmp_path_factory: pytest.TempPathFactory) -> cordicc.Plan:
    return plan_of(tmp_path_factory.mktemp("reach"), REACH, 3)


@pytest.fixture(scope="module")
def files(reach: cordicc.Plan) -> dict[str, str]:
    return reach.emit("verilog", 50)


def test_the_files(files: dict[str, str]) -> None:
    rest = ["Makefile", "README.md", "reach.core", "reach.sdc", "formal/prepare.ys"]
    rest += ["formal/reach_axis.sby", "formal/reach_axis_properties.v", "formal/reach_axis_proof.v"]
    rest += ["reach_axis.v", "reach_core.v", "reach_tb.v", "vectors/reach_in.hex", "vectors/reach_out.hex"]
    units = [name for name in files if name.removeprefix("rtl/") not in rest]
    assert {f"rtl/{name}" for name in rest} < set(files)
    assert units
    assert all(re.fullmatch(r"rtl/reach_[a-z]+[0-9]+\.v", name) for name in units)


def test_each_file_has_the_module_of_its_name(files: dict[str, str]) -> None:
    for name, text in files.items():
        if name.endswith(".v"):
            assert re.findall(r"^module (\w+)", text, re.MULTILINE) == [Path(name).stem]
            assert text.count("`default_nettype none") == 1


def test_headers_tell_where_a_file_comes_from(files: dict[str, str], reach: cordicc.Plan) -> None:
    for name, text in files.items():
        if name.endswith((".v", ".core", ".sdc", "Makefile")):
            head = text[:700]
            assert "cordicc compile problem.yaml --target fixed24 --ii 3" in head
            assert re.search("SHA-256 of plan.json: [0-9a-f]{64}", head)
            assert "SPDX-License-Identifier: CC0-1.0" in head
    assert files == reach.emit("verilog", 50)


def test_no_file_has_a_path_or_a_time(files: dict[str, str]) -> None:
    for text in files.values():
        assert not re.search(r"/(home|tmp|usr|root|work)\b|\.\./|\b20[0-9][0-9]-[01][0-9]", text)


def test_what_a_certificate_rests_on_is_no_parameter(files: dict[str, str]) -> None:
    assert not any(re.search(r"\bparameter\b|`ifdef", text) for text in files.values())


def test_fifos_are_ram_where_they_are_deep(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, SUMS)
    core = plan.emit("verilog", 1)["rtl/small_core.v"]
    deep = [fifo for fifo in plan.fifos if fifo.depth > 16]
    assert deep
    assert len(re.findall(r"^    reg \[[0-9]+:0\] \w+ \[0:[0-9]+\];", core, re.MULTILINE)) == len(deep)
    assert len(deep) < len(plan.fifos)


def test_every_wire_is_declared_before_it_is_used(files: dict[str, str]) -> None:
    for name in ("rtl/reach_core.v", "rtl/reach_axis.v"):
        text = re.sub(r"//.*", "", files[name])
        declared = {
            match[1]: match.start(1)
            for match in re.finditer(r"\b(?:wire|reg)\b[^;=]*?(\w+)\s*(?:[;=]|\[0:)", text)
        }
        assert len(declared) > 10
        for wire, place in declared.items():
            assert re.search(rf"\b{wire}\b", text).start() == place, wire


def test_the_core_file_for_fusesoc_names_the_files(files: dict[str, str]) -> None:
    text = files["rtl/reach.core"]
    assert text.startswith("CAPI=2:\n")
    core = YAML(typ="safe").load(text)
    assert set(core["targets"]) == {"default", "sim", "lint", "synth"}
    named = [
        n if isinstance(n, str) else next(iter(n)) for s in core["filesets"].values() for n in s["files"]
    ]
    assert all(f"rtl/{name}" in files for name in named)
    shipped = {n for n in files if n.endswith((".v", ".hex", ".sdc")) and "formal/" not in n}
    assert shipped == {f"rtl/{name}" for name in named}


def test_the_table_of_ports(files: dict[str, str], reach: cordicc.Plan) -> None:
    page = files["rtl/README.md"]
    for name in ("x", "y", "spare", "a", "r"):
        assert f"| `{name}` | 24 | Q" in page
    assert f"{reach.latency_cycles} cycles after it was taken" in page
    assert "0.2 to 0.5" in page


def words(text: str) -> list[int]:
    return [int(line, 16) for line in text.splitlines() if not line.startswith("//")]


def test_vectors_are_words_of_the_emulator(reach: cordicc.Plan) -> None:
    files = reach.emit("verilog-vectors", 300)
    base = "rtl/vectors/reach_samples"
    rows = list(csv.DictReader(StringIO(files[f"{base}.csv"])))
    about = json.loads(files[f"{base}.json"])
    assert about["samples"] == len(rows) > 300
    formats = {each["name"]: each for each in about["inputs"] + about["outputs"]}
    given = {}
    for item in reach.problem.inputs:
        column = np.array([int(row[item.name]) for row in rows])
        number = np.ldexp(column, -formats[item.name]["fraction"])
        half = 2.0 ** -formats[item.name]["fraction"] / 2
        inside = (number >= item.lo - half) & (number <= item.hi + half)
        given[item.name] = np.where(inside, np.clip(number, item.lo, item.hi), np.nan)
    found = reach.simulate(given)
    ok = np.array([row["out_ok"] == "1" for row in rows])
    assert 0 < ok.sum() < ok.size
    assert np.array_equal(found["valid"], ok)
    for name in reach.outputs:
        column = np.array([int(row[name]) for row in rows])
        assert np.array_equal(np.ldexp(column[ok], -formats[name]["fraction"]), found[name][ok])
        assert set(column[~ok]) == {formats[name]["invalid"]}
    ins, outs = words(files[f"{base}_in.hex"]), words(files[f"{base}_out.hex"])
    mask = (1 << 24) - 1
    for row, one, other in zip(rows, ins, outs, strict=True):
        assert one == sum((int(row[name]) & mask) << 24 * at for at, name in enumerate(given))
        ends = sum((int(row[name]) & mask) << 24 * at for at, name in enumerate(reach.outputs))
        assert other == ends + (int(row["out_ok"]) << 48)


def test_vectors_have_corners_and_what_is_out_of_range(reach: cordicc.Plan) -> None:
    files = reach.emit("verilog-vectors", 10)
    rows = list(csv.DictReader(StringIO(files["rtl/vectors/reach_samples.csv"])))
    about = json.loads(files["rtl/vectors/reach_samples.json"])
    for item, port in zip(reach.problem.inputs, about["inputs"], strict=True):
        column = [int(row[item.name]) for row in rows]
        numbers = np.ldexp(column, -port["fraction"])
        step = 2.0 ** -port["fraction"]
        assert port["invalid"] in column
        assert np.abs(numbers - item.lo).min() <= step
        assert np.abs(numbers - item.hi).min() <= step
        assert (numbers > item.hi + step / 2).any()


@pytest.mark.parametrize("name", ["verilog", "verilog-vectors"])
def test_floating_point_has_no_verilog(name: str, tmp_path: Path) -> None:
    with pytest.raises(Unattainable, match=r"E421.*'kinematic' are in floating point"):
        planned(EXAMPLES / "wheel_beta.yaml").emit(name)
    end = run("compile", EXAMPLES / "wheel_beta.yaml", "--emit", name, "-o", tmp_path / "out")
    assert end.exit_code == 1
    assert "--target fixed24" in end.stderr
    assert not (tmp_path / "out").exists()


def test_an_operation_without_a_circuit_is_named(tmp_path: Path) -> None:
    text = "inputs: {x: [0, 1000]}\nequations:\n  - c = cos(x)\n"
    with pytest.raises(Unattainable, match=r"E421.*rotat.*for c.*many turns"):
        plan_of(tmp_path, text).emit("verilog")


def test_the_reset_on_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(
        "inputs: {arst_n: [0, 1]}\nequations:\n  - y = arst_n + 1\n", encoding="utf-8"
    )
    out = tmp_path / "out"
    arguments = ["compile", tmp_path / "p.yaml", "--target", "fixed24", "--reset", "arst_n", "-o", out]
    end = run(*arguments)
    assert (end.exit_code, "--emit verilog" in end.stderr) == (2, True)
    assert run(*arguments, "--emit", "verilog=5").exit_code == 0
    core = (out / "rtl/p_core.v").read_text(encoding="utf-8")
    assert "--emit verilog --reset arst_n\n" in core
    assert "input  wire arst_n, " in core
    assert "signed [23:0] arst_n_," in core
    assert "always @(posedge clk or negedge arst_n)\n        if (!arst_n)" in core


def test_a_reset_that_there_is_not(reach: cordicc.Plan) -> None:
    with pytest.raises(InvalidInput, match=r"E656.*'reset_n'.*arst_n"):
        reach.emit("verilog", 1, "reset_n")


def test_operands_of_products_have_their_own_widths(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, "inputs: {x: [-1, 1], y: [0, 2]}\nequations:\n  - z = x*y\n")
    product = re.search(
        r"^ *wire signed \[47:0\] \w+ = (.*);", plan.emit("verilog", 1)["rtl/problem_mul1.v"], re.MULTILINE
    )
    assert product is not None
    assert re.fullmatch(r"\w+ \* \w+", product[1])


@pytest.mark.parametrize("form", [("--emit", "verilog-vectors", "70"), ("--emit", "verilog-vectors=70")])
def test_the_count_on_the_command_line(form: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("inputs: {x: [0, 1]}\nequations:\n  - y = x + 1\n", encoding="utf-8")
    out = tmp_path / "out"
    arguments = ["compile", tmp_path / "p.yaml", "--target", "fixed24", *form, "--emit", "verilog", "-o", out]
    assert run(*arguments).exit_code == 0
    rows = (out / "rtl/vectors/p_samples.csv").read_text(encoding="utf-8").splitlines()
    assert 70 < len(rows) < 110
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert run(*arguments).exit_code == 0
    assert before == {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    (out / "rtl/vectors/p_samples.csv").write_text("mine", encoding="utf-8")
    end = run(*arguments)
    assert end.exit_code == 2
    assert "E604" in end.stderr


@pytest.mark.parametrize("value", ["c=5", "verilog=0", "verilog=many", "verilog-vectors=", "vhdl"])
def test_a_wrong_count_or_name(value: str, tmp_path: Path) -> None:
    end = run("compile", EXAMPLES / "wheel_beta.yaml", "--emit", value, "-o", tmp_path / "out")
    assert end.exit_code == 2
    assert "--emit" in end.stderr
