"""What a plan takes on a chip: estimated when it is made, counted when it was built."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Area:
    """Look-up tables, flip-flops, multiplier blocks, and bits of block RAM."""

    lut: int
    ff: int
    dsp: int
    ram_bits: int


@dataclass(frozen=True, slots=True)
class PathEnd:
    """Where a path between registers begins or ends.

    Attributes:
        place: a unit, a FIFO or what else the core has there, in words.
        unit: the id of the unit, None outside of units.
        operations: the ids of the operations that the unit is for.
        stage: the cycle of the unit in which the signal exists, 0 that in which operands enter; None where
            that is not known.
        signal: its name in the module.
        step: what is said beside the logic of that stage, empty if nothing is.
    """

    place: str
    unit: str | None
    operations: tuple[str, ...]
    stage: int | None
    signal: str
    step: str = ""


@dataclass(frozen=True, slots=True)
class SlowestPath:
    """The path between registers that limits the clock: its ends, and seconds in logic and in wires."""

    begin: PathEnd
    end: PathEnd
    logic_seconds: float
    wire_seconds: float


@dataclass(frozen=True, slots=True)
class SynthesisResult:
    """What programs that build hardware found of a plan.

    Attributes:
        device: the name of the chip.
        programs: names and versions of what was run.
        seed: of placing; None where nothing was placed.
        area: counted, of the core alone.
        clock_hz: at which it runs after place and route; None where it was not placed.
        slowest: the path that limits the clock.
    """

    device: str
    programs: tuple[str, ...]
    seed: int | None
    area: Area
    clock_hz: float | None
    slowest: SlowestPath | None
