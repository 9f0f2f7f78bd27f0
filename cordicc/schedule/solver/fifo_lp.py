"""The exact schedule for initiation interval 1: fewest FIFO words, by minimum-cost flow.

With starts s, the hold time t of each value and the latency L as variables, every constraint is a
difference x_j - x_i >= w and the cost, the sum of t - ready, is linear.  At larger intervals the same
program, which knows nothing of units, bounds the cycles that values wait from below.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

from cordicc.schedule.solver.dependences import network
from cordicc.schedule.solver.difference_constraints import ORIGIN, Differences, minimise, minimum
from cordicc.schedule.solver.scheduling_problem import (
    OUT,
    InfeasibleError,
    Schedule,
    SchedulingProblem,
    TaskValue,
    fifo_words,
)

First = Literal["latency", "fifo"]

_END = 1
MOST_WHOLE = 100_000
"""Operations up to which the program is solved as a whole; its time grows faster than they do."""


def solve(
    problem: SchedulingProblem,
    goal: First = "latency",
    max_latency: int | None = None,
    width: Mapping[str, int] | None = None,
) -> Schedule:
    """Return the schedule that is best in `goal`, then in the other one of latency and FIFO words.

    Words count `width` times each if given.  Among the optimal schedules it is the one in which every
    operation starts earliest.  Raises ValueError for a malformed problem, InfeasibleError if
    `max_latency` cycles are too few.
    """
    problem.check()
    critical_cycles = problem.earliest().latency
    if max_latency is not None and max_latency < critical_cycles:
        raise InfeasibleError(f"the longest path takes {critical_cycles} cycles, more than {max_latency}")
    if goal == "latency":
        model = _model(problem, 1, 0, critical_cycles, critical_cycles, width)
    else:
        # An optimal vertex has L <= the sum of latencies, so this weight puts FIFO words first.
        longest = sum(task.latency for task in problem.operations)
        model = _model(problem, 1 + longest, 1, critical_cycles, max_latency, width)
    times = minimise(model)
    start = {task.id: times[index] for index, task in enumerate(problem.operations, _END + 1)}
    latency = times[_END]
    words = fifo_words(problem, start, latency)
    least_words = words if width is None else least_cycles(problem, latency)
    proven = {"latency": True, "fifo_words": words == least_words}
    return Schedule(start, latency, words, proven, {"latency": latency, "fifo_words": least_words})


def least_cycles(problem: SchedulingProblem, latency: int, most_whole: int = MOST_WHOLE) -> int:
    """Return the fewest cycles that values wait at a latency, whatever the units: a bound of words.

    Of problems of more than `most_whole` operations less: blocks of so many, in the order of dependences,
    are bounded one by one, what happens outside a block being free within the windows that the longest
    paths leave.
    """
    if len(problem.operations) <= most_whole:
        return minimum(_model(problem, 1, 0, latency, latency, None)) - _in_units(problem, problem.values)
    net = network(problem, {})
    index = {id: i for i, id in enumerate(net.ids)}
    block = {net.ids[i]: position // most_whole for position, i in enumerate(net.order)}
    blocks: dict[int, list[TaskValue]] = {}
    for value in problem.values:
        takers = [taker for taker in value.takers() if taker != OUT]
        if value.consumers:
            first = value.producer or min(takers, key=lambda id: block[id], default=None)
            blocks.setdefault(0 if first is None else block[first], []).append(value)
    total = 0
    for values in blocks.values():
        ends = {end for value in values for end in (value.producer, *value.takers())} - {None, OUT}
        inside = [problem.operations[i] for i in sorted(index[id] for id in ends if id is not None)]
        part = SchedulingProblem(tuple(inside), tuple(values), problem.interval)
        model = _model(part, 1, 0, latency, latency, None)
        for node, task in enumerate(inside, _END + 1):
            i = index[task.id]
            model.gaps[ORIGIN, node] = net.head[i]
            model.gaps[node, _END] = net.tail[i]
        total += minimum(model) - _in_units(problem, values)
    return total


def _in_units(problem: SchedulingProblem, values: Iterable[TaskValue]) -> int:
    """Return the cycles from the starts of the operations that make values to their ends."""
    latency = {task.id: task.latency for task in problem.operations}
    return sum(latency[v.producer] for v in values if v.consumers and v.producer is not None)


def _model(
    problem: SchedulingProblem,
    fifo_weight: int,
    latency_weight: int,
    least: int,
    most: int | None,
    width: Mapping[str, int] | None,
) -> Differences:
    """Return the linear program; a value with one taker is held until that taker starts."""
    node = {OUT: _END} | {task.id: index for index, task in enumerate(problem.operations, _END + 1)}
    latency = {task.id: task.latency for task in problem.operations}
    cost = [0] * (len(node) + 1)
    gaps: dict[tuple[int, int], int] = {}

    def require(before: int, after: int, gap: int) -> None:
        gaps[before, after] = max(gap, gaps.get((before, after), gap))

    cost[_END] += latency_weight
    cost[ORIGIN] -= latency_weight
    require(ORIGIN, _END, least)
    if most is not None:
        require(_END, ORIGIN, -most)
    for id, index in node.items():
        require(ORIGIN, index, 0)
        if id != OUT:
            require(index, _END, latency[id])
    for value in problem.values:
        takers = value.takers()
        producer = ORIGIN if value.producer is None else node[value.producer]
        for taker in takers:
            require(producer, node[taker], 0 if value.producer is None else latency[value.producer])
        if not takers:
            continue
        last = _last(value, node)
        if last is None:
            last = len(cost)
            cost.append(0)
            for taker in takers:
                require(node[taker], last, 0)
        weight = fifo_weight * (1 if width is None else width[value.name])
        cost[last] += weight
        cost[producer] -= weight
    return Differences(tuple(cost), gaps)


def _last(value: TaskValue, node: dict[str, int]) -> int | None:
    """Return the taker that is last in every schedule, if one is known: the outputs, or the only one."""
    takers = value.takers()
    if OUT in takers:
        return _END
    return node[takers[0]] if len(takers) == 1 else None
