"""Lower bounds of the latency: dependences, units, and both together.

With `c` units of a kind, a set of its operations that start in a window of w cycles has at most c w
members: per kind, operations with heads and tails form a one-machine problem with unit times, which
scheduling by largest tail solves exactly (Jackson's rule).  And modulo the interval, operations whose
windows lie within w < interval consecutive slots have at most c w members (Hall's condition).

An operation that keeps its unit for several cycles counts as pieces of a cycle each, one after the other:
what these need, it needs.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

import numpy as np

from cordicc.schedule.solver.dependences import Network
from cordicc.schedule.solver.scheduling_problem import fewest_units

_MOST_CLOSURES = 1000
"""Operations up to which heads and tails are raised by what all their ancestors need."""
_MOST_SLOTS = 2048


def fewest_by_kind(network: Network) -> dict[str, int]:
    """Return a number of units of each kind that its operations need at least, see `fewest_units`."""
    return {
        kind: fewest_units([network.busy[i] for i in members], network.interval)
        for kind, members in zip(network.kinds, network.members(), strict=True)
    }


def latency_bound(network: Network) -> int:
    """Return a latency that no schedule within the capacities undercuts."""
    bound = network.critical
    if all(capacity is None for capacity in network.capacity):
        return bound
    head, tail = raised(network)
    bound = max(bound, *(h + t for h, t in zip(head, tail, strict=True)))
    for members, capacity in zip(network.members(), network.capacity, strict=True):
        if capacity is None:
            continue
        jobs = [piece for i in members for piece in _pieces(network, i, head[i], tail[i])]
        bound = max(bound, jackson(jobs, capacity))
        bound = _slot_bound(jobs, capacity, network.interval, bound)
    return bound


def _pieces(network: Network, index: int, head: int, tail: int) -> Iterator[tuple[int, int]]:
    """Yield head and tail of each cycle in which an operation keeps its unit."""
    first = network.taking[index]
    for cycle in range(first, first + network.busy[index]):
        yield head + cycle, tail - cycle


def jackson(jobs: Sequence[tuple[int, int]], capacity: int) -> int:
    """Return the least max(start + tail) of jobs (head, tail), `capacity` of which start in a cycle.

    Heads may be negative: backwards in time, an operation may keep its unit after its result has left.
    """
    waiting = sorted(jobs)
    open_tails: list[int] = []
    cycle = waiting[0][0] if waiting else 0
    position = best = 0
    while position < len(waiting) or open_tails:
        if not open_tails:
            cycle = max(cycle, waiting[position][0])
        while position < len(waiting) and waiting[position][0] <= cycle:
            heapq.heappush(open_tails, -waiting[position][1])
            position += 1
        for _ in range(min(capacity, len(open_tails))):
            best = max(best, cycle - heapq.heappop(open_tails))
        cycle += 1
    return best


def raised(network: Network) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return heads and tails raised by what all ancestors and all descendants of one kind need."""
    limited = any(capacity is not None for capacity in network.capacity)
    if not limited or len(network.ids) > _MOST_CLOSURES:
        return network.head, network.tail
    back = _raised_heads(network.reversed())
    return _raised_heads(network), tuple(h + c for h, c in zip(back, network.latency, strict=True))


def _raised_heads(network: Network) -> tuple[int, ...]:
    count = len(network.ids)
    head = [0] * count
    unreached = np.iinfo(np.int64).min // 2
    way = np.full((count, count), unreached, dtype=np.int64)  # [i, a]: longest way from a's start to i's
    kind = np.array(network.kind)
    limited = [(k, capacity) for k, capacity in enumerate(network.capacity) if capacity is not None]
    for index in network.order:
        row = way[index]
        for producer in network.before[index]:
            np.maximum(row, way[producer] + network.latency[producer], out=row)
            row[producer] = max(row[producer], network.latency[producer])
            head[index] = max(head[index], head[producer] + network.latency[producer])
        for k, capacity in limited:
            ancestors = np.nonzero((row >= 0) & (kind == k))[0]
            if len(ancestors) > capacity:
                ways = ((a, head[a], int(row[a])) for a in map(int, ancestors))
                jobs = [piece for way in ways for piece in _pieces(network, *way)]
                head[index] = max(head[index], jackson(jobs, capacity))
    return tuple(head)


def _slot_bound(jobs: Sequence[tuple[int, int]], capacity: int, interval: int, bound: int) -> int:
    """Return the least latency from `bound` on that Hall's condition on the slots allows."""
    if interval > _MOST_SLOTS:
        return bound
    heads = np.array([h for h, _ in jobs], dtype=np.int64)
    tails = np.array([t for _, t in jobs], dtype=np.int64)
    low, high = bound, bound + interval
    # At bound + interval every window spans all slots; windows grow with the latency.
    while low < high:
        middle = (low + high) // 2
        if _slots_suffice(heads, middle - tails, capacity, interval):
            high = middle
        else:
            low = middle + 1
    return low


def _slots_suffice(
    first: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
    last: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
    capacity: int,
    interval: int,
) -> bool:
    """Tell whether no stretch of slots holds more windows (first to last cycle) than it has places."""
    width = last - first + 1
    narrow = width < interval
    count = np.zeros((interval + 1, interval), dtype=np.int64)  # [width, slot of the first cycle]
    np.add.at(count, (width[narrow], first[narrow] % interval), 1)
    up_to = np.cumsum(count, axis=0)  # windows from a slot of at most a width
    inside = np.zeros(interval, dtype=np.int64)  # windows within the stretch of a length, by its first slot
    for length in range(1, interval):
        inside = np.roll(inside, -1) + up_to[length]
        if np.any(inside > capacity * length):
            return False
    return True
