"""The stream around a core, proven by induction: none lost, none doubled, the payload stable, whatever waits.

In place of the core stands a shift register of its latency that takes whatever comes, so that the proof is of
the wrapper as it is generated, for every payload and every behaviour of both sides.
"""

import re
import subprocess
from pathlib import Path

import pytest

from tests.support.hardware import needs
from tests.support.plans import compiled
from tests.support.selection import quick

PROBLEMS = {
    "sum": "inputs: {x: [0, 1]}\nequations:\n  - y = x + 0.5\n",
    "product": "inputs: {x: [0, 1]}\nequations:\n  - y = x*x\n",
    "both": "inputs: {x: [0, 1]}\nequations:\n  - y = x*x + 0.3*x\n",
}
FAULTS = {
    "a credit too many": ("credits <= DEPTH;", "credits <= DEPTH + 1;"),
    "no bypass": ("is_kept ? kept_word : read_word", "read_word"),
    "tlast of another sample": ("lasts[entry] <= s_axis_tlast", "lasts[tail] <= s_axis_tlast"),
    "the next word too early": ("head_now = taken ? head_next : head", "head_now = head_next"),
    "a credit lost": ("if (taken && !accepted) credits", "if (taken && !accepted && made) credits"),
}

CORE = """
module problem_core(
    input clk, input rst, input ce, input in_valid, input signed [23:0] x,
    output out_valid, output out_ok, output signed [23:0] y, output [3:0] inside
);
    reg [LATENCY-1:0] valid, payload;
    always @(posedge clk) if (rst) valid <= 0; else if (ce) valid <= {valid, in_valid};
    always @(posedge clk) if (ce) payload <= {payload, x[0]};
    assign out_valid = valid[LATENCY-1];
    assign out_ok = payload[LATENCY-1];
    assign y = {24{payload[LATENCY-1]}};
    assign inside = COUNT;
endmodule
"""
PROPERTIES = """
    reg started, waited;
    reg [25:0] payload;
    initial begin started = 0; waited = 0; end
    always @(posedge aclk) begin
        if (!aresetn) started <= 1;
        waited <= started && aresetn && m_axis_tvalid && !m_axis_tready;
        payload <= {m_axis_tlast, m_axis_tuser, m_axis_tdata};
    end
    always @* if (started) begin
        // Every place is free, or of a sample in the core, or of one in the FIFO.
        assert({4'd0, credits} + level + inside == DEPTH);
        assert(head <= LAST && tail <= LAST && entry <= LAST);
        assert(({4'd0, head} + level) % PLACES == tail);
        assert(({4'd0, tail} + inside) % PLACES == entry);
        // What is shown is the oldest word with its own tlast.
        assert(level == 0 || shown == words[head]);
        assert(level + inside == 0 || read_last == lasts[head]);
        // It stays until it is taken.
        if (waited) assert(m_axis_tvalid && payload == {m_axis_tlast, m_axis_tuser, m_axis_tdata});
        if (waited) assert(payload == {lasts[head], shown});
    end
endmodule
"""


def proven(folder: Path, problem: str, change: tuple[str, str] | None = None) -> bool:
    """Tell whether yosys proves the wrapper of a problem, with a change if there is one."""
    (folder / "problem.yaml").write_text(problem, encoding="utf-8")
    plan = compiled(folder / "problem.yaml", target="fixed24", certify=False, effort=0.05)
    text = plan.emit("verilog", 1)["rtl/problem_axis.v"]
    if change is not None:
        assert text.count(change[0]) == 1
        text = text.replace(*change)
    places = re.search(r"DEPTH = \d+'d(\d+)", text)
    assert places is not None
    latency = plan.latency_cycles
    core = CORE.replace("LATENCY", str(latency))
    core = core.replace("COUNT", " + ".join(f"valid[{at}]" for at in range(latency)))
    text = text.replace(".out_valid(made)", ".inside(inside), .out_valid(made)")
    text = text.replace("    wire made;", "    wire made;\n    wire [3:0] inside;")
    text = text.replace("endmodule", PROPERTIES.replace("PLACES", places[1]), 1)
    (folder / "proof.v").write_text(core + text, encoding="utf-8")
    script = (
        "read_verilog -formal proof.v; hierarchy -check -top problem_axis; proc; flatten; opt; "
        "memory -nomap; memory_map; opt; sat -verify -prove-asserts -tempinduct -maxsteps 4"
    )
    end = subprocess.run(
        ["yosys", "-q", "-p", script], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )
    assert end.returncode == 0 or "proof did fail" in end.stdout + end.stderr, end.stderr
    return end.returncode == 0


@needs("yosys")
@pytest.mark.parametrize("problem", quick(PROBLEMS, "sum"))
def test_the_stream_keeps_every_sample(problem: str, tmp_path: Path) -> None:
    assert proven(tmp_path, PROBLEMS[problem])


@needs("yosys")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_not_proven(fault: str, tmp_path: Path) -> None:
    assert not proven(tmp_path, PROBLEMS["sum"], FAULTS[fault])
