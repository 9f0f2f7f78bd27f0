"""A laid-out diagram as SVG: title, axis, wires, boxes, legend; one row below the other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from cordicc.backends.labels import headline, kind_rank
from cordicc.backends.palette import MUTED, RULE, WIRES
from cordicc.backends.pictures.folding import Band
from cordicc.backends.pictures.layout import Net, Wire
from cordicc.backends.pictures.shapes import Shape
from cordicc.backends.pictures.svg import Svg, fitted, number, text_width
from cordicc.backends.pictures.wire_paths import branches
from cordicc.plan.model import Plan

MARGIN = 20
LEAST_WIDTH = 720
PAGE_WIDTH = 1240
"""Pixels of a picture at most, unless asked for otherwise: legible across a laptop screen or a sheet."""

_ROW_GAP = 20


@dataclass(frozen=True, slots=True)
class Diagram:
    """The rows of a diagram, and the label of the axis for some of its layers."""

    bands: Sequence[Band]
    ticks: Mapping[int, str]
    axis: str = ""


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


def frame(plan: Plan, what: str, prefix: str, diagram: Diagram) -> str:
    """Return the whole picture."""
    svg = Svg(prefix)
    width = max(*(band.layout.width + 2 * MARGIN for band in diagram.bands), LEAST_WIDTH)
    bottom = heading(svg, plan, what, width)
    colours: dict[str, str] = {}
    for index, band in enumerate(diagram.bands):
        if index:
            line = f"M{MARGIN} {number(bottom + 4)}H{number(width - MARGIN)}"
            svg.tag("path", d=line, stroke=RULE, stroke_width=1)
        bottom = _draw(svg, band, diagram, bottom, colours) + _ROW_GAP
    svg.tag("path", d=f"M{MARGIN} {number(bottom)}H{number(width - MARGIN)}", stroke=RULE)
    bottom = svg.legend(MARGIN, bottom + 12, _kinds(plan, diagram), width - 2 * MARGIN)
    return svg.document(width, bottom + 8, f"{what} of {plan.name}")


def rows(plan: Plan, what: str, prefix: str, diagram: Diagram) -> list[str]:
    """Return the rows as pictures of one width, without title, and the legend as the last one."""
    width = max(*(band.layout.width + 2 * MARGIN for band in diagram.bands), LEAST_WIDTH)
    colours: dict[str, str] = {}
    pictures = []
    for index, band in enumerate(diagram.bands):
        svg = Svg(prefix)
        bottom = _draw(svg, band, diagram, 0, colours, parts=True)
        part = f", row {index + 1} of {len(diagram.bands)}" if len(diagram.bands) > 1 else ""
        pictures.append(svg.document(width, bottom + 8, f"{what} of {plan.name}{part}", inside=True))
    svg = Svg(prefix)
    bottom = svg.legend(MARGIN, 6, _kinds(plan, diagram), width - 2 * MARGIN)
    return [*pictures, svg.document(width, bottom, "Legend")]


def _kinds(plan: Plan, diagram: Diagram) -> list[str]:
    kinds = {shape.kind for band in diagram.bands for shape in band.shapes}
    return kinds_used(plan, *(kind for kind in ("fifo", "input", "output", "link") if kind in kinds))


def _draw(
    svg: Svg, band: Band, diagram: Diagram, top: float, colours: dict[str, str], *, parts: bool = False
) -> float:
    """Draw a row below `top`; return the y below it."""
    ticks = {x: text for layer, text in diagram.ticks.items() if (x := band.column(layer)) is not None}
    top += 52 if ticks else 12
    if ticks:
        _axis(svg, diagram.axis, ticks, (top, top + band.layout.height + 8))
    _wires(svg, band, top, colours, parts=parts)
    for shape in band.shapes:
        x, y = band.layout.places[shape.box.id]
        shape.draw(svg, MARGIN + x, top + y)
    return top + band.layout.height + 8


def _axis(svg: Svg, axis: str, ticks: Mapping[int, str], span: tuple[float, float]) -> None:
    """Write the cycle at which each column starts over a light line."""
    top, bottom = span
    svg.text(MARGIN, top - 27, axis, 9, fill=MUTED)
    free = 0.0
    for x, label in sorted(ticks.items()):
        left = MARGIN + x
        path = f"M{left} {number(top - 10)}V{number(bottom)}"
        svg.tag("path", d=path, stroke=RULE, stroke_dasharray="2 3", fill="none")
        if left >= free:
            svg.text(left, top - 14, label, 9, fill=MUTED, bold=True)
            free = left + text_width(label, 9, bold=True) + 4


def _wires(svg: Svg, band: Band, top: float, colours: dict[str, str], *, parts: bool) -> None:
    """Draw the wires; with `parts` the way to each end once more, unseen, for a page to show."""
    shapes = {shape.box.id: shape for shape in band.shapes}
    for net, wire in zip(band.nets, band.layout.wires, strict=True):
        source = shapes[net.source.box]
        key = f"{source.source or source.box.id}.{net.source.port}"
        colour = colours.setdefault(key, WIRES[len(colours) % len(WIRES)])
        path = "".join(
            f"M{MARGIN + x1} {number(top + y1)}" + (f"H{MARGIN + x2}" if y1 == y2 else f"V{number(top + y2)}")
            for (x1, y1), (x2, y2) in wire.segments
            if (x1, y1) != (x2, y2)
        )
        svg.open(wire.net, data_net=wire.net, fill="none", stroke=colour, stroke_width=1.2)
        svg.tag("path", d=path)
        for x, y in wire.dots:
            svg.tag("circle", cx=MARGIN + x, cy=top + y, r=2.4, fill=colour, stroke="none")
        for to, way in _ways(net, wire, band, shapes) if parts else ():
            line = "L".join(f"{MARGIN + x} {number(top + y)}" for x, y in way)
            svg.tag("path", d=f"M{line}", stroke="none", data_from=source.source or source.box.id, data_to=to)
        svg.close()


def _ways(
    net: Net, wire: Wire, band: Band, shapes: Mapping[str, Shape]
) -> Iterable[tuple[str, list[tuple[int, int]]]]:
    """Return the way to each end of a wire, with the boxes that it leads to."""
    places = band.layout.places
    box = shapes[net.source.box].box
    x, y = places[box.id]
    start = (x + box.width, y + box.outputs[net.source.port])
    ends = []
    for pin in net.sinks:
        x, y = places[pin.box]
        ends.append((x, y + shapes[pin.box].box.inputs[pin.port]))
    for pin, way in zip(net.sinks, branches(wire.segments, start, ends), strict=True):
        if len(way) > 1:
            yield " ".join(shapes[pin.box].leads_to) or pin.box, way
