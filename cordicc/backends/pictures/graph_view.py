"""The dataflow graph of a plan: operations by data dependence, without time or FIFOs."""

from __future__ import annotations

from dataclasses import replace

from cordicc.backends import labels
from cordicc.backends.pictures import wiring
from cordicc.backends.pictures.diagram import MARGIN, PAGE_WIDTH, Diagram, frame
from cordicc.backends.pictures.folding import fold
from cordicc.backends.pictures.layout import Net, compact, forced_layers
from cordicc.backends.pictures.shapes import Shape, name_shape, operation_shape, output_text
from cordicc.plan.model import Plan


def render(plan: Plan, width: float | None = PAGE_WIDTH) -> str:
    """Return the graph as SVG, folded into rows of at most `width` pixels; None: in one row."""
    return frame(plan, "Dataflow graph", "gr", diagram(plan, width))


def diagram(plan: Plan, width: float | None) -> Diagram:
    """Return the graph, placed and wired."""
    nets = wiring.nets(plan, with_fifos=False)
    arcs = [(net.source.box, sink.box) for net in nets for sink in net.sinks]
    names = [f"in.{name}" for name in plan.problem.input_names]
    names += [f"op.{operation.id}" for operation in plan.operations]
    names += [f"out.{name}" for name in plan.outputs]
    layers = compact(_late_inputs(forced_layers(dict.fromkeys(names, 0), arcs), nets))
    last = max(layers.values(), default=0)
    layers |= {f"out.{name}": max(last, 1) for name in plan.outputs}
    return Diagram(fold(_shapes(plan, layers), nets, None if width is None else width - 2 * MARGIN), {})


def _late_inputs(layers: dict[str, int], nets: list[Net]) -> dict[str, int]:
    """Move each input to just before its first use, so that wires stay short."""
    moved = dict(layers)
    for net in nets:
        if net.source.box.startswith("in."):
            moved[net.source.box] = max(min(layers[sink.box] for sink in net.sinks) - 1, 0)
    return moved


def _shapes(plan: Plan, layers: dict[str, int]) -> list[Shape]:
    shapes = [
        name_shape(f"in.{name}", "input", name, f"input {name}", layers[f"in.{name}"])
        for name in plan.problem.input_names
    ]
    for operation in plan.operations:
        shape = operation_shape(operation, layers[f"op.{operation.id}"])
        untimed = tuple(line for line in shape.lines if line.text != labels.cycles(operation))
        shapes.append(replace(shape, lines=untimed))
    for name, operand in plan.outputs.items():
        text, tip = output_text(name, operand), f"output {name}: {labels.operand(operand)}"
        shapes.append(name_shape(f"out.{name}", "output", text, tip, layers[f"out.{name}"]))
    return shapes
