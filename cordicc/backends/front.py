"""The Pareto front as a plot: processors across, latency up, a line and a sign for each interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.backends.svg import INK, MUTED, RULE, Svg, fitted, number, text_width

_WIDTH, _HEIGHT = 640, 360
_LEFT, _TOP, _MARGIN = 84, 84, 20
_COLOURS = ("#1f5d96", "#9a4f00", "#2f7030", "#72418a", "#80660a", "#454c54")
_SIGNS = ("M-5 -5h10v10h-10z", "M0 -6l6 6l-6 6l-6 -6z", "M0 -6l6 11h-12z", "M0 6l6 -11h-12z")


@dataclass(frozen=True, slots=True)
class Mark:
    """A point: processors, latency in cycles, interval in cycles, FIFO words, and its tooltip."""

    processors: int
    latency: int
    interval: int
    fifo_words: int
    tip: str


def render(title: str, marks: Sequence[Mark]) -> str:
    """Return the plot as SVG; the number at a point is its FIFO words."""
    svg = Svg("pf")
    total = _LEFT + _WIDTH + 150
    svg.text(_MARGIN, 30, fitted(title, 16, total - 2 * _MARGIN, bold=True), 16, bold=True)
    svg.text(_MARGIN, 50, "Latency in cycles over CAUs; at each point its FIFO words", 11, fill=MUTED)
    across = _Axis.over([mark.processors for mark in marks], _LEFT, _LEFT + _WIDTH)
    up = _Axis.over([mark.latency for mark in marks], _TOP + _HEIGHT, _TOP)
    _grid(svg, across, up)
    intervals = sorted({mark.interval for mark in marks})
    written: list[tuple[float, float, float]] = []
    for index, interval in enumerate(intervals):
        colour, sign = _COLOURS[index % len(_COLOURS)], _SIGNS[index % len(_SIGNS)]
        series = sorted((m for m in marks if m.interval == interval), key=lambda m: (m.processors, m.latency))
        places = [(across.at(mark.processors), up.at(mark.latency)) for mark in series]
        path = "L".join(f"{number(x)} {number(y)}" for x, y in places)
        svg.tag("path", d=f"M{path}", fill="none", stroke=colour, stroke_width=1.2)
        for mark, (x, y) in zip(series, places, strict=True):
            svg.open(mark.tip)
            svg.tag("path", d=sign, transform=f"translate({number(x)} {number(y)})", fill=colour)
            _label(svg, str(mark.fifo_words), x + 9, y - 6, written)
            svg.close()
        y = _TOP + 20 * index
        svg.tag("path", d=sign, transform=f"translate({_LEFT + _WIDTH + 30} {y})", fill=colour)
        svg.text(_LEFT + _WIDTH + 44, y + 4, f"interval {interval}", 11)
    return svg.document(total, _TOP + _HEIGHT + 56, title)


def _label(svg: Svg, text: str, x: float, y: float, written: list[tuple[float, float, float]]) -> None:
    """Write a label, below those already there."""
    width = text_width(text, 9)
    while any(abs(y - other) < 10 and x < right and left < x + width for left, right, other in written):
        y += 10
    written.append((x, x + width, y))
    svg.text(x, y, text, 9, fill=INK)


@dataclass(frozen=True, slots=True)
class _Axis:
    """A linear scale with round ticks: values `first` to `last` on pixels `begin` to `end`."""

    first: int
    last: int
    step: int
    begin: float
    end: float

    @classmethod
    def over(cls, values: Sequence[int], begin: float, end: float) -> _Axis:
        """Return the axis that has room for some values and zero."""
        most = max(values, default=0)
        step = next(b * 10**p for p in range(18) for b in (1, 2, 5) if b * 10**p * 10 >= max(most, 1))
        return cls(0, step * (most // step + 1), step, begin, end)

    def at(self, value: int) -> float:
        """Return the pixel of a value."""
        return self.begin + (value - self.first) / (self.last - self.first) * (self.end - self.begin)

    def ticks(self) -> range:
        """Return the values that are marked."""
        return range(self.first, self.last + 1, self.step)


def _grid(svg: Svg, across: _Axis, up: _Axis) -> None:
    for value in across.ticks():
        x = across.at(value)
        svg.tag("path", d=f"M{number(x)} {number(up.begin)}V{number(up.end)}", stroke=RULE, stroke_width=1)
        svg.text(x, up.begin + 16, str(value), 10, anchor="middle", fill=MUTED)
    for value in up.ticks():
        y = up.at(value)
        line = f"M{number(across.begin)} {number(y)}H{number(across.end)}"
        svg.tag("path", d=line, stroke=RULE, stroke_width=1)
        svg.text(across.begin - 8, y + 3, str(value), 10, anchor="end", fill=MUTED)
    svg.text((across.begin + across.end) / 2, up.begin + 36, "CAUs", 11, anchor="middle")
    svg.text(_MARGIN, up.end - 12, "cycles", 11)
