"""The Verilog of a plan in the tools that engineers run: equal to the emulator, without a warning."""

import shutil
import subprocess
from pathlib import Path

import pytest

import cordicc
from tests.support.hardware import REACH, SUMS, changed, made, needs, written
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled
from tests.support.selection import quick, slow

TEXTS = {"reach": REACH, "sums": SUMS}
FAULTS = {
    "latency": ("small_tb.v", "localparam LATENCY = ", "localparam LATENCY = 1 + "),
    "clock enable": ("small_core.v", "end else if (ce) begin", "end else begin"),
    "reset of the core": (
        "small_core.v",
        "if (rst) begin\n            valid <= ",
        "if (rst) begin\n            valid <= valid | ",
    ),
    "ready in reset": ("small_axis.v", "open <= 1'b0", "open <= 1'b1"),
    "reset of the stream": ("small_axis.v", "level <= 6'd0;", ""),
    "range": ("small_core.v", "wire x_ok_ok = (", "wire x_ok_ok = 1'b1 || ("),
    "address of RAM": ("small_core.v", "        f1_ <= f1_ram[", "        f1_ <= f1_ram[1 + "),
    "one credit too many": ("small_axis.v", "credits <= DEPTH;", "credits <= DEPTH + 1;"),
    "bypass": ("small_axis.v", "is_kept ? kept_word : read_word", "read_word"),
    "waits for tready": ("small_axis.v", "= level != ", "= m_axis_tready && level != "),
    "tlast": ("small_axis.v", "m_axis_tlast = read_last", "m_axis_tlast = 1'b0"),
    "field": ("small_axis.v", "shown[23:0]", "shown[24:1]"),
}

ASYNCHRONOUS = {"core": " or posedge arst", "axis": " or negedge aresetn"}


def plan_of(folder: Path, text: str, interval: int = 1) -> cordicc.Plan:
    (folder / "problem.yaml").write_text(text, encoding="utf-8")
    return compiled(folder / "problem.yaml", target="fixed24", ii=interval, certify=False, effort=0.05)


