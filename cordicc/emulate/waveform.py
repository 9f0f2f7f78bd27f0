"""A plan run clock by clock, as a value change dump (VCD, IEEE 1364): what a waveform viewer shows.

One signal for every port and result of a unit, every FIFO's end, every input and output: a word, and a bit
beside it that tells whether a sample is there; without one the word is unknown (x).  Of a shared unit,
`operation` names the one in whose slot it is, and `select` is what the multiplexer of a port takes.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from vcd import VCDWriter
from vcd.writer import Variable

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.base.arrays import Bools, Samples, Words
from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.emulate.cycle import Register, Snapshot, clock
from cordicc.emulate.ports import PortFormats, constant_signal, prepare
from cordicc.emulate.sample_columns import Columns
from cordicc.emulate.sample_tables import read_table
from cordicc.ir.sampling import draw_parts
from cordicc.plan.model import Operation, Plan
from cordicc.plan.netlist import Cell, Driver, FifoEnd, InputWord, Netlist
from cordicc.plan.origin import PlanProblem

MOST_SIGNAL_CYCLES = 20_000_000
"""Signals times cycles; larger waveforms are refused."""

_TIME_UNITS = ("s", "ms", "us", "ns", "ps", "fs")
_FEMTOSECONDS = 10**15

State = int | str | None
"""Bits, a text, or None for unknown."""

Probe = Callable[[Snapshot], State]


def first_samples(
    problem: PlanProblem, file: Path | None, drawn: int, seed: int, most: int
) -> tuple[Samples, bool]:
    """Return at most `most` samples, the first of a file or else of those drawn, and whether there are more.

    Raises InvalidInput if the file cannot be read.
    """
    names = problem.input_names
    if file is None:
        parts = draw_parts(problem.workspace, drawn, seed, most + 1)
    else:
        parts = read_table(file, Columns(list(names)), most + 1).parts
    part = next(parts)
    return {name: part[name][:most] for name in names}, any(len(column) > most for column in part.values())


def render(plan: Plan, inputs: Mapping[str, ArrayLike]) -> str:
    """Return the waveform of samples as VCD text without a date.

    `inputs` holds a one-dimensional array of doubles per input.  The clock rises at time 0, where cycle 0
    starts, and falls half a period later.

    Raises:
        Unattainable: the waveform would be too large (E616).
        ValueError, MachineError: as `cycle.run`.
    """
    arithmetic = plan.arithmetic
    samples, in_range = prepare(plan, inputs)
    count = in_range.size
    cycles = plan.latency_cycles + (count - 1) * plan.initiation_interval + 1 if count else 0
    half_period, timescale = timing(plan.clock_hz)
    text = io.StringIO()
    about = _about_words(plan, arithmetic)
    with VCDWriter(
        text, timescale=timescale, date="", version="cordicc", comment=about, check_values=False
    ) as writer:
        signals = _Signals(writer, plan, arithmetic, in_range)
        _check_size(len(signals.probes), cycles)
        ticking = signals.register((), "clk", 1)
        stream = {name: array.reshape(count, 1) for name, array in samples.items()}
        for snapshot in clock(plan, arithmetic, stream, count, 1) if count else ():
            time = 2 * half_period * snapshot.cycle
            writer.change(ticking, time, 1)
            for variable, probe in signals.probes:
                state = probe(snapshot)
                writer.change(variable, time, "x" if state is None else state)
            writer.change(ticking, time + half_period, 0)
        writer.close(2 * half_period * cycles)
    return text.getvalue()


def _about_words(plan: Plan, arithmetic: Arithmetic) -> str:
    """Return what the words stand for, in words: their binary points if they are fixed."""
    formats = PortFormats.of(plan, arithmetic)
    points = {
        name: format_.fraction_bits
        for name, format_ in {**formats.values, **formats.outputs}.items()
        if isinstance(format_, FixedPoint)
    }
    if not points:
        return f"words: {arithmetic.system.spec()['kind']}"
    listed = ", ".join(f"{name} {bits}" for name, bits in points.items())
    return f"words: fixed point, two's complement; bits after the binary point: {listed}"


def _check_size(signals: int, cycles: int) -> None:
    if signals * cycles > MOST_SIGNAL_CYCLES:
        message = f"the waveform would have {signals} signals over {cycles} cycles"
        raise Unattainable([Diagnostic("E616", message, hint="write fewer samples: --vcd-samples")])


def timing(clock_hz: float) -> tuple[int, str]:
    """Return half a clock period, and the coarsest timescale in which it is whole (to a femtosecond)."""
    half = max(1, round(_FEMTOSECONDS / clock_hz / 2))
    scales = ((f * 1000**p, f"{f} {_TIME_UNITS[-1 - p]}") for p in range(5, -1, -1) for f in (100, 10, 1))
    return next((half // scale, name) for scale, name in scales if half % scale == 0)


@dataclass(slots=True)
class _Signals:
    """The signals of a plan, each with a probe that reads it from a cycle's snapshot."""

    writer: VCDWriter
    plan: Plan
    arithmetic: Arithmetic
    in_range: Bools
    probes: list[tuple[Variable[State], Probe]] = field(default_factory=list)
    names: dict[tuple[str, ...], set[str]] = field(default_factory=dict)
    formats: PortFormats = field(init=False)
    netlist: Netlist = field(init=False)

    def __post_init__(self) -> None:
        self.formats = PortFormats.of(self.plan, self.arithmetic)
        self.netlist = Netlist.of(self.plan)
        interval = self.plan.initiation_interval
        if interval > 1:
            self._add((), "slot", (interval - 1).bit_length(), lambda snapshot: snapshot.cycle % interval)
        for name in self.plan.problem.input_names:
            self._add_word(("inputs",), name, self._width(name), _wire(InputWord(name)))
        for fifo in self.plan.fifos:
            self._add_word(("fifos",), f"{fifo.id}_{fifo.value}", fifo.width, _wire(FifoEnd(fifo.id)))
        self._add_outputs()
        for cell in self.netlist.cells.values():
            self._add_unit(cell)

    def register(self, scope: tuple[str, ...], name: str, width: int | None) -> Variable[State]:
        """Declare a signal of so many bits, or one that carries text, under a name that VCD allows."""
        path = (_name(self.plan.name), *map(_name, scope))
        made = _name(name)
        taken = self.names.setdefault(path, set())
        while made in taken:
            made += "_"
        taken.add(made)
        if width is None:
            return self.writer.register_var(path, made, "string", init="")
        return self.writer.register_var(path, made, "wire", size=width)

    def _add(self, scope: tuple[str, ...], name: str, width: int | None, probe: Probe) -> None:
        self.probes.append((self.register(scope, name, width), probe))

    def _add_word(
        self, scope: tuple[str, ...], name: str, width: int, read: Callable[[Snapshot], Register]
    ) -> None:
        self._add(scope, name, width, lambda snapshot: _bits(read(snapshot), width))
        self._add(scope, f"{name}_valid", 1, lambda snapshot: int(read(snapshot) is not None))

    def _width(self, value: str) -> int:
        return self.formats.values[value].width_bits

    def _add_outputs(self) -> None:
        for name in self.plan.outputs:
            width = self.formats.outputs[name].width_bits
            self._add(("outputs",), name, width, self._output(name, width))
        self._add(("outputs",), "valid", 1, self._sample_is_valid)

    def _output(self, name: str, width: int) -> Probe:
        format_ = self.formats.outputs[name]

        def probe(snapshot: Snapshot) -> State:
            numbers = snapshot.outputs.get(name)
            return None if numbers is None else _pattern(format_.encode(numbers), width)

        return probe

    def _sample_is_valid(self, snapshot: Snapshot) -> State:
        """Return 1 for a valid sample that leaves, 0 for an invalid one, x between samples."""
        if not snapshot.outputs:
            return None
        step = (snapshot.cycle - self.plan.latency_cycles) // self.plan.initiation_interval
        numbers = [float(array[0]) for array in snapshot.outputs.values()]
        return int(bool(self.in_range[step]) and not np.isnan(numbers).any())

    def _add_unit(self, cell: Cell) -> None:
        scope = ("units", cell.unit.id)
        operations, interval = cell.operations, self.plan.initiation_interval
        entering = {operation.start % interval: operation for operation in operations}
        leaving = {operation.finish % interval: operation for operation in operations}
        if len(operations) > 1:
            self._add(scope, "operation", None, lambda s: getattr(entering.get(s.cycle % interval), "id", ""))
            for at, multiplexer in enumerate(cell.ports):
                width = max(1, (len(multiplexer.sources) - 1).bit_length())
                self._add(scope, f"select_{at}", width, _selected(multiplexer.select, interval))
        for at, port in enumerate(_common([operation.ports for operation in operations])):
            sources, select = cell.ports[at].sources, cell.ports[at].select
            reads = {slot: _wire(sources[chosen]) for slot, chosen in select.items()}
            widths = [self._operand_width(o, at) for o in operations if at < len(o.ports)]
            self._add_word(scope, port, max(widths), _in_slot(reads, interval))
        results = [tuple(self._result_names(operation)) for operation in operations]
        for at, port in enumerate(_common(results)):
            made = {slot: o.results[at] for slot, o in leaving.items() if at < len(o.results)}
            wires = {s: _wire(self.netlist.results[name].driver) for s, name in made.items() if name}
            widest = max((self._width(name) for name in made.values() if name is not None), default=0)
            if widest:
                self._add_word(scope, f"result_{port}", widest, _in_slot(wires, interval))

    def _result_names(self, operation: Operation) -> list[str]:
        return [
            f"{at}" if name is None else name.rpartition(".")[2] for at, name in enumerate(operation.results)
        ]

    def _operand_width(self, operation: Operation, at: int) -> int:
        operand = operation.operands[at]
        if operand.value is not None:
            return self._width(operand.value)
        return constant_signal(self.arithmetic, operand, 1).format.width_bits


