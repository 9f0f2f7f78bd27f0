"""Waveforms: what a VCD reader finds in them is what the plan computes, in the cycles that it says."""

from __future__ import annotations

import io
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from vcd.reader import TokenKind, tokenize

from cordicc import Plan
from cordicc.base.diagnostics import Unattainable
from cordicc.cli.main import main
from cordicc.emulate import waveform
from cordicc.ir import sampling
from cordicc.pipeline import Options, plan_file
from cordicc.schedule.request import Limits
from tests.support.paths import EXAMPLES


@cache
def compiled(name: str, target: str, interval: int = 1) -> Plan:
    options = Options(target, limits=Limits(initiation_interval=interval))
    return Plan.of(plan_file(EXAMPLES / f"{name}.yaml", options).plan)


def read(text: str) -> tuple[dict[str, Any], dict[str, list[tuple[int, Any]]], str]:
    """Return the signals by path, their changes, and the timescale."""
    scopes: list[str] = []
    paths: dict[str, str] = {}
    variables: dict[str, Any] = {}
    changes: dict[str, list[tuple[int, Any]]] = {}
    time = 0
    for token in tokenize(io.BytesIO(text.encode())):
        if token.kind is TokenKind.SCOPE:
            scopes.append(token.scope.ident)
        elif token.kind is TokenKind.UPSCOPE:
            scopes.pop()
        elif token.kind is TokenKind.VAR:
            path = ".".join([*scopes, token.var.reference])
            assert path not in variables
            paths[token.var.id_code] = path
            variables[path] = token.var
            changes[path] = []
        elif token.kind is TokenKind.CHANGE_TIME:
            time = token.time_change
        elif token.kind in (TokenKind.CHANGE_SCALAR, TokenKind.CHANGE_VECTOR, TokenKind.CHANGE_STRING):
            change = token.data
            changes[paths[change.id_code]].append((time, change.value))
    assert not scopes
    scale = re.search(r"\$timescale (.*) \$end", text)
    assert scale is not None
    return variables, changes, scale[1]


def at(changes: list[tuple[int, Any]], time: int) -> Any:
    return [value for when, value in changes if when <= time][-1]


@pytest.mark.parametrize(("name", "top"), [("planar_2r", "planar_2r"), ("wheel_beta", "wheel_beta")])
@pytest.mark.parametrize("interval", [1, 3])
@pytest.mark.parametrize("target", ["kinematic", "fixed24"])
def test_outputs_leave_with_their_words_when_they_should(
    name: str, top: str, target: str, interval: int
) -> None:
    plan = compiled(name, target, interval)
    samples = sampling.draw(plan.problem.workspace, 5, 3)
    first = next(iter(samples))
    samples[first][2] = 1e9
    machine = plan.arithmetic
    variables, changes, timescale = read(waveform.render(plan, samples))
    assert timescale == "10 ns"
    period = 10
    wanted = plan.simulate(samples)
    for step in range(5):
        time = (plan.latency_cycles + step * interval) * period
        assert at(changes[f"{top}.outputs.valid"], time) == str(int(wanted["valid"][step]))
        for output in plan.outputs:
            format_ = machine.system.format(plan.formats.outputs.get(output))
            word = at(changes[f"{top}.outputs.{output}"], time)
            assert variables[f"{top}.outputs.{output}"].size == format_.width_bits
            if wanted["valid"][step]:
                assert word == pattern(format_.encode(wanted[output][step : step + 1]), format_.width_bits)
        if interval > 1 and step < 4:
            assert at(changes[f"{top}.outputs.valid"], time + period) == "x"
    rising = [time for time, value in changes[f"{top}.clk"] if value == "1"]
    assert rising == [period * cycle for cycle in range(plan.latency_cycles + 4 * interval + 1)]


def pattern(words: np.ndarray, width: int) -> int:
    number = words.view(np.uint32)[0] if words.dtype == np.float32 else words[0]
    return int(number) & ((1 << width) - 1)


