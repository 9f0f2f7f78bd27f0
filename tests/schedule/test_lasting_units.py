"""Units that an operation keeps for several cycles: the engine against exhaustive search, and binding."""

import json
import random
from collections.abc import Iterator
from dataclasses import replace
from itertools import count, pairwise, product

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cordicc.base.diagnostics import Unattainable
from cordicc.plan.netlist import ConstantWord
from cordicc.schedule.bare import parse_graph, schedule_graph
from cordicc.schedule.binding import Wiring, bind
from cordicc.schedule.solver.dependences import network
from cordicc.schedule.solver.engine import Effort, solve
from cordicc.schedule.solver.goals import FIFO_WORDS, LATENCY, Goal, units_used
from cordicc.schedule.solver.latency_bounds import latency_bound, raised
from cordicc.schedule.solver.modulo_list import list_schedule
from cordicc.schedule.solver.reservations import Reservations, coloured
from cordicc.schedule.solver.scheduling_problem import (
    InfeasibleError,
    SchedulingProblem,
    Task,
    TaskValue,
    fewest_units,
    fifo_words,
)
from cordicc.schedule.verify_bare import verify_bare
from tests.support.every_schedule import every_schedule
from tests.support.random_plans import Flow, flows
from tests.support.selection import examples

relaxed = settings(deadline=None, max_examples=examples(60))
UNITS = Goal("processors", {"mix": 1})

Arc = tuple[int, int]


def meet(one: Arc, other: Arc, interval: int) -> bool:
    slots = [{(slot + later) % interval for later in range(busy)} for slot, busy in (one, other)]
    return not slots[0].isdisjoint(slots[1])


def apart(arcs: list[Arc], units: list[int], interval: int) -> bool:
    pairs = ((i, j) for i in range(len(arcs)) for j in range(i))
    return not any(units[i] == units[j] and meet(arcs[i], arcs[j], interval) for i, j in pairs)


def least_units(arcs: list[Arc], interval: int) -> int:
    return next(
        n
        for n in count()
        if any(apart(arcs, list(units), interval) for units in product(range(n), repeat=len(arcs)))
    )


@st.composite
def lasting(draw: st.DrawFn, most_operations: int = 4, most_latency: int = 3) -> SchedulingProblem:
    flow: Flow = draw(flows(most_operations=most_operations, most_latency=most_latency))
    interval = draw(st.integers(2, 5))
    problem = replace(flow.problem(), interval=interval, measure=draw(st.sampled_from(["entries", "cycles"])))
    same = draw(st.none() | st.integers(1, interval))
    tasks = [
        replace(task, busy=draw(st.integers(1, interval)) if same is None else same)
        for task in problem.operations
    ]
    assume(tasks)
    return replace(problem, operations=tuple(tasks))


def arcs_of(problem: SchedulingProblem, start: dict[str, int]) -> list[Arc]:
    return [(start[task.id] % problem.interval, task.busy) for task in problem.operations]


def within(problem: SchedulingProblem, latency: int, units: int) -> Iterator[dict[str, int]]:
    """Yield the schedules of a latency whose operations fit on so many units."""
    for start in every_schedule(problem, latency):
        arcs = arcs_of(problem, start)
        if any(apart(arcs, list(on), problem.interval) for on in product(range(units), repeat=len(arcs))):
            yield start


@relaxed
@given(lasting())
def test_units_then_latency_then_words(problem: SchedulingProblem) -> None:
    solved = solve(problem, [UNITS, LATENCY, FIFO_WORDS])
    units, latency = solved.figures["processors"], solved.latency
    assume(latency < 9)
    assert all(solved.optimal.values())
    assert apart_on(problem, dict(solved.start), units)
    # A cycle less, a unit less (as late as any schedule needs to be), a word less: none of them is possible.
    assert not any(within(problem, latency - 1, units))
    late = latency + problem.interval
    if units > 1 and late < 9:
        assert not any(within(problem, late, units - 1))
    least = min(fifo_words(problem, start, latency) for start in within(problem, latency, units))
    assert solved.fifo_words == least


