"""The constraint program where units are a variable, which the heuristics seldom leave to it."""

import pytest

from cordicc.schedule.solver.cp_program import Space
from cordicc.schedule.solver.cp_search import Work, minimise
from cordicc.schedule.solver.dependences import network
from cordicc.schedule.solver.goals import FIFO_WORDS, Goal
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem, Task, TaskValue

CHAIN = SchedulingProblem(
    tuple(Task(id, "cau", 3) for id in "abc"),
    (
        TaskValue("a.r", "a", (("b", "x"),)),
        TaskValue("b.r", "b", (("c", "x"),)),
        TaskValue("c.r", "c", (("out", "q"),)),
    ),
    interval=4,
)


@pytest.mark.parametrize("most", [1, 2, 3])
@pytest.mark.parametrize(("goal", "cost"), [(Goal("units", {"cau": 1}), 1), (FIFO_WORDS, 0)])
def test_units_within_a_range(most: int, goal: Goal, cost: int) -> None:
    net = network(CHAIN, {})
    space = Space(net.head, net.tail, (9, 12), {"cau": (1, most)})
    answer = minimise(CHAIN, net, goal, space, Work(2.0))
    assert (answer.cost, answer.bound, answer.proven) == (cost, cost, True)


def test_a_space_without_a_schedule_is_told() -> None:
    net = network(CHAIN, {"cau": 1})
    tight = SchedulingProblem(CHAIN.operations, CHAIN.values, interval=3)
    space = Space(net.head, net.tail, (9, 9), {"cau": (1, 1)})
    answer = minimise(tight, network(tight, {}), Goal("units", {"cau": 1}), space, Work(2.0))
    assert answer.infeasible
    assert answer.start is None
