"""The core of a plan in Verilog: its units with their multiplexers, FIFOs and the way of what is valid.

Words stand for numbers where the bit beside them says so; the invalid code appears at the ports alone.  A
sample enters in slot 0 of the interval, and what is taken in cycle c of it is there in slot c modulo the
interval.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cordicc.arith.circuits.builder import CircuitBuilder
from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.plain_operations import ExactNumber, rounded
from cordicc.arith.circuits.units import PORTS, RESULTS, Plain, unit_circuit
from cordicc.arith.circuits.uses import Use
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.backends.rtl.module_text import literal
from cordicc.backends.rtl.names import comment, identifiers
from cordicc.plan.model import Operand, Operation, Plan
from cordicc.plan.netlist import Cell, ConstantWord, Driver, FifoEnd, InputWord, Netlist, UnitResult


@dataclass(frozen=True, slots=True)
class PortWord:
    """A port of the core: the name in the plan and in Verilog, and the format of its words."""

    name: str
    port: str
    format: FixedPoint


@dataclass(frozen=True, slots=True)
class Core:
    """The core of a plan.

    Attributes:
        name: of the module without what follows it, and of the files.
        text: of the module.
        modules: the circuits of its units by module.
        units: the module of each unit.
        inputs: its ports in the order of the plan.
        outputs: the same of what leaves.
        interval: cycles from sample to sample.
        latency: cycles from a sample's words to its outputs.
    """

    name: str
    text: str
    modules: Mapping[str, Circuit]
    units: Mapping[str, str]
    inputs: tuple[PortWord, ...]
    outputs: tuple[PortWord, ...]
    interval: int
    latency: int


def core_of(plan: Plan, header: Sequence[str]) -> Core:
    """Return the core of a plan, with lines above its text.

    Raises:
        NoCircuitError: an operation has no circuit.
    """
    made = _Core(plan)
    lines = [*(f"// {line}".rstrip() for line in header), *made.lines()]
    text = "\n".join(lines) + "\n"
    units = {id: module for id, (module, _) in made.instances.items()}
    ports = made.inputs, made.outputs
    return Core(made.name, text, made.modules, units, *ports, plan.initiation_interval, plan.latency_cycles)


class _Core:
    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._netlist = Netlist.of(plan)
        self._fifo = {fifo.id: fifo for fifo in plan.fifos}
        self.name = identifiers([plan.name])[plan.name]
        ports = identifiers([*plan.problem.input_names, *plan.outputs])
        self.inputs = tuple(
            PortWord(name, ports[name], self._format(name)) for name in plan.problem.input_names
        )
        self.outputs = tuple(PortWord(name, ports[name], self._delivered(name)) for name in plan.outputs)
        self.modules: dict[str, Circuit] = {}
        self.instances = {
            id: self._instance(cell) for id, cell in self._netlist.cells.items() if cell.operations
        }

    def _format(self, name: str) -> FixedPoint:
        """Return the format of an input or a result."""
        return self._stated(self._plan.formats.values.get(name))

    def _delivered(self, name: str) -> FixedPoint:
        """Return the format of an output."""
        return self._stated(self._plan.formats.outputs.get(name))

    def _stated(self, spec: BinaryPoint | None) -> FixedPoint:
        format_ = self._plan.arithmetic.system.format(spec)
        assert isinstance(format_, FixedPoint)
        return format_

    def _operand_format(self, operand: Operand) -> FixedPoint:
        if operand.value is not None:
            return self._format(operand.value)
        assert operand.constant is not None
        format_ = self._plan.arithmetic.system.constant(operand.constant).format
        assert isinstance(format_, FixedPoint)
        return format_

    def _use(self, operation: Operation) -> Use | Plain:
        operands = tuple(self._operand_format(operand) for operand in operation.operands)
        results = tuple(None if name is None else self._format(name) for name in operation.results)
        system = self._plan.arithmetic.system
        constants = tuple(
            None if operand.constant is None else int(system.constant(operand.constant).words)
            for operand in operation.operands
        )
        if operation.kind in self._plan.arithmetic.caus:
            return Use(
                operation.op,
                -1 if operation.op == "lightcone" else operation.m or 0,
                operands,
                results,
                int(operation.params.get("sign", 1)),
                str(operation.params.get("branch", "-")),
                operation.angle,
                operation.slack,
                constants,
            )
        assert results[0] is not None
        return Plain(operation.op, tuple(operation.settings.items()), operands, results[0], constants)

    def _instance(self, cell: Cell) -> tuple[str, dict[int, int]]:
        """Return the module of a unit, and the number of the use by slot."""
        uses = tuple(dict.fromkeys(self._use(operation) for operation in cell.operations))
        modes = {
            operation.start % self._netlist.interval: uses.index(self._use(operation))
            for operation in cell.operations
        }
        circuit = unit_circuit("unit", self._plan.arithmetic, cell.unit.kind, uses, cell.unit.latency)
        for name, other in self.modules.items():
            if (other.cells, other.outputs, other.inputs) == (circuit.cells, circuit.outputs, circuit.inputs):
                return name, modes
        return self._added(cell.unit.kind, circuit), modes

    def _added(self, what: str, circuit: Circuit) -> str:
        """Return the name of a new module."""
        base = f"{self.name}_{what}"
        name = f"{base}{sum(known.startswith(base) for known in self.modules) + 1}"
        self.modules[name] = Circuit(name, circuit.cells, circuit.inputs, circuit.outputs, circuit.notes)
        return name

    def lines(self) -> Iterator[str]:
        plan, interval = self._plan, self._netlist.interval
        yield "`default_nettype none"
        yield ""
        yield f"module {self.name}_core ("
        yield "    input  wire clk,"
        yield "    input  wire rst,  // synchronous; of what is valid and of the slots"
        yield "    input  wire ce,"
        yield "    input  wire in_valid,"
        if interval > 1:
            yield "    output wire in_ready,  // in the slot in which a sample may enter"
        for port in self.inputs:
            yield f"    input  wire signed [{port.format.width_bits - 1}:0] {port.port},"
        yield "    output wire out_valid,"
        yield "    output wire out_ok,  // the sample has outputs; else they are the invalid code"
        ports = [
            f"    output wire signed [{port.format.width_bits - 1}:0] {port.port}" for port in self.outputs
        ]
        yield ",\n".join(ports)
        yield ");"
        yield from self._slots()
        yield from self._entering()
        yield from self._fifos()
        for id, cell in self._netlist.cells.items():
            if cell.operations:
                yield from self._unit(id, cell)
        yield from self._leaving(plan)
        yield "endmodule"
        yield ""
        yield "`default_nettype wire"

    def _slots(self) -> Iterator[str]:
        interval = self._netlist.interval
        yield ""
        if interval > 1:
            yield f"    // One slot after the other; samples enter in slot 0, each {interval} cycles."
            yield f"    reg [{interval - 1}:0] slot;"
            yield "    always @(posedge clk)"
            yield f"        if (rst) slot <= {interval}'d1;"
            yield f"        else if (ce) slot <= {{slot[{interval - 2}:0], slot[{interval - 1}]}};"
            yield "    assign in_ready = slot[0];"
        depth = self._netlist.valid_depth
        fed = "in_valid" + (" && slot[0]" if interval > 1 else "")
        if depth:
            yield f"    reg [{depth - 1}:0] valid;"
            yield "    always @(posedge clk)"
            yield f"        if (rst) valid <= {depth}'d0;"
            shift = "in_valid" if depth == 1 else f"{{valid[{depth - 2}:0], in_valid}}"
            gate = "ce" if interval == 1 else "ce && slot[0]"
            yield f"        else if ({gate}) valid <= {shift};"
            leaves = self._netlist.latency % interval
            ready = f" && slot[{leaves}]" if interval > 1 else ""
            yield f"    assign out_valid = valid[{depth - 1}]{ready};"
        else:
            yield f"    assign out_valid = {fed};"

    def _entering(self) -> Iterator[str]:
        yield ""
        yield "    // Words out of the range of their input stand for no number, as the invalid code does."
        for spec, port in zip(self._plan.problem.inputs, self.inputs, strict=True):
            width = port.format.width_bits
            lo, hi = (int(w) for w in port.format.encode(np.array([spec.lo, spec.hi])))
            if -port.format.largest_word <= lo and hi <= port.format.largest_word:
                least, most = literal(lo, width), literal(hi, width)
                inside = f"({port.port} >= $signed({least})) && ({port.port} <= $signed({most}))"
            else:
                inside = f"{port.port} != $signed({literal(port.format.invalid_word, width)})"
            yield f"    wire {port.port}_ok = {inside};"

    def _text(self, driver: Driver) -> str:
        """Return the wire of a driver."""
        match driver:
            case InputWord(name):
                return next(port.port for port in self.inputs if port.name == name)
            case FifoEnd(fifo):
                return (
                    f"{fifo}_end" if self._fifo[fifo].depth else self._text(self._netlist.fifos[fifo].driver)
                )
            case UnitResult(unit, _):
                return f"{unit}_{RESULTS[self._position(driver)]}"
        raise AssertionError(driver)

    def _ok(self, driver: Driver) -> str:
        return f"{self._text(driver)}_ok"

    def _position(self, driver: UnitResult) -> int:
        return next(result.position for result in self._netlist.results.values() if result.driver == driver)

    def _width(self, driver: Driver) -> int:
        """Return the bits of what a driver carries."""
        match driver:
            case InputWord(name):
                return self._format(name).width_bits
            case FifoEnd(fifo) if not self._fifo[fifo].depth:
                return self._width(self._netlist.fifos[fifo].driver)
            case FifoEnd(fifo):
                return self._format(self._fifo[fifo].value).width_bits
            case UnitResult(unit, _):
                module, _ = self.instances[unit]
                circuit = self.modules[module]
                port = RESULTS[self._position(driver)]
                return next(circuit.cells[p.cell].width for p in circuit.outputs if p.name == port)
        raise AssertionError(driver)

    def _sized(self, driver: Driver, width: int) -> str:
        """Return what a driver carries in a width."""
        if isinstance(driver, ConstantWord):
            return literal(int(self._plan.arithmetic.system.constant(driver.text).words), width)
        own, text = self._width(driver), self._text(driver)
        if own == width:
            return text
        if own > width:
            return f"{text}[{width - 1}:0]"
        return f"{{{{{width - own}{{{text}[{own - 1}]}}}}, {text}}}"

    def _fifos(self) -> Iterator[str]:
        for fifo in self._plan.fifos:
            connection = self._netlist.fifos[fifo.id]
            if not fifo.depth:
                continue
            width, depth = self._format(fifo.value).width_bits, fifo.depth
            yield ""
            about = f"{fifo.value}, {depth} {'word' if depth == 1 else 'words'}"
            yield f"    // FIFO {fifo.id}: {comment(about)}."
            slot = connection.cycle % self._netlist.interval
            gate = "ce" if self._netlist.interval == 1 else f"ce && slot[{slot}]"
            taken = f"{{{self._ok(connection.driver)}, {self._sized(connection.driver, width)}}}"
            yield f"    reg [{depth * (width + 1) - 1}:0] {fifo.id};"
            if depth == 1:
                yield f"    always @(posedge clk) if ({gate}) {fifo.id} <= {taken};"
            else:
                rest = f"{fifo.id}[{(depth - 1) * (width + 1) - 1}:0]"
                yield f"    always @(posedge clk) if ({gate}) {fifo.id} <= {{{rest}, {taken}}};"
            top = depth * (width + 1) - 1
            yield f"    wire signed [{width - 1}:0] {fifo.id}_end = {fifo.id}[{top - 1}:{top - width}];"
            yield f"    wire {fifo.id}_end_ok = {fifo.id}[{top}];"

    def _unit(self, id: str, cell: Cell) -> Iterator[str]:
        module, modes = self.instances[id]
        circuit = self.modules[module]
        interval = self._netlist.interval
        yield ""
        for operation in cell.operations:
            slot = f", slot {operation.start % interval}" if interval > 1 else ""
            text = f"{operation.id}: {operation.mode}, for {operation.equation}, cycles {operation.start} to"
            yield f"    // {comment(f'{text} {operation.finish}{slot}')}"
        taken = []
        for port, wired in zip(PORTS, cell.ports, strict=False):
            width = next((circuit.cells[p.cell].width for p in circuit.inputs if p.name == port), 0)
            if not width:
                continue
            texts = [self._sized(source, width) for source in wired.sources]
            text = self._chosen(wired.select, texts, width)
            yield f"    wire signed [{width - 1}:0] {id}_{port} = {text};"
            taken.append(f".{port}({id}_{port})")
        oks = {}
        for operation in cell.operations:
            drivers = [each.driver for each in self._netlist.operands[operation.id]]
            bits = list(dict.fromkeys(self._ok(d) for d in drivers if not isinstance(d, ConstantWord)))
            oks[operation.start % interval] = " && ".join(bits) or "1'b1"
        distinct = list(dict.fromkeys(oks.values()))
        select = {slot: distinct.index(text) for slot, text in oks.items()}
        yield f"    wire {id}_ok = {self._chosen(select, [f'({text})' for text in distinct], 1)};"
        taken.append(f".ok({id}_ok)")
        if any(port.name == "mode" for port in circuit.inputs):
            width = next(circuit.cells[p.cell].width for p in circuit.inputs if p.name == "mode")
            numbers = sorted(set(modes.values()))
            texts = [literal(number, width) for number in numbers]
            select = {slot: numbers.index(number) for slot, number in modes.items()}
            sized = f"[{width - 1}:0] " if width > 1 else ""
            yield f"    wire {sized}{id}_mode = {self._chosen(select, texts, width)};"
            taken.append(f".mode({id}_mode)")
        for result in circuit.outputs:
            width = circuit.cells[result.cell].width
            signed = "" if result.name.endswith("_ok") else f"signed [{width - 1}:0] "
            yield f"    wire {signed}{id}_{result.name};"
            taken.append(f".{result.name}({id}_{result.name})")
        clocked = circuit.registers() > 0
        taken[:0] = [".clk(clk)", ".ce(ce)"] if clocked else []
        yield f"    {module} {id} ("
        yield ",\n".join(f"        {each}" for each in taken)
        yield "    );"

    def _chosen(self, select: Mapping[int, int], texts: Sequence[str], width: int) -> str:
        """Return the text of what a slot selects."""
        if len(texts) == 1:
            return texts[0]
        terms = []
        for number, text in enumerate(texts):
            slots = [f"slot[{slot}]" for slot, chosen in sorted(select.items()) if chosen == number]
            gate = slots[0] if len(slots) == 1 else f"({' | '.join(slots)})"
            terms.append(f"({{{width}{{{gate}}}}} & {text})" if width > 1 else f"({gate} & {text})")
        return "\n        | ".join(terms)

    def _leaving(self, plan: Plan) -> Iterator[str]:
        yield ""
        yield "    // What leaves: rounded to the words of the outputs, and valid if all of them are."
        oks = []
        for port in self.outputs:
            connection = self._netlist.outputs[port.name]
            driver = connection.driver
            name, width = port.port, port.format.width_bits
            equations = [each.text for each in plan.problem.equations if each.target == port.name]
            for text in equations[:1]:
                yield f"    // {comment(text)}"
            if isinstance(driver, ConstantWord):
                word = plan.arithmetic.system.constant(driver.text)
                (value,) = port.format.encode(np.atleast_1d(word.values))
                yield f"    wire signed [{width - 1}:0] {name}_word = {literal(int(value), width)};"
                continue
            value = plan.outputs[port.name].value
            assert value is not None
            held = self._format(value)
            if held == port.format:
                yield f"    wire signed [{width - 1}:0] {name}_word = {self._sized(driver, width)};"
                oks.append(self._ok(driver))
                continue
            module = self._conversion(held, port.format)
            yield f"    wire signed [{width - 1}:0] {name}_word;"
            yield f"    wire {name}_held;"
            wired = f".a({self._sized(driver, held.width_bits)}), .first({name}_word), .first_ok({name}_held)"
            yield f"    {module} {name}_rounding ({wired});"
            oks += [self._ok(driver), f"{name}_held"]
        yield f"    assign out_ok = {' && '.join(dict.fromkeys(oks)) or chr(49) + chr(39) + 'b1'};"
        for port in self.outputs:
            width = port.format.width_bits
            invalid = literal(port.format.invalid_word, width)
            yield f"    assign {port.port} = out_ok ? {port.port}_word : {invalid};"

    def _conversion(self, held: FixedPoint, delivered: FixedPoint) -> str:
        """Return the module that rounds words between operations to those of an output."""
        b = CircuitBuilder("rounding")
        result = rounded(b, ExactNumber(b.word("a", held.width_bits), held.fraction_bits), delivered)
        b.output("first", b.as_word(result.word, delivered.width_bits))
        b.output("first_ok", result.valid)
        circuit = b.circuit()
        for name, other in self.modules.items():
            if other.cells == circuit.cells:
                return name
        return self._added("rounding", circuit)
