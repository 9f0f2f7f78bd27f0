"""What is said of a plan's area and of the clock at which it was built, in summary and report."""

from __future__ import annotations

from collections.abc import Iterator

from cordicc.backends.labels import duration
from cordicc.plan.area import Area, PathEnd
from cordicc.plan.model import Plan

_MOST_OPERATIONS = 3
"""Of a shared unit, that are named."""


def area_text(area: Area) -> str:
    """Return the figures of an area in one line."""
    return f"{area.lut:,} LUT, {area.ff:,} FF, {area.dsp} DSP, {area.ram_bits:,} RAM bits"


def area_facts(plan: Plan) -> Iterator[tuple[str, str]]:
    """Yield names and texts of what is known of the area, and of what building showed."""
    built = plan.synthesis
    if plan.area is None:
        return
    if built is None:
        yield "area", f"{area_text(plan.area)} (estimated)"
        return
    yield "area", f"{area_text(plan.area)} (counted)"
    if plan.estimate is not None:
        yield "  estimated", area_text(plan.estimate)
    seed = "" if built.seed is None else f", seed {built.seed}"
    yield "built", f"for {built.device} by {', '.join(built.programs)}{seed}"
    if built.clock_hz is None:
        yield "  clock", "not measured: not placed and routed"
        return
    met = "met" if built.clock_hz >= plan.clock_hz else "missed"
    yield "  clock", f"{megahertz(built.clock_hz)}, {megahertz(plan.clock_hz)} of the target {met}"
    if built.slowest is not None:
        logic, wires = built.slowest.logic_seconds, built.slowest.wire_seconds
        parts = f"{duration(logic)} in logic, {duration(wires)} in wires"
        yield "  slowest path", f"{duration(logic + wires)}: {parts}"
        yield "    from", path_end(plan, built.slowest.begin)
        yield "    to", path_end(plan, built.slowest.end)


def megahertz(hertz: float) -> str:
    """Write a clock in MHz to four digits."""
    return f"{hertz / 1e6:.4g} MHz"


def path_end(plan: Plan, end: PathEnd) -> str:
    """Say where a path begins or ends: place, cycle and signal, step, and the operations it is for."""
    parts = [end.place + ("" if end.stage is None else f", cycle {end.stage}")]
    parts.append(f"{end.signal} ({end.step.rstrip('.')})" if end.step else end.signal)
    named = {operation.id: operation for operation in plan.operations}
    told = []
    for id in end.operations[:_MOST_OPERATIONS]:
        made = f" for {named[id].equation}" if id in named and named[id].equation else ""
        told.append(f"{id}{f' {named[id].mode}' if id in named else ''}{made}")
    more = len(end.operations) - len(told)
    text = "; ".join(told) + (f" and {more} more" if more > 0 else "")
    return ": ".join(parts) + (f" [{text}]" if text else "")
