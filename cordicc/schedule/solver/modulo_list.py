"""The heuristic: modulo list scheduling, improved by scheduling forwards and backwards in turns.

A pass places one operation after the other into the first free slot that its operands allow; the order
is by least slack first in the beginning, later by the schedule of the pass before, in the other
direction of time (forward-backward improvement: Li and Willis, "An iterative scheduling technique for
resource-constrained project scheduling", European Journal of Operational Research 56, 1992).  A pass
takes time near-linear in the number of operations.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.reservations import Reservations

SEED = 1
_LEAST_PASSES, _MOST_PASSES = 10, 600
_WORK = 400_000
"""Placements in all, which bounds the passes over large problems."""
_STALE_PASSES = 6


class _Slots:
    """The free slots of each kind: a bit for each slot in which a unit is left.

    Of kinds whose operations keep their units for several cycles, the free slots of each unit.
    """

    def __init__(self, network: Network) -> None:
        self._lasting: dict[int, Reservations] = {}
        for kind in network.lasting:
            capacity = network.capacity[kind]
            if capacity is not None:
                self._lasting[kind] = Reservations(network.interval, capacity)
        self._interval = network.interval
        full = (1 << network.interval) - 1
        self._free = [0 if capacity is None else full for capacity in network.capacity]
        self._capacity = network.capacity
        self._taken: list[dict[int, int]] = [{} for _ in network.kinds]

    def take(self, kind: int, cycle: int, busy: int) -> int | None:
        """Take the first free slots of a kind from `cycle` on; return the first one's cycle.

        None if no unit is free for as long as the operation keeps it.
        """
        if kind in self._lasting:
            found = self._lasting[kind].next_for(cycle, busy)
            if found is None:
                return None
            self._lasting[kind].take(found[1], found[0], busy)
            return found[0]
        capacity = self._capacity[kind]
        if capacity is None:
            return cycle
        slot = cycle % self._interval
        later = self._free[kind] >> slot
        if later:
            wait = (later & -later).bit_length() - 1
        else:
            free = self._free[kind]
            assert free, "no slot is free"
            wait = self._interval - slot + (free & -free).bit_length() - 1
        place = (slot + wait) % self._interval
        count = self._taken[kind].get(place, 0) + 1
        self._taken[kind][place] = count
        if count == capacity:
            self._free[kind] ^= 1 << place
        return cycle + wait


def place(network: Network, order: Sequence[int]) -> list[int] | None:
    """Return the starts of operations placed one by one, each as early as it can be.

    `order` has every operation after those it depends on.  None if what is left of the slots is in pieces
    too short for an operation that keeps its unit for several cycles.
    """
    slots = _Slots(network)
    start = [0] * len(order)
    latency, before, kind = network.latency, network.before, network.kind
    busy, taking = network.busy, network.taking
    for index in order:
        ready = 0
        for producer in before[index]:
            done = start[producer] + latency[producer]
            if done > ready:
                ready = done
        taken = slots.take(kind[index], ready + taking[index], busy[index])
        if taken is None:
            return None
        start[index] = taken - taking[index]
    return start


def _packed(network: Network, order: Sequence[int]) -> list[int] | None:
    """Return starts with slots given out one after the other in an order, whatever the starts.

    So no slots are left between operations of one unit.  None if even then they do not fit.
    """
    interval = network.interval
    filled: dict[int, list[int]] = {k: [0] * (c or 0) for k, c in enumerate(network.capacity)}
    slot: dict[int, int] = {}
    for index in sorted(order, key=lambda i: -network.busy[i]):
        units, busy = filled[network.kind[index]], network.busy[index]
        if network.capacity[network.kind[index]] is None:
            continue
        unit = next((unit for unit, end in enumerate(units) if end + busy <= interval), None)
        if unit is None:
            return None
        slot[index] = units[unit]
        units[unit] += busy
    start = [0] * len(order)
    for index in order:
        ready = max((start[p] + network.latency[p] for p in network.before[index]), default=0)
        wait = (slot[index] - ready - network.taking[index]) % interval if index in slot else 0
        start[index] = ready + wait
    return start


def list_schedule(network: Network, bound: int, *, effort: int = 1) -> list[int] | None:
    """Return the starts of a short schedule, from cycle 0; `bound` is a latency that ends the search.

    `effort` multiplies the work.  The same arguments give the same schedule.  None if no schedule was found,
    which may be where operations keep units for different times.
    """
    if not network.ids:
        return []
    rank = {index: position for position, index in enumerate(network.order)}
    backwards = network.reversed()
    rank_back = {index: position for position, index in enumerate(backwards.order)}
    random_order = random.Random(SEED)
    # Operations with equal latest starts go in dependence order, which latencies of 0 need.
    first = _sorted([-tail for tail in network.tail], rank)
    best = place(network, first) or _packed(network, first)
    if best is None:
        return None
    start = best
    least = network.makespan(best)
    passes = max(_LEAST_PASSES, min(_MOST_PASSES, _WORK // len(network.ids))) * effort
    stale = 0
    for _ in range(passes):
        if least <= bound:
            break
        spread = 0 if stale < _STALE_PASSES else 1 + network.interval * (stale - _STALE_PASSES) // 20
        finish = [s + c for s, c in zip(start, network.latency, strict=True)]
        late = place(backwards, _order(backwards, [-f for f in finish], rank_back, random_order, spread))
        if late is None:
            stale += 1
            continue
        latest = [-s - c for s, c in zip(late, network.latency, strict=True)]
        again = place(network, _order(network, latest, rank, random_order, spread))
        if again is None:
            stale += 1
            continue
        start = again
        if network.makespan(start) < least:
            best, least, stale = start, network.makespan(start), 0
        else:
            stale += 1
    return best


def _below(count: int, source: random.Random) -> Iterator[int]:
    """Yield random numbers below a count without end; `randrange` takes three times as long."""
    draw, bits = source.getrandbits, count.bit_length()
    while True:
        number = draw(bits)
        if number < count:
            yield number


def _sorted(keys: Sequence[int], rank: dict[int, int]) -> list[int]:
    return sorted(range(len(keys)), key=lambda index: (keys[index], rank[index]))


def _order(
    network: Network, keys: Sequence[int], rank: dict[int, int], source: random.Random, spread: int
) -> list[int]:
    """Return the operations by key, disturbed by up to `spread` cycles but after what they depend on."""
    if spread == 0:
        return _sorted(keys, rank)
    disturbed = [key + noise for key, noise in zip(keys, _below(spread + 1, source), strict=False)]
    for index in network.order:
        for producer in network.before[index]:
            if disturbed[producer] > disturbed[index]:
                disturbed[index] = disturbed[producer]
    return _sorted(disturbed, rank)
