"""The schedule as a chart: a row per unit, a row per delayed value, cycles from left to right.

Where units are shared over time, a modulo reservation chart comes first (`reservation`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from cordicc.backends import labels
from cordicc.backends.palette import BAND, INK, LOOKS, MUTED, PAPER, RULE, Look, look_of
from cordicc.backends.pictures.axes import ROUND_STEPS
from cordicc.backends.pictures.diagram import MARGIN, heading, kinds_used
from cordicc.backends.pictures.reservation import draw as draw_reservation
from cordicc.backends.pictures.svg import Svg, fitted, number, text_width
from cordicc.plan.model import Operation, Plan
from cordicc.plan.netlist import Netlist
from cordicc.targets.target import CAU_KINDS

LANE, VALUE_LANE = 18, 15
SIZE = 9.0
CHART_WIDTH = 960
LEAST_SCALE, MOST_SCALE = 1.0, 14.0
LABEL_WIDTH = 170
LABEL_LIMIT = 150.0
TICK_SPACING = 60
MOST_ROWS = 24
"""Rows of their own that values may have; beyond it they share them."""

MOST_UNITS = 6
"""The same for the units of a kind that do one operation each."""


@dataclass(frozen=True, slots=True)
class Bar:
    """A stretch of cycles with its label; `kind` gives the look."""

    id: str
    begin: int
    end: int
    label: str
    kind: str
    tip: str


@dataclass(frozen=True, slots=True)
class Row:
    """The bars of a unit or value in lanes, so that bars that overlap in time do not overlap in print."""

    name: str
    note: str
    lanes: tuple[tuple[Bar, ...], ...]


def render(plan: Plan, width: float | None = None) -> str:
    """Return the schedule as SVG; it is as wide as time takes, whatever the width."""
    return _drawn(plan, inside=False)


def piece(plan: Plan) -> str:
    """Return the schedule as a picture without title, whose parts a page can tell apart."""
    return _drawn(plan, inside=True)


def _drawn(plan: Plan, *, inside: bool) -> str:
    span = max([plan.latency_cycles, 1, *(operation.finish for operation in plan.operations)])
    scale = min(max(CHART_WIDTH / span, LEAST_SCALE), MOST_SCALE)
    left = MARGIN + LABEL_WIDTH
    operations = unit_rows(plan, scale)
    values = _value_rows(plan, scale)
    width = left + span * scale + 90
    svg = Svg("sc")
    top = 0.0 if inside else heading(svg, plan, "Schedule", width)
    if plan.initiation_interval > 1:
        top, widest = draw_reservation(svg, plan, top)
        width = max(width, widest)
    top += 34
    height = LANE * _lane_count(operations) + (VALUE_LANE * _lane_count(values) + 28 if values else 0)
    _axes(svg, plan, (left, top, scale), height, span)
    paint = svg.hatch("hatch", LOOKS["fifo"].stroke)
    y = _rows(svg, operations, top, (left, scale, width - MARGIN), None)
    if values:
        svg.text(MARGIN, y + 18, "Values waiting in FIFOs", 10, bold=True)
        y = _rows(svg, values, y + 28, (left, scale, width - MARGIN), paint)
    y += 30
    if any(operation.finish <= operation.start for operation in plan.operations):
        note = "A diamond is an operation that takes no cycle."
        svg.text(MARGIN, y + 6, note, 10, fill=MUTED)
        y += 18
    extra = ["fifo"] if values else []
    y = svg.legend(MARGIN, y, kinds_used(plan, *extra), width - 2 * MARGIN, fifo_paint=paint)
    return svg.document(width, y + 8, f"Schedule of {plan.name}", inside=inside)


def _lane_count(rows: Sequence[Row]) -> int:
    return sum(len(row.lanes) for row in rows)


def unit_rows(plan: Plan, scale: float) -> list[Row]:
    """Return a row for each unit; many of a kind that do one operation each share rows."""
    rows = []
    together: dict[str, list[Operation]] = {}
    instant: list[Operation] = []
    for cell in sorted(Netlist.of(plan).cells.values(), key=lambda cell: _group(cell.unit.kind)):
        kind = cell.unit.kind
        timed = [operation for operation in cell.operations if operation.finish > operation.start]
        instant += [operation for operation in cell.operations if operation.finish <= operation.start]
        if len(timed) == 1 and _many(plan, kind):
            if kind not in together:
                together[kind] = []
                rows.append(Row(kind, "", ()))
            together[kind] += timed
        elif timed or not cell.operations:
            rows.append(Row(cell.unit.id, "" if timed else "idle", _lanes(_bars(timed), scale)))
    rows = [
        replace(row, note=f"{len(together[row.name])} units", lanes=_lanes(_bars(together[row.name]), scale))
        if row.name in together
        else row
        for row in rows
    ]
    if instant:
        rows.append(Row("no cycle", f"{len(instant)} operations", _lanes(_bars(instant), scale)))
    return rows


def _many(plan: Plan, kind: str) -> bool:
    """Tell whether a kind has so many units that they are drawn together."""
    return kind not in CAU_KINDS and sum(unit.kind == kind for unit in plan.units) > MOST_UNITS


def _group(kind: str) -> tuple[int, str]:
    """Return the sort key of a kind of row: all CAUs are one group."""
    return (-1, "") if kind in CAU_KINDS else labels.kind_rank(kind)


def _bar(operation: Operation) -> Bar:
    name = operation.id
    if operation.kind in CAU_KINDS:
        name = " ".join(
            part for part in (operation.id, operation.equation, f"({labels.mode(operation)})") if part
        )
    tip = labels.operation_tip(operation)
    return Bar(f"op.{operation.id}", operation.start, operation.finish, name, operation.kind, tip)


def _bars(operations: Sequence[Operation]) -> list[Bar]:
    return [_bar(operation) for operation in operations]


def _value_rows(plan: Plan, scale: float) -> list[Row]:
    """Return a row for each value that waits; many of them share rows, with their names at the bars."""
    spans = Netlist.of(plan).spans
    together = len({fifo.value for fifo in plan.fifos}) > MOST_ROWS
    rows: dict[str, list[Bar]] = {}
    for fifo in plan.fifos:
        begin, end = spans[fifo.id]
        text = f"{_short(fifo.value)}\u00a0·\u00a0{fifo.depth}" if together else str(fifo.depth)
        bar = Bar(f"fifo.{fifo.id}", begin, end, text, "fifo", labels.fifo_tip(fifo))
        rows.setdefault("" if together else _short(fifo.value), []).append(bar)
    ordered = sorted(rows.items(), key=lambda item: min(bar.begin for bar in item[1]))
    return [Row(name, "", _lanes(bars, scale)) for name, bars in ordered]


def _short(value: str) -> str:
    return fitted(value.removesuffix(".value"), SIZE, LABEL_LIMIT)


def _lanes(bars: Sequence[Bar], scale: float) -> tuple[tuple[Bar, ...], ...]:
    """Put each bar into the first lane in which neither it nor a label beside it meets another one."""
    lanes: list[list[Bar]] = []
    free: list[float] = []
    for bar in sorted(bars, key=lambda item: (item.begin, item.end)):
        left, right = _extent(bar, scale)
        for number_, lane in enumerate(lanes):
            if free[number_] <= left:
                lane.append(bar)
                free[number_] = right
                break
        else:
            lanes.append([bar])
            free.append(right)
    return tuple(tuple(lane) for lane in lanes) or ((),)


def _extent(bar: Bar, scale: float) -> tuple[float, float]:
    """Return the pixels from the chart's left edge that a bar and its label take."""
    first = bar.label.split(" ")[0]
    left, right = bar.begin * scale, bar.end * scale
    if bar.end <= bar.begin:
        return left - 5, right + 5 + 3 + text_width(first, SIZE) + 6
    if text_width(first, SIZE) + 8 <= right - left:
        return left, right
    return left, right + 3 + text_width(first, SIZE) + 4


