"""The netlist of a plan: what drives every operand port, FIFO and output, at any initiation interval.

Operations that share a unit take its ports in turns: a port has a multiplexer, which selects a source in each
slot, a cycle modulo the initiation interval.  A FIFO shifts in one slot, in which its input is there: so a
word waits up to one interval an entry.  `verify` reconstructs the same for itself and uses nothing of this.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, repeat

from cordicc.plan.model import Fifo, Operand, Operation, Plan, Unit


@dataclass(frozen=True, slots=True)
class UnitResult:
    """A result as it leaves its unit, under the name that the operation gives to the port, such as `norm`.

    Of a shared unit, `x` of a rotation and `norm` of a vectoring are two results on one wire; a multiplexer
    that selects either has an input for each.
    """

    unit: str
    port: str

    def __str__(self) -> str:
        return f"unit {self.unit}.{self.port}"


@dataclass(frozen=True, slots=True)
class FifoEnd:
    """The end of a FIFO, by its id."""

    fifo: str

    def __str__(self) -> str:
        return f"fifo {self.fifo}"


@dataclass(frozen=True, slots=True)
class InputWord:
    """An input of the plan as it enters, by its name."""

    name: str

    def __str__(self) -> str:
        return f"input {self.name}"


@dataclass(frozen=True, slots=True)
class ConstantWord:
    """A constant, in the text of its operand."""

    text: str

    def __str__(self) -> str:
        return f"constant {self.text}"


Driver = UnitResult | FifoEnd | InputWord | ConstantWord
"""What drives a wire.  Its text is what `Unit.inputs` holds."""


@dataclass(frozen=True, slots=True)
class Connection:
    """A sink (`o3.y`, `out.theta`, `f2`), what drives it, and the value it takes, None if a constant.

    `cycle` is the one in which the sink takes it, counted from that in which the sample entered.
    """

    sink: str
    driver: Driver
    value: str | None
    cycle: int


@dataclass(frozen=True, slots=True)
class ResultPort:
    """A value's operation, which of its results it is, from 0, and where it leaves.

    Results of one position leave a shared unit on one wire, whatever the operations call its port.
    """

    operation: Operation
    position: int
    driver: UnitResult


@dataclass(frozen=True, slots=True)
class Multiplexer:
    """What a port of a unit takes: its sources in the order of select values, and the selection by slot.

    Slots in which no operation uses the port are left out; a port with one source needs no hardware.
    """

    sources: tuple[Driver, ...]
    select: Mapping[int, int]


@dataclass(frozen=True, slots=True)
class Cell:
    """A unit with the operations it does, in the order of the slots in which they enter, and its ports."""

    unit: Unit
    operations: tuple[Operation, ...]
    ports: tuple[Multiplexer, ...]


@dataclass(frozen=True, slots=True)
class Netlist:
    """What drives what in a plan.

    `results` by value; `operands` by operation, in the order of its ports; the input of each FIFO by its id;
    `outputs` by name; `spans`, by FIFO, the cycles in which a sample's word enters and in which it is read;
    `cells` by unit, in the order of the plan.
    """

    interval: int
    latency: int
    results: Mapping[str, ResultPort]
    operands: Mapping[str, tuple[Connection, ...]]
    fifos: Mapping[str, Connection]
    outputs: Mapping[str, Connection]
    spans: Mapping[str, tuple[int, int]]
    cells: Mapping[str, Cell]

    @classmethod
    def of(cls, plan: Plan) -> Netlist:
        """Return the netlist of a plan in time linear in its size.

        The operations need not have units yet: then there are no cells.  A value that no operation makes
        counts as an input.
        """
        results = _results(plan)
        feeder = {sink: FifoEnd(fifo.id) for fifo in plan.fifos for sink in fifo.sinks}

        def connected(sink: str, operand: Operand, cycle: int) -> Connection:
            if operand.value is None:
                return Connection(sink, ConstantWord(str(operand.constant)), None, cycle)
            direct = results[operand.value].driver if operand.value in results else InputWord(operand.value)
            return Connection(sink, feeder.get(sink, direct), operand.value, cycle)

        operands = {
            operation.id: tuple(
                connected(f"{operation.id}.{port}", operand, operation.start)
                for port, operand in zip(operation.ports, operation.operands, strict=False)
            )
            for operation in plan.operations
        }
        latency = plan.latency_cycles
        outputs = {name: connected(f"out.{name}", item, latency) for name, item in plan.outputs.items()}
        taken = [*(each for ports in operands.values() for each in ports), *outputs.values()]
        spans = _spans(plan, results, {each.sink: each.cycle for each in taken})
        fifos = {f.id: connected(f.id, Operand(value=f.value), spans[f.id][0]) for f in plan.fifos}
        cells = _cells(plan, operands)
        return cls(plan.initiation_interval, latency, results, operands, fifos, outputs, spans, cells)

    def connections(self) -> Iterator[Connection]:
        """Yield those of FIFOs, then of operations, then of outputs, in the order of the plan."""
        yield from self.fifos.values()
        for ports in self.operands.values():
            yield from ports
        yield from self.outputs.values()

    @property
    def valid_depth(self) -> int:
        """The entries of a FIFO fed in slot 0, from which a bit of a sample leaves with its outputs."""
        return -(-self.latency // self.interval)


def _results(plan: Plan) -> dict[str, ResultPort]:
    return {
        value: ResultPort(operation, position, UnitResult(operation.unit, value.rpartition(".")[2]))
        for operation in plan.operations
        for position, value in enumerate(operation.results)
        if value is not None
    }


def _spans(
    plan: Plan, results: Mapping[str, ResultPort], reading: Mapping[str, int]
) -> dict[str, tuple[int, int]]:
    """Return when a word enters each FIFO and when it is read, from the cycles in which sinks read.

    A FIFO that only feeds another one is read after as many intervals as it has entries.
    """
    before = {sink: fifo for fifo in plan.fifos for sink in fifo.sinks}
    found: dict[str, tuple[int, int]] = {}

    def span(fifo: Fifo) -> tuple[int, int]:
        begin = results[fifo.value].operation.finish if fifo.value in results else 0
        if fifo.id in before and before[fifo.id].id in found:
            begin = found[before[fifo.id].id][1]
        ends = [reading[sink] for sink in fifo.sinks if sink in reading]
        end = min(ends, default=begin + fifo.depth * plan.initiation_interval)
        return begin, max(begin, end)

    for fifo in plan.fifos:
        # From the head of the chain on, as far as it is not known yet.
        way = {fifo.id: fifo}
        while (last := before.get(next(reversed(way)))) is not None:
            if last.id in found or last.id in way:
                break
            way[last.id] = last
        for each in reversed(way.values()):
            if each.id not in found:
                found[each.id] = span(each)
    return found


def _cells(plan: Plan, operands: Mapping[str, tuple[Connection, ...]]) -> dict[str, Cell]:
    on: dict[str, list[Operation]] = {unit.id: [] for unit in plan.units}
    for operation in sorted(plan.operations, key=lambda each: each.start % plan.initiation_interval):
        on.setdefault(operation.unit, []).append(operation)
    cells = {}
    for unit in plan.units:
        count = max((len(operation.ports) for operation in on[unit.id]), default=0)
        ports: list[dict[int, Driver]] = [{} for _ in range(count)]
        for operation in on[unit.id]:
            for port, connection in zip(ports, operands[operation.id], strict=False):
                port[operation.start % plan.initiation_interval] = connection.driver
        stated = chain(unit.inputs, repeat(()))
        wired = tuple(_multiplexer(*each) for each in zip(ports, stated, strict=False))
        cells[unit.id] = Cell(unit, tuple(on[unit.id]), wired)
    return cells


def _multiplexer(taken: Mapping[int, Driver], stated: Sequence[str]) -> Multiplexer:
    """Return the multiplexer of a port from its driver by slot, with its sources in the order stated."""
    order = {text: place for place, text in enumerate(stated)}
    sources = sorted(dict.fromkeys(taken.values()), key=lambda each: order.get(str(each), len(order)))
    place = {driver: at for at, driver in enumerate(sources)}
    return Multiplexer(tuple(sources), {slot: place[driver] for slot, driver in taken.items()})
