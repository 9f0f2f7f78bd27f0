"""The engine against exhaustive search, on problems small enough for it."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cordicc.plan.netlist import ConstantWord
from cordicc.schedule.binding import Wiring, bind
from cordicc.schedule.solver import neighbourhoods
from cordicc.schedule.solver.cp_program import Space
from cordicc.schedule.solver.cp_search import Clock, Work
from cordicc.schedule.solver.dependences import network
from cordicc.schedule.solver.engine import Effort, solve
from cordicc.schedule.solver.fifo_lp import least_cycles
from cordicc.schedule.solver.goals import FIFO_WORDS, LATENCY, Goal
from cordicc.schedule.solver.latency_bounds import latency_bound
from cordicc.schedule.solver.modulo_list import list_schedule
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem, TaskValue, fifo_words
from cordicc.schedule.solver.shift import improve
from cordicc.schedule.solver.symmetry import exchanges
from tests.support.every_schedule import every_schedule
from tests.support.random_plans import Flow, flows
from tests.support.selection import examples

relaxed = settings(deadline=None, max_examples=examples(60))
UNITS = Goal("processors", {"mix": 1})


def fits(problem: SchedulingProblem, start: dict[str, int], units: int) -> bool:
    busy = Counter(cycle % problem.interval for cycle in start.values())
    return all(count <= units for count in busy.values())


def least_latency(problem: SchedulingProblem, units: int) -> int:
    """Return the least latency with so many units, by trying all schedules."""
    latency = problem.earliest().latency
    while True:
        for start in every_schedule(problem, latency):
            if fits(problem, start, units):
                return latency
        latency += 1


def within(problem: SchedulingProblem, latency: int, units: int) -> Iterator[dict[str, int]]:
    yield from (start for start in every_schedule(problem, latency) if fits(problem, start, units))


@relaxed
@given(flows(most_operations=5, most_latency=3), st.integers(2, 4), st.sampled_from(["entries", "cycles"]))
def test_processors_then_latency_then_words(flow: Flow, interval: int, measure: str) -> None:
    problem = replace(flow.problem(), interval=interval, measure=measure)
    count = len(problem.operations)
    assume(count)
    units = problem.fewest("mix")
    latency = least_latency(problem, units)
    assume(latency < 9)
    words = min(fifo_words(problem, start, latency) for start in within(problem, latency, units))
    solved = solve(problem, [UNITS, LATENCY, FIFO_WORDS])
    assert (solved.figures["processors"], solved.latency, solved.fifo_words) == (units, latency, words)
    assert all(solved.optimal.values())
    assert solved == solve(problem, [UNITS, LATENCY, FIFO_WORDS])


@relaxed
@given(flows(most_operations=5, most_latency=3), st.integers(2, 4), st.integers(0, 2))
def test_fewest_units_within_a_latency(flow: Flow, interval: int, spare: int) -> None:
    problem = replace(flow.problem(), interval=interval)
    count = len(problem.operations)
    limit = problem.earliest().latency + spare
    assume(count)
    assume(limit < 9)
    units = next(u for u in range(1, count + 1) if any(within(problem, limit, u)))
    assert solve(problem, [UNITS, LATENCY], max_latency=limit).figures["processors"] == units
    quick = solve(problem, [LATENCY, UNITS])
    least = problem.earliest().latency
    needed = next(u for u in range(1, count + 1) if any(within(problem, least, u)))
    assert (quick.latency, quick.figures["processors"]) == (least, needed)


@relaxed
@given(flows(most_operations=3, most_latency=2), st.integers(2, 3))
def test_words_first(flow: Flow, interval: int) -> None:
    problem = replace(flow.problem(), interval=interval)
    # A gap in which no operation runs is shorter than the interval in some optimal schedule.
    longest = sum(task.latency for task in problem.operations) + (len(problem.operations) + 1) * interval
    assume(longest <= 14)
    found = (
        (fifo_words(problem, start, latency), latency)
        for latency in range(problem.earliest().latency, longest + 1)
        for start in every_schedule(problem, latency)
    )
    solved = solve(problem, [FIFO_WORDS, LATENCY])
    assert (solved.fifo_words, solved.latency) == min(found)
    assert all(solved.optimal.values())


@relaxed
@given(flows(most_operations=5, most_latency=3), st.integers(1, 4), st.integers(1, 3))
def test_bounds_hold_and_lists_are_feasible(flow: Flow, interval: int, units: int) -> None:
    problem = replace(flow.problem(), interval=interval)
    count = len(problem.operations)
    assume(0 < count <= units * interval)
    net = network(problem, {"mix": units})
    start = list_schedule(net, 0)
    assert start is not None
    assert all(start[t] >= start[i] + net.latency[i] for i in range(count) for t in net.after[i])
    assert fits(problem, dict(zip(net.ids, start, strict=True)), units)
    assert latency_bound(net) <= net.makespan(start)
    assume(net.makespan(start) < 9)
    assert latency_bound(net) <= least_latency(problem, units)


@relaxed
@given(flows(most_operations=12, most_latency=9), st.integers(1, 6), st.sampled_from(["entries", "cycles"]))
def test_words_are_never_above_those_of_the_list_schedule(flow: Flow, interval: int, measure: str) -> None:
    problem = replace(flow.problem(), interval=interval, measure=measure)
    count = len(problem.operations)
    assume(count)
    net = network(problem, {"mix": problem.fewest("mix")})
    start = list_schedule(net, 0)
    assert start is not None
    latency = net.makespan(start)
    moved = improve(problem, net, start, latency, [1] * len(problem.values))
    before, after = (dict(zip(net.ids, cycles, strict=True)) for cycles in (start, moved))
    assert fifo_words(problem, after, latency) <= fifo_words(problem, before, latency)
    assert net.makespan(moved) <= latency
    assert all(moved[t] >= moved[i] + net.latency[i] for i in range(count) for t in net.after[i])
    assert fits(problem, after, problem.fewest("mix"))


@relaxed
@given(flows(most_operations=12, most_latency=9), st.integers(1, 6), st.sampled_from(["entries", "cycles"]))
def test_large_problems_go_in_blocks(flow: Flow, interval: int, measure: str) -> None:
    problem = replace(flow.problem(), interval=interval, measure=measure)
    net = network(problem, {"mix": problem.fewest("mix")})
    start = list_schedule(net, 0)
    assert start is not None
    latency = net.makespan(start)
    whole = least_cycles(problem, latency)
    assert 0 <= least_cycles(problem, latency, most_whole=3) <= whole
    moved = improve(problem, net, start, latency, [1] * len(problem.values), block=3)
    before, after = (dict(zip(net.ids, cycles, strict=True)) for cycles in (start, moved))
    assert fifo_words(problem, after, latency) <= fifo_words(problem, before, latency)
    assert net.makespan(moved) <= latency
    assert all(moved[t] >= moved[i] + net.latency[i] for i in range(len(start)) for t in net.after[i])


@relaxed
@given(flows(most_operations=10, most_latency=9), st.integers(2, 6))
def test_taps_never_cost_more_than_a_delay_for_each_consumer(flow: Flow, interval: int) -> None:
    problem = replace(flow.problem(), interval=interval)
    solved = solve(problem, [LATENCY, FIFO_WORDS], effort=Effort(words=0.2))
    apart = tuple(
        TaskValue(f"{value.name}{k}", value.producer, (sink,))
        for value in problem.values
        for k, sink in enumerate(value.consumers)
    )
    alone = replace(problem, values=apart)
    assert solved.fifo_words <= fifo_words(alone, solved.start, solved.latency)
    assert solved.fifo_words <= problem.earliest().fifo_words


@relaxed
@given(
    st.lists(st.tuples(st.integers(0, 2), st.lists(st.integers(0, 3), min_size=1, max_size=2)), max_size=6)
)
def test_binding_has_the_fewest_multiplexer_inputs(rows: list[tuple[int, list[int]]]) -> None:
    slot = {f"o{k}": row[0] for k, row in enumerate(rows)}
    drivers = {f"o{k}": tuple(ConstantWord(str(c)) for c in row[1]) for k, row in enumerate(rows)}
    wires = Wiring(dict.fromkeys(slot, "mul"), slot, dict.fromkeys(slot, 1), 3, drivers)
    found = bind(wires, Effort().binding)
    places = [(slot[id], unit) for id, unit in found.items()]
    assert len(set(places)) == len(places)
    units = max(Counter(slot.values()).values(), default=0)
    assert all(0 <= unit < units for unit in found.values())
    every = (
        dict(zip(slot, chosen, strict=True))
        for chosen in product(range(units), repeat=len(slot))
        if len({(slot[id], unit) for id, unit in zip(slot, chosen, strict=True)}) == len(slot)
    )

    def sources(binding: dict[str, int]) -> int:
        ports = {(binding[id], p, d) for id, taken in drivers.items() for p, d in enumerate(taken)}
        return len(ports)

    assert sources(found) == min(map(sources, every), default=0)


def doubled(flow: Flow) -> Flow:
    """Return two instances of a flow side by side."""
    count = len(flow.operations)

    def second(source: str) -> str:
        if source[0] == "o" and "." in source:
            id, dot, result = source.partition(".")
            return f"o{int(id[1:]) + count}{dot}{result}"
        return f"{source}x" if source in flow.inputs else source

    more = tuple((cycles, tuple(second(s) for s in sources), n) for cycles, sources, n in flow.operations)
    return Flow(
        (*flow.inputs, *(f"{name}x" for name in flow.inputs)),
        (*flow.operations, *more),
        (*flow.outputs, *(second(source) for source in flow.outputs)),
    )


@relaxed
@given(flows(most_operations=6, most_latency=3))
def test_copies_are_exchanged(flow: Flow) -> None:
    problem = doubled(flow).problem()
    count = len(flow.operations)
    assume(count)
    net = network(problem)
    found = exchanges(problem, net, lambda index: "", lambda value: 1)
    assert any(exchange.first == 0 and exchange.image[0] >= 1 for exchange in found)
    edges = set(problem.edges())
    for exchange in found:
        assert sorted(exchange.image) == list(range(2 * count))
        assert all(exchange.image[index] == index for index in range(exchange.first))
        assert {
            (f"o{exchange.image[int(a[1:])]}", f"o{exchange.image[int(b[1:])]}") for a, b in edges
        } == edges


@relaxed
@given(flows(most_operations=2, most_latency=3), st.integers(2, 3))
def test_symmetries_cost_nothing(flow: Flow, interval: int) -> None:
    problem = replace(doubled(flow).problem(), interval=interval)
    count = len(problem.operations)
    assume(count)
    units = problem.fewest("mix")
    latency = least_latency(problem, units)
    assume(latency < 12)
    words = min(fifo_words(problem, start, latency) for start in within(problem, latency, units))
    solved = solve(problem, [UNITS, LATENCY, FIFO_WORDS])
    assert (solved.figures["processors"], solved.latency, solved.fifo_words) == (units, latency, words)
    assert all(solved.optimal.values())


@settings(deadline=None, max_examples=examples(25))
@given(flows(most_operations=12, most_latency=9), st.integers(2, 6))
def test_neighbourhoods_keep_what_holds_and_lose_no_words(flow: Flow, interval: int) -> None:
    problem = replace(flow.problem(), interval=interval)
    count = len(problem.operations)
    assume(count)
    units = problem.fewest("mix")
    net = network(problem, {})
    start = list_schedule(network(problem, {"mix": units}), 0)
    assert start is not None
    latency = net.makespan(start)
    space = Space(net.head, net.tail, (latency, latency), {"mix": (units, units)})
    clock = Clock(Work(0.2))
    found = [
        neighbourhoods.improved(problem, net, FIFO_WORDS, space, start, 0.2, clock.solver, lambda: False)
        for _ in range(2)
    ]
    assert found[0] == found[1]
    before, after = (dict(zip(net.ids, cycles, strict=True)) for cycles in (start, found[0]))
    assert fifo_words(problem, after, latency) <= fifo_words(problem, before, latency)
    assert net.makespan(found[0]) <= latency
    assert all(after[t] >= after[p] + net.latency[net.ids.index(p)] for p, t in problem.edges())
    assert fits(problem, after, units)
