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
    "hold": "the operand of the cycle before, until another operation is as far",
    "loop": "the state k[1] of the loop k[0], whose operands are its states and what it keeps",
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
    "loop": "turned",
    "hold": "held",
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


INDEX = "index"
"""The input of a loop's body that is 0 in the first step, 1 in the next, and so on."""


@dataclass(frozen=True, slots=True)
class Loop:
    """A step that is made again and again, in as many cycles: a body without registers.

    Its inputs are the states, under their names, then what stays the same, and perhaps `INDEX`; its outputs
    are the states of the next step, under the same names.  The states begin as the operands of the loop's
    cells, in the cycle in which these exist.
    """

    body: Circuit
    states: tuple[str, ...]
    kept: tuple[str, ...]
    steps: int


@dataclass(frozen=True, slots=True)
class Circuit:
    """Cells in an order in which operands come first, and ports.

    All outputs exist in one cycle, the latency.  `notes` by cell are comments that stand in front of it.
    A circuit with loops takes an operation as often as the longest of them has steps.
    """

    name: str
    cells: tuple[Gate, ...]
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    notes: Mapping[int, str]
    loops: tuple[Loop, ...] = ()

    @property
    def strobes(self) -> tuple[int, ...]:
        """The cycles after an operation entered in which something is loaded: by holds and loops."""
        found = {(cell.cycle or 0) - 1 for cell in self.cells if cell.kind == "hold"}
        found |= {self.begin(number) for number in range(len(self.loops))}
        return tuple(sorted(found))

    def begin(self, loop: int) -> int:
        """Return the cycle in which the first step of a loop is made."""
        made = next(each for each in self.cells if each.kind == "loop" and each.params[0] == loop)
        return (made.cycle or 0) - self.loops[loop].steps

    @property
    def latency(self) -> int:
        """Cycles from inputs to outputs."""
        return max((self.cells[port.cell].cycle or 0 for port in self.outputs), default=0)

    def registers(self) -> int:
        """Return the bits of all registers, those that count steps apart."""
        inside = sum(
            loop.body.cells[port.cell].width
            for loop in self.loops
            for port in loop.body.inputs
            if port.name != INDEX
        )
        return inside + sum(cell.width for cell in self.cells if cell.kind in ("register", "hold"))


def pruned(
    name: str,
    cells: Sequence[Gate],
    inputs: Sequence[Port],
    outputs: Sequence[Port],
    notes: Mapping[int, str],
    loops: Sequence[Loop] = (),
) -> Circuit:
    """Return a circuit of the cells that outputs depend on, and of its inputs."""
    live = {port.cell for port in (*inputs, *outputs)}
    for number in reversed(range(len(cells))):
        if number in live:
            live.update(cells[number].operands)
    place = {old: new for new, old in enumerate(sorted(live))}
    needed = sorted({cells[old].params[0] for old in place if cells[old].kind == "loop"})
    renumbered = {old: new for new, old in enumerate(needed)}

    def moved(cell: Gate) -> Gate:
        params = (renumbered[cell.params[0]], cell.params[1]) if cell.kind == "loop" else cell.params
        return replace(cell, operands=tuple(place[each] for each in cell.operands), params=params)

    return Circuit(
        name,
        tuple(moved(cells[old]) for old in place),
        tuple(Port(port.name, place[port.cell]) for port in inputs),
        tuple(Port(port.name, place[port.cell]) for port in outputs),
        {place[old]: text for old, text in notes.items() if old in place},
        tuple(loops[old] for old in needed),
    )
