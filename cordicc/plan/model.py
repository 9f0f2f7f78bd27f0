"""The plan: what cordicc emits, as frozen data.  Only `plain_data` and `file` beside know its JSON form."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from graphlib import TopologicalSorter
from typing import Any

from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.arith.numbers.slack import EXACT, SLACK, Slack
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.ir.graph import Graph
from cordicc.ir.ops import angle_result
from cordicc.plan.area import Area, SynthesisResult
from cordicc.plan.origin import PlanOptions, PlanProblem, PlanTarget
from cordicc.plan.stated_accuracy import CheckFigures, OutputAccuracy
from cordicc.targets.target import CAU_KINDS


@dataclass(frozen=True, slots=True)
class ControlWord:
    """What a shared unit does in a slot: the operation, and the multiplexer input of each of its ports."""

    slot: int
    operation: str
    select: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Unit:
    """A hardware unit; `latency` in cycles, and it takes an operation every `initiation_interval` cycles.

    Of a unit that several operations share, `inputs` are the sources of each port (`fifo f1`,
    `input x`, `constant 1/2` or `unit cau1.norm`) and `control` the words of the slots in use.
    """

    id: str
    kind: str
    latency: int
    inputs: tuple[tuple[str, ...], ...] = ()
    control: tuple[ControlWord, ...] = ()
    initiation_interval: int = 1


@dataclass(frozen=True, slots=True)
class Operand:
    """What an operand port takes: the name of a value (an input, a result) or a constant.

    A constant is a number of the target's format, written so that it reads back exactly.
    """

    value: str | None = None
    constant: str | None = None


@dataclass(frozen=True, slots=True)
class EndError:
    """What is proven of an implicit angle near the end of reach, |C| = R, its rounding to a word apart.

    It is off by at most `residual`, in the unit of A, B and C, over the second result sqrt(R^2 - C^2) as long
    as that is small beside it, and by `angle_rad` at the end itself, None if that has no bound.
    """

    residual: float
    angle_rad: float | None


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
    params: Mapping[str, int | str]
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
    slack: Slack = EXACT
    end_error: EndError | None = None

    @property
    def m(self) -> int | None:
        """Return the coordinate system of a CAU operation, None for an operation without one."""
        m = self.params.get("m")
        assert m is None or isinstance(m, int)
        return m

    @property
    def settings(self) -> Mapping[str, Any]:
        """Return what the unit is told: the parameters, and as `slack` the slack if there is one."""
        return self.params if self.slack == EXACT else {**self.params, SLACK: self.slack}

    @property
    def angle(self) -> int | None:
        """Return the number of the result that is an angle in radians, None if none is."""
        return angle_result(self.op, self.params)

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

    `facts` are the assumptions of the problem, as written there, on which the choice rests; `left_out` what
    was not among the alternatives for its size, its work or the target, in words; `turned_down` are the
    checks for which cheaper operations were turned down.
    """

    searched: bool = False
    proven: bool = False
    facts: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    turned_down: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Formats:
    """The number formats of values and of outputs by name.

    Empty where the target implies them: every word of a floating-point target is alike.
    """

    values: Mapping[str, BinaryPoint] = field(default_factory=dict)
    outputs: Mapping[str, BinaryPoint] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plan:
    """A complete hardware plan.

    Times are in clock cycles, counted from the one in which the inputs are accepted.  `outputs` are what
    each output takes.  Of the figures `processors`, `latency` and `fifo_words`, `optimal` tells which are
    proven to be the least under the options, `bounds` what each is at the least.  `accuracy` is by output,
    `checks` by check, both empty for a plan that was not run.  `unit_program` is the graph of the
    operations with exact constants, from which error bounds are derived.  `estimate` is the area that the
    device of the target is expected to need, None of a target without one; `synthesis` what building showed,
    None of a plan that was not built.
    """

    problem: PlanProblem
    target: PlanTarget
    options: PlanOptions
    initiation_interval: int
    latency_cycles: int
    cau_cycles: int
    units: tuple[Unit, ...]
    operations: tuple[Operation, ...]
    fifos: tuple[Fifo, ...]
    outputs: Mapping[str, Operand]
    optimal: Mapping[str, bool]
    bounds: Mapping[str, int]
    accuracy: Mapping[str, OutputAccuracy] = field(default_factory=dict)
    formats: Formats = field(default_factory=Formats)
    selection: Selection = field(default_factory=Selection)
    unit_program: Graph | None = None
    checks: Mapping[str, CheckFigures] = field(default_factory=dict)
    estimate: Area | None = None
    synthesis: SynthesisResult | None = None

    @property
    def name(self) -> str:
        """Return the name of the problem."""
        return self.problem.name

    @property
    def description(self) -> str:
        """Return what the problem is, in the words of its file."""
        return self.problem.description

    @property
    def arithmetic(self) -> Arithmetic:
        """Return the arithmetic of the target, which fixes every bit."""
        return self.target.arithmetic

    @property
    def clock_hz(self) -> float:
        """Return the clock of the target."""
        return self.target.clock_hz

    @property
    def latency_seconds(self) -> float:
        """Return the time from the inputs to the outputs."""
        return self.latency_cycles / self.clock_hz

    @property
    def fifo_words(self) -> int:
        """Return the words of all FIFOs together."""
        return sum(fifo.depth for fifo in self.fifos)

    @property
    def area(self) -> Area | None:
        """Return the area as it was counted, else as it was estimated; None if it was neither."""
        return self.estimate if self.synthesis is None else self.synthesis.area

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
