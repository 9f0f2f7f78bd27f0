"""Which bits of a circuit's signals need flip-flops: those that somebody reads, once if they are alike."""

from __future__ import annotations

from collections.abc import Iterator

from cordicc.arith.circuits.circuit import Circuit, Gate

SUMS = frozenset(("add", "sub", "addc", "subc", "addsub", "negif"))
"""Kinds of cells that are a chain of carries, from the lowest bit on."""

_SAME = frozenset(("register", "narrow", "cut", "and", "or", "xor", "not"))


def register_bits(circuit: Circuit) -> dict[int, int]:
    """Return the flip-flops that registers need, by the numbers of their cells.

    A bit that no result depends on needs none, nor does one that is constant, as those below a number that
    was shifted are; bits that are always equal, as those of a choice among few constants may be, share one.
    """
    read = _read_bits(circuit)
    zeros = _trailing_zeros(circuit)
    values: dict[int, tuple[int, ...]] = {}
    found = {}
    for number, cell in enumerate(circuit.cells):
        known = _constants(circuit, cell, values)
        if known:
            values[number] = known
        if cell.kind == "register":
            places = [at for at in range(zeros[number], cell.width) if read[number] >> at & 1]
            if number in values:
                columns = {tuple(value >> at & 1 for value in values[number]) for at in places}
                found[number] = sum(len(set(column)) > 1 for column in columns)
            else:
                found[number] = len(places)
    return found


def _trailing_zeros(circuit: Circuit) -> list[int]:
    """Return how many of the lowest bits of each cell are always 0."""
    found: list[int] = []
    for cell in circuit.cells:
        of = [found[each] for each in cell.operands]
        match cell.kind:
            case "constant":
                value = cell.params[0]
                found.append((value & -value).bit_length() - 1 if value else cell.width)
            case "shl":
                found.append(min(of[0] + cell.params[0], cell.width))
            case "register" | "narrow" | "cut":
                found.append(min(of[0], cell.width))
            case "mux":
                found.append(min(of[1:]))
            case _:
                found.append(0)
    return found


def _constants(circuit: Circuit, cell: Gate, values: dict[int, tuple[int, ...]]) -> tuple[int, ...]:
    """Return the few values that a signal may have, in the order of what chooses them; none of others."""
    match cell.kind:
        case "constant" | "pick":
            return cell.params
        case "register":
            return values.get(cell.operands[0], ())
        case "mux":
            first, second = (values.get(each, ()) for each in cell.operands[1:])
            return first + second if first and second else ()
    return ()


def _read_bits(circuit: Circuit) -> list[int]:
    """Return the bits of each cell that outputs depend on, as a mask."""
    cells = circuit.cells
    read = [0] * len(cells)
    for port in circuit.outputs:
        read[port.cell] = (1 << cells[port.cell].width) - 1
    for number in reversed(range(len(cells))):
        for operand, mask in _taken(cells[number], read[number], [cells[o] for o in cells[number].operands]):
            width = cells[operand].width
            # What is above the operand is its sign.
            read[operand] |= mask & (1 << width) - 1 | (1 << width - 1 if mask >> width else 0)
    return read


def _taken(cell: Gate, mask: int, operands: list[Gate]) -> Iterator[tuple[int, int]]:
    """Yield the operands of a cell, and their bits on which some of its bits depend."""
    if not mask:
        return
    below = (1 << mask.bit_length()) - 1
    whole = [(1 << each.width) - 1 for each in operands]
    if cell.kind in _SAME:
        masks = [mask] * len(operands)
    elif cell.kind == "low":
        masks = [mask & (1 << cell.params[0]) - 1]
    elif cell.kind in ("shl", "shr"):
        (count,) = cell.params
        masks = [mask >> count if cell.kind == "shl" else mask << count]
    elif cell.kind == "round":
        (count,) = cell.params
        masks = [below << count | 1 << count - 1]
    elif cell.kind in SUMS:
        masks = [below] * len(operands)
    elif cell.kind == "mux":
        masks = [1, mask, mask]
    else:
        masks = whole
    yield from zip(cell.operands, masks, strict=True)
