"""One operation of a fixed-point plan on one sample: every signal of its unit's circuit, cycle by cycle.

Operands and results are the words of the emulator.  Words that stand for no number are those that the Verilog
has there, of which the emulator knows nothing: the circuits before the operation make them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.evaluation import values_of
from cordicc.arith.circuits.units import PORTS, RESULTS
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.formats import Signal
from cordicc.backends.rtl.core import Core
from cordicc.backends.rtl.module_text import signal_names
from cordicc.backends.rtl.package import core_in_verilog
from cordicc.backends.rtl.reset_style import USUAL_RESET
from cordicc.backends.rtl.word_ports import WordFormats
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source, Unattainable
from cordicc.emulate import functional
from cordicc.plan.model import Operation, Plan, dependence_order
from cordicc.plan.netlist import Connection, ConstantWord, Driver, FifoEnd, InputWord, Netlist
from cordicc.studies.picked_sample import PickedSample


@dataclass(frozen=True, slots=True)
class TracedWord:
    """An operand or result.

    Attributes:
        name: in the plan, such as `C` or `first`.
        port: of the unit's module, None of an operand that is constant in all that the unit does.
        value: the input or result that it is, or the text of a constant.
        format: of the word.
        word: as an integer.
        ok: whether it stands for a number.
    """

    name: str
    port: str | None
    value: str
    format: FixedPoint
    word: int
    ok: bool

    @property
    def number(self) -> float | None:
        """What it stands for."""
        return float(np.ldexp(float(self.word), -self.format.fraction_bits)) if self.ok else None


@dataclass(frozen=True, slots=True)
class StageSignal:
    """A signal of the unit's module.

    Attributes:
        cycle: in which it has the word, counted from that in which the operands enter.
        name: in the module.
        width: in bits.
        signed: whether it is in two's complement.
        word: as an integer.
        comment: what stands above it in the module, may be empty.
    """

    cycle: int
    name: str
    width: int
    signed: bool
    word: int
    comment: str


@dataclass(frozen=True, slots=True)
class StageTrace:
    """What an operation does with a sample.

    Attributes:
        plan: whose operation it is.
        operation: that is traced.
        sample: whose words they are.
        module: the Verilog module of its unit.
        instance: its unit in the core, behind the core's name and a dot.
        invalid: why the sample is invalid, in words, None if it is valid.
        operands: in the order of the operation's ports.
        results: those that somebody takes.
        signals: by cycle.
    """

    plan: Plan
    operation: Operation
    sample: PickedSample
    module: str
    instance: str
    invalid: str | None
    operands: tuple[TracedWord, ...]
    results: tuple[TracedWord, ...]
    signals: tuple[StageSignal, ...]


def stage_trace(plan: Plan, id: str, sample: PickedSample, file: str) -> StageTrace:
    """Return the trace of an operation.

    Args:
        plan: whose operation it is.
        id: of the operation.
        sample: on which it runs.
        file: the name of the plan for the user.

    Raises:
        InvalidInput: there is no such operation (E655).
        Unattainable: the plan has no circuits (E421).
    """
    source = Source(file, "")
    found = {operation.id: operation for operation in plan.operations}
    if id not in found:
        hint = f"there are {', '.join(found)}" if found else "the plan has no operations"
        raise InvalidInput([Diagnostic("E655", f"there is no operation '{id}'", None, hint, source=source)])
    if not isinstance(plan.arithmetic.system, FixedSystem):
        message = (
            f"operation {id} cannot be traced: the words of target '{plan.target.name}' are in floating "
            "point, of which there are no circuits"
        )
        hint = (
            "a plan for a fixed-point target: compile --target fixed24; of any plan 'cordicc simulate --vcd' "
            "shows the words between units"
        )
        raise Unattainable([Diagnostic("E421", message, None, hint, source=source)])
    try:
        traced = TracedSample(plan, sample)
    except Unattainable as error:
        raise Unattainable(replace(each, source=source) for each in error.diagnostics) from None
    return traced.trace(found[id])


class _Word(NamedTuple):
    word: int
    ok: bool


class _Unit(NamedTuple):
    """A unit's circuit with the words of all its cells."""

    circuit: Circuit
    made: list[int]

    def output(self, name: str) -> int:
        return next(self.made[port.cell] for port in self.circuit.outputs if port.name == name)

    def signals(self) -> Iterator[StageSignal]:
        """Yield all signals, as they stand in the module: by cycle, registers first; then the outputs."""
        names, notes = signal_names(self.circuit), self.circuit.notes
        cells = self.circuit.cells
        numbers = [number for number, cell in enumerate(cells) if cell.kind != "constant"]
        for number in sorted(numbers, key=lambda n: (cells[n].cycle or 0, cells[n].kind != "register")):
            yield self._signal(names[number], number, notes.get(number, ""))
        for port in self.circuit.outputs:
            yield self._signal(port.name, port.cell)

    def _signal(self, name: str, number: int, comment: str = "") -> StageSignal:
        cell = self.circuit.cells[number]
        return StageSignal(cell.cycle or 0, name, cell.width, cell.signed, self.made[number], comment)


