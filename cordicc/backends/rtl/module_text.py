"""A circuit as the text of a Verilog-2005 module.

Every operand is brought to the width of its expression in the text, so that no tool has to widen or cut one;
those of products are not, so that no tool takes multipliers for their signs.
Nothing is reset: registers hold data alone, and what is valid travels beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby

from cordicc.arith.circuits.circuit import INDEX, Circuit, Gate

_CLOCKED = ("register", "hold")

_LINE = 110
"""Characters of a line of the list of unused bits."""


def module_text(circuit: Circuit, comments: Sequence[str] = ()) -> str:
    """Return the module of a circuit, with comments above it."""
    return "\n".join(_Module(circuit).lines(comments)) + "\n"


def signal_names(circuit: Circuit, prefix: str = "") -> list[str]:
    """Return what the signal of each cell is called in the module; that of a constant has no name.

    A prefix is that of the names in the body of a loop.
    """
    inputs = {port.cell: port.name for port in circuit.inputs}
    outputs = {port.name for port in circuit.outputs}

    def name(number: int, cell: Gate) -> str:
        own = cell.name.rstrip("_")
        return prefix + (inputs.get(number) or (f"{own}_w" if own in outputs else own))

    return [name(*each) if each[1].kind != "constant" else "" for each in enumerate(circuit.cells)]


class _Module:
    def __init__(self, circuit: Circuit, prefix: str = "") -> None:
        self._circuit = circuit
        self._prefix = prefix
        self._cells = circuit.cells
        self._read: dict[int, set[int]] = {number: set() for number in range(len(circuit.cells))}
        self._taken = signal_names(circuit, prefix)

    def lines(self, comments: Sequence[str]) -> Iterator[str]:
        circuit = self._circuit
        yield from (f"// {line}".rstrip() for line in comments)
        yield "`default_nettype none"
        yield ""
        yield f"module {circuit.name} ("
        clocked = circuit.loops or any(cell.kind in _CLOCKED for cell in self._cells)
        ports = ["input  wire clk", "input  wire ce"] if clocked else []
        ports += ["input  wire start"] if circuit.strobes else []
        ports += [f"input  wire {self._declared(port.cell, port.name)}" for port in circuit.inputs]
        ports += [f"output wire {self._declared(port.cell, port.name)}" for port in circuit.outputs]
        yield from (f"    {port}," for port in ports[:-1])
        yield f"    {ports[-1]}"
        yield ");"
        order = sorted(range(len(self._cells)), key=lambda number: (self._cells[number].cycle or 0, number))
        body = [n for n in order if self._cells[n].kind not in ("input", "constant")]
        yield from self._strobes()
        waiting = sorted(range(len(circuit.loops)), key=circuit.begin)
        for cycle, numbers in groupby(body, key=lambda number: self._cells[number].cycle or 0):
            while waiting and circuit.begin(waiting[0]) < cycle:
                yield from self._loop(waiting.pop(0))
            yield from self._cycle(cycle, list(numbers))
        yield ""
        for port in circuit.outputs:
            text = self._whole(port.cell, self._cells[port.cell].width)
            yield f"    assign {port.name} = {text};"
        yield from self.unused()
        yield "endmodule"
        yield ""
        yield "`default_nettype wire"

    def _strobes(self) -> Iterator[str]:
        """Yield where operations are, as far as something is loaded by that."""
        if not self._circuit.strobes:
            return
        last = self._circuit.strobes[-1]
        yield ""
        yield "    // Bit k: an operation entered k cycles ago."
        if not last:
            yield "    wire here = start;"
            return
        yield f"    reg [{last}:1] here_q;"
        yield f"    wire [{last}:0] here = {{here_q, start}};"
        yield f"    always @(posedge clk) if (ce) here_q <= here[{last - 1}:0];"

    def _strobe(self, cycle: int) -> str:
        return f"here[{cycle}]" if self._circuit.strobes[-1] else "here"

    def _loop(self, number: int) -> Iterator[str]:
        """Yield the registers of a loop, its body, and what the registers take."""
        loop, begin = self._circuit.loops[number], self._circuit.begin(number)
        prefix = f"loop{number + 1}_"
        inner = _Module(loop.body, prefix)
        ports = {port.name: port.cell for port in loop.body.inputs}
        first = next(cell for cell in self._cells if cell.kind == "loop" and cell.params[0] == number)
        entering = dict(zip((*loop.states, *loop.kept), first.operands, strict=True))
        yield ""
        yield f"    // Cycles {begin} to {begin + loop.steps - 1}, a step each."
        yield f"    wire {prefix}first = {self._strobe(begin)};"
        for name, cell in ports.items():
            width = loop.body.cells[cell].width
            value = literal(0, width) if name == INDEX else self._whole(entering[name], width)
            yield f"    reg {inner._declared(cell, f'{prefix}{name}_q')};"
            text = f"{prefix}first ? {value} : {prefix}{name}_q"
            yield f"    wire {inner._declared(cell, prefix + name)} = {text};"
        yield from inner.body()
        yield "    always @(posedge clk) if (ce) begin"
        following = {port.name: port.cell for port in loop.body.outputs}
        for name, cell in ports.items():
            width = loop.body.cells[cell].width
            if name == INDEX:
                text = f"{prefix}{name} + {literal(1, width)}"
            elif name in following:
                text = inner.whole(following[name], width)
            else:
                text = prefix + name
            yield f"        {prefix}{name}_q <= {text};"
        yield "    end"
        yield from inner.unused()

    def body(self) -> Iterator[str]:
        """Yield the cells of a circuit without registers, ports and constants apart."""
        for number, cell in enumerate(self._cells):
            if cell.kind not in ("input", "constant"):
                yield from self._made(number)

    def _cycle(self, cycle: int, numbers: list[int]) -> Iterator[str]:
        registers = [n for n in numbers if self._cells[n].kind in _CLOCKED]
        always = [n for n in registers if self._cells[n].kind == "register"]
        holds = [n for n in registers if self._cells[n].kind == "hold"]
        yield ""
        yield f"    // Cycle {cycle}."
        for number in registers:
            yield f"    reg {self._declared(number, self._taken[number])};"
        for gate, loaded in (("ce", always), (f"ce && {self._strobe(cycle - 1)}" if holds else "", holds)):
            if not loaded:
                continue
            yield f"    always @(posedge clk) if ({gate}) begin"
            for number in loaded:
                source = self._cells[number].operands[0]
                yield f"        {self._taken[number]} <= {self._whole(source, self._cells[number].width)};"
            yield "    end"
        for number in numbers:
            if number in registers:
                continue
            if number in self._circuit.notes:
                yield f"    // {self._circuit.notes[number]}"
            yield from self._made(number)

    def _made(self, number: int) -> Iterator[str]:
        cell, name = self._cells[number], self._taken[number]
        if cell.kind == "pick" and self._cells[cell.operands[0]].kind == "constant":
            # Simulators would wait for a change of the index for ever.
            index = self._cells[cell.operands[0]].params[0]
            yield f"    wire {self._declared(number, name)} = {literal(cell.params[index], cell.width)};"
        elif cell.kind == "loop":
            loop, state = cell.params
            name_of_state = f"loop{loop + 1}_{self._circuit.loops[loop].states[state]}_q"
            yield f"    wire {self._declared(number, name)} = {name_of_state};"
        elif cell.kind == "pick":
            yield f"    reg {self._declared(number, name)};"
            yield f"    always @* case ({self._whole(cell.operands[0])})"
            width = self._cells[cell.operands[0]].width
            *first, last = cell.params
            while first and first[-1] == last:
                first.pop()
            for at, value in enumerate(first):
                yield f"        {literal(at, width)}: {name} = {literal(value, cell.width)};"
            yield f"        default: {name} = {literal(cell.params[-1], cell.width)};"
            yield "    endcase"
        elif cell.kind == "subc":
            # The half is a place below the last: one chain of carries, and no operand is inverted.
            one, other = (self._whole(each, cell.width) for each in cell.operands[:2])
            half = self._whole(cell.operands[2], 1)
            yield f"    wire [{cell.width}:0] {name}_halves = {{{one}, 1'b0}} - {{{other}, {half}}};"
            yield f"    wire {self._declared(number, name)} = {name}_halves[{cell.width}:1];"
        else:
            yield f"    wire {self._declared(number, name)} = {_TEXTS[cell.kind](self, cell)};"

    def unused(self) -> Iterator[str]:
        """Yield a wire that takes what nothing else does."""
        bits = []
        for number, cell in enumerate(self._cells):
            left = sorted(set(range(cell.width)) - self._read[number])
            if cell.kind == "constant":
                continue
            for _, run in groupby(enumerate(left), key=lambda each: each[1] - each[0]):
                places = [place for _, place in run]
                bits.append(self._slice(number, places[0], places[-1]))
            if cell.kind == "subc":
                bits.append(f"{self._taken[number]}_halves[0]")
        if bits:
            yield ""
            yield "    // Bits below the last place of a result, and above what its range needs."
            line = f"    wire {self._prefix}unused_bits = &{{1'b0"
            for text in bits:
                if len(line) + len(text) > _LINE:
                    yield line + ","
                    line = f"        {text}"
                else:
                    line += f", {text}"
            yield line + "};"

    def _declared(self, number: int, name: str) -> str:
        """Return a name with the width of a cell's signal."""
        cell = self._cells[number]
        signed = "signed " if cell.signed else ""
        return f"{signed}[{cell.width - 1}:0] {name}" if cell.width > 1 or cell.signed else name

    def _slice(self, number: int, low: int, high: int) -> str:
        """Return bits that a signal has."""
        cell, name = self._cells[number], self._taken[number]
        if cell.width == 1 and not cell.signed:
            return name
        if (low, high) == (0, cell.width - 1):
            return name
        return f"{name}[{high}]" if low == high else f"{name}[{high}:{low}]"

    def factor(self, number: int, product: Gate) -> str:
        """Return an operand of a product: no wider than its own, but signed as the product is."""
        cell = self._cells[number]
        if not product.signed:
            return self._whole(number, product.width if cell.signed else min(cell.width, product.width))
        text = self._whole(number, min(cell.width + (not cell.signed), product.width))
        return text if cell.signed and text == self._taken[number] else f"$signed({text})"

    def whole(self, number: int, width: int) -> str:
        return self._whole(number, width)

    def _whole(self, number: int, width: int | None = None) -> str:
        """Return a signal in a width, 0 or its sign before it."""
        cell = self._cells[number]
        return self.part(number, 0, (cell.width if width is None else width) - 1)

    def part(self, number: int, low: int, high: int) -> str:
        """Return bits of a signal, which has any number of them: above its width are 0 or its sign."""
        cell = self._cells[number]
        count = high - low + 1
        if cell.kind == "constant":
            return literal(cell.params[0] >> low, count)
        inside = min(high, cell.width - 1)
        texts = []
        if inside >= low:
            texts = [self._slice(number, low, inside)]
            self._read[number].update(range(low, inside + 1))
        more = high - max(inside, low - 1)
        if more:
            if cell.signed:
                self._read[number].add(cell.width - 1)
                sign = self._slice(number, cell.width - 1, cell.width - 1)
                texts.insert(0, sign if more == 1 else f"{{{more}{{{sign}}}}}")
            else:
                texts.insert(0, f"{more}'d0")
        return texts[0] if len(texts) == 1 else "{" + ", ".join(texts) + "}"

    def pair(self, cell: Gate) -> tuple[str, str, bool]:
        """Return two operands in a common width, and whether they are signed."""
        a, b = (self._cells[each] for each in cell.operands)
        signed = a.signed or b.signed
        width = max(each.width + (signed and not each.signed) for each in (a, b))
        first, second = (self._whole(each, width) for each in cell.operands)
        return (f"$signed({first})", f"$signed({second})", True) if signed else (first, second, False)

    def cell(self, number: int) -> Gate:
        return self._cells[number]


