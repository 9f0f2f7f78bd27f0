"""How yosys and nextpnr are asked for a chip of a family, and which of their cells count as what."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from cordicc.plan.area import Area
from cordicc.targets.device import Device


@dataclass(frozen=True, slots=True)
class Family:
    """A family of chips.

    Attributes:
        synthesis: command of yosys without the name of the top.
        cells: patterns of the types of cells by figure, each with what one cell adds to it.
        router: the program that places and routes, None where there is none for it.
        options: arguments of the router by the name of the device.
        free_pins: its argument that leaves pins where it likes.
    """

    synthesis: str
    cells: Mapping[str, Mapping[str, int]]
    router: str | None = None
    options: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    free_pins: str = ""

    def area(self, count: Mapping[str, int]) -> Area:
        """Return the area of cells, counted by their types as yosys names them."""
        figures = {
            figure: sum(
                number * each
                for kind, number in count.items()
                for pattern, each in patterns.items()
                if re.fullmatch(pattern, kind)
            )
            for figure, patterns in self.cells.items()
        }
        return Area(**{name: figures.get(name, 0) for name in ("lut", "ff", "dsp", "ram_bits")})


FAMILIES = {
    # A CCU2C is two LUTs with a carry chain, 16 words of 4 bits of distributed RAM take six.
    "ecp5": Family(
        "synth_ecp5",
        {
            "lut": {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 6},
            "ff": {"TRELLIS_FF": 1},
            "dsp": {"MULT18X18D": 1},
            "ram_bits": {"DP16KD": 18_432, "PDPW16KD": 18_432},
        },
        "nextpnr-ecp5",
        {
            f"ecp5-{size}": (f"--{size}", "--speed", "6", "--package", "CABGA381", "--router", "router2")
            for size in ("25k", "45k", "85k")
        },
        "--lpf-allow-unconstrained",
    ),
    # A carry shares its logic cell with the LUT that adds.
    "ice40": Family(
        "synth_ice40",
        {
            "lut": {"SB_LUT4": 1},
            "ff": {"SB_DFF.*": 1},
            "dsp": {"SB_MAC16": 1},
            "ram_bits": {"SB_RAM40_4K.*": 4_096},
        },
        "nextpnr-ice40",
        {
            "ice40-up5k": ("--up5k", "--package", "sg48"),
            "ice40-hx8k": ("--hx8k", "--package", "ct256"),
        },
        "--pcf-allow-unconstrained",
    ),
    # Shift registers and distributed RAM stand in LUTs; an inverter that stays takes one.
    "xc7": Family(
        "synth_xilinx -family xc7 -flatten -noiopad -noclkbuf",
        {
            "lut": {
                "LUT[1-6]|INV|SRL16E?|SRLC16E?|SRLC32E": 1,
                "RAM32X1D|RAM64X1D": 2,
                "RAM32M|RAM64M": 4,
            },
            "ff": {"FD[RSCP]E(_1)?": 1},
            "dsp": {"DSP48E1": 1},
            "ram_bits": {"RAMB18E1": 18_432, "RAMB36E1": 36_864},
        },
    ),
    "generic": Family(
        "synth -flatten -lut 6",
        {"lut": {r"\$lut": 1}, "ff": {r"\$_(S?DFF|DFFE|SDFFC?E|ALDFF).*": 1}},
    ),
}
"""By name."""

_OPTIONS = {"ice40-up5k": "-device u -dsp", "ice40-hx8k": "-device hx"}
"""Of yosys for one device."""


def synthesis_command(device: Device, top: str) -> str:
    """Return the command of yosys that makes cells of a device."""
    options = _OPTIONS.get(device.name, "")
    return " ".join(each for each in (FAMILIES[device.family].synthesis, options, "-top", top) if each)
