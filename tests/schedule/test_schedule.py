import random
import subprocess
import sys
from dataclasses import replace

import pytest

from cordicc.plan.model import Fifo, Operand, Operation, Plan, Unit
from cordicc.plan.netlist import Netlist
from cordicc.plan.verify import verify
from cordicc.schedule.control import controlled
from cordicc.schedule.delays import delays
from cordicc.schedule.solver.fifo_lp import solve
from cordicc.schedule.solver.scheduling_problem import (
    InfeasibleError,
    SchedulingProblem,
    Task,
    TaskValue,
    fifo_words,
)
from tests.support.random_plans import Flow


def problem(tasks: dict[str, int], values: dict[str, str]) -> SchedulingProblem:
    """Return a problem from latencies and values such as {"a.r": "b.x out.q"}."""
    return SchedulingProblem(
        tuple(Task(id, "any", latency) for id, latency in tasks.items()),
        tuple(
            TaskValue(
                name,
                name.split(".")[0] if "." in name else None,
                tuple((sink.split(".")[0], sink.split(".")[1]) for sink in sinks.split()),
            )
            for name, sinks in values.items()
        ),
    )


def test_late_start_shares_one_delay() -> None:
    # b and c take only i, which waits anyway; started late, neither result waits.
    given = problem(
        {"a": 9, "b": 1, "c": 1, "d": 1},
        {"i": "a.x b.x c.x", "a.r": "d.x", "b.r": "d.y", "c.r": "d.z", "d.r": "out.q"},
    )
    assert given.earliest().fifo_words == 16
    solved = solve(given)
    assert solved.start == {"a": 0, "b": 8, "c": 8, "d": 9}
    assert (solved.latency, solved.fifo_words) == (10, 8)
    assert solved.optimal == {"latency": True, "fifo_words": True}
    assert solved.bounds == {"latency": 10, "fifo_words": 8}


def test_early_start_where_the_operands_would_wait() -> None:
    given = problem({"a": 9, "b": 1}, {"i": "a.x", "j": "b.x", "k": "b.y", "a.r": "out.p", "b.r": "out.q"})
    assert solve(given).start == {"a": 0, "b": 0}


def test_fewest_words_can_cost_latency() -> None:
    # q waits for e: with a, b and c early their three results wait too, late only i does.
    given = problem(
        {"e": 9, "a": 1, "b": 1, "c": 1, "q": 1, "r": 20, "s": 20, "t": 20},
        {
            "i": "e.x a.x b.x c.x",
            "e.v": "q.w",
            "a.v": "q.x r.x",
            "b.v": "q.y s.x",
            "c.v": "q.z t.x",
            "q.v": "out.q",
            "r.v": "out.r",
            "s.v": "out.s",
            "t.v": "out.t",
        },
    )
    found = [
        (s.latency, s.fifo_words) for s in (solve(given), solve(given, "fifo"), solve(given, "fifo", 25))
    ]
    assert found == [(21, 35), (29, 27), (25, 31)]


def test_trivial_problems() -> None:
    assert solve(problem({}, {})).latency == 0
    wire = solve(problem({}, {"i": "out.q"}))
    assert (wire.latency, wire.fifo_words, wire.start) == (0, 0, {})
    beside = problem({"a": 5}, {"i": "out.q", "j": "a.x", "a.r": "out.p"})
    assert solve(beside).fifo_words == 5
    unused = problem({"a": 5}, {"i": "", "j": "a.x", "a.r": ""})
    assert (solve(unused).latency, solve(unused).fifo_words) == (5, 0)


