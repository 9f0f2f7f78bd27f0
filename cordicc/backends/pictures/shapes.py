"""The boxes of the datapath and graph pictures: their sizes, ports and drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

from cordicc.backends.labels import constant, cycles, fifo_tip, operation_tip, symbol
from cordicc.backends.labels import mode as mode_of
from cordicc.backends.palette import INK, MUTED, look_of
from cordicc.backends.pictures.layout import Box
from cordicc.backends.pictures.routing import GRID
from cordicc.backends.pictures.svg import Svg, fitted, text_width, wrapped
from cordicc.backends.pictures.wiring import live_inputs
from cordicc.ir.ops import OPS
from cordicc.plan.model import Fifo, Operand, Operation
from cordicc.targets.target import CAU_KINDS

ROW = 2 * GRID
CAU_TEXT = 150
SMALL_TEXT = 128
NAME_TEXT = 140
MARKED = ("sub", "flip", "guard", "select")


@dataclass(frozen=True, slots=True)
class Line:
    """A line of text, relative to the box's corner."""

    x: float
    y: float
    text: str
    size: float
    anchor: str = "start"
    bold: bool = False
    fill: str = INK


@dataclass(frozen=True, slots=True)
class Shape:
    """A box with its kind, texts and tooltip.

    A label that stands for a box of another row has that as its `source`, and names the boxes that it
    leads to.
    """

    box: Box
    kind: str
    lines: tuple[Line, ...]
    tip: str
    source: str = ""
    leads_to: tuple[str, ...] = ()

    def draw(self, svg: Svg, x: float, y: float) -> None:
        """Draw the shape with its corner at (x, y)."""
        if self.source:
            svg.open(self.tip, data_from=self.source, data_to=" ".join(self.leads_to))
        else:
            svg.open(self.tip, data_id=self.box.id)
        if self.kind == "fifo":
            svg.stripes(x, y, self.box.width, self.box.height)
        else:
            svg.box(x, y, self.box.width, self.box.height, look_of(self.kind))
        for line in self.lines:
            svg.text(
                x + line.x,
                y + line.y,
                line.text,
                line.size,
                anchor=line.anchor,
                bold=line.bold,
                fill=line.fill,
            )
        svg.close()


def operation_shape(operation: Operation, layer: int) -> Shape:
    """Return the box of an operation: large with labelled ports for a CAU, a symbol otherwise."""
    return _cau(operation, layer) if operation.kind in CAU_KINDS else _small(operation, layer)


def _whole(value: float) -> int:
    return GRID * ceil(value / GRID)


def _cau(operation: Operation, layer: int) -> Shape:
    heading = fitted(
        " · ".join(part for part in (operation.unit, operation.id, operation.equation) if part),
        11,
        CAU_TEXT,
        bold=True,
    )
    mode = wrapped(mode_of(operation), 10, CAU_TEXT, 3)
    left = [_port(port, item) for port, item in zip(operation.ports, operation.operands, strict=False)]
    right = [
        fitted(name, 10, CAU_TEXT / 2) + ("" if operation.results[index] else " (unused)")
        for index, name in enumerate(OPS[operation.op].results)
    ]
    head = _whole(20 + 13 * len(mode))
    rows = max(len(left), len(right))
    sides = [text_width(a, 10) for a in left or [""]], [text_width(b, 10) for b in right or [""]]
    texts = [text_width(heading, 11, bold=True), *(text_width(line, 10) for line in mode)]
    width = _whole(max(max(sides[0]) + max(sides[1]) + 30, max(texts) + 16))
    ports = [head + GRID + ROW * row for row in range(rows)]
    lines = [Line(width / 2, 15, heading, 11, "middle", bold=True)]
    lines += [Line(width / 2, 28 + 13 * row, text, 10, "middle") for row, text in enumerate(mode)]
    lines += [Line(6, ports[row] + 3.5, text, 10) for row, text in enumerate(left)]
    lines += [Line(width - 6, ports[row] + 3.5, text, 10, "end") for row, text in enumerate(right)]
    height = head + ROW * rows + ROW
    lines.append(Line(width / 2, height - 7, cycles(operation), 9, "middle", fill=MUTED))
    live = [port for port, item in zip(ports, operation.operands, strict=False) if item.value is not None]
    box = Box(f"op.{operation.id}", layer, width, height, tuple(live), tuple(ports[: len(right)]))
    return Shape(box, operation.kind, tuple(lines), operation_tip(operation))