def literal(value: int, width: int) -> str:
    """Return an integer in a width, in two's complement."""
    value %= 1 << width
    return f"{width}'h{value:x}" if value > 9 else f"{width}'d{value}"


def signed_literal(value: int, width: int) -> str:
    """Return an integer in a width, in two's complement, as a signed number."""
    return literal(value, width).replace("'", "'s")


def _sum(sign: str) -> Callable[[_Module, Gate], str]:
    def text(module: _Module, cell: Gate) -> str:
        return f" {sign} ".join(module.whole(each, cell.width) for each in cell.operands)

    return text


def _addsub(module: _Module, cell: Gate) -> str:
    a, b, minus, carry = cell.operands
    width = cell.width
    last = module.whole(carry, 1)
    second = f"({module.whole(b, width)} ^ {{{width}{{{module.whole(minus, 1)}}}}})"
    if width > 1:
        last = f"{{{width - 1}'d0, {last}}}"
    return f"{module.whole(a, width)} + {second} + {last}"


def _negif(module: _Module, cell: Gate) -> str:
    a, c = cell.operands
    mask = f"{{{cell.width}{{{module.whole(c, 1)}}}}}"
    return f"({module.whole(a, cell.width)} ^ {mask}) + {module.whole(c, cell.width)}"


def _product(module: _Module, cell: Gate) -> str:
    """Return a product of operands in widths of their own, which tell tools what multipliers to take."""
    return " * ".join(module.factor(each, cell) for each in cell.operands)


