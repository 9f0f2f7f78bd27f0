"""The report of nextpnr in the terms of the plan: which operation limits the clock, and in which stage.

Instances in the core have the names of the plan's units, and cells are named after the signal whose register
or logic they are, so that most names lead back to a signal of a circuit, and it to its cycle.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from cordicc.arith.circuits.circuit import Circuit
from cordicc.backends.rtl.core import Core
from cordicc.backends.synthesis.wrapper import INSTANCE
from cordicc.plan.area import PathEnd, SlowestPath
from cordicc.plan.model import Plan

_STEP = re.compile(r"(?:^|_)step([0-9]+)_")
_ROUNDING = "_rounding"


def slowest_path(
    plan: Plan, core: Core, report: Mapping[str, Any]
) -> tuple[float | None, SlowestPath | None]:
    """Return the clock in hertz that closes, and the path that limits it; None of what is not reported."""
    clocks = {name: float(found["achieved"]) for name, found in report.get("fmax", {}).items()}
    if not clocks:
        return None, None
    name = min(clocks, key=lambda each: clocks[each])
    between = f"posedge {name}"
    path = next((p["path"] for p in report["critical_paths"] if p["from"] == p["to"] == between), None)
    if not path:
        return 1e6 * clocks[name], None
    wires = sum(part["delay"] for part in path if part["type"] == "routing")
    whole = sum(part["delay"] for part in path)
    ends = (_end(plan, core, text) for text in (path[0]["from"]["cell"], path[-1]["to"]["cell"]))
    begin, end = ends
    return 1e6 * clocks[name], SlowestPath(begin, end, _seconds(whole - wires), _seconds(wires))


def _seconds(nanoseconds: float) -> float:
    return round(nanoseconds * 1e-9, 13)


def _end(plan: Plan, core: Core, cell: str) -> PathEnd:
    """Return what a cell stands for."""
    scopes = cell.split(".")
    if scopes[0] != INSTANCE or len(scopes) == 1:
        return PathEnd("registers in the place of pins", None, (), None, _plain(cell))
    if len(scopes) == 2:
        return _of_core(plan, core, scopes[1])
    instance, text = scopes[1], scopes[2]
    operations = tuple(o.id for o in plan.operations if o.unit == instance)
    if instance not in core.units:
        return PathEnd(_outside(instance), None, (), None, _plain(text))
    circuit = core.modules[core.units[instance]]
    signal, stage = _signal(circuit, text)
    return PathEnd(f"unit {instance}", instance, operations, stage, signal, _said(circuit, signal))


def _outside(instance: str) -> str:
    if instance.endswith(_ROUNDING):
        return f"the rounding of output {instance.removesuffix(_ROUNDING)}"
    return instance


def _of_core(plan: Plan, core: Core, text: str) -> PathEnd:
    """Return what a cell of the core itself stands for: a FIFO, validity, what stands before a unit."""
    fifos = {fifo.id: fifo.value for fifo in plan.fifos}
    units = {unit.id for unit in plan.units}
    for name in _beginnings(text):
        if name in fifos:
            return PathEnd(f"FIFO {name} of {fifos[name]}", None, (), None, name)
        if name in ("valid", "slot"):
            place = "the bits of what is valid" if name == "valid" else "the slots of the interval"
            return PathEnd(place, None, (), None, name)
        if name in units:
            operations = tuple(o.id for o in plan.operations if o.unit == name)
            return PathEnd(f"the operands of unit {name}", name, operations, 0, _plain(text))
        for port in (*core.inputs, *core.outputs):
            if name == port.port:
                return PathEnd(f"the port of {port.name}", None, (), None, name)
    return PathEnd("the core", None, (), None, _plain(text))


def _signal(circuit: Circuit, text: str) -> tuple[str, int | None]:
    """Return the signal of a circuit after which a cell is named, and the cycle in which it exists."""
    cycles = {port.name: circuit.latency for port in circuit.outputs}
    cycles |= {cell.name.rstrip("_"): cell.cycle or 0 for cell in circuit.cells if cell.kind != "constant"}
    found = next((name for name in _beginnings(text) if name in cycles), None)
    return (_plain(text), None) if found is None else (found, cycles[found])


def _said(circuit: Circuit, signal: str) -> str:
    """Return what is said beside the step to which a signal belongs."""
    step = _STEP.search(signal)
    if step is None:
        return ""
    return next((note for note in circuit.notes.values() if note.startswith(f"Step {step[1]}:")), "")


def _beginnings(text: str) -> list[str]:
    """Return what a name may begin with, the longest first: yosys adds what a cell is, behind `_`."""
    whole = re.split(r"[\[$]", text, maxsplit=1)[0]
    parts = whole.split("_")
    return ["_".join(parts[:count]) for count in range(len(parts), 0, -1)]


def _plain(text: str) -> str:
    """Return a name without what yosys adds to it."""
    return re.split(r"_(?=[A-Z][A-Z0-9]{2})|[\[$]", text, maxsplit=1)[0]
