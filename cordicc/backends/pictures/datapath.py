"""The datapath picture: units, FIFOs and wires, time from left to right."""

from __future__ import annotations

from cordicc.backends import labels
from cordicc.backends.pictures import wiring
from cordicc.backends.pictures.diagram import MARGIN, PAGE_WIDTH, Diagram, frame, rows
from cordicc.backends.pictures.folding import fold
from cordicc.backends.pictures.layout import compact, forced_layers
from cordicc.backends.pictures.shapes import Shape, fifo_shape, name_shape, operation_shape, output_text
from cordicc.plan.model import Plan
from cordicc.plan.netlist import Netlist

Slot = tuple[int, int]
"""A cycle and a place within it: operations without latency come before those that take time."""

_LATE = 1 << 20


_drawn: tuple[Plan, float | None, Diagram] | None = None
"""The last datapath: the page, the picture and the notebook of a plan show the same."""


def render(plan: Plan, width: float | None = PAGE_WIDTH) -> str:
    """Return the datapath as SVG, in rows of at most `width` pixels; None: in one row."""
    return frame(plan, "Datapath", "dp", _kept(plan, width))


def pieces(plan: Plan) -> list[str]:
    """Return the rows of the datapath as pictures without titles, and the legend as the last one."""
    return rows(plan, "Datapath", "dp", _kept(plan, PAGE_WIDTH))


def _kept(plan: Plan, width: float | None) -> Diagram:
    """Return the datapath; placing and wiring take long, so the last one is kept."""
    global _drawn
    last = _drawn
    if last is None or last[0] is not plan or last[1] != width:
        last = _drawn = plan, width, diagram(plan, width)
    return last[2]


def diagram(plan: Plan, width: float | None = PAGE_WIDTH) -> Diagram:
    """Return the datapath, placed and wired, in rows of at most `width` pixels; None: in one row."""
    slots = _slots(plan)
    names = sorted(set(slots.values()))
    wished = {box: names.index(slot) for box, slot in slots.items()}
    nets = wiring.nets(plan)
    arcs = [(net.source.box, sink.box) for net in nets for sink in net.sinks]
    layers = compact(forced_layers(wished, arcs))
    ticks: dict[int, int] = {}
    for box, (cycle, _) in sorted(slots.items(), key=lambda item: item[1]):
        if not box.startswith("in."):
            ticks.setdefault(cycle, layers[box])
    bands = fold(_shapes(plan, layers), nets, None if width is None else width - 2 * MARGIN)
    return Diagram(bands, {layer: str(cycle) for cycle, layer in ticks.items()}, "start cycle")


def _slots(plan: Plan) -> dict[str, Slot]:
    """Give each box its cycle.  A FIFO stands in the last column before the one it feeds."""
    slots: dict[str, Slot] = {f"in.{name}": (-1, 0) for name in plan.problem.input_names}
    instant = {op.id: op.start for op in plan.operations if op.finish <= op.start}
    starts = sorted({op.start for op in plan.operations if op.id not in instant})
    for operation in plan.operations:
        slots[f"op.{operation.id}"] = (operation.start, 0 if operation.id in instant else _LATE)
    for fifo_id, (begin, end) in Netlist.of(plan).spans.items():
        columns = [cycle for cycle in starts if begin <= cycle < end]
        slots[f"fifo.{fifo_id}"] = (columns[-1] if columns else begin, _LATE)
    for name in plan.outputs:
        slots[f"out.{name}"] = (plan.latency_cycles, 2 * _LATE)
    nets = wiring.nets(plan)
    chains = [
        (net.source.box, sink.box)
        for net in nets
        for sink in net.sinks
        if slots[net.source.box][0] == slots[sink.box][0] and slots[sink.box][1] < _LATE
    ]
    depths = forced_layers({f"op.{name}": 0 for name in instant}, chains)
    return slots | {box: (slots[box][0], depth) for box, depth in depths.items()}


def _shapes(plan: Plan, layers: dict[str, int]) -> list[Shape]:
    shapes = []
    for item in plan.problem.inputs:
        box, shown = f"in.{item.name}", labels.shown_range(item)
        tip = f"input {item.name}: {shown.lo} to {shown.hi} {shown.unit}".rstrip()
        shapes.append(name_shape(box, "input", item.name, tip, layers[box]))
    shapes += [operation_shape(item, layers[f"op.{item.id}"]) for item in plan.operations]
    shapes += [fifo_shape(item, layers[f"fifo.{item.id}"]) for item in plan.fifos]
    for name, operand in plan.outputs.items():
        text, tip = output_text(name, operand), f"output {name}: {labels.operand(operand)}"
        shapes.append(name_shape(f"out.{name}", "output", text, tip, layers[f"out.{name}"]))
    return shapes
