"""Histograms of the errors that were seen of each output: a bar per factor of two, on one axis for all."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cordicc.backends.palette import INK, LOOKS, MUTED, RULE
from cordicc.backends.pictures.svg import Svg, fitted, number
from cordicc.plan.model import Plan
from cordicc.plan.stated_accuracy import SeenErrors

_WIDTH, _HEIGHT = 300.0, 92.0
_LEFT, _TOP, _RIGHT, _BELOW = 16.0, 44.0, 16.0, 34.0
_MOST_BINS = 26
"""Factors of two that are drawn; smaller errors share a bar at the left."""


@dataclass(frozen=True, slots=True)
class _OctaveAxis:
    """Powers of two across, from the bar of all smaller errors on."""

    first: int
    last: int

    def at(self, error: float) -> float:
        """Return the pixel of an error."""
        place = (math.log2(error) - self.first) / (self.last - self.first)
        return _LEFT + min(max(place, 0.0), 1.0) * _WIDTH

    def bar(self, exponent: int) -> tuple[float, float]:
        """Return left edge and width of the bar from 2^exponent on."""
        step = _WIDTH / (self.last - self.first)
        return _LEFT + (max(exponent, self.first) - self.first) * step, step


def render(plan: Plan) -> list[str]:
    """Return a picture for each output of which errors are recorded."""
    known = {name: plan.accuracy[name].observed for name in plan.outputs if name in plan.accuracy}
    known = {name: seen for name, seen in known.items() if seen.histogram}
    if not known:
        return []
    largest = [least for found in known.values() for least, _ in found.histogram if least > 0]
    bounds = [bound for name in known if (bound := _bound(plan, name))]
    last = max([math.frexp(error)[1] for error in (*largest, *bounds)], default=0)
    smallest = min((math.frexp(error)[1] - 1 for error in largest), default=last - 1)
    axis = _OctaveAxis(max(smallest, last - _MOST_BINS) - 1, last)
    angles = plan.problem.angles
    return [_chart(name, seen, _bound(plan, name), axis, angles) for name, seen in known.items()]


def _bound(plan: Plan, name: str) -> float | None:
    bound = plan.accuracy[name].bound
    return bound.value if bound is not None and bound.value > 0 else None


def _chart(
    name: str, seen: SeenErrors, bound: float | None, axis: _OctaveAxis, angles: dict[str, bool]
) -> str:
    svg = Svg("eh")
    unit = " rad" if angles[name] else ""
    svg.text(_LEFT, 16, fitted(name, 12, 120, bold=True), 12, bold=True)
    figures = [f"max {seen.max:.2e}", f"rms {seen.rms:.2e}"]
    figures += [f"bound {bound:.2e}"] if bound else []
    svg.text(_LEFT, 32, " · ".join(figures) + unit, 10, fill=MUTED)
    counts: dict[int, int] = {}
    for least, count in seen.histogram:
        exponent = axis.first if least <= 0 else max(math.frexp(least)[1] - 1, axis.first)
        counts[exponent] = counts.get(exponent, 0) + int(count)
    total, most = sum(counts.values()) or 1, max(counts.values(), default=0) or 1
    base = _TOP + _HEIGHT
    svg.text(_LEFT + _WIDTH, 16, f"tallest bar {most / total:.0%}", 9, anchor="end", fill=MUTED)
    look = LOOKS["standard"]
    for exponent, count in sorted(counts.items()):
        left, width = axis.bar(exponent)
        height = _HEIGHT * count / most
        svg.open(f"{_range(exponent, axis)}: {count} samples, {count / total:.1%}")
        svg.tag(
            "rect", x=left + 0.5, y=base - height, width=width - 1, height=height,
            fill=look.fill, stroke=look.stroke, stroke_width=0.8,
        )  # fmt: skip
        svg.close()
    svg.tag("path", d=f"M{_LEFT} {base}h{_WIDTH}", stroke=INK, stroke_width=1)
    _ticks(svg, axis, base)
    for value, dash in ((seen.rms, "2 2"), (seen.max, ""), (bound, "6 3")):
        if value:
            _mark(svg, axis.at(value), base, dash)
    summary = f"Errors of {name}: " + ", ".join(figures) + unit
    return svg.document(_LEFT + _WIDTH + _RIGHT, base + _BELOW, summary)


def _range(exponent: int, axis: _OctaveAxis) -> str:
    if exponent <= axis.first:
        return f"below {math.ldexp(1.0, axis.first + 1):.2e}"
    end = math.ldexp(1.0, exponent + 1) if exponent + 1 < sys.float_info.max_exp else sys.float_info.max
    return f"{math.ldexp(1.0, exponent):.2e} to {end:.2e}"


def _mark(svg: Svg, x: float, base: float, dash: str) -> None:
    style: dict[str, Any] = {"stroke_dasharray": dash} if dash else {}
    svg.tag("path", d=f"M{number(x)} {_TOP}V{number(base)}", stroke=INK, stroke_width=1.4, **style)


def _ticks(svg: Svg, axis: _OctaveAxis, base: float) -> None:
    """Mark powers of ten, as many as have room."""
    tens = [p for p in range(-40, 41) if axis.first + 1 < p * math.log2(10) < axis.last]
    step = max(1, math.ceil(len(tens) / 6))
    for power in _every(tens, step):
        x = axis.at(10.0**power)
        svg.tag("path", d=f"M{number(x)} {base}v4", stroke=INK, stroke_width=1)
        svg.text(x, base + 16, f"1e{power}".replace("-", "−"), 9, anchor="middle", fill=MUTED)
    left, width = axis.bar(axis.first)
    svg.tag("path", d=f"M{number(left + width)} {base}v4", stroke=RULE, stroke_width=1)


def _every(powers: Sequence[int], step: int) -> list[int]:
    return [power for power in powers if power % step == 0]
