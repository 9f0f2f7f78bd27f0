"""Circuits in NumPy: what their cells make of arrays of integers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cordicc.arith.circuits.circuit import INDEX, Circuit, Gate, Loop
from cordicc.base.arrays import Integers

_FITS = 62
"""Bits that integers of an int64 array may have; wider ones are Python's, in object arrays."""


def outputs_of(circuit: Circuit, inputs: Mapping[str, Integers]) -> dict[str, Integers]:
    """Return the outputs of a circuit by name, for arrays of shape (n,) by the names of the inputs.

    Raises OverflowError where a result is not within the range that its cell states.
    """
    made = values_of(circuit, inputs)
    count = len(next(iter(inputs.values()), np.zeros(1)))
    return {port.name: np.broadcast_to(made[port.cell], (count,)) for port in circuit.outputs}


def values_of(circuit: Circuit, inputs: Mapping[str, Integers], *, wrapped: bool = False) -> list[Integers]:
    """Return the results of all cells.

    With `wrapped`, one that is not within the range of its cell loses its upper bits, as in hardware: words
    that stand for no number may make such results.
    """
    places = {port.cell: port.name for port in circuit.inputs}
    turned: dict[int, list[Integers]] = {}
    made: list[Integers] = []
    for number, cell in enumerate(circuit.cells):
        if cell.kind == "input":
            value = np.asarray(inputs[places[number]])
            value = value if value.dtype == object else value.astype(np.int64)
        elif cell.kind == "loop":
            number_of_loop, state = cell.params
            if number_of_loop not in turned:
                operands = [made[each] for each in cell.operands]
                turned[number_of_loop] = _looped(circuit.loops[number_of_loop], operands, wrapped)
            value = turned[number_of_loop][state]
        else:
            operands = [made[each] for each in cell.operands]
            value = _CELLS[cell.kind](cell, *_prepared(cell, circuit, operands))
        if wrapped and cell.kind != "constant":
            value = _cut(cell, value)
        elif cell.kind != "cut" and np.any((value < cell.lo) | (value > cell.hi)):
            raise OverflowError(f"{circuit.name}.{cell.name} is not within {cell.lo} to {cell.hi}")
        wide = max(abs(cell.lo), abs(cell.hi)).bit_length() > _FITS
        made.append(value if wide or value.dtype != object else value.astype(np.int64))
    return made


def _looped(loop: Loop, operands: list[Integers], wrapped: bool) -> list[Integers]:
    """Return the states of a loop after its last step."""
    now = dict(zip((*loop.states, *loop.kept), operands, strict=True))
    for step in range(loop.steps):
        made = values_of(loop.body, {**now, INDEX: np.array(step)}, wrapped=wrapped)
        now |= {port.name: made[port.cell] for port in loop.body.outputs}
    return [now[name] for name in loop.states]


def _prepared(cell: Gate, circuit: Circuit, operands: list[Integers]) -> list[Integers]:
    """Return operands as Python's integers if the result may not fit, even on the way to it."""
    bits = cell.width + 2
    if cell.kind in ("round", "addsub"):
        bits += 1
    if bits <= _FITS and all(each.dtype != object for each in operands):
        return operands
    return [each.astype(object) for each in operands]


def _pick(cell: Gate, index: Integers) -> Integers:
    wide = max(map(abs, cell.params)).bit_length() > _FITS
    table = np.array(cell.params, dtype=object if wide else np.int64)
    return np.asarray(table[np.minimum(index.astype(np.int64), len(table) - 1)])


def _cut(cell: Gate, a: Integers) -> Integers:
    low = a & ((1 << cell.width) - 1)
    return np.asarray(np.where(low >> (cell.width - 1), low - (1 << cell.width), low) if cell.signed else low)


def _bit(value: Integers) -> Integers:
    return np.asarray(value).astype(np.int64)


_CELLS: dict[str, Callable[..., Integers]] = {
    "constant": lambda cell: np.array(cell.params[0]),
    "register": lambda cell, a: a,
    "hold": lambda cell, a: a,
    "add": lambda cell, a, b: a + b,
    "addc": lambda cell, a, b, c: a + b + c,
    "subc": lambda cell, a, b, c: a - b - c,
    "sub": lambda cell, a, b: a - b,
    "addsub": lambda cell, a, b, c, d: a + b * (1 - 2 * c) - c + d,
    "negif": lambda cell, a, c: a * (1 - 2 * c),
    "mul": lambda cell, a, b: a * b,
    "shl": lambda cell, a: a << cell.params[0],
    "shr": lambda cell, a: a >> min(cell.params[0], 63 if a.dtype != object else cell.params[0]),
    "round": lambda cell, a: ((a >> (cell.params[0] - 1)) + 1) >> 1,
    "low": lambda cell, a: a & ((1 << cell.params[0]) - 1),
    "eq": lambda cell, a, b: _bit(a == b),
    "and": lambda cell, a, b: a & b,
    "or": lambda cell, a, b: a | b,
    "xor": lambda cell, a, b: a ^ b,
    "not": lambda cell, a: 1 - a,
    "mux": lambda cell, c, a, b: np.asarray(np.where(c != 0, b, a)),
    "pick": _pick,
    "join": lambda cell, *bits: sum(
        np.asarray(bit) << (len(bits) - 1 - n + cell.params[0]) for n, bit in enumerate(bits)
    ),
    "narrow": lambda cell, a: a,
    "cut": _cut,
}
