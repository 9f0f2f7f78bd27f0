"""A circuit as data: signals of integers with their ranges, and the cycle in which each of them exists.

A signal is the result of one cell.  Its width follows from its range: it is in two's complement if it may be
negative, else unsigned.  Cycles count from that in which the inputs of a sample enter; a register hands its
operand on to the next one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

CELLS = {
    "input": "a port",
    "constant": "an integer that is there in every cycle",
    "register": "the operand of the cycle before",
    "add": "a + b",
    "addc": "a + b + c, c a bit",
    "sub": "a - b",
    "subc": "a - b - c, c a bit",
    "addsub": "a + d + b, or a + d - b - 1 where the bit c is 1, d a bit",
    "negif": "-a where the bit c is 1, else a",
    "mul": "a * b",
    "shl": "a * 2^k",
    "shr": "a / 2^k rounded down",
    "round": "a / 2^k rounded half up",
    "low": "a modulo 2^k",
    "eq": "1 where a = b",
    "and": "of the bits of a and b",
    "or": "of the bits of a and b",
    "xor": "of the bits of a and b",
    "not": "1 where the bit a is 0",
    "mux": "b where the bit c is 1, else a",
    "pick": "of a list of constants the one with the number a",
    "join": "of bits, the highest first, the number times 2^k",
    "narrow": "a, known to lie in a smaller range",
    "cut": "the last bits of a, which lies in a smaller range wherever anybody looks at it",
}
"""Kinds of cells, and what they make of operands a, b, c and parameters k."""


SIGNAL_NAMES = {
    "add": "sum",
    "addc": "sum",
    "sub": "diff",
    "subc": "diff",
    "addsub": "turned",
    "negif": "flipped",
    "mul": "product",
    "shl": "wide",
    "shr": "high",
    "round": "rounded",
    "low": "part",
    "eq": "equal",
    "and": "both",
    "or": "either",
    "xor": "apart",
    "not": "other",
    "mux": "chosen",
    "pick": "entry",
    "join": "joined",
    "narrow": "fit",
    "cut": "cut",
}
"""What signals are called that nobody names, by the kind of their cell; no words of Verilog."""


@dataclass(frozen=True, slots=True)
class Gate:
    """A cell and its result.

    Attributes:
        kind: one of `CELLS`.
        operands: the numbers of the cells whose results it takes.
        params: a shift, the value of a constant, or a list of values.
        lo: least value of the result.
        hi: largest value.
        cycle: in which the result exists; None of a constant.
        name: of the signal.
    """

    kind: str
    operands: tuple[int, ...]
    params: tuple[int, ...]
    lo: int
    hi: int
    cycle: int | None
    name: str

    @property
    def signed(self) -> bool:
        """Whether the signal is in two's complement."""
        return self.lo < 0

    @property
    def width(self) -> int:
        """Bits of the signal."""
        return width_of(self.lo, self.hi)


def width_of(lo: int, hi: int) -> int:
    """Return the bits that hold all integers from `lo` to `hi`, with a sign if some are negative."""
    if lo >= 0:
        return max(1, hi.bit_length())
    return 1 + max((~lo).bit_length(), hi.bit_length() if hi > 0 else 0)


@dataclass(frozen=True, slots=True)
class Port:
    """An input or output: its name and the number of its cell."""

    name: str
    cell: int


@dataclass(frozen=True, slots=True)
class Circuit:
    """Cells in an order in which operands come first, and ports.

    All outputs exist in one cycle, the latency.  `notes` by cell are comments that stand in front of it.
    """

    name: str
    cells: tuple[Gate, ...]
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    notes: Mapping[int, str]

    @property
    def latency(self) -> int:
        """Cycles from inputs to outputs."""
        return max((self.cells[port.cell].cycle or 0 for port in self.outputs), default=0)

    def registers(self) -> int:
        """Return the bits of all registers."""
        return sum(cell.width for cell in self.cells if cell.kind == "register")


def pruned(
    name: str,
    cells: Sequence[Gate],
    inputs: Sequence[Port],
    outputs: Sequence[Port],
    notes: Mapping[int, str],
) -> Circuit:
    """Return a circuit of the cells that outputs depend on, and of its inputs."""
    live = {port.cell for port in (*inputs, *outputs)}
    for number in reversed(range(len(cells))):
        if number in live:
            live.update(cells[number].operands)
    place = {old: new for new, old in enumerate(sorted(live))}
    return Circuit(
        name,
        tuple(
            replace(cells[old], operands=tuple(place[each] for each in cells[old].operands)) for old in place
        ),
        tuple(Port(port.name, place[port.cell]) for port in inputs),
        tuple(Port(port.name, place[port.cell]) for port in outputs),
        {place[old]: text for old, text in notes.items() if old in place},
    )