def _wire(driver: Driver) -> Callable[[Snapshot], Register]:
    return lambda snapshot: snapshot.wires.get(driver)


def _selected(select: Mapping[int, int], interval: int) -> Probe:
    return lambda snapshot: select.get(snapshot.cycle % interval)


def _in_slot(
    reads: Mapping[int, Callable[[Snapshot], Register]], interval: int
) -> Callable[[Snapshot], Register]:
    """Return what reads the port of the operation in whose slot a cycle is, nothing in other slots."""

    def read(snapshot: Snapshot) -> Register:
        chosen = reads.get(snapshot.cycle % interval)
        return None if chosen is None else chosen(snapshot)

    return read


def _common(ports: list[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the names of the ports on which all operations of a unit agree, else numbers."""
    most = max((len(names) for names in ports), default=0)
    return ports[0] if len(set(ports)) == 1 else tuple(f"port_{at}" for at in range(most))


def _bits(register: Register, width: int) -> State:
    return None if register is None else _pattern(register.words, width)


def _pattern(words: Words, width: int) -> int:
    """Return the bits of the first word."""
    word = np.atleast_1d(words)[:1]
    number = word.view(np.uint32)[0] if word.dtype == np.float32 else word[0]
    return int(number) & ((1 << width) - 1)


def _name(text: str) -> str:
    """Return a name that every VCD reader takes."""
    return re.sub(r"[^A-Za-z0-9_]", "_", text) or "_"
