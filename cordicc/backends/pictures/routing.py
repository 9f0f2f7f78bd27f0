"""Channel routing: the vertical tracks of nets between two layers of boxes.

A net enters a channel at one height on the left and leaves it at one or more on the right.  It gets one
vertical trunk.  Two trunks share a track only if they stay apart; where one net comes in at the height at
which another goes out, the first must turn off before the second turns in (the vertical-constraint graph
of channel routing).  A cycle of such constraints is cut by a jog at the right edge.
"""

from __future__ import annotations

from dataclasses import dataclass

MOST_WEIGHED = 1_000
"""Nets of a channel of which each two are compared for the order with fewer crossings; of more, none are."""

GRID = 8
"""Pixels between lanes; all terminals lie on this raster."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """A net in a channel: heights on the left and, ascending, on the right."""

    net: int
    left: int
    right: tuple[int, ...]

    @property
    def straight(self) -> bool:
        """Whether the net needs no trunk."""
        return self.right == (self.left,)


@dataclass(frozen=True, slots=True)
class Route:
    """Where a net turns: its track, and per right terminal the height it turns at and the jog's track."""

    net: int
    left: int
    track: int
    turns: tuple[tuple[int, int, int | None], ...]


@dataclass(frozen=True, slots=True)
class Channel:
    """The routes of a channel that need a trunk, and how many tracks they take."""

    tracks: int
    routes: tuple[Route, ...]


def route(crossings: list[Crossing]) -> Channel:
    """Assign tracks, left to right, preferring the order with fewer wire crossings."""
    pending = {crossing.net: crossing for crossing in crossings if not crossing.straight}
    used = {height for crossing in crossings for height in (crossing.left, *crossing.right)}
    turns = {net: {height: height for height in crossing.right} for net, crossing in pending.items()}
    placed: dict[int, int] = {}
    track = 0
    while pending:
        free = _free(pending, turns)
        if not free:
            _cut(min(pending), pending, turns, used)
            continue
        if len(pending) <= MOST_WEIGHED:
            free.sort(key=lambda net: (_score(net, pending, turns), net))
        spans: list[tuple[int, int]] = []
        for net in free:
            low, high = _span(pending[net].left, turns[net])
            if all(high + GRID <= other_low or other_high + GRID <= low for other_low, other_high in spans):
                spans.append((low, high))
                placed[net] = track
        for net in [net for net in free if net in placed]:
            del pending[net]
        track += 1
    return _channel(crossings, placed, turns, track)


def _channel(
    crossings: list[Crossing], placed: dict[int, int], turns: dict[int, dict[int, int]], track: int
) -> Channel:
    routes = []
    for crossing in crossings:
        if crossing.net not in placed:
            continue
        ends: list[tuple[int, int, int | None]] = []
        for height, turn in turns[crossing.net].items():
            ends.append((height, turn, None if turn == height else track))
            track += turn != height
        routes.append(Route(crossing.net, crossing.left, placed[crossing.net], tuple(ends)))
    return Channel(track, tuple(routes))


def _span(left: int, turns: dict[int, int]) -> tuple[int, int]:
    heights = [left, *turns.values()]
    return min(heights), max(heights)


def _free(pending: dict[int, Crossing], turns: dict[int, dict[int, int]]) -> list[int]:
    """Return the nets that go out at no height at which another unplaced one comes in."""
    entering: dict[int, set[int]] = {}
    for net, crossing in pending.items():
        entering.setdefault(crossing.left, set()).add(net)
    return [
        net for net in pending if all(entering.get(height, {net}) <= {net} for height in turns[net].values())
    ]


def _cut(net: int, pending: dict[int, Crossing], turns: dict[int, dict[int, int]], used: set[int]) -> None:
    """Free `net` of its constraints by turning at unused heights and jogging back."""
    taken = {crossing.left for other, crossing in pending.items() if other != net}
    for height, turn in turns[net].items():
        if turn in taken:
            steps = (
                height + sign * GRID * step // 2 for step in range(1, 4 * len(used) + 4) for sign in (1, -1)
            )
            choice = next(step for step in steps if step not in used)
            used.add(choice)
            turns[net][height] = choice


def _score(net: int, pending: dict[int, Crossing], turns: dict[int, dict[int, int]]) -> int:
    """Count the wire crossings gained by putting `net` left of all others that wait."""
    return sum(
        _crossings(net, other, pending, turns) - _crossings(other, net, pending, turns)
        for other in pending
        if other != net
    )


def _crossings(
    first: int, second: int, pending: dict[int, Crossing], turns: dict[int, dict[int, int]]
) -> int:
    low, high = _span(pending[second].left, turns[second])
    count = sum(low < height < high for height in turns[first].values())
    low, high = _span(pending[first].left, turns[first])
    return count + (low < pending[second].left < high)
