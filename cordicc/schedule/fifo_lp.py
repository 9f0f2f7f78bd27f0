"""The exact schedule for initiation interval 1: fewest FIFO words, by minimum-cost flow.

With starts s, the hold time t of each value and the latency L as variables, every constraint is a
difference x_j - x_i >= w and the cost, the sum of t - ready, is linear.  At larger intervals the same
program, which knows nothing of units, bounds the cycles that values wait from below.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from cordicc.schedule.differences import ORIGIN, Differences, minimise
from cordicc.schedule.problem import (
    OUT,
    InfeasibleError,
    Schedule,
    SchedulingProblem,
    Value,
    fifo_words,
    taps,
)

First = Literal["latency", "fifo"]

_END = 1


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


def least_cycles(problem: SchedulingProblem, latency: int) -> int:
    """Return the fewest cycles that values wait at a latency, whatever the units: a bound of words."""
    times = minimise(_model(problem, 1, 0, latency, latency, None))
    start = {task.id: times[index] for index, task in enumerate(problem.operations, _END + 1)}
    return sum(cycles[-1] for cycles in taps(problem, start, latency).values())


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


def _last(value: Value, node: dict[str, int]) -> int | None:
    """Return the taker that is last in every schedule, if one is known: the outputs, or the only one."""
    takers = value.takers()
    if OUT in takers:
        return _END
    return node[takers[0]] if len(takers) == 1 else None
