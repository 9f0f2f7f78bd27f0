"""Chips: what they are made of, as far as a plan's area and the programs that build it go."""

from __future__ import annotations

from dataclasses import dataclass, replace

from cordicc.arith.circuits.cell_delays import DELAYS, Delays


@dataclass(frozen=True, slots=True)
class Device:
    """A chip.

    Attributes:
        name: by which users know it.
        family: whose cells it has, `ecp5`, `ice40`, `xc7`, or `generic` of none in particular.
        part: as the vendor names it; empty of none in particular.
        lut_inputs: of a look-up table (LUT).
        dsp_bits: widths of the factors of a multiplier block (DSP); None without such blocks.
        ram_block_bits: of a block RAM, 0 without.
        luts: so many there are; 0 where nobody counts them.
        ffs: flip-flops (FF).
        dsps: multiplier blocks.
        ram_blocks: block RAMs.
        delays: of its cells, with the usual ways between them.
    """

    name: str
    family: str
    part: str
    lut_inputs: int
    dsp_bits: tuple[int, int] | None = None
    ram_block_bits: int = 0
    luts: int = 0
    ffs: int = 0
    dsps: int = 0
    ram_blocks: int = 0
    delays: Delays = DELAYS

    @property
    def capacity(self) -> dict[str, int]:
        """Return what there is of LUT, FF, DSP and RAM bits, by the names of figures of area."""
        if not self.luts:
            return {}
        ram_bits = self.ram_blocks * self.ram_block_bits
        return {"lut": self.luts, "ff": self.ffs, "dsp": self.dsps, "ram_bits": ram_bits}


_XC7 = replace(DELAYS, table_ns=0.9, chain_ns=1.3, carry_ns=0.025, product_ns=4.0, register_ns=0.6)
_HX = replace(DELAYS, table_ns=1.3, chain_ns=2.0, carry_ns=0.13, product_ns=12.0, register_ns=1.0)
_UP = Delays(2.7, 3.6, 0.28, 14.0, 2.0, 16)

DEVICES = {
    each.name: each
    for each in (
        Device("ecp5-85k", "ecp5", "LFE5U-85F", 4, (18, 18), 18_432, 83_640, 83_640, 156, 208),
        Device("ecp5-45k", "ecp5", "LFE5U-45F", 4, (18, 18), 18_432, 43_848, 43_848, 72, 108),
        Device("ecp5-25k", "ecp5", "LFE5U-25F", 4, (18, 18), 18_432, 24_288, 24_288, 28, 56),
        Device("ice40-up5k", "ice40", "iCE40UP5K", 4, (16, 16), 4_096, 5_280, 5_280, 8, 30, _UP),
        Device("ice40-hx8k", "ice40", "iCE40HX8K", 4, None, 4_096, 7_680, 7_680, 0, 32, _HX),
        Device("artix7-100t", "xc7", "XC7A100T", 6, (25, 18), 18_432, 63_400, 126_800, 240, 270, _XC7),
        Device("artix7-35t", "xc7", "XC7A35T", 6, (25, 18), 18_432, 20_800, 41_600, 90, 100, _XC7),
        Device("generic", "generic", "", 6),
    )
}
"""By name."""

DEFAULT_DEVICE = "ecp5-85k"
"""On which a plan is built whose target names none."""
