"""Which part of a drawn net leads to which of its ends."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from cordicc.backends.pictures.layout import Point

Line = tuple[Point, Point]


def branches(segments: Sequence[Line], start: Point, ends: Sequence[Point]) -> list[list[Point]]:
    """Return the corner points of the way from `start` to each of the ends along the segments."""
    neighbours: dict[Point, list[Point]] = {}
    for one, other in _pieces(segments):
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    before: dict[Point, Point] = {start: start}
    todo = [start]
    for point in todo:
        for other in neighbours.get(point, []):
            if other not in before:
                before[other] = point
                todo.append(other)
    return [_corners(_way(end, before)) for end in ends]


def _pieces(segments: Sequence[Line]) -> list[Line]:
    """Return the segments parted where another one ends on them."""
    points = {point for segment in segments for point in segment}
    pieces: list[Line] = []
    for one, other in segments:
        low, high = sorted((one, other))
        on = sorted(p for p in points if low <= p <= high and _within(p, low, high))
        pieces += pairwise(on)
    return pieces


def _within(point: Point, low: Point, high: Point) -> bool:
    """Tell whether a point lies on an upright or level segment."""
    return all(a <= p <= b for p, a, b in zip(point, low, high, strict=True))


def _way(end: Point, before: dict[Point, Point]) -> list[Point]:
    way = [end]
    while end in before and before[end] != end:
        end = before[end]
        way.append(end)
    return way[::-1]


def _corners(way: list[Point]) -> list[Point]:
    """Return a way without the points at which it goes straight on."""
    kept = way[:1]
    for point, after in pairwise(way[1:]):
        straight = kept[-1][0] == point[0] == after[0] or kept[-1][1] == point[1] == after[1]
        if not straight:
            kept.append(point)
    return [*kept, *way[1:][-1:]]
