"""The modulo reservation chart: a row per unit, a column per slot, whatever the latency.

A slot is a cycle modulo the initiation interval; a cell has the operation that enters the unit in it, and
the number of intervals after the sample's first in which it does.
"""

from __future__ import annotations

from collections.abc import Iterable

from cordicc.backends import labels
from cordicc.backends.palette import MUTED, RULE, look_of
from cordicc.backends.pictures.diagram import MARGIN
from cordicc.backends.pictures.svg import Svg, fitted, number, text_width
from cordicc.plan.model import Operation, Plan, Unit
from cordicc.plan.netlist import Netlist

_ROW = 20
_LABEL_WIDTH = 110
_LEAST_CELL, _MOST_CELL = 38.0, 96.0
_CHART_WIDTH = 860.0
_MOST_COLUMNS = 128
"""Slots drawn; of longer intervals only the slots in use."""
_SIZE = 9.0


def draw(svg: Svg, plan: Plan, top: float) -> tuple[float, float]:
    """Draw the chart of the units that take cycles below `top`; return the y below it and its width."""
    units = sorted((u for u in plan.units if u.latency), key=lambda unit: labels.kind_rank(unit.kind))
    cells = Netlist.of(plan).cells
    held = {
        unit.id: {each.start % plan.initiation_interval: each for each in cells[unit.id].operations}
        for unit in units
    }
    slots = _columns(plan, held.values())
    cell = min(max(_CHART_WIDTH / max(len(slots), 1), _LEAST_CELL), _MOST_CELL)
    left, right = MARGIN + _LABEL_WIDTH, MARGIN + _LABEL_WIDTH + cell * len(slots)
    svg.text(MARGIN, top + 14, "Operations by unit and slot (cycle modulo the interval)", 10, bold=True)
    y = top + 38
    svg.text(left - 12, y - 6, "slot", _SIZE, anchor="end", fill=MUTED)
    for column, slot in enumerate(slots):
        svg.text(left + (column + 0.5) * cell, y - 6, str(slot), _SIZE, anchor="middle", fill=MUTED)
    for unit in units:
        _row(svg, unit, [held[unit.id].get(slot) for slot in slots], (left, y, cell), plan)
        y += _ROW
    grid = "".join(
        f"M{number(left + k * cell)} {number(top + 38)}V{number(y)}" for k in range(len(slots) + 1)
    )
    svg.tag("path", d=grid, stroke=RULE, stroke_width=0.6)
    note = "+k: k intervals after the sample entered"
    if len(slots) < plan.initiation_interval:
        note += f"; {len(slots)} of {plan.initiation_interval} slots, those in use"
    svg.text(MARGIN, y + 14, note, _SIZE, fill=MUTED)
    return y + 24, right + MARGIN


def _columns(plan: Plan, held: Iterable[Iterable[int]]) -> list[int]:
    """Return the slots to draw, from those in use by unit."""
    if plan.initiation_interval <= _MOST_COLUMNS:
        return list(range(plan.initiation_interval))
    return sorted(set().union(*held))


def _row(
    svg: Svg,
    unit: Unit,
    cells: list[Operation | None],
    place: tuple[float, float, float],
    plan: Plan,
) -> None:
    left, y, width = place
    use = f"{sum(cell is not None for cell in cells)}/{plan.initiation_interval}"
    name = fitted(unit.id, 10, _LABEL_WIDTH - 24 - text_width(use, _SIZE))
    svg.text(MARGIN + 4, y + 14, name, 10)
    svg.text(left - 12, y + 14, use, _SIZE, anchor="end", fill=MUTED)
    for column, operation in enumerate(cells):
        if operation is None:
            continue
        x = left + column * width
        svg.open(labels.operation_tip(operation), data_id=f"slot.{operation.id}")
        svg.box(x + 1, y + 2, width - 2, _ROW - 4, look_of(operation.kind))
        turn = operation.start // plan.initiation_interval
        text = f"{operation.id} +{turn}"
        if text_width(text, _SIZE) > width - 4:
            text = operation.id
        svg.text(x + width / 2, y + 14, fitted(text, _SIZE, width - 4), _SIZE, anchor="middle")
        svg.close()