def _axes(svg: Svg, plan: Plan, origin: tuple[float, float, float], height: float, span: int) -> None:
    left, top, scale = origin
    step = next(step for step in ROUND_STEPS if step * scale >= TICK_SPACING)
    clock = plan.clock_hz
    marks = [cycle for cycle in range(0, span + 1, step) if span - cycle >= step * 0.6 or cycle == span]
    svg.text(left - 12, top - 20, "cycle", SIZE, anchor="end", fill=MUTED)
    svg.text(left - 12, top + height + 16, "time", SIZE, anchor="end", fill=MUTED)
    for cycle in sorted({*marks, plan.latency_cycles}):
        x = left + cycle * scale
        end = cycle == plan.latency_cycles
        svg.tag(
            "path", d=f"M{number(x)} {number(top - 12)}V{number(top + height + 4)}",
            stroke=INK if end else RULE, stroke_width=1,
        )  # fmt: skip
        svg.text(x, top - 20, str(cycle), SIZE, anchor="middle", bold=end)
        svg.text(x, top + height + 16, labels.seconds(cycle, clock), SIZE, anchor="middle", fill=MUTED)


def _rows(
    svg: Svg, rows: Sequence[Row], y: float, across: tuple[float, float, float], paint: str | None
) -> float:
    """Draw rows; FIFOs, which have a `paint`, in lower lanes."""
    left, _, right = across
    lane_height = VALUE_LANE if paint else LANE
    for index, row in enumerate(rows):
        height = lane_height * len(row.lanes)
        if index % 2 == 0:
            svg.tag("rect", x=MARGIN, y=y, width=right - MARGIN, height=height, fill=BAND, fill_opacity=0.6)
        name = fitted(row.name, 10, LABEL_LIMIT - (text_width(row.note, SIZE) + 8 if row.note else 0))
        base = y + lane_height / 2 + 3.5
        if name:
            svg.text(MARGIN + 4, base, name, 10)
        if row.note:
            svg.text(left - 12, base, row.note, SIZE, anchor="end", fill=MUTED)
        for lane in row.lanes:
            for place, bar in enumerate(lane):
                after = left + lane[place + 1].begin * across[1] - 4 if place + 1 < len(lane) else right
                _draw_bar(svg, bar, y, (left, across[1], after), paint)
            y += lane_height
    return y