class TracedSample:
    """A sample in the hardware of a fixed-point plan.

    Raises:
        Unattainable: the plan has no circuits (E421).
    """

    def __init__(self, plan: Plan, sample: PickedSample) -> None:
        self._plan = plan
        self._sample = sample
        self._core: Core = core_in_verilog(plan, USUAL_RESET)
        self._netlist = Netlist.of(plan)
        self._formats = WordFormats(plan)
        self._makers = {name: o for o in plan.operations for name in o.results if name is not None}
        self._units: dict[str, _Unit] = {}
        self._inputs: dict[str, _Word] = {}
        ranges = plan.problem.workspace.ranges
        numbers = {}
        for port in self._core.inputs:
            number = sample.numbers[port.name]
            word = int(port.format.encode(np.array([number]))[0])
            lo, hi = ranges[port.name]
            if (
                port.lo is None and lo <= number <= hi
            ):  # nothing takes it, and its words do not hold its range
                word = min(max(word, port.least), port.most)
            ok = port.least <= word <= port.most
            self._inputs[port.name] = _Word(word, ok)
            # What enters are words: a number beyond its range whose word is within is the end of the range.
            numbers[port.name] = np.array([float(np.clip(number, lo, hi)) if ok else np.nan])
        self._numbers: Mapping[str, np.ndarray] = numbers
        self._emulated: Mapping[str, Signal] = functional.words(plan, plan.arithmetic, numbers)

    def trace(self, operation: Operation) -> StageTrace:
        """Return the trace of an operation."""
        unit = self._unit(operation)
        ports = {port.name for port in unit.circuit.inputs}
        operands = tuple(
            TracedWord(
                name,
                PORTS[at] if PORTS[at] in ports else None,
                str(operand.value or operand.constant),
                self._formats.of_operand(operand),
                *self._word(connection),
            )
            for at, (name, operand, connection) in enumerate(
                zip(operation.ports, operation.operands, self._netlist.operands[operation.id], strict=True)
            )
        )
        results = tuple(
            TracedWord(
                name.rpartition(".")[2], RESULTS[at], name, self._formats.held(name), *self._result(name)
            )
            for at, name in enumerate(operation.results)
            if name is not None
        )
        return StageTrace(
            self._plan,
            operation,
            self._sample,
            self._core.units[operation.unit],
            f"{self._core.name}_core.{self._core.instances[operation.unit]}",
            self._invalid,
            operands,
            results,
            tuple(unit.signals()),
        )

    @cached_property
    def _invalid(self) -> str | None:
        for name, (_, ok) in self._inputs.items():
            if not ok:
                lo, hi = self._plan.problem.workspace.ranges[name]
                return f"input {name} is not from {lo!r} to {hi!r}"
        for operation in dependence_order(self._plan):
            if any(name is not None and self._known(name) is None for name in operation.results):
                return f"operation {operation.id} makes no number"
        outputs = functional.run(self._plan, self._plan.arithmetic, self._numbers)
        return None if outputs["valid"][0] else "no word of an output holds its number"

    def _known(self, value: str) -> int | None:
        """Return the word of an input or result in the emulator, None of the invalid one."""
        words, format_ = self._emulated[value]
        word = int(words[0])
        assert isinstance(format_, FixedPoint)
        return None if word == format_.invalid_word else word

    def _word(self, connection: Connection) -> _Word:
        """Return what a port of a unit takes."""
        if connection.value is not None and (word := self._known(connection.value)) is not None:
            return _Word(word, True)
        return self._carried(connection.driver, connection.value or "")

    def _carried(self, driver: Driver, value: str) -> _Word:
        """Return what a driver carries in hardware, where it makes a difference how a word gets there."""
        match driver:
            case ConstantWord(text):
                return _Word(int(self._plan.arithmetic.system.constant(text).words), True)
            case InputWord(name):
                return self._inputs[name]
            case FifoEnd(fifo):
                word, ok = self._carried(self._netlist.fifos[fifo].driver, value)
                depth = next(each.depth for each in self._plan.fifos if each.id == fifo)
                return _Word(_signed(word, self._formats.held(value).width_bits) if depth else word, ok)
        return self._result(value)

    def _result(self, value: str) -> _Word:
        """Return what leaves a unit."""
        unit = self._unit(self._makers[value])
        name = RESULTS[self._netlist.results[value].position]
        return _Word(unit.output(name), bool(unit.output(f"{name}_ok")))

    def _unit(self, operation: Operation) -> _Unit:
        """Return the unit of an operation with what it does for it."""
        if operation.id not in self._units:
            circuit = self._core.modules[self._core.units[operation.unit]]
            taken = [self._word(each) for each in self._netlist.operands[operation.id]]
            given = dict(zip(PORTS, (each.word for each in taken), strict=False))
            given |= {"ok": int(all(each.ok for each in taken)), "mode": self._core.uses[operation.id]}
            arrays = {}
            for port in circuit.inputs:
                cell = circuit.cells[port.cell]
                word = given.get(port.name, 0)
                arrays[port.name] = np.array([_signed(word, cell.width) if cell.signed else word])
            made = values_of(circuit, arrays, wrapped=True)
            self._units[operation.id] = _Unit(circuit, [int(np.ravel(each)[0]) for each in made])
        return self._units[operation.id]


def _signed(word: int, width: int) -> int:
    """Return the last bits of a word in two's complement."""
    low = word & ((1 << width) - 1)
    return low - (1 << width) if low >> (width - 1) else low
