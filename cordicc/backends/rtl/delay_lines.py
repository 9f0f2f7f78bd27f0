"""FIFOs of a core: shift registers, and RAM where they are deep.

A FIFO of a plan delays a value by so many samples: it takes one word and gives up the oldest whenever a
sample passes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from cordicc.plan.model import Fifo

SHIFTED_WORDS = 16
"""Words up to which a FIFO is a shift register; a deeper one is RAM."""


@dataclass(frozen=True, slots=True)
class Place:
    """The address at which all FIFOs of one depth that are in RAM write, and the one after it.

    Such a FIFO writes and reads in one slot of the interval, the address moves on in slot 0: so FIFOs of
    one depth share it, whatever their slots.
    """

    depth: int

    @property
    def width(self) -> int:
        """Bits of the address."""
        return (self.depth - 1).bit_length()

    @property
    def register(self) -> str:
        """The name that is wanted for the register."""
        return f"place{self.depth}"

    @property
    def following(self) -> str:
        """The name that is wanted for what it becomes."""
        return f"place{self.depth}_next"


def places(fifos: Iterable[Fifo]) -> dict[int, Place]:
    """Return the addresses of the FIFOs that are in RAM, by their depth."""
    return {depth: Place(depth) for depth in sorted({f.depth for f in fifos if f.depth > SHIFTED_WORDS})}


@dataclass(frozen=True, slots=True)
class Delay:
    """A FIFO as signals.

    Attributes:
        name: of its register.
        depth: in words, at least 1.
        width: of a word.
        word: what it takes.
        ok: whether that stands for a number.
        end: the wire of the oldest word.
        end_ok: the wire that tells whether that stands for a number.
        gate: when it takes a word.
    """

    name: str
    depth: int
    width: int
    word: str
    ok: str
    end: str
    end_ok: str
    gate: str


def delay_text(delay: Delay, ram: tuple[str, str, str] | None = None) -> Iterator[str]:
    """Yield the lines of a FIFO; `ram` are its memory and the addresses at which it writes and reads."""
    width = delay.width + 1
    taken = f"{{{delay.ok}, {delay.word}}}"
    top = width - 1
    if ram is not None:
        memory, write, read = ram
        yield f"    reg [{width - 1}:0] {memory} [0:{delay.depth - 1}];"
        yield f"    reg [{width - 1}:0] {delay.name};"
        yield f"    always @(posedge clk) if ({delay.gate}) begin"
        yield f"        {memory}[{write}] <= {taken};"
        yield f"        {delay.name} <= {memory}[{read}];"
        yield "    end"
    else:
        yield f"    reg [{delay.depth * width - 1}:0] {delay.name};"
        if delay.depth > 1:
            taken = f"{{{delay.name}[{(delay.depth - 1) * width - 1}:0], {taken}}}"
            top = delay.depth * width - 1
        yield f"    always @(posedge clk) if ({delay.gate}) {delay.name} <= {taken};"
    yield f"    assign {delay.end} = {delay.name}[{top - 1}:{top - delay.width}];"
    yield f"    assign {delay.end_ok} = {delay.name}[{top}];"