def _draw_bar(svg: Svg, bar: Bar, y: float, across: tuple[float, float, float], paint: str | None) -> None:
    left, scale, nearest = across
    x, end = left + bar.begin * scale, left + bar.end * scale
    svg.open(bar.tip, data_id=bar.id)
    if bar.end <= bar.begin:
        look = look_of(bar.kind)
        path = f"M{number(x - 5)} {number(y + LANE / 2)}l5 -5l5 5l-5 5z"
        svg.tag("path", d=path, fill=look.fill, stroke=look.stroke, stroke_width=look.width)
        end = x + 5
    elif paint:
        ground = Look("", paint, LOOKS["fifo"].stroke, 0.8, radius=0)
        svg.box(x, y + 2.5, end - x, VALUE_LANE - 5, ground)
    else:
        svg.box(x, y + 2, end - x, LANE - 4, look_of(bar.kind))
    middle = y + (VALUE_LANE if paint else LANE) / 2
    _label(svg, bar, middle, (x, end, nearest), backed=paint is not None)
    svg.close()


def _label(svg: Svg, bar: Bar, middle: float, room: tuple[float, float, float], *, backed: bool) -> None:
    """Write the label into the bar, else its first word, else right of it where there is room."""
    x, end, nearest = room
    base = middle + 3.2
    for text in (bar.label, bar.label.split(" ")[0]):
        width = text_width(text, SIZE)
        if width + 8 <= end - x:
            centre = (x + end) / 2
            if backed:
                svg.tag(
                    "rect", x=centre - width / 2 - 2, y=middle - 4.5, width=width + 4, height=9, fill=PAPER
                )
            svg.text(centre, base, text, SIZE, anchor="middle")
            return
    text = bar.label.split(" ")[0]
    if end + 3 + text_width(text, SIZE) <= nearest:
        svg.text(end + 3, base, text, SIZE)
