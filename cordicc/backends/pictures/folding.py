"""A wide diagram in several rows, like lines of text, so that it fits a page at a legible size.

The layers are parted where few wires are cut.  A wire that is cut ends at a small label with its name, and
every row that needs the value starts a wire at a label of the same name, next to where it is used.  An
input is drawn in each row that takes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from cordicc.backends.pictures.layout import Layout, Net, Pin, arrange, estimated_columns
from cordicc.backends.pictures.shapes import Shape, link_shape

_LABELS = 150
"""Pixels that labels at both ends of a row may take."""

_STRETCH = 1.15
"""How far beyond the limit one row is better than two."""

_MOST_AT_ONCE = 300
"""Boxes of a diagram that is laid out in one row to see how wide it is; of more, the width is estimated."""

_TRIES = 4


@dataclass(frozen=True, slots=True)
class Band:
    """A row of a diagram: its shapes, placed, its nets, and which of the diagram's layers are in it.

    Layers of the shapes count from 0 in each row; `shift` columns of labels and FIFOs come first.
    """

    shapes: tuple[Shape, ...]
    nets: tuple[Net, ...]
    layout: Layout
    layers: range
    shift: int = 0

    def column(self, layer: int) -> int | None:
        """Return the left edge of one of the diagram's layers, None if it is in another row."""
        if layer not in self.layers:
            return None
        return self.layout.columns[layer - self.layers.start + self.shift][0]


def fold(shapes: Sequence[Shape], nets: Sequence[Net], limit: float | None) -> list[Band]:
    """Return a diagram in rows of about `limit` pixels, as far as single layers allow; None: in one row."""
    boxes = [shape.box for shape in shapes]
    if limit is not None and len(boxes) > _MOST_AT_ONCE:
        columns = estimated_columns(boxes, nets)
    else:
        whole = arrange(boxes, nets)
        columns = whole.columns
        if limit is None or whole.width <= limit * _STRETCH:
            return [Band(tuple(shapes), tuple(nets), whole, range(len(columns)))]
    room = limit - _LABELS
    for _ in range(_TRIES):
        starts = _starts(columns, shapes, nets, room)
        rows = [range(*ends) for ends in pairwise([*starts, len(columns)])]
        placed = _with_late_boxes(shapes, nets, rows)
        used = {row for _, row in placed.values()}  # all boxes of a row may have moved on
        bands = [_band(placed, nets, row, index) for index, row in enumerate(rows) if index in used]
        excess = max(band.layout.width for band in bands) - limit
        if excess <= 0 or len(starts) == len(columns):
            break
        room -= excess
    return bands


def _starts(
    columns: Sequence[tuple[int, int]], shapes: Sequence[Shape], nets: Sequence[Net], room: float
) -> list[int]:
    """Return the first layer of each row: the fewest rows, then the fewest wires cut."""
    layer = {shape.box.id: shape.box.layer for shape in shapes}
    count = len(columns)
    cut = [0] * (count + 1)
    for net in nets:
        last = max((layer[sink.box] for sink in net.sinks), default=0)
        for after in range(layer[net.source.box] + 1, last + 1):
            cut[after] += 1
    best: list[tuple[int, int, int]] = [(0, 0, 0)]
    for end in range(1, count + 1):
        right = sum(columns[end - 1])
        options = []
        for first in range(end - 1, -1, -1):
            if first < end - 1 and right - columns[first][0] > room:
                break
            rows, cuts, _ = best[first]
            options.append((rows + 1, cuts + cut[first], first))
        best.append(min(options))
    starts, end = [], count
    while end:
        end = best[end][2]
        starts.append(end)
    return starts[::-1]


Placed = dict[str, tuple[Shape, int]]
"""The shapes by the id of their box, each with the number of its row."""


def _with_late_boxes(shapes: Sequence[Shape], nets: Sequence[Net], rows: Sequence[range]) -> Placed:
    """Assign shapes to rows.  A FIFO or an input leaves the row of its layer for the first one that it feeds.

    It then stands in a column before the first one of that row.  A FIFO stays with its driver.
    """
    row_of = {layer: index for index, row in enumerate(rows) for layer in row}
    placed = {shape.box.id: (shape, row_of[shape.box.layer]) for shape in shapes}
    drivers: dict[str, str] = {}
    fed_by: dict[str, list[str]] = {}
    for net in nets:
        for end in _ends(net):
            drivers.setdefault(end, net.source.box)
            fed_by.setdefault(net.source.box, []).append(end)
    # Feeders follow: of two segments in sequence the second one moves first.
    for shape in sorted(shapes, key=lambda each: -each.box.layer):
        own = placed[shape.box.id][1]
        driver = drivers.get(shape.box.id)
        fed = [placed[end] for end in fed_by.get(shape.box.id, ())]
        together = driver is not None and placed[driver][1] == own and placed[driver][0].kind != "input"
        if shape.kind not in ("fifo", "input") or not fed or together:
            continue
        first = min(row for _, row in fed)
        if first > own:
            layer = min(rows[first].start, *(each.box.layer for each, row in fed if row == first)) - 1
            placed[shape.box.id] = replace(shape, box=replace(shape.box, layer=layer)), first
    return placed


def _ends(net: Net) -> list[str]:
    return [sink.box for sink in net.sinks]


def _band(placed: Placed, nets: Sequence[Net], layers: range, row: int) -> Band:
    """Return one row."""
    here = {name: shape for name, (shape, own) in placed.items() if own == row}
    kept: list[Net] = []
    for net in nets:
        source, sinks = placed[net.source.box][0], [sink for sink in net.sinks if sink.box in here]
        away = tuple(dict.fromkeys(end for end in _ends(net) if end not in here))
        if source.box.id in here:
            if away and source.kind != "input":
                label = link_shape(f"to.{row}.{len(kept)}", net.name, source, away, source.box.layer + 1)
                here[label.box.id] = label
                sinks.append(Pin(label.box.id, 0))
            kept.append(replace(net, sinks=tuple(sinks)))
        elif sinks:
            layer = min(here[sink.box].box.layer for sink in sinks) - 1
            to = tuple(dict.fromkeys(sink.box for sink in sinks))
            label = link_shape(f"from.{row}.{len(kept)}", net.name, source, to, layer)
            here[label.box.id] = label
            kept.append(Net(net.name, Pin(label.box.id, 0), tuple(sinks)))
    shift = max(layers.start - shape.box.layer for shape in here.values())
    moved = tuple(
        replace(shape, box=replace(shape.box, layer=shape.box.layer - layers.start + shift))
        for shape in here.values()
    )
    return Band(moved, tuple(kept), arrange([shape.box for shape in moved], kept), layers, shift)