def apart_on(problem: SchedulingProblem, start: dict[str, int], units: int) -> bool:
    arcs = arcs_of(problem, start)
    found = coloured(arcs, problem.interval)
    return apart(arcs, found, problem.interval) and max(found) < units


@relaxed
@given(lasting(), st.integers(1, 3))
def test_latency_bounds_hold(problem: SchedulingProblem, units: int) -> None:
    limited = problem.limited({"mix": units})
    try:
        limited.check()
    except InfeasibleError:
        assert units < len(problem.operations)
        return
    net = network(limited)
    bound = latency_bound(net)
    assume(bound <= 8)
    assert not any(within(problem, bound - 1, units))


@relaxed
@given(lasting(most_operations=12), st.integers(1, 4))
def test_list_schedules_fit(problem: SchedulingProblem, units: int) -> None:
    assume(units >= problem.fewest("mix"))
    net = network(problem.limited({"mix": units}))
    start = list_schedule(net, 0)
    if start is None:
        return
    assert all(start[p] + net.latency[p] <= start[i] for i in range(len(start)) for p in net.before[i])
    if net.capacity[0] is not None:
        arcs = arcs_of(problem, dict(zip(net.ids, start, strict=True)))
        # The list scheduler keeps each on one unit; colouring finds so many, but for its bounded search.
        assert max(coloured(arcs, problem.interval)) < units
        assert units_used(net, start)["mix"] <= units


@relaxed
@given(st.integers(1, 7).flatmap(lambda n: st.tuples(st.just(n), st.lists(arcs_in(n), max_size=5))))
def test_colouring_is_least(given: tuple[int, list[Arc]]) -> None:
    interval, arcs = given
    found = coloured(arcs, interval)
    assert apart(arcs, found, interval)
    if arcs:
        least = least_units(arcs, interval)
        assert fewest_units([busy for _, busy in arcs], interval) <= least
        load = max(sum(meet(arc, (slot, 1), interval) for arc in arcs) for slot in range(interval))
        assert max(found) + 1 == least or load < least


def arcs_in(interval: int) -> st.SearchStrategy[Arc]:
    return st.tuples(st.integers(0, interval - 1), st.integers(1, interval))


def test_three_arcs_that_meet_in_pairs_need_three_units() -> None:
    """No slot has more than two of them."""
    arcs = [(0, 4), (2, 4), (4, 4)]
    assert sorted(coloured(arcs, 6)) == [0, 1, 2]
    tasks = tuple(Task(f"o{slot}", "mix", slot, busy) for slot, busy in arcs)
    chain = tuple(
        TaskValue(f"v{i}", one.id, ((other.id, "x"),)) for i, (one, other) in enumerate(pairwise(tasks))
    )
    problem = SchedulingProblem(tasks, chain, 6)
    assert solve(problem, [LATENCY, UNITS]).figures["processors"] == 3
    assert solve(problem, [UNITS, LATENCY]).figures["processors"] == 3


