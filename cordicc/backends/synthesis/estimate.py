"""The area of a plan, estimated without building it: bits of its circuits times what a bit takes.

The table beside this module is written by `benchmarks/units_area.py`, which builds circuits of units for each
kind of chip and fits look-up tables, flip-flops and multiplier blocks for a bit of each kind of logic.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from typing import Any

from cordicc.backends.rtl.core import Core
from cordicc.backends.rtl.slots import RING_SLOTS
from cordicc.backends.synthesis.build import core_of_plan
from cordicc.backends.synthesis.cell_bits import cell_bits, choice_luts, fifo_bits
from cordicc.backends.synthesis.deep_fifos import ram_bits
from cordicc.base.diagnostics import Unattainable
from cordicc.plan.area import Area
from cordicc.plan.model import Plan
from cordicc.plan.netlist import Netlist
from cordicc.targets.device import DEVICES, Device

TABLE = "measured_bits.json"


@cache
def measured_bits() -> dict[str, Any]:
    """Return the table: by `table_name`, per figure what a bit of each kind takes, and the error seen."""
    text = files("cordicc.backends.synthesis").joinpath(TABLE).read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def table_name(device: Device) -> str:
    """Return the name under which a device stands in the table: chips of one family and one DSP are alike."""
    dsp = "" if device.dsp_bits is None else "-{}x{}".format(*device.dsp_bits)
    return f"{device.family}{dsp}"


def estimated_area(plan: Plan) -> Area | None:
    """Return what the device of a plan's target is expected to need; None if that is not known."""
    device = DEVICES.get(plan.target.device or "")
    if device is None or table_name(device) not in measured_bits():
        return None
    try:
        core = core_of_plan(plan)
    except Unattainable:
        return None
    return area_of(_bits(plan, core, device), device)


def area_of(bits: Mapping[str, int], device: Device) -> Area:
    """Return the area of so many bits of each kind; `lut` and `ram_bits` among them count as they are."""
    table = measured_bits()[table_name(device)]
    figures = {
        figure: round(sum(bits.get(kind, 0) * each for kind, each in table[figure].items()))
        for figure in ("lut", "ff", "dsp")
    }
    luts = figures["lut"] + round(bits.get("lut", 0))
    return Area(luts, figures["ff"], figures["dsp"], bits.get("ram_bits", 0))


def _bits(plan: Plan, core: Core, device: Device) -> Counter[str]:
    count: Counter[str] = Counter()
    for module, circuit in core.modules.items():
        instances = core.text.count(f"    {module} ")
        count.update({kind: instances * much for kind, much in cell_bits(circuit, device).items()})
    for more in _around(plan, core, device):
        count.update(more)
    return count


def _around(plan: Plan, core: Core, device: Device) -> Iterator[dict[str, int]]:
    """Yield what stands around the units: FIFOs, choices of operands, ranges, validity."""
    netlist = Netlist.of(plan)
    for fifo in plan.fifos:
        if fifo.depth:
            width = plan.arithmetic.system.format(plan.formats.values.get(fifo.value)).width_bits
            yield ram_bits(width + 1, fifo.depth, device) or fifo_bits(width + 1, fifo.depth, device)
    for id, cell in netlist.cells.items():
        if cell.operations:
            ports = {port.name: core.modules[core.units[id]].cells[port.cell] for port in _inputs(core, id)}
            for name, wired in zip("abc", cell.ports, strict=False):
                if name in ports:
                    yield {"lut": choice_luts(ports[name].width, len(wired.sources), device)}
    for port in core.inputs:
        yield {"add": 2 * port.format.width_bits}
    for port in core.outputs:
        yield {"lut": port.format.width_bits}
    yield {"register": netlist.valid_depth + core.slot_bits}
    if core.interval > RING_SLOTS:
        # A digit of the counter is decoded once, and a slot is a function of few digits.
        yield {"lut": 2 * core.slot_bits}


def _inputs(core: Core, unit: str) -> Any:
    return core.modules[core.units[unit]].inputs


def relative(estimated: float, counted: float) -> float:
    """Return how far an estimate is from a count, as a part of it."""
    if counted:
        return (estimated - counted) / counted
    return math.inf if estimated else 0.0
