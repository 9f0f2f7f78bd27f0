"""What RAM the deep FIFOs of a core become on a chip, by what yosys made of such ones of 17 to 400 words."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cordicc.backends.rtl.delay_lines import SHIFTED_WORDS
from cordicc.targets.device import Device


@dataclass(frozen=True, slots=True)
class _Distributed:
    """RAM made of look-up tables: words and bits of a piece, the tables that it takes, where it ends."""

    words: int
    bits: int
    luts: int
    below: int


@dataclass(frozen=True, slots=True)
class _Block:
    """A block RAM: its bits, and bits of a word at its widest."""

    size: int
    bits: int


# Below 33 words Artix-7 has pieces of 32 words, below 128 of 64.
_DISTRIBUTED = {
    "ecp5": (_Distributed(16, 4, 6, 64),),
    "xc7": (_Distributed(32, 6, 4, 33), _Distributed(64, 3, 4, 128)),
}
_BLOCKS = {"ecp5": _Block(18_432, 36), "ice40": _Block(4_096, 16), "xc7": _Block(18_432, 36)}


def ram_bits(width: int, depth: int, device: Device) -> dict[str, int]:
    """Return what a FIFO of words of `width` bits takes, nothing where it is made of registers.

    `lut` are look-up tables, `ram_bits` the bits of whole blocks, `register` those of the word that leaves.
    """
    block = _BLOCKS.get(device.family)
    if depth <= SHIFTED_WORDS or block is None:
        return {}
    for piece in _DISTRIBUTED.get(device.family, ()):
        if depth < piece.below:
            rows = math.ceil(depth / piece.words)
            luts = piece.luts * rows * math.ceil(width / piece.bits) + (rows - 1) * width
            return {"lut": luts, "register": width}
    words = block.size // block.bits
    return {"ram_bits": block.size * math.ceil(width / block.bits) * math.ceil(depth / words)}