@pytest.mark.parametrize(("interval", "busy", "units"), [(17, 4, 7), (40, 12, 9), (28, 5, 8)])
def test_arcs_of_full_units_are_coloured_with_as_many(interval: int, busy: int, units: int) -> None:
    """Where first fit takes more, in any order."""
    for seed in range(12):
        draw = random.Random(seed)
        arcs = []
        for _ in range(units):
            first = draw.randrange(interval)
            spare = interval % busy
            for place in range(interval // busy):
                gap = draw.randint(0, spare)
                spare -= gap
                first += gap
                arcs.append(((first + place * busy) % interval, busy))
        draw.shuffle(arcs)
        found = coloured(arcs, interval)
        assert apart(arcs, found, interval)
        assert max(found) < units


def test_free_slots() -> None:
    slots = Reservations(8, 2)
    slots.take(0, 6, 4)
    assert slots.next_for(0, 3) == (0, 1)
    slots.take(1, 0, 3)
    assert slots.next_for(0, 4) == (2, 0)
    assert slots.next_for(7, 5) == (11, 1)
    assert slots.next_for(0, 6) is None
    slots.release(0, 6, 4)
    assert slots.next_for(3, 8) == (3, 0)


@relaxed
@given(lasting(most_operations=8), st.data())
def test_binding_keeps_units_apart(problem: SchedulingProblem, data: st.DataObject) -> None:
    start = {task.id: data.draw(st.integers(0, 20)) for task in problem.operations}
    sources = {t.id: (ConstantWord(data.draw(st.sampled_from("abc"))),) for t in problem.operations}
    arcs = arcs_of(problem, start)
    wires = Wiring(
        {task.id: "mix" for task in problem.operations},
        {id: cycle % problem.interval for id, cycle in start.items()},
        {task.id: task.busy for task in problem.operations},
        problem.interval,
        sources,
    )
    bound = bind(wires, data.draw(st.sampled_from([0.0, 0.5])))
    units = [bound[task.id] for task in problem.operations]
    assert apart(arcs, units, problem.interval)
    assert max(units) == max(coloured(arcs, problem.interval))


GRAPH = {
    "initiation_interval": 12,
    "minimize": "processors",
    "kinds": {"cau": {"latency": 7, "initiation_interval": 6}, "add": {"latency": 1}},
    "operations": [*({"id": f"c{i}", "kind": "cau"} for i in range(5)), {"id": "s", "kind": "add"}],
    "edges": [["c0", "c1"], ["c0", "c2"], ["c1", "s"], ["c2", "s"], ["s", "c3"], ["c4", "c3"]],
}


def test_a_bare_graph() -> None:
    graph = json.dumps(GRAPH)
    answer = schedule_graph(parse_graph(graph, "g"), Effort())
    verify_bare(GRAPH, answer)
    caus = {unit for id, unit in answer["unit"].items() if id.startswith("c")}
    assert len(caus) == 3
    assert answer["optimal"]["processors"]
    wrong = {**answer, "unit": {**answer["unit"], "c0": answer["unit"]["c1"]}}
    overlap = {**answer["start"], "c1": answer["start"]["c0"] + 7}
    with pytest.raises(AssertionError):
        verify_bare(GRAPH, {**wrong, "start": overlap})


def test_a_unit_that_is_busy_longer_than_its_operation_takes() -> None:
    """The last one keeps its unit beyond the end, which is no reason to end later."""
    graph = {
        "initiation_interval": 20,
        "kinds": {"add": {"latency": 1}, "cau": {"latency": 1, "initiation_interval": 5, "limit": 1}},
        "operations": [{"id": "s", "kind": "add"}, *({"id": f"c{i}", "kind": "cau"} for i in range(3))],
        "edges": [["s", f"c{i}"] for i in range(3)],
    }
    answer = schedule_graph(parse_graph(json.dumps(graph), "g"), Effort())
    verify_bare(graph, answer)
    assert answer["latency"] == answer["bounds"]["latency"] == 12
    before = Task("s", "add", 1)
    takers = [Task(f"c{i}", "cau", 1, 5) for i in range(3)]
    value = TaskValue("v", "s", tuple((task.id, "x") for task in takers))
    problem = SchedulingProblem((before, *takers), (value,), 20, {"cau": 1})
    _, tail = raised(network(problem))
    assert tail == (12, 1, 1, 1)


def test_an_interval_that_a_unit_cannot_keep() -> None:
    graph = json.dumps({**GRAPH, "initiation_interval": 5})
    with pytest.raises(Unattainable, match="takes an operation every 6 cycles") as raised:
        schedule_graph(parse_graph(graph, "g"), Effort())
    assert "interval of 6" in str(raised.value.diagnostics[0].hint)


def test_the_same_answer_again() -> None:
    tasks = tuple(Task(f"o{i}", "mix", 5, 3 + i % 3) for i in range(12))
    values = tuple(TaskValue(f"v{i}", f"o{i}", ((f"o{i + 3}", "x"),)) for i in range(9))
    problem = SchedulingProblem(tasks, values, 17)
    first, second = (solve(problem, [UNITS, LATENCY, FIFO_WORDS]) for _ in range(2))
    assert first == second
    assert first.optimal["processors"]
