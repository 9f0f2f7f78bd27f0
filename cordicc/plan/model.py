"""The plan: what cordicc emits, as frozen data.  Its JSON form is in `cordicc.plan.file`."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from graphlib import TopologicalSorter
from typing import Any

from cordicc.targets.target import CAU_KINDS

FORMAT = "cordicc-plan"
VERSION = 1


@dataclass(frozen=True, slots=True)
class ControlWord:
    """What a shared unit does in a slot: the operation, and the multiplexer input of each of its ports."""

    slot: int
    operation: str
    select: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Unit:
    """A hardware unit; `latency` in cycles.

    Of a unit that several operations share, `inputs` are the sources of each port (`fifo f1`,
    `input x`, `constant 1/2` or `unit cau1.norm`) and `control` the words of the slots in use.
    """

    id: str
    kind: str
    latency: int
    inputs: tuple[tuple[str, ...], ...] = ()
    control: tuple[ControlWord, ...] = ()


@dataclass(frozen=True, slots=True)
class Operand:
    """What an operand port takes: the name of a value (an input, a result) or a constant.

    A constant is a number of the target's format, written so that it reads back exactly.
    """

    value: str | None = None
    constant: str | None = None


@dataclass(frozen=True, slots=True)
class Operation:
    """One operation in its time slot.

    `op` and `params` are those of the graph (`cordicc.ir.ops`), `mode` says the same in words.
    `start` is the cycle in which the operands enter, `finish` the one from which results are usable.
    `results` names the value of each result port, None where nobody takes it.  `derivation` is the chain of
    rewriting steps that led from the equation to it, in words and, between backticks, formulas written as
    in a problem file; empty if the equation says it.
    """

    id: str
    op: str
    params: dict[str, Any]
    kind: str
    mode: str
    unit: str
    start: int
    finish: int
    ports: tuple[str, ...]
    operands: tuple[Operand, ...]
    results: tuple[str | None, ...]
    equation: str
    derivation: tuple[str, ...] = ()

    def at(self, unit: str, start: int, finish: int) -> Operation:
        """Return the operation bound to a unit and a slot."""
        return replace(self, unit=unit, start=start, finish=finish)


@dataclass(frozen=True, slots=True)
class Fifo:
    """One segment of a value's delay between consecutive taps; `depth` in words, `width` in bits.

    `source` is the producing operation, the input, or the FIFO before; `sinks` are the operand ports
    (`o3.y`), outputs (`out.theta`) or the FIFO (`f2`) fed by its end.
    """

    id: str
    value: str
    source: str
    sinks: tuple[str, ...]
    depth: int
    width: int


@dataclass(frozen=True, slots=True)
class Selection:
    """How the operations were chosen: whether alternatives were searched, and proven the cheapest of them.

    `facts` are the assumptions of the problem, as written there, on which the choice rests.
    """

    searched: bool = False
    proven: bool = False
    facts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Formats:
    """The number formats of values and of outputs by name, `width` and `fraction` in bits.

    Empty where the target implies them: every word of a floating-point target is alike.
    """

    values: dict[str, dict[str, int]] = field(default_factory=dict)
    outputs: dict[str, dict[str, int]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plan:
    """A complete hardware plan.  The schema of its JSON form explains each field."""

    name: str
    description: str
    target: dict[str, Any]
    problem: dict[str, Any]
    options: dict[str, Any]
    initiation_interval: int
    latency_cycles: int
    cau_cycles: int
    units: tuple[Unit, ...]
    operations: tuple[Operation, ...]
    fifos: tuple[Fifo, ...]
    outputs: dict[str, Operand]
    optimal: dict[str, bool]
    bounds: dict[str, int]
    accuracy: dict[str, Any] = field(default_factory=dict)
    formats: Formats = field(default_factory=Formats)
    selection: Selection = field(default_factory=Selection)

    @property
    def clock_hz(self) -> float:
        """Return the clock of the target."""
        return float(self.target["clock_hz"])

    @property
    def latency_seconds(self) -> float:
        """Return the time from the inputs to the outputs."""
        return self.latency_cycles / self.clock_hz

    @property
    def fifo_words(self) -> int:
        """Return the words of all FIFOs together."""
        return sum(fifo.depth for fifo in self.fifos)

    def units_by_kind(self) -> dict[str, int]:
        """Return the number of units of each kind, CAUs first."""
        count = Counter(unit.kind for unit in self.units)
        order = (*CAU_KINDS, *sorted(set(count) - set(CAU_KINDS)))
        return {kind: count[kind] for kind in order if count[kind]}

    def processors(self) -> dict[str, int]:
        """Return the number of CAUs by kind and in total."""
        count = {kind: sum(unit.kind == kind for unit in self.units) for kind in CAU_KINDS}
        return {**count, "total": sum(count.values())}

    def critical_path(self) -> dict[str, int]:
        """Return the cycles by kind of unit on the longest path from an input to an output."""
        longest: dict[str, tuple[int, Counter[str]]] = {}
        best: tuple[int, Counter[str]] = (0, Counter())
        for operation in sorted(self.operations, key=lambda o: (o.start, o.finish)):
            before = max(
                (longest[o.value] for o in operation.operands if o.value in longest),
                key=lambda path: path[0],
                default=(0, Counter()),
            )
            cycles = operation.finish - operation.start
            path = (before[0] + cycles, before[1] + Counter({operation.kind: cycles}))
            best = max(best, path, key=lambda p: p[0])
            longest |= {result: path for result in operation.results if result is not None}
        return dict(best[1])


def dependence_order(plan: Plan) -> tuple[Operation, ...]:
    """Return the operations, each after those whose results it takes."""
    operations = {operation.id: operation for operation in plan.operations}
    maker = {name: operation.id for operation in plan.operations for name in operation.results if name}
    sorter: TopologicalSorter[str] = TopologicalSorter()
    for operation in plan.operations:
        taken = (operand.value for operand in operation.operands)
        sorter.add(operation.id, *(maker[name] for name in taken if name in maker))
    return tuple(operations[id] for id in sorter.static_order())
