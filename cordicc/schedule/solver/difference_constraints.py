"""Linear programs whose constraints are differences, solved in integers as minimum-cost flows.

Minimise the sum of cost[i] x[i] subject to x[j] - x[i] >= gap.  The dual is a minimum-cost flow, so
integral optima exist on both sides; this is the problem of minimising registers in retiming and
modulo scheduling (Leiserson and Saxe, "Retiming synchronous circuitry", Algorithmica 6, 1991).  The
optimal x are potentials of the residual network; equal objectives prove them optimal.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

ORIGIN = 0


@dataclass(frozen=True, slots=True)
class Differences:
    """Minimise the sum of cost[i] x[i] subject to x[j] - x[i] >= gaps[i, j], x[ORIGIN] = 0.

    The costs sum to 0, every x is bounded below through the gaps, and no cycle of gaps is positive.
    """

    cost: tuple[int, ...]
    gaps: dict[tuple[int, int], int]


def minimise(model: Differences) -> list[int]:
    """Return the componentwise least optimal solution."""
    objective, flows = _flow(model)
    # Complementary slackness: the optimal solutions are the feasible ones in which every
    # difference that carries flow is tight.
    carrying = zip(model.gaps.items(), flows, strict=True)
    tight = [((j, i), -gap) for ((i, j), gap), flow in carrying if flow > 0]
    times = longest_paths(len(model.cost), [*model.gaps.items(), *tight])
    assert objective == sum(c * x for c, x in zip(model.cost, times, strict=True)), "duality gap"
    assert all(times[j] - times[i] >= gap for (i, j), gap in model.gaps.items()), "infeasible schedule"
    return times


def minimum(model: Differences) -> int:
    """Return the least cost alone, by duality."""
    return _flow(model)[0]


def _flow(model: Differences) -> tuple[int, list[int]]:
    """Return the least cost, and the flow on each gap.

    Duality: inflow - outflow = cost at every node, flow >= 0, sum of gap * flow largest.
    """
    from ortools.graph.python import min_cost_flow

    network = min_cost_flow.SimpleMinCostFlow()
    ends = np.array(list(model.gaps), dtype=np.int64).reshape(-1, 2)
    gaps = np.array(list(model.gaps.values()), dtype=np.int64)
    # Without cycles of negative cost, no arc of some optimal flow carries more than all supply together.
    most = sum(cost for cost in model.cost if cost > 0)
    arcs = network.add_arcs_with_capacity_and_unit_cost(
        ends[:, 0], ends[:, 1], np.full(len(gaps), most, dtype=np.int64), -gaps
    )
    for node, cost in enumerate(model.cost):
        network.set_node_supply(node, -cost)
    status = network.solve()
    assert status == network.OPTIMAL, f"minimum-cost flow: status {status}"
    return -network.optimal_cost(), network.flows(arcs).tolist()


def longest_paths(count: int, edges: Iterable[tuple[tuple[int, int], int]]) -> list[int]:
    """Return the longest distances from the origin (Bellman and Ford, with a queue).

    Every node is reachable and no cycle is positive.
    """
    leaving: list[list[tuple[int, int]]] = [[] for _ in range(count)]
    for (i, j), gap in edges:
        leaving[i].append((j, gap))
    distance: list[int | None] = [None] * count
    distance[ORIGIN] = 0
    queue = deque([ORIGIN])
    queued = {ORIGIN}
    while queue:
        i = queue.popleft()
        queued.remove(i)
        base = distance[i]
        assert base is not None
        for j, gap in leaving[i]:
            known = distance[j]
            if known is None or base + gap > known:
                assert j != ORIGIN, "positive cycle"
                distance[j] = base + gap
                if j not in queued:
                    queued.add(j)
                    queue.append(j)
    found = [d for d in distance if d is not None]
    assert len(found) == count, "unreachable node"
    return found
