"""The core of a plan in Verilog: equal to the emulator in a simulator, without a warning of lint."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from cordicc.backends.rtl.core import Core, PortWord, core_of
from cordicc.backends.rtl.module_text import module_text
from tests.support.plans import compiled

REACH = """
name: reach
inputs: {x: [0.2, 0.5], y: [-0.2, 0.3]}
equations:
  - solve: x*cos(a) + y*sin(a) = (x**2 + y**2 + 0.05)/0.7
    for: a
    branch: "-"
  - r = hypot(x, y)*cos(a) + 2*x
outputs: [a, r]
"""
SAMPLES = 200

needs = {
    program: pytest.mark.skipif(shutil.which(program) is None, reason=f"{program} is not installed")
    for program in ("iverilog", "verilator")
}


def core_in(folder: Path, interval: int) -> tuple[Core, list[Path], object]:
    path = folder / "reach.yaml"
    path.write_text(REACH, encoding="utf-8")
    plan = compiled(path, target="fixed24", ii=interval, certify=False, effort=0.05)
    core = core_of(plan, ["A core."])
    texts = {f"{core.name}_core": core.text} | {n: module_text(c) for n, c in core.modules.items()}
    files = []
    for name, text in texts.items():
        files.append(folder / f"{name}.v")
        files[-1].write_text(text, encoding="ascii")
    return core, files, plan


def bench(core: Core, ins: list[np.ndarray], outs: list[np.ndarray]) -> str:
    """Return a bench that feeds words, with gaps, and compares what leaves."""

    def row(ports: tuple[PortWord, ...], columns: list[np.ndarray], at: int) -> str:
        words = [_hex(int(c[at]), p.format.width_bits) for p, c in zip(ports, columns, strict=True)]
        return f"{{{', '.join(words)}}}"

    rows = "\n".join(
        f"        given[{at}] = {row(core.inputs, ins, at)}; wanted[{at}] = {row(core.outputs, outs, at)};"
        for at in range(SAMPLES)
    )
    widths = [sum(p.format.width_bits for p in ports) for ports in (core.inputs, core.outputs)]
    wires = "".join(
        f"    wire [{p.format.width_bits - 1}:0] {p.port};\n" for p in (*core.inputs, *core.outputs)
    )
    took, made = (f"{{{', '.join(p.port for p in ports)}}}" for ports in (core.inputs, core.outputs))
    ready = "in_ready" if core.interval > 1 else "1'b1"
    ports = ["clk", "rst", "ce", "in_valid", "out_valid", "out_ok"] + ["in_ready"] * (core.interval > 1)
    wired = ", ".join(
        f".{name}({name})" for name in [*ports, *(p.port for p in (*core.inputs, *core.outputs))]
    )
    return f"""
module bench;
    reg clk = 0, rst = 1, ce = 1, in_valid = 0;
    wire in_ready, out_valid, out_ok;
{wires}    reg [{widths[0] - 1}:0] given [0:{SAMPLES}], now;
    reg [{widths[1] - 1}:0] wanted [0:{SAMPLES}];
    integer in = 0, out = 0, bad = 0, cycle = 0;
    assign {took} = now;
    {core.name}_core core ({wired});
    always #5 clk = ~clk;
    initial begin
{rows}
        #22 rst = 0;
    end
    always @(negedge clk) if (!rst && out_valid) begin
        if ({made} !== wanted[out]) begin
            bad = bad + 1;
            $display("sample %0d: %h, not %h", out, {made}, wanted[out]);
        end
        out = out + 1;
        if (out == {SAMPLES}) begin
            if (bad == 0) $display("PASS"); else $display("FAIL %0d", bad);
            $finish;
        end
    end
    always @(posedge clk) if (!rst) begin
        if (in_valid && {ready}) in = in + 1;
        cycle = cycle + 1;
        #1 in_valid = in < {SAMPLES} && (cycle % 7 != 3);
        now = given[in];
    end
endmodule
"""


def _hex(word: int, width: int) -> str:
    return f"{width}'h{word % (1 << width):x}"


@pytest.mark.parametrize("interval", [1, 3])
def test_the_core_has_the_bits_of_the_emulator(interval: int, tmp_path: Path) -> None:
    core, files, plan = core_in(tmp_path, interval)
    assert (core.interval, core.latency) == (interval, plan.latency_cycles)
    if shutil.which("iverilog") is None:
        pytest.skip("iverilog is not installed")
    random = np.random.default_rng(1)
    given = {
        item.name: random.uniform(item.lo - 0.02, item.hi + 0.02, SAMPLES) for item in plan.problem.inputs
    }
    found = plan.simulate(given)
    ok = found["valid"].astype(bool)
    assert ok.any()
    assert not ok.all()
    ins = []
    for port, item in zip(core.inputs, plan.problem.inputs, strict=True):
        column = given[port.name]
        words = port.format.encode(np.clip(column, item.lo, item.hi))
        ins.append(np.where((column < item.lo) | (column > item.hi), port.format.invalid_word, words))
    outs = [p.format.encode(np.where(ok, found[p.name], np.nan)) for p in core.outputs]
    (tmp_path / "bench.v").write_text(bench(core, ins, outs), encoding="ascii")
    subprocess.run(
        ["iverilog", "-g2005", "-o", tmp_path / "sim", tmp_path / "bench.v", *files], check=True, timeout=120
    )
    end = subprocess.run([tmp_path / "sim"], capture_output=True, text=True, check=True, timeout=300)
    assert end.stdout.startswith("PASS"), end.stdout


@needs["verilator"]
def test_lint_has_nothing_to_say(tmp_path: Path) -> None:
    core, files, _ = core_in(tmp_path, 1)
    top = f"{core.name}_core"
    end = subprocess.run(
        ["verilator", "--lint-only", "-Wall", "--top-module", top, *files],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (end.returncode, end.stderr) == (0, "")