@pytest.mark.parametrize("interval", [1, 4])
def test_every_port_result_and_fifo_has_a_signal(interval: int) -> None:
    plan = compiled("planar_2r", "kinematic", interval)
    samples = sampling.draw(plan.problem.workspace, 3, 0)
    variables, changes, _ = read(waveform.render(plan, samples))
    for fifo in plan.fifos:
        path = f"planar_2r.fifos.{fifo.id}_{fifo.value.replace('.', '_')}"
        assert variables[path].size == fifo.width
        arrivals = [time for time, value in changes[f"{path}_valid"] if value == "1"]
        assert arrivals
    for unit in plan.units:
        operations = [operation for operation in plan.operations if operation.unit == unit.id]
        ports = {operation.ports for operation in operations}
        names = ports.pop() if len(ports) == 1 else [f"port_{k}" for k in range(len(unit.inputs))]
        for port in names:
            assert f"planar_2r.units.{unit.id}.{port}" in variables
            assert f"planar_2r.units.{unit.id}.{port}_valid" in variables
        if len(operations) > 1:
            shown = {value for _, value in changes[f"planar_2r.units.{unit.id}.operation"]}
            assert {operation.id for operation in operations} <= shown
            assert f"planar_2r.units.{unit.id}.select_0" in variables
    for operation in plan.operations:
        for result in filter(None, operation.results):
            found = [p for p in variables if p.startswith(f"planar_2r.units.{operation.unit}.result_")]
            assert found, result


def test_operands_enter_when_the_plan_says() -> None:
    plan = compiled("planar_2r", "fixed24")
    samples = sampling.draw(plan.problem.workspace, 1, 0)
    _, changes, _ = read(waveform.render(plan, samples))
    for operation in plan.operations:
        for port, operand in zip(operation.ports, operation.operands, strict=True):
            if operand.value is not None:
                seen = changes[f"planar_2r.units.{operation.unit}.{port}_valid"]
                assert (operation.start * 10, "1") in seen
                assert at(seen, (operation.start + 1) * 10) == "0"


def test_the_same_bytes_and_no_date() -> None:
    plan = compiled("wheel_beta", "fixed24")
    samples = sampling.draw(plan.problem.workspace, 4, 0)
    texts = {waveform.render(plan, samples) for _ in range(2)}
    assert len(texts) == 1
    assert "$date" not in texts.pop()


@pytest.mark.parametrize(
    ("clock_hz", "half", "timescale"),
    [(1e7, 5, "10 ns"), (1e8, 5, "1 ns"), (1.0, 5, "100 ms"), (3e6, 166666667, "1 fs"), (1e12, 5, "100 fs")],
)
def test_timescales(clock_hz: float, half: int, timescale: str) -> None:
    assert waveform.timing(clock_hz) == (half, timescale)


def test_a_waveform_that_would_be_too_large_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = compiled("wheel_beta", "fixed24")
    monkeypatch.setattr(waveform, "MOST_SIGNAL_CYCLES", 1000)
    with pytest.raises(Unattainable, match="E616"):
        waveform.render(plan, sampling.draw(plan.problem.workspace, 100, 0))


def test_no_samples() -> None:
    plan = compiled("wheel_beta", "fixed24")
    variables, changes, _ = read(waveform.render(plan, {"S": np.empty(0)}))
    assert variables
    assert all(len(found) <= 1 for found in changes.values())


def test_the_first_samples_are_those_that_simulate_takes(tmp_path: Path) -> None:
    problem = compiled("planar_2r", "fixed24").problem
    drawn, more = waveform.first_samples(problem, None, 50, 7, 20)
    assert more
    wanted = sampling.draw(problem.workspace, 50, 7)
    assert all(np.array_equal(drawn[name], wanted[name][:20]) for name in wanted)
    file = tmp_path / "in.csv"
    file.write_text("y,note,x\n0.1,5,0.3\n0.2,6,0.25\n", encoding="utf-8")
    read_back, more = waveform.first_samples(problem, file, 0, 0, 2)
    assert not more
    assert {name: column.tolist() for name, column in read_back.items()} == {
        "x": [0.3, 0.25],
        "y": [0.1, 0.2],
    }


def test_the_command_writes_the_first_samples_and_says_so(tmp_path: Path) -> None:
    file = tmp_path / "wave.vcd"
    problem = str(EXAMPLES / "wheel_beta.yaml")
    options = ["--random", "50", "--vcd", str(file), "--vcd-samples", "20"]
    done = CliRunner().invoke(main, ["simulate", problem, *options])
    assert done.exit_code == 0, done.output
    assert "warning[W616]: the waveform holds the first 20 samples" in done.output
    variables, _, _ = read(file.read_text(encoding="utf-8"))
    assert "wheel_beta.clk" in variables
