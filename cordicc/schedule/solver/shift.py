"""Fewer FIFO words for a schedule of any size, by moving clusters, then single operations.

With the slots held, an operation moves by whole intervals, and the entries of a value to its last tap
are a difference of integers plus a constant: a linear program of differences, solved exactly.  Single
operations then move to whatever free slot in their window saves most.  Both steps take near-linear time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.difference_constraints import ORIGIN, Differences, minimise
from cordicc.schedule.solver.reservations import Reservations, coloured
from cordicc.schedule.solver.scheduling_problem import OUT, SchedulingProblem, value_words

_ROUNDS = 4
_SWEEPS = 4
_MOST_VISITS = 400_000
"""Visits of single operations in all, which bounds the sweeps over large problems."""
BLOCK = 10_000
"""Operations that move in one linear program; those of other blocks stay meanwhile."""


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
        self._last_counts = problem.measure == "cycles"
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
            takers = wire.takers
            if len(takers) == 1:
                waits = [start[takers[0]] - ready]
            elif self._last_counts:
                waits = [max([start[taker] for taker in takers]) - ready]
            else:
                waits = sorted({start[taker] - ready for taker in takers})
            total += wire.weight * value_words(self.problem, waits)
        return total


def improve(
    problem: SchedulingProblem,
    net: Network,
    start: Sequence[int],
    latency: int,
    weights: Sequence[int],
    block: int = BLOCK,
) -> list[int]:
    """Return starts of the same latency with at most the same weighted FIFO words.

    `weights` are those of a word of each value, in the order of the problem; `block` operations move
    together.
    """
    state = _State(problem, net, weights, latency)
    blocks = [net.order[i : i + block] for i in range(0, len(net.order), block)]
    sweeps = max(2, min(_ROUNDS * _SWEEPS, _MOST_VISITS // max(1, len(net.ids))))
    best = [*start, latency]
    least = state.words(best, state.wires)
    while sweeps > 0:
        before = least
        for members in blocks:
            best = _by_intervals(state, best, members)
        best, used = _one_by_one(state, best, min(sweeps, _SWEEPS))
        sweeps -= used
        least = state.words(best, state.wires)
        if least == before:
            break
    return best[:-1]


def _by_intervals(state: _State, start: Sequence[int], block: Sequence[int]) -> list[int]:
    """Return the starts with the operations of a block moved by whole intervals, if that saves words.

    They are best for values counted to their last taps; the other operations and all slots stay.
    """
    net, interval = state.net, state.net.interval
    node = {i: position for position, i in enumerate(block, ORIGIN + 1)}
    cost = [0] * (len(block) + 1)
    gaps: dict[tuple[int, int], int] = {}

    def require(before: tuple[int, int], after: tuple[int, int], gap: int) -> None:
        """Keep one turn at least `gap` after another; turns are of a node, plus a constant."""
        (i, plus), (j, more) = before, after
        if i != j:
            gaps[i, j] = max(gap + plus - more, gaps.get((i, j), gap + plus - more))

    def turn(i: int) -> tuple[int, int]:
        """Return the turn of an operation or the end: a node of its own, or as it is."""
        return (node[i], 0) if i in node else (ORIGIN, start[i] // interval)

    slot = [cycle % interval for cycle in start]
    wires: dict[int, _Wire] = {}
    for i in block:
        require((ORIGIN, 0), turn(i), 0)
        require(turn(i), (ORIGIN, 0), -((state.latency - net.latency[i] - slot[i]) // interval))
        for producer in net.before[i]:
            least = -((slot[i] - slot[producer] - net.latency[producer]) // interval)
            require(turn(producer), turn(i), least)
        for taker in net.after[i]:
            if taker not in node:
                require(turn(i), turn(taker), -((slot[taker] - slot[i] - net.latency[i]) // interval))
        wires.update((id(wire), wire) for wire in state.touching[i])
    for wire in wires.values():
        at = slot[wire.producer] + wire.latency if wire.producer >= 0 else 0
        made = (ORIGIN, 0) if wire.producer < 0 else turn(wire.producer)
        last = len(cost)
        cost.append(wire.weight)
        cost[made[0]] -= wire.weight
        require(made, (last, 0), 0)
        for taker in wire.takers:
            # A tap k turns after its producer holds k - (at - slot) // interval entries, rounded up.
            require(turn(taker), (last, 0), -((at - slot[taker]) // interval))
    turns = minimise(Differences(tuple(cost), gaps))
    moved = list(start)
    for i in block:
        moved[i] = interval * turns[node[i]] + slot[i]
    touched = list(wires.values())
    return moved if state.words(moved, touched) < state.words(start, touched) else list(start)


def _one_by_one(state: _State, start: Sequence[int], most: int) -> tuple[list[int], int]:
    """Return the starts after at most so many sweeps over all operations, and how many there were."""
    net = state.net
    now = list(start)
    places = {kind: _places(net, kind, now) for kind, most in enumerate(net.capacity) if most is not None}
    for sweep in range(most):
        changed = False
        for index in net.order if sweep % 2 else reversed(net.order):
            taken = places.get(net.kind[index])
            if taken is not None:
                taken.leave(index, now[index])
            cycle = _best_cycle(state, now, index, taken)
            if taken is not None:
                taken.enter(index, cycle)
            if cycle != now[index]:
                now[index] = cycle
                changed = True
        if not changed:
            return now, sweep + 1
    return now, most


class _Counts:
    """The operations of a kind in each slot, all of which keep their units for a cycle."""

    def __init__(self, interval: int, capacity: int) -> None:
        self._interval, self._capacity = interval, capacity
        self._taken: Counter[int] = Counter()

    def enter(self, index: int, cycle: int) -> None:
        """Count an operation that starts in a cycle."""
        self._taken[cycle % self._interval] += 1

    def leave(self, index: int, cycle: int) -> None:
        """Undo `enter`."""
        self._taken[cycle % self._interval] -= 1

    def free(self, index: int, cycle: int) -> bool:
        """Tell whether an operation has a unit if it starts in a cycle."""
        return self._taken[cycle % self._interval] < self._capacity


class _Lasting:
    """The operations of a kind on each unit, some of which keep it for several cycles."""

    def __init__(self, net: Network, capacity: int) -> None:
        self._busy = net.busy
        self._slots = Reservations(net.interval, capacity)
        self._unit: dict[int, int] = {}

    def enter(self, index: int, cycle: int, unit: int | None = None) -> None:
        """Put an operation on a unit, the first one that is free if none is named."""
        if unit is None:
            unit = self._slots.unit_for(cycle, self._busy[index])
            assert unit is not None
        self._slots.take(unit, cycle, self._busy[index])
        self._unit[index] = unit

    def leave(self, index: int, cycle: int) -> None:
        """Undo `enter`."""
        self._slots.release(self._unit.pop(index), cycle, self._busy[index])

    def free(self, index: int, cycle: int) -> bool:
        """Tell whether an operation has a unit if it starts in a cycle."""
        return self._slots.unit_for(cycle, self._busy[index]) is not None


def _places(net: Network, kind: int, start: Sequence[int]) -> _Counts | _Lasting:
    """Return where the operations of a kind with limited units are."""
    capacity = net.capacity[kind]
    assert capacity is not None
    members = net.members()[kind]
    if kind not in net.lasting:
        counts = _Counts(net.interval, capacity)
        for index in members:
            counts.enter(index, start[index])
        return counts
    units = coloured([(start[i] % net.interval, net.busy[i]) for i in members], net.interval)
    # The colouring may need more units than there are, if its search ends early.
    lasting = _Lasting(net, max(capacity, *(unit + 1 for unit in units)))
    for index, unit in zip(members, units, strict=True):
        lasting.enter(index, start[index], unit)
    return lasting


def _best_cycle(state: _State, start: list[int], index: int, taken: _Counts | _Lasting | None) -> int:
    """Return the cycle in the window of an operation at which the values it touches hold least.

    `taken` are the places of the other operations of its kind, None if units are not limited.
    """
    net, interval = state.net, state.net.interval
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
            if taken is not None:
                while first <= place <= last and abs(place - cycle) < interval:
                    if taken.free(index, place):
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