def test_latency_limit() -> None:
    given = problem({"a": 5}, {"i": "a.x", "a.r": "out.p"})
    assert solve(given, max_latency=5) == solve(given, "fifo", 5) == solve(given)
    with pytest.raises(InfeasibleError, match="5 cycles, more than 4"):
        solve(given, "fifo", 4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (problem({"a": 1, "b": 1}, {"a.r": "b.x", "b.r": "a.x"}), "depend on one another: "),
        (problem({"a": 0}, {"a.r": "a.x"}), "depend on one another: a -> a"),
        (problem({"a": -1}, {}), "'a' has latency -1"),
        (problem({"out": 1}, {}), "'out' is reserved"),
        (problem({}, {"a.r": ""}), "'a.r' comes from unknown operation 'a'"),
        (problem({}, {"i": "a.x"}), "'i' goes to unknown operation 'a'"),
        (problem({"a": 1}, {"i": "a.x", "j": "a.x"}), "sink 'a.x' occurs twice"),
        (SchedulingProblem((Task("a", "k", 1), Task("a", "k", 1)), ()), "operation 'a' occurs twice"),
        (
            SchedulingProblem((), (TaskValue("i", None, ()), TaskValue("i", None, ()))),
            "value 'i' occurs twice",
        ),
    ],
)
def test_malformed_problems(given: SchedulingProblem, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        solve(given)


def test_a_value_is_tapped_once_for_each_distinct_delay() -> None:
    given = problem(
        {"a": 2, "b": 3, "c": 1},
        {"i": "a.x b.y c.y out.p", "a.r": "b.x", "b.r": "c.x", "c.r": "out.q"},
    )
    fifos = delays(given, solve(given), {"i": 24, "a.r": 24, "b.r": 24, "c.r": 24})
    assert fifos == (
        Fifo("f1", "i", "i", ("b.y", "f2"), 2, 24),
        Fifo("f2", "i", "f1", ("c.y", "f3"), 3, 24),
        Fifo("f3", "i", "f2", ("out.p",), 1, 24),
    )


def test_three_hundred_operations() -> None:
    rng = random.Random(7)
    sinks: dict[str, list[str]] = {f"i{k}": [] for k in range(8)}
    tasks = {f"o{k}": rng.choice([1, 1, 2, 4, 44, 66]) for k in range(300)}
    for id in tasks:
        for port in "xyz":
            sinks[rng.choice(list(sinks))].append(f"{id}.{port}")
        sinks.update({f"{id}.{result}": [] for result in ("norm", "angle")})
    for position, taken in enumerate(sinks.values()):
        if not taken:
            taken.append(f"out.q{position}")
    given = problem(tasks, {name: " ".join(taken) for name, taken in sinks.items()})
    solved = solve(given)
    assert solved.fifo_words == fifo_words(given, solved.start, solved.latency)
    assert solved.fifo_words < given.earliest().fifo_words


def test_ortools_and_networkx_are_loaded_only_where_they_work() -> None:
    script = (
        "import sys, cordicc.schedule.place, cordicc.schedule.bare\n"
        "sys.exit(bool({'ortools', 'networkx'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0


def sound() -> Plan:
    flow = Flow(
        ("i",), ((2, ("i", "2"), 2), (1, ("i", "o0.norm"), 1), (0, ("o1.norm",), 1)), ("o2.norm", "i")
    )
    plan = flow.plan(solve(flow.problem()))
    verify(plan)
    return plan


def with_operation(plan: Plan, index: int, **changes: object) -> Plan:
    operations = list(plan.operations)
    operations[index] = replace(operations[index], **changes)  # type: ignore[arg-type]
    return replace(plan, operations=tuple(operations))


def with_fifo(plan: Plan, index: int, **changes: object) -> Plan:
    fifos = list(plan.fifos)
    fifos[index] = replace(fifos[index], **changes)  # type: ignore[arg-type]
    return replace(plan, fifos=tuple(fifos))


SOUND = sound()
SPARE_FIFO = Fifo("f9", "i", "i", ("out.nowhere",), 1, 24)
RING = (Fifo("f8", "i", "f9", ("f9",), 1, 24), Fifo("f9", "i", "f8", ("f8",), 1, 24))
SPARE_OPERATION = Operation("o9", "mix", {}, "mix", "", "u0", 0, 2, ("x",), (Operand("i"),), (None,), "")


@pytest.mark.parametrize(
    ("plan", "message"),
    [
        (replace(SOUND, operations=(*SOUND.operations, SOUND.operations[0])), "operation 'o0' occurs twice"),
        (replace(SOUND, units=(*SOUND.units, SOUND.units[0])), "unit 'u0' occurs twice"),
        (replace(SOUND, fifos=(*SOUND.fifos, SOUND.fifos[0])), "FIFO 'f1' occurs twice"),
        (replace(SOUND, initiation_interval=0), "initiation interval 0"),
        (replace(SOUND, latency_cycles=1), "o0: finishes after the outputs left"),
        (replace(SOUND, latency_cycles=4), "out.q0: takes 'o2.norm' directly, 1 cycles late|f2: depth"),
        (replace(SOUND, cau_cycles=44), "CAU cycles: 44, expected 0"),
        (replace(SOUND, bounds={"latency": 2, "fifo_words": 3}), "latency: 3 is called optimal with bound 2"),
        (replace(SOUND, bounds={"latency": 3, "fifo_words": 4}), "fifo_words: 3 is below its bound 4"),
        (replace(SOUND, outputs={"q0": Operand("o2.norm")}), "f2: feeds unknown sink 'out.q1'"),
        (replace(SOUND, outputs={**SOUND.outputs, "q0": Operand("what")}), "takes unknown value 'what'"),
        (replace(SOUND, outputs={**SOUND.outputs, "q0": Operand()}), "out.q0: value or constant"),
        (replace(SOUND, fifos=(*SOUND.fifos, SPARE_FIFO)), "f9: feeds unknown sink 'out.nowhere'"),
        (replace(SOUND, fifos=(*SOUND.fifos, *RING)), "FIFOs in a ring: f8, f9"),
        (replace(SOUND, fifos=SOUND.fifos[:1]), "f1: feeds unknown sink 'f2'"),
        (replace(SOUND, operations=(*SOUND.operations, SPARE_OPERATION)), "o9: nobody takes a result"),
        (replace(SOUND, units=(*SOUND.units[:2], Unit("u2", "mix", 7))), "o2: from 3 to 3 on a unit of 7"),
        (with_operation(SOUND, 1, unit="u9"), "o1: unknown unit 'u9'"),
        (with_operation(SOUND, 1, kind="standard"), "o1: kind standard on a mix unit"),
        (with_operation(SOUND, 0, start=-1, finish=1), "o0: starts in cycle -1"),
        (with_operation(SOUND, 1, start=1, finish=2), "o1.y: takes 'o0.norm' in cycle 1, ready in 2"),
        (with_operation(SOUND, 1, ports=("x",)), "o1: ports and operands differ"),
        (with_operation(SOUND, 1, ports=("x", "x")), "port of o1 'x' occurs twice"),
        (with_operation(SOUND, 1, results=("odd",)), "o1: result named 'odd'"),
        (with_operation(SOUND, 1, operands=(Operand("i"), Operand("2", "2"))), "o1.y: value or constant"),
        (with_operation(SOUND, 2, operands=(Operand("o2.norm"),)), "nobody takes 'o1.norm'"),
        (with_fifo(SOUND, 0, depth=3), "f1: depth 3 for 2 cycles"),
        (with_fifo(SOUND, 0, width=0), "f1: width 0"),
        (with_fifo(SOUND, 0, value="what"), "f1: delays unknown value 'what'"),
        (with_fifo(SOUND, 0, value="o0.norm"), "f1: holds 'o0.norm', but 'o1.x' takes 'i'"),
        (with_fifo(SOUND, 0, source="o0"), "f1: fed by 'o0', expected 'i'"),
        (with_fifo(SOUND, 1, source="i"), "f2: fed by 'i', expected 'f1'"),
        (with_fifo(SOUND, 0, sinks=("f2",)), r"f1: its sinks read in cycles \[\], expected one"),
        (with_fifo(SOUND, 0, sinks=("f2", "o1.x", "o1.x")), "FIFO sink 'o1.x' occurs twice"),
    ],
)
def test_verify_names_what_is_wrong(plan: Plan, message: str) -> None:
    with pytest.raises(AssertionError, match=message):
        verify(plan)


def test_verify_sees_operations_that_depend_on_one_another() -> None:
    loop = with_operation(SOUND, 2, operands=(Operand("o2.norm"), Operand("o1.norm")), ports=("x", "y"))
    with pytest.raises(AssertionError, match="depend on one another: o2"):
        verify(loop)


def test_units_are_shared_slot_by_slot() -> None:
    flow = Flow(("i",), ((1, ("i",), 1), (1, ("o0.norm",), 1), (1, ("o1.norm",), 1)), ("o2.norm",))
    plan = with_operation(flow.plan(solve(flow.problem())), 2, unit="u0")
    with pytest.raises(AssertionError, match="o2 and o0 share slot 0 of u0"):
        verify(plan)
    with pytest.raises(AssertionError, match="o2 and o0 share slot 0 of u0"):
        verify(replace(plan, initiation_interval=2))
    spaced = replace(plan, initiation_interval=3)
    with pytest.raises(AssertionError, match="u0: shared, but without control words"):
        verify(spaced)
    verify(replace(spaced, units=controlled(Netlist.of(spaced))))


def test_fifo_words_shrink_with_the_initiation_interval() -> None:
    shallow = with_fifo(replace(SOUND, initiation_interval=3, optimal={}, bounds={}), 0, depth=1)
    verify(shallow)
    with pytest.raises(AssertionError, match="f1: depth 2 for 2 cycles"):
        verify(with_fifo(shallow, 0, depth=2))


def test_cau_cycles_count_arithmetic_units_alone() -> None:
    flow = Flow(("i",), ((44, ("i",), 1), (4, ("o0.norm",), 1), (66, ("o1.norm",), 1)), ("o2.norm",))
    plan = flow.plan(solve(flow.problem()))
    for index, kind in ((0, "standard"), (2, "implicit")):
        plan = with_operation(plan, index, kind=kind)
        units = list(plan.units)
        units[index] = replace(units[index], kind=kind)
        plan = replace(plan, units=tuple(units))
    verify(replace(plan, cau_cycles=110))
    with pytest.raises(AssertionError, match="CAU cycles: 114, expected 110"):
        verify(replace(plan, cau_cycles=114))
