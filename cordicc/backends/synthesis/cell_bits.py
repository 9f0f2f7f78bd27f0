"""What a circuit is made of, counted by kinds of logic: what its area on a chip is proportional to."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

from cordicc.arith.circuits.circuit import Circuit, Gate
from cordicc.backends.synthesis.live_bits import SUMS, register_bits
from cordicc.targets.device import Device

_LOGIC = ("and", "or", "xor", "not")
_WITH_SHIFT_REGISTERS = ("xc7",)
"""Families whose look-up tables can be shift registers."""

_SHIFT_REGISTER = 3
"""Registers in a row, at the least, of which tools make a shift register where the chip has some."""

LUT_KINDS = ("add", "turn", "round", "equal", "mux", "pick", "logic", "tile", "array", "delay")
"""Kinds that look-up tables are for.

Bits of sums; of operands whose sign is chosen; of roundings; of comparisons; of choices; of tables, as LUTs;
of logic; 36 bits for each multiplier block whose product is added to that of another; bits of the partial
products of a multiplication without such blocks; bits of shift registers, as LUTs.
"""

FF_KINDS = ("register", "row", "delay")
"""Kinds that flip-flops are for: bits of registers; where a chip has shift registers, of those in a row of
three and more; as above."""


DSP_KINDS = ("block", "constant")
"""Multiplier blocks of products of two values, and of products with a constant, which may do with fewer."""


def cell_bits(circuit: Circuit, device: Device) -> dict[str, int]:
    """Return how much there is of each of `LUT_KINDS` and `FF_KINDS`, and of `DSP_KINDS`."""
    count: Counter[str] = Counter()
    for cell in circuit.cells:
        operands = [circuit.cells[each] for each in cell.operands]
        for kind, much in _of_cell(cell, operands, device):
            count[kind] += much
    for bits, length in _rows(circuit):
        count.update(fifo_bits(bits, length, device))
    for loop in circuit.loops:
        count.update(cell_bits(loop.body, device))
        # Each state is a register, and begins as something else.
        states = sum(loop.body.cells[port.cell].width for port in loop.body.inputs)
        count.update({"register": states, "mux": states})
    if circuit.strobes:
        count["register"] += circuit.strobes[-1]
    return dict(count)


def fifo_bits(bits: int, depth: int, device: Device) -> dict[str, int]:
    """Return the same of registers in a row."""
    if depth < _SHIFT_REGISTER or device.family not in _WITH_SHIFT_REGISTERS:
        return {"register": bits * depth}
    return {"row": bits * depth, "delay": bits * math.ceil(depth / 32)}


def choice_luts(bits: int, sources: int, device: Device) -> int:
    """Return the LUTs in front of a port with several sources, each gated by a bit of its slots."""
    return 0 if sources < 2 else bits * math.ceil((2 * sources - 1) / (device.lut_inputs - 1))


def _of_cell(cell: Gate, operands: list[Gate], device: Device) -> Iterator[tuple[str, int]]:
    kind = cell.kind
    if kind == "hold":
        yield "register", cell.width
    elif kind == "round":
        yield "round", cell.width
    elif kind in SUMS:
        yield "add", cell.width
        if kind in ("addsub", "negif"):
            turned = operands[kind == "addsub"]
            yield "turn", 0 if turned.kind == "constant" else turned.width
    elif kind == "eq":
        yield "equal", max(each.width for each in operands)
    elif kind == "mux":
        yield "mux", cell.width
    elif kind == "pick":
        yield "pick", cell.width << max(0, operands[0].width - device.lut_inputs)
    elif kind in _LOGIC:
        yield "logic", cell.width
    elif kind == "mul":
        yield from _product(operands, device)


def _product(operands: list[Gate], device: Device) -> Iterator[tuple[str, int]]:
    wide, narrow = sorted((each.width - each.signed for each in operands), reverse=True)
    constant = next((each.params[0] for each in operands if each.kind == "constant"), None)
    if device.dsp_bits is not None:
        a, b = device.dsp_bits
        blocks = math.ceil(wide / (a - 1)) * math.ceil(narrow / (b - 1))
        yield "block" if constant is None else "constant", blocks
        yield "tile", 36 * (blocks - 1)
        return
    rows = narrow if constant is None else _digits(constant)
    yield "array", wide * rows


def _digits(value: int) -> int:
    """Return the digits other than 0 of an integer written with -1, 0 and 1 and the fewest of them."""
    return (value ^ 3 * value).bit_count() if value >= 0 else _digits(-value)


def _rows(circuit: Circuit) -> Iterator[tuple[int, int]]:
    """Yield bits and length of the rows of registers of which nobody reads those between."""
    readers = Counter(each for cell in circuit.cells for each in cell.operands)
    readers.update(port.cell for port in circuit.outputs)
    registers = [number for number, cell in enumerate(circuit.cells) if cell.kind == "register"]
    bits = register_bits(circuit)
    follows = {circuit.cells[number].operands[0]: number for number in registers}
    for number in registers:
        before = circuit.cells[number].operands[0]
        if circuit.cells[before].kind == "register" and readers[before] == 1:
            continue
        length, last = 1, number
        while last in follows and readers[last] == 1:
            length, last = length + 1, follows[last]
        yield bits[last], length
