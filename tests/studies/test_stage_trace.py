"""Stages of an operation: the words of the emulator, and of the simulated Verilog; refusals."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.emulate.cycle import clock
from cordicc.plan.netlist import Netlist
from cordicc.studies.picked_sample import PickedSample, drawn_sample
from cordicc.studies.stage_trace import StageTrace, TracedSample
from tests.support.command_line import run
from tests.support.hardware import REACH, SUMS, needs
from tests.support.plans import compiled
from tests.support.selection import quick
from tests.support.waveforms import waves

ROOTS = """
name: roots
inputs: {x: [-0.5, 0.5], y: [0.1, 0.4]}
equations:
  - r = sqrt(x)*y
  - c = cos(r + y)*x
  - t = atan2(y, x - r)
"""
"""Operands that stand for no number where x is negative."""

TEXTS = {"reach": REACH, "sums": SUMS, "roots": ROOTS}
CASES = [("reach", 1), ("reach", 4), ("sums", 1), ("sums", 4), ("roots", 1), ("roots", 3)]
OPERATIONS = {("reach", 1): {"implicit", "add"}, ("reach", 4): {"vector", "rotate"}, ("sums", 1): {"mul"}}
"""Operations that a plan is here for."""


def plan_of(folder: Path, name: str, interval: int) -> cordicc.Plan:
    (folder / f"{name}.yaml").write_text(TEXTS[name], encoding="utf-8")
    return compiled(folder / f"{name}.yaml", target="fixed24", ii=interval, certify=False, effort=0.05)


def samples_of(plan: cordicc.Plan) -> list[PickedSample]:
    """Some in range, and one in which the first input is not."""
    some = [drawn_sample(plan.problem, number, 4, 5) for number in range(4)]
    first = plan.problem.inputs[0]
    beyond = dict(some[1].numbers) | {first.name: first.hi + 0.2}
    return [*some[:2], PickedSample(2, "those by hand", beyond), *some[2:]]


def traces(plan: cordicc.Plan, sample: PickedSample) -> list[StageTrace]:
    traced = TracedSample(plan, sample)
    return [traced.trace(operation) for operation in plan.operations]


@pytest.mark.parametrize(("name", "interval"), quick(CASES, ("reach", 4), ("roots", 1)))
def test_the_words_are_those_of_the_emulator(name: str, interval: int, tmp_path: Path) -> None:
    """Of the cycle-accurate one: operands when the operation starts, results when it ends."""
    plan = plan_of(tmp_path, name, interval)
    assert {operation.op for operation in plan.operations} >= OPERATIONS.get((name, interval), set())
    assert interval == 1 or len(plan.units) < len(plan.operations)
    netlist = Netlist.of(plan)
    seen = 0
    for sample in samples_of(plan):
        if sample.among == "those by hand":
            continue
        stream = {each: np.array([[number]]) for each, number in sample.numbers.items()}
        machine = list(clock(plan, plan.arithmetic, stream, 1, 1))
        valid = bool(plan.simulate({n: [x] for n, x in sample.numbers.items()})["valid"][0])
        for trace in traces(plan, sample):
            operation = trace.operation
            assert (trace.invalid is None) == valid
            taken = [(operation.start, each.driver) for each in netlist.operands[operation.id]]
            made = [(operation.finish, netlist.results[word.value].driver) for word in trace.results]
            words = [*trace.operands, *trace.results]
            for word, (cycle, driver) in zip(words, [*taken, *made], strict=True):
                register = machine[cycle].wires.get(driver)
                if register is None:  # the end of a FIFO without words
                    continue
                assert isinstance(register.format, FixedPoint)
                expected = int(register.words[0])
                assert word.ok == (expected != register.format.invalid_word)
                if word.ok:
                    assert (word.word, word.format) == (expected, register.format)
                    assert word.number == register.values[0]
                seen += 1
    assert seen > len(plan.operations)


@needs("iverilog")
@pytest.mark.parametrize(("name", "interval"), quick(CASES, ("reach", 4), ("roots", 1)))
def test_the_signals_are_those_of_the_verilog(name: str, interval: int, tmp_path: Path) -> None:
    """Every signal of every operation, in the core, by name and cycle; of invalid samples too."""
    plan = plan_of(tmp_path, name, interval)
    samples = samples_of(plan)
    invalid = set()
    cycles = waves(plan, [sample.numbers for sample in samples], tmp_path)
    for number, sample in enumerate(samples):
        for trace in traces(plan, sample):
            invalid.add(trace.invalid)
            scope = trace.instance.partition(".")[2]
            entered = number * interval + trace.operation.start
            wrong = [
                signal
                for signal in trace.signals
                if cycles[entered + signal.cycle][scope, signal.name] != signal.word % (1 << signal.width)
            ]
            assert wrong == [], (number, trace.operation.id)
            in_module = {found for where, found in cycles[0] if where == scope}
            named = {signal.name for signal in trace.signals} | {"clk", "ce", "unused_bits"}
            assert {each for each in in_module - named if not each.endswith("_halves")} == set()
    assert len(invalid) > 1


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("roots")
    (folder / "plan.json").write_text(plan_of(folder, "roots", 3).to_json(), encoding="utf-8")
    (folder / "in.csv").write_text("y,x\n0.2,0.3\n0.25,-0.25\n0.5,0.25\n", encoding="utf-8")
    return folder / "plan.json"


def root_of(plan_file: Path) -> str:
    plan = cordicc.load_plan(plan_file)
    return next(o.id for o in plan.operations if o.op in ("vector", "lightcone") and o.m != 1)


def test_the_forms_say_the_same(plan_file: Path, tmp_path: Path) -> None:
    asked = (
        "trace",
        plan_file.parent,
        "--operation",
        root_of(plan_file),
        "--inputs",
        plan_file.parent / "in.csv",
    )
    text, as_json, as_csv = (run(*asked, *more) for more in ((), ("--json",), ("--csv",)))
    assert text.exit_code == as_json.exit_code == as_csv.exit_code == 0
    data = json.loads(as_json.stdout)
    rows = list(csv.DictReader(io.StringIO(as_csv.stdout)))
    assert [{key: str(row[key]) for key in rows[0]} for row in data["signals"]] == rows
    lines = text.stdout.partition("Signals of the unit\n")[2].splitlines()[1:]
    shown = ["cycle", "plan_cycle", "signal", "width", "hex", "integer"]
    assert [line.split()[:6] for line in lines] == [[row[key] for key in shown] for row in rows]
    assert data["sample"]["inputs"] == {"x": 0.3, "y": 0.2}
    assert data["sample"]["valid"]
    assert "sample     0 of in.csv, valid" in text.stdout
    (result,) = data["results"]
    assert result["number"] == pytest.approx(0.3**0.5, abs=1e-6)
    assert int(result["hex"], 16) == result["integer"]
    leaving = {row["signal"]: row for row in data["signals"] if row["cycle"] == data["signals"][-1]["cycle"]}
    assert leaving[result["port"]]["integer"] == result["integer"]
    assert leaving[result["port"]]["plan_cycle"] == data["operation"]["finish"]
    for suffix, expected in ((".json", as_json), (".csv", as_csv), (".txt", text)):
        assert run(*asked, "-o", tmp_path / f"o{suffix}").stdout == ""
        assert (tmp_path / f"o{suffix}").read_text(encoding="utf-8") == expected.stdout


@pytest.mark.parametrize(
    ("row", "reason"), [(1, "operation {root} makes no number"), (2, "input y is not from 0.1 to 0.4")]
)
def test_an_invalid_sample_is_shown_and_marked(row: int, reason: str, plan_file: Path) -> None:
    root = root_of(plan_file)
    asked = (
        "trace",
        plan_file,
        "--operation",
        root,
        "--inputs",
        plan_file.parent / "in.csv",
        "--sample",
        row,
    )
    result = run(*asked)
    assert (result.exit_code, result.stderr) == (0, "")
    assert f"{row} of in.csv, invalid: {reason.format(root=root)}" in result.stdout
    data = json.loads(run(*asked, "--json").stdout)
    assert (data["sample"]["valid"], data["sample"]["invalid"]) == (False, reason.format(root=root))
    ok = {signal["signal"]: signal["integer"] for signal in data["signals"]}
    assert [ok[f"{word['port']}_ok"] for word in data["results"]] == [
        int(w["valid"]) for w in data["results"]
    ]
    assert [word["number"] for word in data["results"]] == [None] if row == 1 else [0.5]


def test_drawn_samples_are_those_of_simulate(plan_file: Path, tmp_path: Path) -> None:
    problem = cordicc.load_plan(plan_file).problem
    asked = ("trace", plan_file, "--operation", root_of(plan_file), "--json")
    plain, drawn = (run(*asked, *more) for more in ((), ("--random", "--seed", 0)))
    assert plain.stdout == drawn.stdout
    data = json.loads(run(*asked, "--random", 20, "--seed", 3, "--sample", 19).stdout)
    from cordicc.ir.sampling import draw

    expected = {name: column[19] for name, column in draw(problem.workspace, 20, 3).items()}
    assert data["sample"]["inputs"] == expected


def test_refusals(plan_file: Path, tmp_path: Path) -> None:
    root, file = root_of(plan_file), plan_file.parent / "in.csv"
    refused = run("trace", plan_file, "--operation", "o99")
    assert refused.exit_code == 2
    assert refused.stderr.startswith(
        f"{plan_file}: error[E655]: there is no operation 'o99'\n  hint: there are o1, "
    )
    refused = run("trace", plan_file, "--operation", root, "--inputs", file, "--sample", 3)
    assert refused.exit_code == 2
    assert refused.stderr == (
        f"{file}: error[E619]: there is no sample 3: the file has 3 samples\n"
        "  hint: samples count from 0, to 2\n"
    )
    refused = run("trace", plan_file, "--operation", root, "--random", 5, "--sample", 5)
    assert refused.stderr == (
        "error[E619]: there is no sample 5: only 5 samples drawn\n"
        "  hint: samples count from 0, to 4; --random N draws more\n"
    )
    (tmp_path / "none.csv").write_text("x,y\n", encoding="utf-8")
    refused = run("trace", plan_file, "--operation", root, "--inputs", tmp_path / "none.csv")
    assert refused.stderr.endswith("there is no sample 0: the file has no sample\n")
    (tmp_path / "roots.yaml").write_text(ROOTS, encoding="utf-8")
    floating = compiled(tmp_path / "roots.yaml", certify=False, effort=0.05)
    (tmp_path / "plan.json").write_text(floating.to_json(), encoding="utf-8")
    refused = run("trace", tmp_path, "--operation", floating.operations[0].id)
    assert refused.exit_code == 1
    assert refused.stderr.startswith(
        f"{tmp_path}: error[E421]: operation {floating.operations[0].id} cannot be"
    )
    assert "--target fixed24" in refused.stderr
    assert "simulate --vcd" in refused.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["PLAN"], "a PLAN is traced for one of its operations"),
        (["PLAN", "--operation", "o1", "--inputs", "in.csv", "--random"], "exclude each other"),
        (["PLAN", "--operation", "o1", "--json", "--csv"], "--json and --csv exclude each other"),
        (["PLAN", "--operation", "o1", "--x", "2"], "--x goes with a MODE, not a PLAN"),
        (["rotation", "--operation", "o1"], "--operation goes with a PLAN, not a MODE"),
        (["rotation", "--json"], "--json goes with a PLAN, not a MODE"),
        (["turning"], "'turning' is not one of 'rotation', 'vectoring', 'implicit'"),
        (["PLAN", "--operation", "o1", "-o", "PLAN"], "which this command reads"),
    ],
)
def test_options_that_do_not_go_together(arguments: list[str], message: str, plan_file: Path) -> None:
    result = run("trace", *[plan_file if each == "PLAN" else each for each in arguments])
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_mode_is_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rotation").mkdir()
    assert run("trace", "rotation", "--z", 1).exit_code == 0
    assert "E600" in run("trace", "./rotation", "--operation", "o1").stderr


def test_the_help_has_both_kinds_of_options() -> None:
    text = run("trace", "--help").stdout
    modes, _, rest = text.partition("Options of a MODE:")[2].partition("Options of a PLAN:")
    assert "--sequence" in modes
    assert "--operation" in rest
    assert rest.count("--help") == 1
