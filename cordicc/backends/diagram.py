"""A laid-out diagram as SVG: title, axis, wires, boxes, legend."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cordicc.backends.labels import headline, kind_rank
from cordicc.backends.layout import Layout, Wire
from cordicc.backends.shapes import Shape
from cordicc.backends.svg import INK, MUTED, RULE, Svg, fitted, number, text_width
from cordicc.plan import Plan

MARGIN = 20
LEAST_WIDTH = 720
WIRE_COLOURS = (INK, "#1f4e79", "#7a3b00", "#2d5a2d", "#6a2c70", "#5f6670")


@dataclass(frozen=True, slots=True)
class Diagram:
    """Shapes with their layout, and the labels of the axis by x."""

    shapes: Sequence[Shape]
    layout: Layout
    ticks: Mapping[int, str]


def heading(svg: Svg, plan: Plan, what: str, width: float) -> float:
    """Write title, description and key figures; return the y below them."""
    limit = width - 2 * MARGIN
    svg.text(MARGIN, 30, fitted(f"{what} of {plan.name}", 16, limit, bold=True), 16, bold=True)
    y = 48
    for text in (headline(plan), plan.description):
        if text.strip():
            svg.text(MARGIN, y, fitted(" ".join(text.split()), 11, limit), 11, fill=MUTED)
            y += 16
    return y


def kinds_used(plan: Plan, *extra: str) -> list[str]:
    """Return the kinds a legend has to explain, CAUs first."""
    kinds = {operation.kind for operation in plan.operations}
    return [*sorted(kinds, key=kind_rank), *extra]


def frame(plan: Plan, what: str, prefix: str, diagram: Diagram, axis: str = "") -> str:
    """Return the whole picture."""
    layout = diagram.layout
    svg = Svg(prefix)
    width = max(layout.width + 2 * MARGIN, LEAST_WIDTH)
    top = heading(svg, plan, what, width) + (52 if diagram.ticks else 12)
    if diagram.ticks:
        _axis(svg, diagram, axis, top)
    _wires(svg, layout.wires, top)
    for shape in diagram.shapes:
        x, y = layout.places[shape.box.id]
        shape.draw(svg, MARGIN + x, top + y)
    kinds = {shape.kind for shape in diagram.shapes}
    extra = [kind for kind in ("fifo", "input", "output") if kind in kinds]
    bottom = top + layout.height + 24
    svg.tag("path", d=f"M{MARGIN} {number(bottom)}H{number(width - MARGIN)}", stroke=RULE)
    bottom = svg.legend(MARGIN, bottom + 12, kinds_used(plan, *extra), width - 2 * MARGIN)
    return svg.document(width, bottom + 8, f"{what} of {plan.name}")


def _axis(svg: Svg, diagram: Diagram, axis: str, top: float) -> None:
    """Write the cycle at which each column starts over a light line."""
    bottom = top + diagram.layout.height + 8
    svg.text(MARGIN, top - 27, axis, 9, fill=MUTED)
    free = 0.0
    for x, label in sorted(diagram.ticks.items()):
        left = MARGIN + x
        path = f"M{left} {number(top - 10)}V{number(bottom)}"
        svg.tag("path", d=path, stroke=RULE, stroke_dasharray="2 3", fill="none")
        if left >= free:
            svg.text(left, top - 14, label, 9, fill=MUTED, bold=True)
            free = left + text_width(label, 9, bold=True) + 4


def _wires(svg: Svg, wires: Iterable[Wire], top: float) -> None:
    colours: dict[str, str] = {}
    for wire in wires:
        colour = colours.setdefault(wire.net, WIRE_COLOURS[len(colours) % len(WIRE_COLOURS)])
        path = "".join(
            f"M{MARGIN + x1} {number(top + y1)}" + (f"H{MARGIN + x2}" if y1 == y2 else f"V{number(top + y2)}")
            for (x1, y1), (x2, y2) in wire.segments
            if (x1, y1) != (x2, y2)
        )
        svg.open(wire.net, fill="none", stroke=colour, stroke_width=1.2)
        svg.tag("path", d=path)
        for x, y in wire.dots:
            svg.tag("circle", cx=MARGIN + x, cy=top + y, r=2.4, fill=colour, stroke="none")
        svg.close()
