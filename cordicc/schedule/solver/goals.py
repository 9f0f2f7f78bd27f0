"""What a schedule is judged by: goals in order, and their figures for given starts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.reservations import coloured
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem, taps, value_words


@dataclass(frozen=True, slots=True)
class Goal:
    """A weighted sum of units by kind, latency and FIFO words by value, to be minimised.

    `words` is the cost of a FIFO word, times the `width` of its value if widths are given.
    """

    name: str
    units: Mapping[str, int] = field(default_factory=dict)
    latency: int = 0
    words: int = 0
    width: Mapping[str, int] | None = None

    def word_weight(self, value: str) -> int:
        """Return what a FIFO word of a value costs."""
        return self.words * (1 if self.width is None else self.width[value])


LATENCY = Goal("latency", latency=1)
FIFO_WORDS = Goal("fifo_words", words=1)


def units_used(net: Network, start: Sequence[int]) -> dict[str, int]:
    """Return the units of each kind that starts need: the most operations of the kind in one slot.

    Where operations keep units for several cycles it may be more, see `reservations`.
    """
    busy = Counter((kind, cycle % net.interval) for kind, cycle in zip(net.kind, start, strict=True))
    used = dict.fromkeys(net.kinds, 0)
    for (kind, _), count in busy.items():
        used[net.kinds[kind]] = max(used[net.kinds[kind]], count)
    for kind in net.lasting:
        arcs = [(start[i] % net.interval, net.busy[i]) for i in net.members()[kind]]
        used[net.kinds[kind]] = max(coloured(arcs, net.interval)) + 1
    return used


def figure(problem: SchedulingProblem, net: Network, goal: Goal, start: Sequence[int], latency: int) -> int:
    """Return the cost of a schedule by a goal."""
    cost = goal.latency * latency
    if goal.units:
        used = units_used(net, start)
        cost += sum(weight * used.get(kind, 0) for kind, weight in goal.units.items())
    if goal.words:
        waiting = taps(problem, dict(zip(net.ids, start, strict=True)), latency)
        cost += sum(goal.word_weight(name) * value_words(problem, cycles) for name, cycles in waiting.items())
    return cost


def counted_kinds(goals: Iterable[Goal]) -> set[str]:
    """Return the kinds whose units some goal counts."""
    return {kind for goal in goals for kind, weight in goal.units.items() if weight}
