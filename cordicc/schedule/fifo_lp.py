"""The exact schedule for initiation interval 1: fewest FIFO words, by minimum-cost flow.

With starts s, the hold time t of each value and the latency L as variables, every constraint is a
difference x_j - x_i >= w and the cost, the sum of t - ready, is linear.  The dual is a minimum-cost
flow, so integral optima exist on both sides; this is the problem of minimising registers in retiming
and modulo scheduling (Leiserson and Saxe, "Retiming synchronous circuitry", Algorithmica 6, 1991).
The optimal starts are potentials of the residual network; equal objectives prove them optimal.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from cordicc.schedule.problem import OUT, InfeasibleError, Schedule, SchedulingProblem, Value, fifo_words

Goal = Literal["latency", "fifo"]

_ORIGIN, _END = 0, 1


@dataclass(frozen=True, slots=True)
class _Differences:
    """Minimise the sum of cost[i] x_i subject to x_j - x_i >= gaps[i, j], x_origin = 0."""

    cost: tuple[int, ...]
    gaps: dict[tuple[int, int], int]


def solve(problem: SchedulingProblem, goal: Goal = "latency", max_latency: int | None = None) -> Schedule:
    """Return the schedule that is best in `goal`, then in the other one of latency and FIFO words.

    Among the optimal schedules it is the one in which every operation starts earliest.  Raises
    ValueError for a malformed problem, InfeasibleError if `max_latency` cycles are too few.
    """
    problem.check()
    critical_cycles = problem.earliest().latency
    if max_latency is not None and max_latency < critical_cycles:
        raise InfeasibleError(f"the longest path takes {critical_cycles} cycles, more than {max_latency}")
    if goal == "latency":
        model = _model(problem, 1, 0, critical_cycles, critical_cycles)
    else:
        # An optimal vertex has L <= the sum of latencies, so this weight puts FIFO words first.
        longest = sum(task.latency for task in problem.operations)
        model = _model(problem, 1 + longest, 1, critical_cycles, max_latency)
    times = _solve(model)
    start = {task.id: times[index] for index, task in enumerate(problem.operations, _END + 1)}
    latency = times[_END]
    words = fifo_words(problem, start, latency)
    proven = {"latency": True, "fifo_words": True}
    return Schedule(start, latency, words, proven, {"latency": latency, "fifo_words": words})


def _model(
    problem: SchedulingProblem, fifo_weight: int, latency_weight: int, least: int, most: int | None
) -> _Differences:
    """Return the linear program; a value with one taker is held until that taker starts."""
    node = {OUT: _END} | {task.id: index for index, task in enumerate(problem.operations, _END + 1)}
    latency = {task.id: task.latency for task in problem.operations}
    cost = [0] * (len(node) + 1)
    gaps: dict[tuple[int, int], int] = {}

    def require(before: int, after: int, gap: int) -> None:
        gaps[before, after] = max(gap, gaps.get((before, after), gap))

    cost[_END] += latency_weight
    cost[_ORIGIN] -= latency_weight
    require(_ORIGIN, _END, least)
    if most is not None:
        require(_END, _ORIGIN, -most)
    for id, index in node.items():
        require(_ORIGIN, index, 0)
        if id != OUT:
            require(index, _END, latency[id])
    for value in problem.values:
        takers = value.takers()
        producer = _ORIGIN if value.producer is None else node[value.producer]
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
        cost[last] += fifo_weight
        cost[producer] -= fifo_weight
    return _Differences(tuple(cost), gaps)


def _last(value: Value, node: dict[str, int]) -> int | None:
    """Return the taker that is last in every schedule, if one is known: the outputs, or the only one."""
    takers = value.takers()
    if OUT in takers:
        return _END
    return node[takers[0]] if len(takers) == 1 else None


def _solve(model: _Differences) -> list[int]:
    """Return the componentwise least optimal solution.

    Duality: inflow - outflow = cost at every node, flow >= 0, sum of gap * flow largest.
    """
    import networkx as nx

    network = nx.DiGraph()
    network.add_nodes_from((index, {"demand": cost}) for index, cost in enumerate(model.cost))
    network.add_edges_from((i, j, {"weight": -gap}) for (i, j), gap in model.gaps.items())
    negated, flow = nx.network_simplex(network)
    # Complementary slackness: the optimal solutions are the feasible ones in which every
    # difference that carries flow is tight.
    tight = [((j, i), -gap) for (i, j), gap in model.gaps.items() if flow[i][j] > 0]
    times = _longest_paths(len(model.cost), [*model.gaps.items(), *tight])
    assert sum(c * x for c, x in zip(model.cost, times, strict=True)) == -negated, "duality gap"
    assert all(times[j] - times[i] >= gap for (i, j), gap in model.gaps.items()), "infeasible schedule"
    return times


def _longest_paths(count: int, edges: Iterable[tuple[tuple[int, int], int]]) -> list[int]:
    """Return the longest distances from the origin (Bellman and Ford, with a queue).

    Every node is reachable and no cycle is positive.
    """
    leaving: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    for (i, j), gap in edges:
        leaving[i].append((j, gap))
    distance: list[int | None] = [None] * count
    distance[_ORIGIN] = 0
    queue = deque([_ORIGIN])
    queued = {_ORIGIN}
    while queue:
        i = queue.popleft()
        queued.remove(i)
        base = distance[i]
        assert base is not None
        for j, gap in leaving[i]:
            known = distance[j]
            if known is None or base + gap > known:
                assert j != _ORIGIN, "positive cycle"
                distance[j] = base + gap
                if j not in queued:
                    queued.add(j)
                    queue.append(j)
    found = [d for d in distance if d is not None]
    assert len(found) == count, "unreachable node"
    return found
