"""The core of a plan in Verilog: its units with their multiplexers, FIFOs and the way of what is valid.

Words stand for numbers where the bit beside them says so; the invalid code appears at the ports alone.  A
sample enters in slot 0 of the interval, and what is taken in cycle c of it is there in slot c modulo the
interval.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.units import PORTS
from cordicc.backends.labels import constant
from cordicc.backends.rtl.delay_lines import Delay, delay_text, places
from cordicc.backends.rtl.module_text import literal, signed_literal
from cordicc.backends.rtl.names import comment, stem
from cordicc.backends.rtl.reset_style import USUAL_RESET, ResetStyle
from cordicc.backends.rtl.slots import Slots
from cordicc.backends.rtl.unit_modules import UnitModules
from cordicc.backends.rtl.wires import Wires
from cordicc.backends.rtl.word_ports import Ports, PortWord, WordFormats
from cordicc.plan.model import Operand, Operation, Plan
from cordicc.plan.netlist import Cell, ConstantWord, FifoEnd, InputWord, Netlist


@dataclass(frozen=True, slots=True)
class Core:
    """The core of a plan.

    Attributes:
        name: of the module without what follows it, and of the files.
        text: of the module.
        modules: the circuits of its units by module.
        units: the module of each unit.
        instances: the name of each unit in the core.
        uses: of each operation, what its unit takes as `mode`: the number of the use.
        inputs: its ports in the order of the plan.
        outputs: the same of what leaves.
        interval: cycles from sample to sample.
        latency: cycles from a sample's words to its outputs.
        reset: its style.
        valid: the name of the register that tells where samples are.
        slot: that of the ring of slots, or of their counter.
        slot_bits: bits of the registers of the slots.
    """

    name: str
    text: str
    modules: Mapping[str, Circuit]
    units: Mapping[str, str]
    instances: Mapping[str, str]
    uses: Mapping[str, int]
    inputs: tuple[PortWord, ...]
    outputs: tuple[PortWord, ...]
    interval: int
    latency: int
    reset: ResetStyle
    valid: str
    slot: str
    slot_bits: int


def core_of(plan: Plan, header: Sequence[str], reset: ResetStyle = USUAL_RESET) -> Core:
    """Return the core of a plan, with lines above its text.

    Raises:
        NoCircuitError: an operation has no circuit.
    """
    made = _Core(plan, reset)
    lines = [*(f"// {line}".rstrip() for line in header), *made.lines()]
    return Core(
        made.name,
        "\n".join(lines) + "\n",
        made.modules.circuits,
        made.units,
        made.instances(),
        made.uses(),
        made.ports.inputs,
        made.ports.outputs,
        plan.initiation_interval,
        plan.latency_cycles,
        reset,
        *made.control,
        made.slots.registers,
    )


class _Core:
    def __init__(self, plan: Plan, reset: ResetStyle) -> None:
        self._plan = plan
        self._reset = reset
        self._netlist = Netlist.of(plan)
        self._interval = plan.initiation_interval
        self._words = WordFormats(plan)
        self.name = stem(plan.name)
        self.ports = Ports.of(plan)
        self.modules = UnitModules(plan, self.name)
        self._instances = {
            id: self.modules.of_unit(cell, self._interval)
            for id, cell in self._netlist.cells.items()
            if cell.operations
        }
        self.units = {id: module for id, (module, _) in self._instances.items()}
        circuits = {id: self.modules.circuits[module] for id, module in self.units.items()}
        self._wires = Wires(plan, self._netlist, self.ports, circuits)
        self._places = places(plan.fifos)
        self.control = (self._wires.name("", "valid"), self._wires.name("", "slot"))
        self.slots = Slots(self._interval, partial(self._wires.name, ""))

    def lines(self) -> Iterator[str]:
        yield "`default_nettype none"
        yield ""
        yield f"module {self.name}_core ("
        yield from self._header()
        yield ");"
        # Slots that nothing else takes have no register.
        rest = list(self._following())
        yield from self._control()
        yield from rest
        yield "endmodule"
        yield ""
        yield "`default_nettype wire"

    def _following(self) -> Iterator[str]:
        """Yield what stands behind the registers that are reset."""
        yield from self._entering()
        yield ""
        yield "    // What units deliver and FIFOs give up, and whether it stands for a number."
        yield from (f"    {line}" for line in self._wires.declared())
        for id, cell in self._netlist.cells.items():
            if cell.operations:
                yield from self._unit(id, cell)
        yield from self._fifos()
        yield from self._leaving()

    def instances(self) -> dict[str, str]:
        return {id: self._wires.name("unit", id) for id in self.units}

    def uses(self) -> dict[str, int]:
        operations = self._plan.operations
        return {each.id: self._instances[each.unit][1][each.start % self._interval] for each in operations}

    def _header(self) -> Iterator[str]:
        """Yield the ports, in columns."""
        rows = [
            ("input  wire", "clk", ""),
            ("input  wire", self._reset.port, self._reset.about),
            ("input  wire", "ce", "clock enable of everything but the reset"),
            ("input  wire", "in_valid", "a sample is there"),
        ]
        if self._interval > 1:
            rows.append(("output wire", "in_ready", "it is taken: slot 0 of the interval"))
        rows += [("input  wire", *_port(port)) for port in self.ports.inputs]
        rows += [
            ("output wire", "out_valid", f"a sample leaves, {self._netlist.latency} cycles after it entered"),
            ("output wire", "out_ok", "it has outputs; else each of them is the invalid code"),
        ]
        rows += [("output wire", *_port(port)) for port in self.ports.outputs]
        longest = max(len(f"{kind} {name}") for kind, name, _ in rows) + 1
        for number, (kind, name, about) in enumerate(rows):
            text = f"{kind} {name}{',' if number < len(rows) - 1 else ''}"
            yield f"    {text:<{longest}}  // {comment(about)}".rstrip().removesuffix("  //").rstrip()

    def _control(self) -> Iterator[str]:
        """Yield the registers that are reset: valid bits, the ring of slots, and where RAM is written."""
        depth = self._netlist.valid_depth
        name = self._wires.name
        valid = self.control[0]
        leaves, entered = self.slots.bit(self._netlist.latency), self.slots.bit(0)
        resets, steps, each_sample = self.slots.resets(), self.slots.steps(), []
        yield ""
        yield from self.slots.declared()
        if depth:
            yield "    // Whether a sample is in a place of the pipeline."
            yield f"    reg [{depth - 1}:0] {valid};"
            yield f"    assign out_valid = {valid}[{depth - 1}]{f' && {leaves}' if leaves else ''};"
            yield ""
            resets.append(f"{valid} <= {literal(0, depth)};")
            shifted = "in_valid" if depth == 1 else f"{{{valid}[{depth - 2}:0], in_valid}}"
            each_sample.append(f"{valid} <= {shifted};")
        else:
            yield f"    assign out_valid = in_valid{f' && {entered}' if entered else ''};"
        for place in self._places.values():
            register, following = name("", place.register), name("", place.following)
            yield f"    // Where FIFOs of {place.depth} words write; next to it is the oldest word."
            yield f"    reg [{place.width - 1}:0] {register};"
            first, last, one = (f"{place.width}'d{value}" for value in (0, place.depth - 1, 1))
            step = f"({register} == {last}) ? {first} : {register} + {one}"
            yield f"    wire [{place.width - 1}:0] {following} = {step};"
            yield ""
            resets.append(f"{register} <= {first};")
            each_sample.append(f"{register} <= {following};")
        if not resets:
            yield ""
            yield "    // There is no register."
            yield f"    wire {name('', 'unused_bits')} = &{{1'b0, clk, {self._reset.port}, ce}};"
        if resets:
            yield from _reset_block(self._reset, resets, steps, each_sample, entered)

    def _gate(self, cycle: int) -> str:
        """Return when what is there in a cycle of a sample is taken into a register."""
        return " && ".join(filter(None, ("ce", self.slots.bit(cycle))))

    def _entering(self) -> Iterator[str]:
        yield ""
        yield "    // Words out of the range of their input stand for no number, as the invalid code does."
        for port in self.ports.inputs:
            least, most = (signed_literal(word, port.width) for word in (port.least, port.most))
            if port.most < port.format.largest_word or port.least > -port.format.largest_word:
                inside = f"({port.port} >= {least}) && ({port.port} <= {most})"
            else:
                inside = f"{port.port} != {signed_literal(-port.invalid, port.width)}"
            yield f"    wire {self._wires.ok(InputWord(port.name))} = {inside};"

    def _fifos(self) -> Iterator[str]:
        for fifo in self._plan.fifos:
            if not fifo.depth:
                continue
            connection = self._netlist.fifos[fifo.id]
            end = FifoEnd(fifo.id)
            width = self._wires.width(end)
            delay = Delay(
                self._wires.name("fifo", fifo.id),
                fifo.depth,
                width,
                self._wires.sized(connection.driver, width),
                self._wires.ok(connection.driver),
                self._wires.word(end),
                self._wires.ok(end),
                self._gate(connection.cycle),
            )
            words = "word" if fifo.depth == 1 else "words"
            yield ""
            yield f"    // FIFO {fifo.id}: {comment(fifo.value)}, {fifo.depth} {words}."
            place = self._places.get(fifo.depth)
            if place is None:
                yield from delay_text(delay)
            else:
                memory = self._wires.name("fifo", f"{fifo.id}_ram")
                write, read = (self._wires.name("", each) for each in (place.register, place.following))
                yield from delay_text(delay, (memory, write, read))

    def _about(self, operation: Operation) -> str:
        """Say what an operation is, and when."""
        taken = ", ".join(_shown(operand) for operand in operation.operands)
        slot = f", slot {operation.start % self._interval}" if self._interval > 1 else ""
        purpose = f", for {operation.equation}" if operation.equation else ""
        text = f"{operation.id}: {operation.mode or operation.op} of {taken}{purpose}"
        return f"{text}; cycles {operation.start} to {operation.finish}{slot}"

    def _unit(self, id: str, cell: Cell) -> Iterator[str]:
        module, modes = self._instances[id]
        circuit = self.modules.circuits[module]
        widths = {port.name: circuit.cells[port.cell].width for port in circuit.inputs}
        yield ""
        for operation in cell.operations:
            yield f"    // {comment(self._about(operation))}."
        wired = [("clk", "clk"), ("ce", "ce")] if circuit.registers() else []
        if circuit.strobes:
            slots = [self.slots.bit(operation.start) for operation in cell.operations]
            wired.append(("start", " | ".join(dict.fromkeys(slots))))
        for port, taken in zip(PORTS, cell.ports, strict=False):
            if port not in widths:
                continue
            width, name = widths[port], self._wires.name("unit", f"{id}_{port}")
            texts = [self._wires.sized(source, width) for source in taken.sources]
            yield f"    wire signed [{width - 1}:0] {name} ={self._chosen(taken.select, texts, width)};"
            wired.append((port, name))
        oks = {}
        for operation in cell.operations:
            drivers = [each.driver for each in self._netlist.operands[operation.id]]
            oks[operation.start % self._interval] = self._wires.all_ok(drivers)
        distinct = list(dict.fromkeys(oks.values()))
        select = {slot: distinct.index(text) for slot, text in oks.items()}
        ok = self._wires.name("unit", f"{id}_ok")
        yield f"    wire {ok} ={self._chosen(select, distinct, 1)};"
        wired.append(("ok", ok))
        if "mode" in widths:
            width, name = widths["mode"], self._wires.name("unit", f"{id}_mode")
            numbers = sorted(set(modes.values()))
            select = {slot: numbers.index(number) for slot, number in modes.items()}
            chosen = self._chosen(select, [literal(number, width) for number in numbers], width)
            yield f"    wire {f'[{width - 1}:0] ' if width > 1 else ''}{name} ={chosen};"
            wired.append(("mode", name))
        for result in circuit.outputs:
            wired.append((result.name, self._wires.name("unit", f"{id}_{result.name}")))
        yield f"    {module} {self._wires.name('unit', id)} ("
        yield ",\n".join(f"        .{port}({name})" for port, name in wired)
        yield "    );"

    def _chosen(self, select: Mapping[int, int], texts: Sequence[str], width: int) -> str:
        """Return the text of what a slot selects, a space or the end of a line before it."""
        if len(texts) == 1:
            return f" {texts[0]}"
        terms = []
        for number, text in enumerate(texts):
            if text == literal(0, width):
                continue
            slots = [self.slots.bit(slot) for slot, chosen in sorted(select.items()) if chosen == number]
            gate = slots[0] if len(slots) == 1 else f"({' | '.join(slots)})"
            if text == "1'd1":
                terms.append(gate)
            elif width > 1:
                terms.append(f"({{{width}{{{gate}}}}} & {text})")
            else:
                terms.append(f"({gate} & {f'({text})' if ' ' in text else text})")
        return "".join(f"\n        {'|' if at else ' '} {term}" for at, term in enumerate(terms))

    def _never_taken(self) -> Generator[str, None, list[str]]:
        """Return the bit, if there is any, that tells whether inputs which nothing takes are in range."""
        taken = {each.driver for each in self._netlist.connections()}
        bits = [self._wires.ok(each) for p in self.ports.inputs if (each := InputWord(p.name)) not in taken]
        depth = self._netlist.valid_depth
        if not bits:
            return []
        inside = " && ".join(bits)
        if not depth:
            return [inside]
        name = self._wires.name("", "unused_ok")
        yield "    // Whether the inputs that nothing takes are in range, which counts too."
        yield f"    reg [{depth - 1}:0] {name};"
        shifted = inside if depth == 1 else f"{{{name}[{depth - 2}:0], {inside}}}"
        yield f"    always @(posedge clk) if ({self._gate(0)}) {name} <= {shifted};"
        return [f"{name}[{depth - 1}]"]

    def _leaving(self) -> Iterator[str]:
        yield ""
        yield "    // What leaves: rounded to the words of the outputs, and valid if all of them are."
        plan, words = self._plan, {}
        oks = yield from self._never_taken()
        for port in self.ports.outputs:
            driver = self._netlist.outputs[port.name].driver
            word = words[port.port] = self._wires.name("output", f"{port.port}_word")
            for equation in plan.problem.equations:
                if equation.target == port.name:
                    yield f"    // {comment(equation.text)}"
            if isinstance(driver, ConstantWord):
                number = plan.arithmetic.system.constant(driver.text)
                (value,) = port.format.encode(np.atleast_1d(number.values))
                yield f"    wire signed [{port.width - 1}:0] {word} = {literal(int(value), port.width)};"
                continue
            value_name = plan.outputs[port.name].value
            assert value_name is not None
            held = self._words.held(value_name)
            oks.append(self._wires.ok(driver))
            if held == port.format:
                sized = self._wires.sized(driver, port.width)
                yield f"    wire signed [{port.width - 1}:0] {word} = {sized};"
                continue
            module = self.modules.of_rounding(held, port.format)
            fits = self._wires.name("output", f"{port.port}_fits")
            rounding = self._wires.name("output", f"{port.port}_rounding")
            yield f"    wire signed [{port.width - 1}:0] {word};"
            yield f"    wire {fits};"
            yield f"    {module} {rounding} ("
            yield f"        .a({self._wires.sized(driver, held.width_bits)}),"
            yield f"        .first({word}),"
            yield f"        .first_ok({fits})"
            yield "    );"
            oks.append(fits)
        yield f"    assign out_ok = {' && '.join(dict.fromkeys(oks)) or literal(1, 1)};"
        for port in self.ports.outputs:
            invalid = literal(port.invalid, port.width)
            yield f"    assign {port.port} = out_ok ? {words[port.port]} : {invalid};"


def _port(port: PortWord) -> tuple[str, str]:
    """Return the declaration of a port of words, and what they stand for."""
    return f"signed [{port.width - 1}:0] {port.port}", port.meaning


def _reset_block(
    reset: ResetStyle, resets: Sequence[str], steps: Sequence[str], each_sample: Sequence[str], slot: str
) -> Iterator[str]:
    yield "    // All that is reset: words are not, as they count where a valid bit says so."
    yield f"    always @({reset.edges})"
    yield f"        if ({reset.active}) begin"
    yield from (f"            {line}" for line in resets)
    yield "        end else if (ce) begin"
    yield from (f"            {line}" for line in steps)
    if slot and each_sample:
        yield f"            if ({slot}) begin"
        yield from (f"                {line}" for line in each_sample)
        yield "            end"
    else:
        yield from (f"            {line}" for line in each_sample)
    yield "        end"


def _shown(operand: Operand) -> str:
    """Return an operand for a comment."""
    if operand.value is not None:
        return operand.value
    return constant(str(operand.constant)).replace("−", "-")
