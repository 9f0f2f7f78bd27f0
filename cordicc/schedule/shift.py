"""Fewer FIFO words for a schedule of any size, by moving clusters, then single operations.

With the slots held, an operation moves by whole intervals, and the entries of a value to its last tap
are a difference of integers plus a constant: a linear program of differences, solved exactly.  Single
operations then move to whatever free slot in their window saves most.  Both steps take near-linear time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from cordicc.schedule.differences import ORIGIN, Differences, minimise
from cordicc.schedule.network import Network
from cordicc.schedule.problem import OUT, SchedulingProblem, value_words

_ROUNDS = 4
_SWEEPS = 4
_MOST_FLOW = 20_000
"""Operations up to which the linear program is solved."""


@dataclass(frozen=True, slots=True)
class _Wire:
    """A value: its producer (-1: an input) and that one's latency, its takers (the count: the end)."""

    producer: int
    latency: int
    takers: tuple[int, ...]
    weight: int


class _State:
    """Starts, in a list with the end's cycle last, and the free places of each slot."""

    def __init__(
        self, problem: SchedulingProblem, net: Network, weights: Sequence[int], latency: int
    ) -> None:
        self.problem, self.net, self.latency = problem, net, latency
        count = len(net.ids)
        index = {id: i for i, id in enumerate(net.ids)} | {OUT: count}
        self.wires = [
            _Wire(
                -1 if value.producer is None else index[value.producer],
                0 if value.producer is None else net.latency[index[value.producer]],
                tuple(index[taker] for taker in value.takers()),
                weight,
            )
            for value, weight in zip(problem.values, weights, strict=True)
            if value.consumers
        ]
        self.touching: list[list[_Wire]] = [[] for _ in range(count + 1)]
        for wire in self.wires:
            for node in {wire.producer, *wire.takers} - {-1}:
                self.touching[node].append(wire)

    def words(self, start: Sequence[int], wires: Iterable[_Wire]) -> int:
        """Return the weighted words of some values."""
        total = 0
        for wire in wires:
            ready = 0 if wire.producer < 0 else start[wire.producer] + wire.latency
            waits = sorted({start[taker] - ready for taker in wire.takers})
            total += wire.weight * value_words(self.problem, waits)
        return total


def improve(
    problem: SchedulingProblem, net: Network, start: Sequence[int], latency: int, weights: Sequence[int]
) -> list[int]:
    """Return starts of the same latency with at most the same weighted FIFO words.

    `weights` are those of a word of each value, in the order of the problem.
    """
    state = _State(problem, net, weights, latency)
    best = [*start, latency]
    least = state.words(best, state.wires)
    for _ in range(_ROUNDS):
        before = least
        if len(net.ids) <= _MOST_FLOW:
            moved = _by_intervals(state, best)
            words = state.words(moved, state.wires)
            if words < least:
                best, least = moved, words
        best = _one_by_one(state, best)
        least = state.words(best, state.wires)
        if least == before:
            break
    return best[:-1]


def _by_intervals(state: _State, start: Sequence[int]) -> list[int]:
    """Return the best starts with the same slots, each value counted to its last tap."""
    net, interval = state.net, state.net.interval
    count = len(net.ids)
    end = count + 1
    cost = [0] * (count + 2)
    gaps: dict[tuple[int, int], int] = {}

    def require(before: int, after: int, gap: int) -> None:
        gaps[before, after] = max(gap, gaps.get((before, after), gap))

    slot = [cycle % interval for cycle in start]
    turn = start[count] // interval
    require(ORIGIN, end, turn)
    require(end, ORIGIN, -turn)
    for i in range(count):
        require(ORIGIN, i + 1, 0)
        require(i + 1, ORIGIN, -((state.latency - net.latency[i] - slot[i]) // interval))
        for taker in net.after[i]:
            require(i + 1, taker + 1, -((slot[taker] - slot[i] - net.latency[i]) // interval))
    for wire in state.wires:
        at = slot[wire.producer] + wire.latency if wire.producer >= 0 else 0
        # A tap k turns after its producer holds k - (at - slot) // interval entries, rounded up.
        extra = {taker: -((at - slot[taker]) // interval) for taker in wire.takers}
        last = len(cost)
        cost.append(wire.weight)
        cost[wire.producer + 1] -= wire.weight
        for taker, entries in extra.items():
            require(taker + 1, last, entries)
    turns = minimise(Differences(tuple(cost), gaps))
    return [interval * turns[i + 1] + slot[i] for i in range(count)] + [start[count]]


def _one_by_one(state: _State, start: Sequence[int]) -> list[int]:
    net, interval = state.net, state.net.interval
    now = list(start)
    busy: dict[int, Counter[int]] = {
        kind: Counter() for kind, capacity in enumerate(net.capacity) if capacity is not None
    }
    for index, kind in enumerate(net.kind):
        if kind in busy:
            busy[kind][now[index] % interval] += 1
    for sweep in range(_SWEEPS):
        changed = False
        for index in net.order if sweep % 2 else reversed(net.order):
            taken = busy.get(net.kind[index])
            cycle = _best_cycle(state, now, index, taken)
            if cycle != now[index]:
                if taken is not None:
                    taken[now[index] % interval] -= 1
                    taken[cycle % interval] += 1
                now[index] = cycle
                changed = True
        if not changed:
            break
    return now


def _best_cycle(state: _State, start: list[int], index: int, taken: Counter[int] | None) -> int:
    """Return the cycle in the window of an operation at which the values it touches hold least."""
    net, interval = state.net, state.net.interval
    capacity = net.capacity[net.kind[index]]
    old = start[index]
    first = max((start[p] + net.latency[p] for p in net.before[index]), default=0)
    last = min((start[t] for t in net.after[index]), default=state.latency) - net.latency[index]
    if first == last:
        return old
    wires = state.touching[index]
    best, least = old, state.words(start, wires)
    for cycle in _candidates(state, start, index, first, last):
        # The nearest free slot on either side, within the window.
        for step in (-1, 1):
            place = cycle
            if taken is not None and capacity is not None:
                while first <= place <= last and abs(place - cycle) < interval:
                    if taken[place % interval] < capacity or place % interval == old % interval:
                        break
                    place += step
                else:
                    continue
            start[index] = place
            words = state.words(start, wires)
            if words < least:
                best, least = place, words
            if taken is None:
                break
    start[index] = old
    return best


def _candidates(state: _State, start: Sequence[int], index: int, first: int, last: int) -> list[int]:
    """Return the cycles at which the words of the touched values may be least."""
    interval = state.net.interval
    cycles = {first, last}
    for wire in state.touching[index]:
        if wire.producer == index:
            cycles.update(start[taker] - wire.latency for taker in wire.takers[:4])
        else:
            ready = 0 if wire.producer < 0 else start[wire.producer] + wire.latency
            cycles.update((ready, *(start[taker] for taker in wire.takers[:4] if taker != index)))
    aligned = set(cycles)
    for cycle in cycles:
        aligned.add(first + (cycle - first) % interval)
        aligned.add(last - (last - cycle) % interval)
    return sorted(cycle for cycle in aligned if first <= cycle <= last)
