from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cordicc.emulate import cycle, functional
from cordicc.emulate.cycle import MachineError
from cordicc.plan.model import Operand, Plan
from cordicc.plan.netlist import FifoEnd, InputWord
from cordicc.schedule.solver.fifo_lp import solve
from tests.support.random_plans import FORMAT, FakeArithmetic, Flow, flows, samples, with_interval
from tests.support.selection import examples

relaxed = settings(deadline=None, max_examples=examples(100))
ARITHMETIC = FakeArithmetic()

# o2 joins a short and a long way from i; the second output is i itself.
FORK = Flow(
    ("i", "j"),
    ((3, ("i", "j"), 2), (1, ("i", "2"), 1), (0, ("o0.angle", "o1.norm"), 1)),
    ("o2.norm", "i", "5"),
)


def plan_of(flow: Flow) -> Plan:
    return flow.plan(solve(flow.problem()))


def same(left: dict[str, Any], right: dict[str, Any]) -> bool:
    return left.keys() == right.keys() and all(left[k].tobytes() == right[k].tobytes() for k in left)


@relaxed
@given(flows(), st.sampled_from([1, 2, 31, 33, 100]), st.integers(1, 4), st.booleans())
def test_both_emulators_give_the_same_bytes(flow: Flow, count: int, interval: int, share: bool) -> None:
    plan = with_interval(plan_of(flow), interval, share)
    inputs = samples(flow.inputs, count)
    assert same(functional.run(plan, ARITHMETIC, inputs), cycle.run(plan, ARITHMETIC, inputs))


@relaxed
@given(flows(), st.data())
def test_a_wrong_fifo_depth_shows(flow: Flow, data: st.DataObject) -> None:
    plan = plan_of(flow)
    assume(plan.fifos)
    index = data.draw(st.integers(0, len(plan.fifos) - 1))
    fifos = list(plan.fifos)
    change = data.draw(st.sampled_from([-1, 1, 2]))
    fifos[index] = replace(fifos[index], depth=max(0, fifos[index].depth + change))
    inputs = samples(flow.inputs, 50)
    wrong = replace(plan, fifos=tuple(fifos))
    # The stream's ends give every misalignment away, so it never comes to wrong bits.
    with pytest.raises(MachineError):
        cycle.run(wrong, ARITHMETIC, inputs)


@relaxed
@given(flows(), st.data())
def test_a_missing_fifo_shows(flow: Flow, data: st.DataObject) -> None:
    plan = plan_of(flow)
    assume(plan.fifos)
    dropped = data.draw(st.sampled_from(plan.fifos))
    wrong = replace(plan, fifos=tuple(fifo for fifo in plan.fifos if fifo is not dropped))
    with pytest.raises(MachineError):
        cycle.run(wrong, ARITHMETIC, samples(flow.inputs, 50))


def test_machine_errors_name_operation_and_cycle() -> None:
    plan = plan_of(FORK)
    assert [fifo.value for fifo in plan.fifos] == ["i", "i"]
    delay, rest = plan.fifos
    inputs = samples(FORK.inputs, 5)
    wrong = replace(plan, fifos=(replace(delay, depth=delay.depth - 1), rest))
    with pytest.raises(MachineError, match=r"cycle 2: operands of o2 do not meet, none on x"):
        cycle.run(wrong, ARITHMETIC, inputs)
    wrong = replace(plan, fifos=(delay, replace(rest, depth=rest.depth + 1)))
    with pytest.raises(MachineError, match=r"cycle 3: output q1 is not there"):
        cycle.run(wrong, ARITHMETIC, inputs)


@pytest.mark.parametrize("count", [0, 1, 8191, 8192, 8200])
def test_blocks_and_lanes_of_any_length(count: int) -> None:
    plan = plan_of(FORK)
    inputs = samples(FORK.inputs, count)
    whole = functional.run(plan, ARITHMETIC, inputs)
    assert all(array.shape == (count,) for array in whole.values())
    assert list(whole) == ["q0", "q1", "q2", "valid"]
    assert same(whole, cycle.run(plan, ARITHMETIC, inputs))
    single = functional.run(plan, ARITHMETIC, {name: array[-1:] for name, array in inputs.items()})
    assert all(single[name].tobytes() == whole[name][-1:].tobytes() for name in whole)