@pytest.fixture(scope="module")
def sums(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sums")
    return written(plan_of(folder, SUMS), folder, 100)


@needs("iverilog")
@pytest.mark.parametrize(
    ("name", "interval"), quick([(n, i) for n in TEXTS for i in (1, 3, 4)], ("sums", 3), ("sums", 1))
)
def test_the_bench_passes_under_icarus(name: str, interval: int, tmp_path: Path) -> None:
    folder = written(plan_of(tmp_path, TEXTS[name], interval), tmp_path, 60)
    count = len((folder / "vectors" / f"{folder_name(folder)}_in.hex").read_text().splitlines()) - 1
    end = made(folder, "sim")
    assert (end.stdout.splitlines()[-1], end.returncode) == (f"PASS {count} samples", 0), end.stdout


@needs("iverilog")
@pytest.mark.parametrize("name", quick(TEXTS, "reach"))
def test_iterations_one_after_the_other_pass_under_icarus(name: str, tmp_path: Path) -> None:
    (tmp_path / "problem.yaml").write_text(TEXTS[name], encoding="utf-8")
    plan = compiled(tmp_path / "problem.yaml", target="serial16", ii=250, certify=False, effort=0.05)
    (busy,) = {unit.initiation_interval for unit in plan.units if unit.kind == "standard"}
    assert busy == plan.arithmetic.caus["standard"].iterations
    folder = written(plan, tmp_path, 10)
    assert "loop1_first" in (folder / f"{folder_name(folder)}_standard1.v").read_text()
    end = made(folder, "sim")
    assert end.stdout.startswith("PASS"), end.stdout
    if shutil.which("verilator"):
        assert made(folder, "lint").stderr == ""


def folder_name(folder: Path) -> str:
    (core,) = folder.glob("*.core")
    return core.stem


@needs("iverilog")
@pytest.mark.parametrize("fault", quick(FAULTS, "latency", "one credit too many"))
def test_the_bench_tells_faults(fault: str, sums: Path, tmp_path: Path) -> None:
    folder = tmp_path / "rtl"
    shutil.copytree(sums, folder)
    changed(folder, *FAULTS[fault])
    end = made(folder, "sim")
    assert "FAIL" in end.stdout
    assert "PASS" not in end.stdout
    assert end.returncode != 0


@needs("iverilog", "verilator")
@pytest.mark.parametrize(
    ("reset", "interval"),
    quick([(r, i) for r in ("rst_n", "arst", "arst_n") for i in (1, 3)], ("arst_n", 3), ("rst_n", 1)),
)
def test_every_style_of_reset(reset: str, interval: int, tmp_path: Path) -> None:
    folder = written(plan_of(tmp_path, SUMS, interval), tmp_path, 20, reset)
    end = made(folder, "sim")
    assert (end.stdout.startswith("PASS"), end.returncode) == (True, 0), end.stdout
    end = made(folder, "lint")
    assert (end.returncode, end.stdout, end.stderr) == (0, "", "")


@needs("iverilog")
@pytest.mark.parametrize("file", ["core", "axis"])
def test_a_reset_that_waits_for_the_clock_is_not_asynchronous(file: str, tmp_path: Path) -> None:
    folder = written(plan_of(tmp_path, SUMS), tmp_path, 20, "arst")
    changed(folder, f"small_{file}.v", ASYNCHRONOUS[file], "")
    assert "FAIL reset" in made(folder, "sim").stdout


@needs("verilator")
@pytest.mark.exhaustive(reason="Verilator compiles for half a minute")
def test_asynchronous_reset_under_verilator(tmp_path: Path) -> None:
    end = made(written(plan_of(tmp_path, SUMS, 3), tmp_path, 500, "arst_n"), "verilate")
    assert (end.stdout.startswith("PASS"), end.returncode) == (True, 0), end.stdout + end.stderr


@needs("verilator")
@pytest.mark.parametrize("interval", [slow(1), slow(4)])
@pytest.mark.exhaustive(reason="Verilator compiles for half a minute")
def test_the_bench_passes_under_verilator(interval: int, tmp_path: Path) -> None:
    end = made(written(plan_of(tmp_path, REACH, interval), tmp_path, 5000), "verilate")
    last = end.stdout.splitlines()[-1].split()
    assert (last[0], end.returncode, end.stderr) == ("PASS", 0, ""), end.stdout + end.stderr
    assert int(last[1]) > 5000


@needs("verilator")
@pytest.mark.exhaustive(reason="Verilator compiles for half a minute")
def test_verilator_tells_a_fault(sums: Path, tmp_path: Path) -> None:
    folder = tmp_path / "rtl"
    shutil.copytree(sums, folder)
    changed(folder, *FAULTS["bypass"])
    end = made(folder, "verilate")
    assert "FAIL" in end.stdout
    assert end.returncode != 0


@needs("verilator")
@pytest.mark.exhaustive(reason="10^5 samples")
def test_no_sample_of_the_stream_is_lost_or_doubled(tmp_path: Path) -> None:
    """The bench waits at random on both sides, and compares every payload while it waits too."""
    folder = written(plan_of(tmp_path, SUMS, 2), tmp_path, 100_000)
    end = made(folder, "verilate")
    last = end.stdout.splitlines()[-1].split()
    assert (last[0], end.returncode) == ("PASS", 0), end.stdout + end.stderr
    assert int(last[1]) > 100_000


@needs("verilator")
@pytest.mark.parametrize("name", TEXTS)
@pytest.mark.parametrize("interval", quick([1, 4], 1))
def test_lint_has_nothing_to_say(name: str, interval: int, tmp_path: Path) -> None:
    end = made(written(plan_of(tmp_path, TEXTS[name], interval), tmp_path, 1), "lint")
    assert (end.returncode, end.stdout, end.stderr) == (0, "", "")


@needs("iverilog", "verilator")
@pytest.mark.parametrize("interval", [1, 2])
def test_a_plan_without_a_cycle(interval: int, tmp_path: Path) -> None:
    plan = plan_of(tmp_path, "inputs: {x: [0, 1]}\nequations:\n  - y = x\n", interval)
    assert plan.latency_cycles == 0
    folder = written(plan, tmp_path, 20)
    assert made(folder, "sim").returncode == 0
    end = made(folder, "lint")
    assert (end.returncode, end.stdout, end.stderr) == (0, "", "")


@needs("yosys")
@pytest.mark.parametrize("top", ["core", "axis"])
@pytest.mark.parametrize("interval", quick([1, 4], 4))
def test_yosys_has_nothing_to_say(top: str, interval: int, tmp_path: Path) -> None:
    folder = written(plan_of(tmp_path, SUMS, interval), tmp_path, 1)
    sources = " ".join(sorted(f.name for f in folder.glob("*.v") if not f.stem.endswith("_tb")))
    script = f"read_verilog {sources}; hierarchy -check -top small_{top}; proc; check -assert"
    end = subprocess.run(
        ["yosys", "-q", "-p", script], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )
    assert (end.returncode, end.stdout, end.stderr) == (0, "", "")


@needs("iverilog")
@pytest.mark.parametrize(
    "file", [slow(file) for file in sorted(EXAMPLES.glob("*.yaml"))], ids=lambda f: f.stem
)
@pytest.mark.exhaustive(reason="minutes of simulation")
def test_the_examples_pass(file: Path, tmp_path: Path) -> None:
    plan = compiled(file, target="fixed24", ii=4, certify=False, effort=0.1)
    end = made(written(plan, tmp_path, 20), "sim")
    assert end.stdout.splitlines()[-1].startswith("PASS"), end.stdout
