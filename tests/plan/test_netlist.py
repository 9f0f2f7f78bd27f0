"""The netlist: a machine of its units, multiplexers and FIFOs alone takes every value where the plan says."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cordicc.plan.model import Operand, Operation, Plan, dependence_order
from cordicc.plan.netlist import ConstantWord, Driver, FifoEnd, InputWord, Multiplexer, Netlist, UnitResult
from cordicc.plan.verify import verify
from cordicc.schedule.control import controlled
from cordicc.schedule.solver.fifo_lp import solve
from tests.support import hand_plans
from tests.support.random_plans import Flow, flows, with_interval
from tests.support.selection import examples

STEPS = 4

Token = tuple[str, int] | None
"""A value of a sample, or of a constant its text and no sample; None: nothing."""


def machine(plan: Plan, interval: int, share: bool) -> Plan:
    return replace(with_interval(plan, interval, share), optimal={}, bounds={})


class Clocked:
    """A machine made of a netlist, through which names run instead of words."""

    def __init__(self, plan: Plan) -> None:
        self.netlist = Netlist.of(plan)
        self.order = dependence_order(plan)
        self.pipelines = {unit.id: deque([{}] * unit.latency) for unit in plan.units if unit.latency}
        self.fifos: dict[str, deque[Token]] = {f.id: deque([None] * f.depth) for f in plan.fifos}
        self.valid = deque([False] * self.netlist.valid_depth)
        self.wires: dict[Driver, Token] = {}

    def carried(self, driver: Driver) -> Token:
        return (driver.text, -1) if isinstance(driver, ConstantWord) else self.wires.get(driver)

    def tick(
        self, cycle: int, entering: dict[str, Token]
    ) -> tuple[dict[str, list[Token]], list[Token], bool]:
        """Return what the operations in whose slot it is take, what the outputs carry, and `valid`."""
        slot = cycle % self.netlist.interval
        self.wires = {InputWord(name): token for name, token in entering.items()}
        self.wires |= {FifoEnd(id): words[0] for id, words in self.fifos.items()}
        for pipeline in self.pipelines.values():
            self.wires.update(pipeline.popleft())
        issued: dict[str, dict[Driver, Token]] = {}
        taken: dict[str, list[Token]] = {}
        for operation in self.order:
            if (cycle - operation.start) % self.netlist.interval:
                continue
            cell = self.netlist.cells[operation.unit]
            chosen = [port.sources[port.select[slot]] for port in cell.ports[: len(operation.ports)]]
            taken[operation.id] = [self.carried(driver) for driver in chosen]
            made = self.made(operation, taken[operation.id])
            if cell.unit.latency:
                issued[operation.unit] = made
            else:
                self.wires.update(made)
        outputs = [self.carried(connection.driver) for connection in self.netlist.outputs.values()]
        here = next(iter(entering.values())) is not None
        valid = self.valid[0] if self.valid else here
        moving = {id: self.carried(each.driver) for id, each in self.netlist.fifos.items()}
        for id, token in moving.items():
            if (cycle - self.netlist.fifos[id].cycle) % self.netlist.interval == 0:
                self.fifos[id].append(token)
                self.fifos[id].popleft()
        if slot == 0:
            self.valid.append(here)
            self.valid.popleft()
        for unit, pipeline in self.pipelines.items():
            pipeline.append(issued.get(unit, {}))
        return taken, outputs, valid

    def made(self, operation: Operation, operands: list[Token]) -> dict[Driver, Token]:
        step = max((token[1] for token in operands if token is not None), default=-1)
        named = [name for name in operation.results if name is not None]
        return {self.netlist.results[name].driver: (name, step) for name in named} if any(operands) else {}


@settings(deadline=None, max_examples=examples(150))
@given(flows(), st.integers(1, 4), st.booleans())
def test_every_port_and_output_takes_its_value_of_its_sample(flow: Flow, interval: int, share: bool) -> None:
    plan = machine(flow.plan(solve(flow.problem())), interval, share)
    of_constants = constants_alone(plan)

    def expected(operand: Operand, step: int) -> Token:
        if operand.value is None:
            return str(operand.constant), -1
        return operand.value, -1 if operand.value in of_constants else step

    clocked = Clocked(plan)
    checked = 0
    for cycle in range(plan.latency_cycles + STEPS * interval):
        step, slot = divmod(cycle, interval)
        fresh = slot == 0 and step < STEPS
        taken, outputs, valid = clocked.tick(cycle, {n: (n, step) if fresh else None for n in flow.inputs})
        for operation in plan.operations:
            step = (cycle - operation.start) // interval
            if operation.id in taken and 0 <= step < STEPS:
                assert taken[operation.id] == [expected(operand, step) for operand in operation.operands]
                checked += 1
        step, late = divmod(cycle - plan.latency_cycles, interval)
        if not late:
            assert valid == (0 <= step < STEPS)
            assert not valid or outputs == [expected(operand, step) for operand in plan.outputs.values()]
    assert checked == STEPS * len(plan.operations)


def constants_alone(plan: Plan) -> set[str | None]:
    """Return the values that depend on no input: no sample can be told from another by them."""
    found: set[str | None] = set()
    for operation in dependence_order(plan):
        if all(operand.value is None or operand.value in found for operand in operation.operands):
            found.update(name for name in operation.results if name is not None)
    return found


@settings(deadline=None, max_examples=examples(100))
@given(flows(), st.integers(1, 4))
def test_the_control_words_are_those_that_verification_expects(flow: Flow, interval: int) -> None:
    plan = machine(flow.plan(solve(flow.problem())), interval, share=True)
    given = replace(plan, units=controlled(Netlist.of(plan)))
    verify(given)
    count = Counter(operation.unit for operation in plan.operations)
    assert {unit.id for unit in given.units if unit.control} == {id for id in count if count[id] > 1}
    assert Netlist.of(given).operands == Netlist.of(plan).operands


@settings(deadline=None, max_examples=examples(100))
@given(flows(), st.integers(1, 4))
def test_spans_fit_depths_and_cover_every_wait(flow: Flow, interval: int) -> None:
    plan = machine(flow.plan(solve(flow.problem())), interval, share=False)
    netlist = Netlist.of(plan)
    ready = dict.fromkeys(flow.inputs, 0) | {r: o.finish for o in plan.operations for r in o.results if r}
    for fifo in plan.fifos:
        enters, leaves = netlist.spans[fifo.id]
        assert fifo.depth == -(-(leaves - enters) // interval)
    for connection in netlist.connections():
        driver = connection.driver
        if isinstance(driver, FifoEnd):
            assert connection.cycle == netlist.spans[driver.fifo][1]
        elif connection.value is not None:
            assert connection.cycle == ready[connection.value]


def test_spans_follow_the_chain() -> None:
    assert sorted(Netlist.of(hand_plans.wheel()).spans.values()) == [(7, 48), (48, 92), (48, 92)]


@pytest.mark.parametrize(
    ("driver", "text"),
    [
        (UnitResult("cau1", "norm"), "unit cau1.norm"),
        (FifoEnd("f1"), "fifo f1"),
        (InputWord("x"), "input x"),
        (ConstantWord("1/2"), "constant 1/2"),
    ],
)
def test_drivers_in_text(driver: Driver, text: str) -> None:
    assert str(driver) == text


def test_a_shared_port_selects_its_sources_in_the_order_of_slots_or_as_stated() -> None:
    flow = Flow(("i", "j"), ((1, ("j", "2"), 1), (1, ("o0.norm", "2"), 1)), ("o1.norm",))
    plan = machine(flow.plan(solve(flow.problem())), 2, share=True)
    assert {operation.unit for operation in plan.operations} == {"u0"}
    first, second = Netlist.of(plan).cells["u0"].ports
    assert first == Multiplexer((InputWord("j"), UnitResult("u0", "norm")), {0: 0, 1: 1})
    assert second == Multiplexer((ConstantWord("2"),), {0: 0, 1: 0})
    units = (replace(plan.units[0], inputs=(("unit u0.norm", "input j"), ("constant 2",))), plan.units[1])
    first, _ = Netlist.of(replace(plan, units=units)).cells["u0"].ports
    assert first == Multiplexer((UnitResult("u0", "norm"), InputWord("j")), {0: 1, 1: 0})


def test_results_know_their_operation_and_position() -> None:
    netlist = Netlist.of(hand_plans.wheel())
    found = netlist.results["o6.angle"]
    assert (found.operation.id, found.position, found.driver) == ("o6", 1, UnitResult("standard3", "angle"))
