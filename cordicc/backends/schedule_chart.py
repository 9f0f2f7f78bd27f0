"""The schedule as a chart: a row per unit, a row per delayed value, cycles from left to right.

Where units are shared over time, a modulo reservation chart comes first (`reservation`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.backends import labels
from cordicc.backends.diagram import MARGIN, heading, kinds_used
from cordicc.backends.reservation import draw as draw_reservation
from cordicc.backends.svg import INK, LOOKS, MUTED, RULE, Look, Svg, fitted, look_of, number, text_width
from cordicc.plan import Operation, Plan

LANE = 18
BAR = 14
SIZE = 9.0
CHART_WIDTH = 860
LEAST_SCALE, MOST_SCALE = 1.0, 14.0
LABEL_WIDTH = 170
LABEL_LIMIT = 150.0
TICK_SPACING = 60


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


def render(plan: Plan) -> str:
    """Return the schedule as SVG."""
    span = max([plan.latency_cycles, 1, *(operation.finish for operation in plan.operations)])
    scale = min(max(CHART_WIDTH / span, LEAST_SCALE), MOST_SCALE)
    left = MARGIN + LABEL_WIDTH
    operations = _unit_rows(plan)
    values = _value_rows(plan)
    width = left + span * scale + 90
    svg = Svg("sc")
    top = heading(svg, plan, "Schedule", width)
    if plan.initiation_interval > 1:
        top, widest = draw_reservation(svg, plan, top)
        width = max(width, widest)
    top += 34
    height = LANE * sum(len(row.lanes) for row in operations + values) + (28 if values else 0)
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
    return svg.document(width, y + 8, f"Schedule of {plan.name}")


def _unit_rows(plan: Plan) -> list[Row]:
    busy: dict[str, list[Operation]] = {}
    for operation in plan.operations:
        busy.setdefault(operation.unit, []).append(operation)
    kinds = {unit.id: unit.kind for unit in plan.units}
    kinds |= {op.unit: op.kind for op in plan.operations if op.unit not in kinds}
    order = {unit: index for index, unit in enumerate(kinds)}
    rows = []
    instant: list[Operation] = []
    for unit in sorted(kinds, key=lambda name: (_group(kinds[name]), order[name])):
        group = busy.get(unit, [])
        timed = [operation for operation in group if operation.finish > operation.start]
        instant += [operation for operation in group if operation.finish <= operation.start]
        if timed or not group:
            rows.append(Row(unit, "" if timed else "idle", _lanes([_bar(operation) for operation in timed])))
    if instant:
        rows.append(
            Row("no cycle", f"{len(instant)} operations", _lanes([_bar(item) for item in instant], 26))
        )
    return rows


def _group(kind: str) -> tuple[int, str]:
    """Return the sort key of a kind of row: all CAUs are one group."""
    return (-1, "") if kind in labels.CAU_KINDS else labels.kind_rank(kind)


def _bar(operation: Operation) -> Bar:
    name = operation.id
    if operation.kind in labels.CAU_KINDS:
        name = " ".join(part for part in (operation.id, operation.equation, f"({operation.mode})") if part)
    tip = labels.operation_tip(operation)
    return Bar(f"op.{operation.id}", operation.start, operation.finish, name, operation.kind, tip)


def _value_rows(plan: Plan) -> list[Row]:
    spans = labels.spans(plan)
    rows: dict[str, list[Bar]] = {}
    for fifo in plan.fifos:
        begin, end = spans[fifo.id]
        bar = Bar(f"fifo.{fifo.id}", begin, end, str(fifo.depth), "fifo", labels.fifo_tip(fifo))
        rows.setdefault(fifo.value, []).append(bar)
    ordered = sorted(rows.items(), key=lambda item: min(bar.begin for bar in item[1]))
    return [Row(name, "", _lanes(bars)) for name, bars in ordered]


def _lanes(bars: Sequence[Bar], apart: int = 0) -> tuple[tuple[Bar, ...], ...]:
    """Put each bar into the first lane that is free, `apart` cycles after the last."""
    lanes: list[list[Bar]] = []
    for bar in sorted(bars, key=lambda item: (item.begin, item.end)):
        for lane in lanes:
            if lane[-1].end + apart <= bar.begin:
                lane.append(bar)
                break
        else:
            lanes.append([bar])
    return tuple(tuple(lane) for lane in lanes) or ((),)


def _axes(svg: Svg, plan: Plan, origin: tuple[float, float, float], height: float, span: int) -> None:
    left, top, scale = origin
    step = next(
        base * 10**power
        for power in range(12)
        for base in (1, 2, 5)
        if base * 10**power * scale >= TICK_SPACING
    )
    clock = labels.clock_hz(plan)
    marks = [cycle for cycle in range(0, span + 1, step) if span - cycle >= step * 0.6 or cycle == span]
    svg.text(left - 12, top - 20, "cycle", SIZE, anchor="end", fill=MUTED)
    if clock:
        svg.text(left - 12, top + height + 16, "time", SIZE, anchor="end", fill=MUTED)
    for cycle in sorted({*marks, plan.latency_cycles}):
        x = left + cycle * scale
        end = cycle == plan.latency_cycles
        svg.tag(
            "path", d=f"M{number(x)} {number(top - 12)}V{number(top + height + 4)}",
            stroke=INK if end else RULE, stroke_width=1,
        )  # fmt: skip
        svg.text(x, top - 20, str(cycle), SIZE, anchor="middle", bold=end)
        if clock:
            svg.text(x, top + height + 16, labels.seconds(cycle, clock), SIZE, anchor="middle", fill=MUTED)


def _rows(
    svg: Svg, rows: Sequence[Row], y: float, across: tuple[float, float, float], paint: str | None
) -> float:
    left, _, right = across
    for index, row in enumerate(rows):
        height = LANE * len(row.lanes)
        if index % 2 == 0:
            svg.tag(
                "rect", x=MARGIN, y=y, width=right - MARGIN, height=height, fill="#000000", fill_opacity=0.035
            )
        name = fitted(row.name, 10, LABEL_LIMIT - (text_width(row.note, SIZE) + 8 if row.note else 0))
        svg.text(MARGIN + 4, y + 13, name, 10)
        if row.note:
            svg.text(left - 12, y + 13, row.note, SIZE, anchor="end", fill=MUTED)
        for lane in row.lanes:
            _lane(svg, lane, y, across, paint)
            y += LANE
    return y


def _lane(
    svg: Svg, lane: Sequence[Bar], y: float, across: tuple[float, float, float], paint: str | None
) -> None:
    left, scale, right = across
    for index, bar in enumerate(lane):
        x, end = left + bar.begin * scale, left + bar.end * scale
        nearest = left + lane[index + 1].begin * scale - 4 if index + 1 < len(lane) else right
        svg.open(bar.tip, data_id=bar.id)
        if bar.end <= bar.begin:
            middle = number(y + LANE / 2)
            look = look_of(bar.kind)
            path = f"M{number(x - 5)} {middle}l5 -5l5 5l-5 5z"
            svg.tag("path", d=path, fill=look.fill, stroke=look.stroke, stroke_width=look.width)
            end = x + 5
        elif paint:
            ground = Look("", paint, LOOKS["fifo"].stroke, 0.8, radius=0)
            svg.box(x, y + 4, end - x, BAR - 4, ground)
        else:
            svg.box(x, y + 2, end - x, BAR, look_of(bar.kind))
        _label(svg, bar, y, (x, end, nearest), backed=paint is not None)
        svg.close()


def _label(svg: Svg, bar: Bar, y: float, room: tuple[float, float, float], *, backed: bool) -> None:
    """Write the label into the bar, else its first word, else right of it where there is room."""
    x, end, nearest = room
    base = y + LANE / 2 + 3.2
    for text in (bar.label, bar.label.split(" ")[0]):
        width = text_width(text, SIZE)
        if width + 8 <= end - x:
            middle = (x + end) / 2
            if backed:
                svg.tag(
                    "rect",
                    x=middle - width / 2 - 2,
                    y=y + 4.5,
                    width=width + 4,
                    height=BAR - 5,
                    fill="#ffffff",
                )
            svg.text(middle, base, text, SIZE, anchor="middle")
            return
    text = bar.label.split(" ")[0]
    if end + 3 + text_width(text, SIZE) <= nearest:
        svg.text(end + 3, base, text, SIZE)