def _left(module: _Module, cell: Gate) -> str:
    (count,) = cell.params
    return f"{{{module.whole(cell.operands[0], cell.width - count)}, {count}'d0}}"


def _right(module: _Module, cell: Gate) -> str:
    (count,) = cell.params
    return module.part(cell.operands[0], count, count + cell.width - 1)


def _rounded(module: _Module, cell: Gate) -> str:
    (count,) = cell.params
    (a,) = cell.operands
    half = module.part(a, count - 1, count - 1)
    carry = half if cell.width == 1 else f"{{{cell.width - 1}'d0, {half}}}"
    return f"{module.part(a, count, count + cell.width - 1)} + {carry}"


def _equal(module: _Module, cell: Gate) -> str:
    first, second, _ = module.pair(cell)
    return f"{first} == {second}"


def _mux(module: _Module, cell: Gate) -> str:
    choice, a, b = cell.operands
    return f"{module.whole(choice, 1)} ? {module.whole(b, cell.width)} : {module.whole(a, cell.width)}"


def _joined(module: _Module, cell: Gate) -> str:
    (place,) = cell.params
    texts = [module.whole(each, 1) for each in cell.operands]
    return f"{{{', '.join(texts + [f'{place}{chr(39)}d0'] * bool(place))}}}"


_TEXTS: dict[str, Callable[[_Module, Gate], str]] = {
    "add": _sum("+"),
    "addc": _sum("+"),
    "sub": _sum("-"),
    "addsub": _addsub,
    "negif": _negif,
    "mul": _product,
    "shl": _left,
    "shr": _right,
    "round": _rounded,
    "low": lambda module, cell: module.part(cell.operands[0], 0, cell.width - 1),
    "eq": _equal,
    "and": _sum("&"),
    "or": _sum("|"),
    "xor": _sum("^"),
    "not": lambda module, cell: f"~{module.whole(cell.operands[0], 1)}",
    "mux": _mux,
    "join": _joined,
    "narrow": lambda module, cell: module.part(cell.operands[0], 0, cell.width - 1),
    "cut": lambda module, cell: module.part(cell.operands[0], 0, cell.width - 1),
}
