from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cordicc.plan.verify import verify
from cordicc.schedule.delays import delays
from cordicc.schedule.solver.fifo_lp import solve
from cordicc.schedule.solver.scheduling_problem import InfeasibleError, SchedulingProblem, fifo_words, waits
from tests.support.every_schedule import every_schedule
from tests.support.random_plans import Flow, flows
from tests.support.selection import examples

relaxed = settings(deadline=None, max_examples=examples(150))


@relaxed
@given(flows(most_operations=5, most_latency=3))
def test_fifo_words_are_least_at_the_critical_path(flow: Flow) -> None:
    problem = flow.problem()
    solved = solve(problem)
    assume(len(problem.operations) * solved.latency < 40)
    least = min(fifo_words(problem, s, solved.latency) for s in every_schedule(problem, solved.latency))
    assert solved.fifo_words == least


@relaxed
@given(flows(most_operations=4, most_latency=2), st.integers(0, 2) | st.none())
def test_fifo_goal_is_lexicographic(flow: Flow, spare: int | None) -> None:
    problem = flow.problem()
    critical = solve(problem).latency
    longest = critical + spare if spare is not None else sum(task.latency for task in problem.operations)
    solved = solve(problem, "fifo", None if spare is None else longest)
    found = (
        (fifo_words(problem, start, latency), latency)
        for latency in range(critical, longest + 1)
        for start in every_schedule(problem, latency)
    )
    assert (solved.fifo_words, solved.latency) == min(found)


@relaxed
@given(flows(most_operations=12))
def test_never_worse_than_asap(flow: Flow) -> None:
    problem = flow.problem()
    asap, solved, thrifty = problem.earliest(), solve(problem), solve(problem, "fifo")
    assert solved.latency == asap.latency == solved.bounds["latency"]
    assert thrifty.fifo_words <= solved.fifo_words <= asap.fifo_words
    assert all(asap.start[id] <= cycle for id, cycle in solved.start.items())
    assert solved == solve(problem)
    if asap.latency:
        with pytest.raises(InfeasibleError):
            solve(problem, max_latency=asap.latency - 1)


@relaxed
@given(flows())
def test_the_order_of_the_problem_does_not_matter(flow: Flow) -> None:
    problem = flow.problem()
    turned = SchedulingProblem(problem.operations[::-1], problem.values[::-1])
    assert solve(turned).start == solve(problem).start


@relaxed
@given(flows(most_operations=10), st.sampled_from(["asap", "latency", "fifo"]))
def test_delays_make_a_plan_that_verifies(flow: Flow, method: str) -> None:
    problem = flow.problem()
    schedule = problem.earliest() if method == "asap" else solve(problem, method)  # type: ignore[arg-type]
    plan = flow.plan(schedule)
    verify(plan)
    assert sum(fifo.depth for fifo in plan.fifos) == schedule.fifo_words
    assert delays(problem, schedule, {v.name: 24 for v in problem.values}) == plan.fifos
    delayed = {sink for fifo in plan.fifos for sink in fifo.sinks}
    for sink, wait in waits(problem, schedule.start, schedule.latency).items():
        assert (".".join(sink) in delayed) == (wait > 0)


@relaxed
@given(flows(), st.data())
def test_verify_sees_every_wrong_depth_and_start(flow: Flow, data: st.DataObject) -> None:
    plan = flow.plan(solve(flow.problem()))
    change = data.draw(st.sampled_from([-1, 1, 7]))
    if plan.fifos and data.draw(st.booleans()):
        index = data.draw(st.integers(0, len(plan.fifos) - 1))
        fifos = list(plan.fifos)
        fifos[index] = replace(fifos[index], depth=fifos[index].depth + change)
        wrong = replace(plan, fifos=tuple(fifos))
    else:
        moved = [o for o in plan.operations if any(operand.value for operand in o.operands)]
        assume(moved)
        chosen = data.draw(st.sampled_from(moved))
        late = replace(chosen, start=chosen.start + change, finish=chosen.finish + change)
        operations = tuple(late if o is chosen else o for o in plan.operations)
        wrong = replace(plan, operations=operations)
    with pytest.raises(AssertionError, match=r"f[0-9]|o[0-9]|latency|fifo_words"):
        verify(wrong)
