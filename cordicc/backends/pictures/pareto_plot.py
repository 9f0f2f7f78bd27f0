"""The Pareto front as a plot: processors across, latency up, a line and a sign for each interval."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.backends.palette import INK, MUTED, RULE, SERIES
from cordicc.backends.pictures.axes import ROUND_STEPS
from cordicc.backends.pictures.svg import Svg, fitted, number, text_width

_WIDTH, _HEIGHT = 640, 360
_LEFT, _TOP, _MARGIN = 84, 84, 20
_SIDE = 18.0
_SIZE = 9.0
_SIGNS = (
    "M-5 -5h10v10h-10z",
    "M0 -6l6 6l-6 6l-6 -6z",
    "M0 -6l6 11h-12z",
    "M0 6l6 -11h-12z",
    "M-6 0a6 6 0 1 0 12 0a6 6 0 1 0 -12 0z",
)


@dataclass(frozen=True, slots=True)
class Mark:
    """A point: processors, latency and interval in cycles, FIFO words, its units, and what is proven."""

    processors: int
    latency: int
    interval: int
    fifo_words: int
    units: str
    certificate: str

    @property
    def tip(self) -> str:
        """Return the tooltip."""
        figures = f"interval {self.interval}, latency {self.latency}, {self.fifo_words} FIFO words"
        return f"{figures}\n{self.units}\n{self.certificate}"


def render(title: str, marks: Sequence[Mark]) -> str:
    """Return the plot as SVG; the number at a point is its FIFO words."""
    svg = Svg("pf")
    total = _LEFT + _WIDTH + 150
    svg.text(_MARGIN, 30, fitted(title, 16, total - 2 * _MARGIN, bold=True), 16, bold=True)
    svg.text(
        _MARGIN,
        50,
        "Latency in cycles over CAUs, intervals side by side; at each point its FIFO words",
        11,
        fill=MUTED,
    )
    across = _LinearAxis.over([0, *(mark.processors for mark in marks)], _LEFT, _LEFT + _WIDTH)
    up = _LinearAxis.over([mark.latency for mark in marks], _TOP + _HEIGHT, _TOP)
    _grid(svg, across, up)
    intervals = sorted({mark.interval for mark in marks})
    # Intervals stand side by side, as the same CAUs and latency serve several of them.
    apart = min(_SIDE, 0.8 * (across.at(1) - across.at(0)) / max(len(intervals), 1))
    places: list[tuple[Mark, float, float]] = []
    for index, interval in enumerate(intervals):
        colour, sign = _look(index)
        shift = (index - (len(intervals) - 1) / 2) * apart
        series = sorted((m for m in marks if m.interval == interval), key=lambda m: (m.processors, m.latency))
        here = [(m, across.at(m.processors) + shift, up.at(m.latency)) for m in series]
        path = "L".join(f"{number(x)} {number(y)}" for _, x, y in here)
        svg.tag("path", d=f"M{path}", fill="none", stroke=colour, stroke_width=1, stroke_opacity=0.5)
        places += here
        row = _TOP + 20 * index
        svg.tag("path", d=sign, transform=f"translate({_LEFT + _WIDTH + 30} {row})", fill=colour)
        svg.text(_LEFT + _WIDTH + 44, row + 4, f"interval {interval}", 11)
    taken = [(x - 7, x + 7, y - 7, y + 7) for _, x, y in places]
    for mark, x, y in places:
        colour, sign = _look(intervals.index(mark.interval))
        svg.open(mark.tip)
        svg.tag("path", d=sign, transform=f"translate({number(x)} {number(y)})", fill=colour)
        _label(svg, str(mark.fifo_words), x, y, taken)
        svg.close()
    return svg.document(total, _TOP + _HEIGHT + 56, title)


def _look(index: int) -> tuple[str, str]:
    return SERIES[index % len(SERIES)], _SIGNS[index % len(_SIGNS)]


def _label(svg: Svg, text: str, x: float, y: float, taken: list[tuple[float, float, float, float]]) -> None:
    """Write a label above or below a mark, clear of what is there (left, right, top, bottom)."""
    half = text_width(text, _SIZE) / 2 + 1
    # Baselines nearest to the mark first; one of so many is free of so few marks.
    baselines = [y + side for step in range(len(taken) + 1) for side in (-10 - 11 * step, 18 + 11 * step)]

    def free(line: float) -> bool:
        return not any(
            x - half < right and left < x + half and line - _SIZE < bottom and top < line + 1
            for left, right, top, bottom in taken
        )

    line = next(filter(free, baselines), baselines[0])
    taken.append((x - half, x + half, line - _SIZE, line + 1))
    svg.text(x, line, text, _SIZE, anchor="middle", fill=INK)


@dataclass(frozen=True, slots=True)
class _LinearAxis:
    """A linear scale with round ticks: values `first` to `last` on pixels `begin` to `end`."""

    first: int
    last: int
    step: int
    begin: float
    end: float

    @classmethod
    def over(cls, values: Sequence[int], begin: float, end: float) -> _LinearAxis:
        """Return the axis that has room on both sides of some values, but none below zero."""
        least, most = min(values, default=0), max(values, default=0)
        # A few cycles of difference are to be seen, but not to look like much.
        span = max(most - least, most // 8, 1)
        step = next(step for step in ROUND_STEPS if step * 8 >= span)
        return cls(max(0, step * (least // step - 1)), step * (most // step + 1), step, begin, end)

    def at(self, value: int) -> float:
        """Return the pixel of a value."""
        return self.begin + (value - self.first) / (self.last - self.first) * (self.end - self.begin)

    def ticks(self) -> range:
        """Return the values that are marked."""
        return range(self.first, self.last + 1, self.step)


def _grid(svg: Svg, across: _LinearAxis, up: _LinearAxis) -> None:
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
