"""The core of a plan in Icarus Verilog, with every signal as it is in every cycle of a sample."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from vcd.reader import TokenKind, tokenize

from cordicc.backends.rtl.module_text import module_text
from cordicc.backends.rtl.package import core_in_verilog
from cordicc.backends.rtl.reset_style import USUAL_RESET
from cordicc.plan.model import Plan

Wave = Mapping[tuple[str, str], int | str]
"""By scope and name, the bits of a signal; a text where some are unknown."""


def waves(plan: Plan, samples: Sequence[Mapping[str, float]], folder: Path) -> list[Wave]:
    """Return the signals by cycle of a core that takes a sample in each interval, the first in cycle 0."""
    core = core_in_verilog(plan, USUAL_RESET)
    texts = {core.name: core.text} | {name: module_text(circuit) for name, circuit in core.modules.items()}
    cycles = core.interval * len(samples) + core.latency + 1
    lines = [
        "module bench;",
        "reg clk = 0, rst = 1; integer t;  // unknown at first: what hangs on it is evaluated once it is not",
        "always #5 clk = ~clk;",
        # In reset it is the last slot of the interval.
        f"always @(posedge clk) if (rst) t <= {-1 if core.interval > 1 else 0}; else t <= t + 1;",
        f"initial begin $dumpfile({str(folder / 'wave.vcd')!r});".replace("'", '"'),
        f"$dumpvars(0, bench); #12 rst = 0; #{10 * cycles + 20} $finish; end",
    ]
    for port in core.inputs:
        words = [int(port.format.encode(np.array([sample[port.name]]))[0]) for sample in samples]
        chosen = "".join(
            f"t / {core.interval} == {k} ? {port.width}'h{word & ((1 << port.width) - 1):x} : "
            for k, word in enumerate(words)
        )
        lines.append(f"wire [{port.width - 1}:0] in_{port.port} = {chosen}{port.width}'d0;")
    wired = [".clk(clk)", ".rst(rst)", ".ce(1'b1)", ".in_valid(1'b1)"]
    wired += [f".{port.port}(in_{port.port})" for port in core.inputs]
    lines += [f"{core.name}_core dut ({', '.join(wired)});", "endmodule"]
    texts["bench"] = "\n".join(lines) + "\n"
    files = []
    for name, text in texts.items():
        files.append(folder / f"{name}.v")
        files[-1].write_text(text, encoding="utf-8")
    made = folder / "bench.vvp"
    for command in (["iverilog", "-g2005", "-s", "bench", "-o", made, *files], ["vvp", "-n", made]):
        subprocess.run(command, check=True, capture_output=True, timeout=300)
    return _by_cycle(folder / "wave.vcd", cycles)


def _by_cycle(file: Path, cycles: int) -> list[Wave]:
    """Return what stands at the end of each cycle."""
    names: dict[str, list[tuple[str, str]]] = {}
    state: dict[tuple[str, str], int | str] = {}
    found: dict[int, Wave] = {}
    scopes: list[str] = []
    with file.open("rb") as stream:
        for token in tokenize(stream):
            match token.kind:
                case TokenKind.SCOPE:
                    scopes.append(token.scope.ident)
                case TokenKind.UPSCOPE:
                    scopes.pop()
                case TokenKind.VAR:
                    names.setdefault(token.var.id_code, []).append((scopes[-1], token.var.reference))
                case TokenKind.CHANGE_TIME:
                    now = state.get(("bench", "t"))
                    if isinstance(now, int) and state[("bench", "rst")] == 0:
                        found[now] = dict(state)
                case TokenKind.CHANGE_SCALAR:
                    change = token.scalar_change
                    bit = int(change.value) if change.value in "01" else change.value
                    state |= dict.fromkeys(names[change.id_code], bit)
                case TokenKind.CHANGE_VECTOR:
                    state |= dict.fromkeys(names[token.vector_change.id_code], token.vector_change.value)
    return [found[cycle] for cycle in range(cycles)]