def test_ranges_are_closed_and_hold_the_nearest_doubles() -> None:
    plan = plan_of(Flow(("i",), (), ("i",)))
    edges = [-0.25, 0.75, np.nextafter(-0.25, -1), np.nextafter(0.75, 1), np.nan, np.inf, -np.inf, 0.0]
    for emulate in (functional.run, cycle.run):
        found = emulate(plan, ARITHMETIC, {"i": np.array(edges)})
        invalid_word = FORMAT.decode(FORMAT.encode(np.array(edges)))
        expected = [not np.isnan(invalid_word[k]) and k in (0, 1, 7) for k in range(len(edges))]
        assert found["valid"].tolist() == expected
        assert np.isnan(found["q0"]).tolist() == [not valid for valid in expected]


def test_one_invalid_output_makes_the_sample_invalid() -> None:
    found = functional.run(plan_of(FORK), ARITHMETIC, samples(FORK.inputs, 2000))
    assert 0 < found["valid"].sum() < 2000
    for name in ("q0", "q1", "q2"):
        assert (np.isnan(found[name]) == ~found["valid"]).all()


def test_unfit_inputs() -> None:
    plan = plan_of(FORK)
    for emulate in (functional.run, cycle.run):
        with pytest.raises(ValueError, match="missing inputs: j"):
            emulate(plan, ARITHMETIC, {"i": [0.1]})
        with pytest.raises(ValueError, match="one-dimensional arrays of equal length"):
            emulate(plan, ARITHMETIC, {"i": [0.1], "j": [0.1, 0.2]})
        with pytest.raises(ValueError, match="one-dimensional arrays of equal length"):
            emulate(plan, ARITHMETIC, {"i": 0.1, "j": 0.1})


def test_an_operation_on_constants_alone_runs_with_the_stream() -> None:
    plan = plan_of(Flow(("i",), ((2, ("3", "4"), 1), (1, ("o0.norm", "i"), 1)), ("o1.norm",)))
    inputs = samples(("i",), 70)
    assert same(functional.run(plan, ARITHMETIC, inputs), cycle.run(plan, ARITHMETIC, inputs))


def test_the_order_of_operations_in_the_plan_does_not_matter() -> None:
    plan = plan_of(FORK)
    turned = replace(plan, operations=plan.operations[::-1], units=plan.units[::-1], fifos=plan.fifos[::-1])
    inputs = samples(FORK.inputs, 40)
    assert same(functional.run(plan, ARITHMETIC, inputs), functional.run(turned, ARITHMETIC, inputs))
    assert same(functional.run(plan, ARITHMETIC, inputs), cycle.run(turned, ARITHMETIC, inputs))


def test_inputs_may_be_named_like_operations_and_fifos() -> None:
    flow = Flow(("f1", "o0"), ((2, ("f1",), 1), (1, ("o0.norm", "f1", "o0"), 1)), ("o1.norm", "f1"))
    plan = plan_of(flow)
    inputs = samples(flow.inputs, 40)
    assert same(functional.run(plan, ARITHMETIC, inputs), cycle.run(plan, ARITHMETIC, inputs))


def test_clock_shows_the_wires() -> None:
    plan = plan_of(FORK)
    stream = {name: np.array([[0.25], [0.5]]) for name in FORK.inputs}
    trace = list(cycle.clock(plan, ARITHMETIC, stream, steps=2, lanes=1))
    assert [snapshot.cycle for snapshot in trace] == list(range(plan.latency_cycles + 2))
    assert [bool(snapshot.outputs) for snapshot in trace] == [False] * plan.latency_cycles + [True, True]
    assert [snapshot.wires[InputWord("i")] is not None for snapshot in trace] == [
        True,
        True,
        False,
        False,
        False,
    ]
    assert [snapshot.wires[FifoEnd("f1")] is not None for snapshot in trace] == [
        False,
        False,
        True,
        True,
        False,
    ]


def test_outputs_may_be_constants_alone() -> None:
    plan = replace(plan_of(Flow(("i",), (), ("i",))), outputs={"q": Operand(constant="3/7")})
    found = cycle.run(plan, ARITHMETIC, {"i": [0.1, 0.2]})
    assert same(found, functional.run(plan, ARITHMETIC, {"i": [0.1, 0.2]}))
    assert found["q"][0] == found["q"][1]