def _port(port: str, item: Operand) -> str:
    label = port if item.constant is None else f"{port} = {constant(item.constant)}"
    return fitted(label, 10, CAU_TEXT / 2)


def _small(operation: Operation, layer: int) -> Shape:
    live = live_inputs(operation)
    tiny = operation.kind == "sign"
    sign = "a − b" if operation.op == "sub" and len(live) == 2 else symbol(operation)
    size = 9.0 if tiny else 12.0
    sign = fitted(sign, size, SMALL_TEXT)
    marks = [port if operation.op in MARKED and len(live) > 1 else "" for port, _ in live]
    marks = [fitted(mark, 8, 30) for mark in marks]
    margin = max([text_width(mark, 8) for mark in marks] or [0]) + (10 if any(marks) else 6)
    name = "" if tiny else fitted(operation.id, 8, SMALL_TEXT)
    text = max(text_width(sign, size), text_width(name, 8))
    width = _whole(max(text + margin + 6, 24 if tiny else 40))
    height = max(ROW * len(live), ROW if tiny else 2 * ROW)
    ports = [height // 2] if len(live) == 1 else [GRID + ROW * row for row in range(len(live))]
    output = GRID * (height // 2 // GRID)
    centre = margin + (width - 6 - margin) / 2
    base = height / 2 + 3 if tiny else height / 2
    lines = [Line(centre, base, sign, size, "middle", bold=not tiny)]
    if name:
        lines.append(Line(centre, height / 2 + 11, name, 8, "middle", fill=MUTED))
    lines += [Line(4, port + 3, mark, 8, fill=MUTED) for port, mark in zip(ports, marks, strict=True) if mark]
    outputs = tuple(output for _ in operation.results)
    box = Box(f"op.{operation.id}", layer, width, height, tuple(ports), outputs)
    return Shape(box, operation.kind, tuple(lines), operation_tip(operation))


def fifo_shape(fifo: Fifo, layer: int) -> Shape:
    """Return the striped box of a FIFO with its depth."""
    text = str(fifo.depth)
    width = _whole(text_width(text, 10) + 24)
    line = Line(width / 2, 12, text, 10, "middle")
    return Shape(Box(f"fifo.{fifo.id}", layer, width, ROW, (GRID,), (GRID,)), "fifo", (line,), fifo_tip(fifo))


def name_shape(box_id: str, kind: str, text: str, tip: str, layer: int) -> Shape:
    """Return the box of an input or output."""
    label = fitted(text, 11, NAME_TEXT, bold=True)
    width = _whole(text_width(label, 11, bold=True) + 12)
    line = Line(width / 2, 12, label, 11, "middle", bold=True)
    ports: Sequence[int] = (GRID,)
    inputs, outputs = (tuple(ports), ()) if kind == "output" else ((), tuple(ports))
    return Shape(Box(box_id, layer, width, ROW, inputs, outputs), kind, (line,), tip)


def link_shape(box_id: str, name: str, source: Shape, leads_to: tuple[str, ...], layer: int) -> Shape:
    """Return the label at which a wire to or from another row ends; that of an input looks like one."""
    if source.kind == "input":
        shape = name_shape(box_id, "input", name, source.tip, layer)
        return replace(shape, source=source.box.id, leads_to=leads_to)
    text = fitted(name.removesuffix(".value"), 9, NAME_TEXT)
    width = _whole(text_width(text, 9) + 10)
    ends = ((), (GRID,)) if box_id.startswith("from.") else ((GRID,), ())
    line = Line(width / 2, 11.5, text, 9, "middle", fill=MUTED)
    where = "from" if box_id.startswith("from.") else "to"
    tip = f"{name}, {where} another row"
    return Shape(Box(box_id, layer, width, ROW, *ends), "link", (line,), tip, source.box.id, leads_to)


def output_text(name: str, item: Operand) -> str:
    """Return an output's label, with its value if that is constant."""
    return name if item.constant is None else f"{name} = {constant(item.constant)}"
