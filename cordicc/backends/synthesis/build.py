"""A plan through yosys, and nextpnr where there is one for the chip: area, clock and slowest path."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import gettempdir
from typing import Any

from cordicc.arith.circuits.uses import NoCircuitError
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.backends.rtl.core import Core, core_of
from cordicc.backends.rtl.module_text import module_text
from cordicc.backends.synthesis.families import FAMILIES, synthesis_command
from cordicc.backends.synthesis.programs import BuildProgram, installed, newest, run_first
from cordicc.backends.synthesis.room import too_large
from cordicc.backends.synthesis.timing import slowest_path
from cordicc.backends.synthesis.wrapper import TOP, wrapper_text
from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.base.temporaries import folder_in, locked
from cordicc.plan.area import SynthesisResult
from cordicc.plan.model import Plan
from cordicc.targets.device import Device

_COUNT, _REPORT, _NETLIST = "count.json", "report.json", "netlist.json"


def built(
    plan: Plan, device: Device, *, place: bool, seed: int, enter: Callable[[str], None]
) -> tuple[SynthesisResult, list[Diagnostic]]:
    """Return what yosys, and nextpnr if `place`, say of a plan on a device, and what there is to warn of.

    Cells of the core are counted, not those of the registers around it that stand for pins.

    Args:
        plan: a plan on fixed point.
        device: the chip.
        place: also place and route, where there is a program for that and the plan fits.
        seed: of placing.
        enter: called with what is about to be done.

    Raises:
        InvalidInput: a program is not installed (E660).
        Unattainable: the plan has no Verilog (E421), or a program fails (E422).
    """
    core = core_of_plan(plan)
    family = FAMILIES[device.family]
    several = installed("yosys")
    router = newest(family.router) if place and family.router else None
    with ExitStack() as stack:
        parent = Path(gettempdir())
        with locked(parent):
            folder = stack.enter_context(folder_in(parent))
        yosys, count = _counted(several, core, device, folder, netlist=router is not None, enter=enter)
        area = family.area(count)
        warnings = too_large(area, device)
        if router is None or warnings:
            return SynthesisResult(device.name, (str(yosys),), None, area, None, None), warnings
        enter(f"{router} places and routes")
        report = _routed(router, device, folder, plan.clock_hz, seed)
    hertz, path = slowest_path(plan, core, report)
    return SynthesisResult(device.name, (str(yosys), str(router)), seed, area, hertz, path), warnings


def core_of_plan(plan: Plan) -> Core:
    """Return the core of a plan; raises Unattainable (E421) for one that has no Verilog."""
    reason = "its words are not fixed point"
    if isinstance(plan.arithmetic.system, FixedSystem):
        try:
            return core_of(plan, ())
        except (NoCircuitError, ValueError) as error:
            reason = str(error)
    message = f"there is no Verilog of this plan: {reason}"
    raise Unattainable([Diagnostic("E421", message, hint="compile it for a fixed-point target")])


def _counted(
    several: Sequence[BuildProgram],
    core: Core,
    device: Device,
    folder: Path,
    *,
    netlist: bool,
    enter: Callable[[str], None],
) -> tuple[BuildProgram, Mapping[str, int]]:
    """Return the yosys that did it and the cells of a core by type; leave a netlist with a wrapper if wanted.

    The next of several is tried where one fails: as WebAssembly it has a small stack, which deep logic fills.
    """
    texts = {f"{core.name}_core": core.text} | {n: module_text(c) for n, c in core.modules.items()}
    for name, text in texts.items():
        (folder / f"{name}.v").write_text(text, encoding="ascii")
    script = [
        *(f"read_verilog {name}.v" for name in texts),
        synthesis_command(device, f"{core.name}_core"),
        f"tee -q -o {_COUNT} stat -json",
    ]
    if netlist:
        (folder / "wrapper.v").write_text(wrapper_text(core), encoding="ascii")
        around = ["read_verilog wrapper.v", synthesis_command(device, TOP), "design -stash around"]
        joined = [f"design -copy-from around -as {TOP} {TOP}", f"hierarchy -top {TOP}", "flatten", "clean"]
        script = [*around, *script, *joined, f"write_json {_NETLIST}"]
    (folder / "run.ys").write_text("\n".join(script) + "\n", encoding="ascii")
    yosys = run_first(
        several, ["-s", "run.ys"], folder, lambda each: enter(f"{each} makes cells of {device.name}")
    )
    return yosys, _read(folder / _COUNT)["design"]["num_cells_by_type"]


def _routed(
    router: BuildProgram, device: Device, folder: Path, clock_hz: float, seed: int
) -> Mapping[str, Any]:
    """Return the report of the router."""
    family = FAMILIES[device.family]
    arguments = [*family.options[device.name], "--json", _NETLIST, "--report", _REPORT]
    arguments += ["--freq", f"{clock_hz / 1e6:.6g}", "--seed", str(seed), "--timing-allow-fail"]
    arguments += [family.free_pins]
    router.run(arguments, folder)
    report: Mapping[str, Any] = _read(folder / _REPORT)
    return report


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8", errors="replace"))
