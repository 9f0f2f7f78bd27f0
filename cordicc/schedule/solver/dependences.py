"""The dependences of a scheduling problem by number, for algorithms that visit them often."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cordicc.schedule.solver.scheduling_problem import SchedulingProblem


@dataclass(frozen=True, slots=True)
class Network:
    """Operations by their index in the problem, kinds by their index in `kinds`.

    An operation keeps its unit for `busy` cycles, from `taking` cycles after its start on.  `capacity` is the
    number of units of a kind, None if unlimited.  `head` is the earliest start of an operation, `tail` the
    longest way from its start to the end, both by dependences alone.  A kind whose operations all fit
    whatever their slots counts as unlimited.
    """

    ids: tuple[str, ...]
    latency: tuple[int, ...]
    busy: tuple[int, ...]
    taking: tuple[int, ...]
    kind: tuple[int, ...]
    kinds: tuple[str, ...]
    capacity: tuple[int | None, ...]
    interval: int
    before: tuple[tuple[int, ...], ...]
    after: tuple[tuple[int, ...], ...]
    order: tuple[int, ...]
    head: tuple[int, ...]
    tail: tuple[int, ...]

    @property
    def critical(self) -> int:
        """Return the length of the longest path in cycles."""
        return max((h + t for h, t in zip(self.head, self.tail, strict=True)), default=0)

    def reversed(self) -> Network:
        """Return the network in which time runs backwards; a start there is minus a finish here."""
        spans = zip(self.latency, self.busy, self.taking, strict=True)
        return build(
            self.ids,
            self.latency,
            self.busy,
            [latency - busy - taking for latency, busy, taking in spans],
            self.kind,
            self.kinds,
            self.capacity,
            self.interval,
            self.after,
            self.before,
        )

    @property
    def lasting(self) -> list[int]:
        """Return the kinds of which some operation keeps its unit for more than a cycle."""
        return sorted({kind for kind, busy in zip(self.kind, self.busy, strict=True) if busy > 1})

    def members(self) -> list[list[int]]:
        """Return the operations of each kind."""
        found: list[list[int]] = [[] for _ in self.kinds]
        for index, kind in enumerate(self.kind):
            found[kind].append(index)
        return found

    def makespan(self, start: Sequence[int]) -> int:
        """Return the cycle in which the last operation finishes, from cycle 0."""
        return max((s + c for s, c in zip(start, self.latency, strict=True)), default=0)


def build(
    ids: Sequence[str],
    latency: Sequence[int],
    busy: Sequence[int],
    taking: Sequence[int],
    kind: Sequence[int],
    kinds: Sequence[str],
    capacity: Sequence[int | None],
    interval: int,
    before: Sequence[Sequence[int]],
    after: Sequence[Sequence[int]],
) -> Network:
    """Return a network with its order, heads and tails; the dependences form no cycle."""
    waiting = [len(each) for each in before]
    order = [index for index, count in enumerate(waiting) if count == 0]
    head = [0] * len(ids)
    for index in order:
        done = head[index] + latency[index]
        for taker in after[index]:
            head[taker] = max(head[taker], done)
            waiting[taker] -= 1
            if waiting[taker] == 0:
                order.append(taker)
    assert len(order) == len(ids), "operations depend on one another"
    tail = list(latency)
    for index in reversed(order):
        for taker in after[index]:
            tail[index] = max(tail[index], latency[index] + tail[taker])
    return Network(
        tuple(ids), tuple(latency), tuple(busy), tuple(taking), tuple(kind), tuple(kinds), tuple(capacity),
        interval, tuple(tuple(each) for each in before), tuple(tuple(each) for each in after),
        tuple(order), tuple(head), tuple(tail),
    )  # fmt: skip


def network(problem: SchedulingProblem, limits: Mapping[str, int] | None = None) -> Network:
    """Return the network of a checked problem, `limits` in place of its own if given."""
    position = {task.id: index for index, task in enumerate(problem.operations)}
    counts = problem.counts()
    kinds = {kind: index for index, kind in enumerate(counts)}
    given = problem.limits if limits is None else limits
    capacity = [
        given[kind] if kind in given and given[kind] < count else None for kind, count in counts.items()
    ]
    before: list[dict[int, None]] = [{} for _ in position]
    after: list[dict[int, None]] = [{} for _ in position]
    for producer, taker in problem.edges():
        before[position[taker]][position[producer]] = None
        after[position[producer]][position[taker]] = None
    tasks = problem.operations
    return build(
        [task.id for task in tasks], [task.latency for task in tasks], [task.busy for task in tasks],
        [0] * len(tasks), [kinds[task.kind] for task in tasks], tuple(kinds), capacity, problem.interval,
        [tuple(b) for b in before], [tuple(a) for a in after],
    )  # fmt: skip
