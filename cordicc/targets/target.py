"""A target: what hardware there is, its timing, its area and its arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.targets.device import Device

DEFAULT_TARGET = "kinematic"
CAU_KINDS = ("standard", "implicit")
"""Kinds of CORDIC arithmetic unit (CAU)."""

SYSTEMS = {1: "circular", 0: "linear", -1: "hyperbolic"}


FUNCTIONS_OF_KIND: dict[str, set[str]] = {
    "standard": {f"{op}-{system}" for op in ("rotate", "vector") for system in SYSTEMS.values()}
    | {"lightcone"},
    "implicit": {"implicit-circular", "implicit-hyperbolic"},
    "add": {"add", "sub", "min", "max", "select", "wrap"},
    "mul": {"mul"},
    "cmul": {"cmul"},
    "shift": {"shift"},
    "sign": {"neg", "abs", "flip", "sign", "guard"},
}
"""What each kind of unit may be able to do, by the names of `function_name`."""


@dataclass(frozen=True, slots=True)
class UnitKind:
    """A kind of unit: cycles of latency, cycles between operations, what it does, and its size.

    `functions` as of `function_name`; `area` in adder equivalents; `stages` cycles by part.  `latencies` are
    those of units that do a function alone, where they are known.
    """

    name: str
    latency: int
    initiation_interval: int
    functions: frozenset[str]
    adders: int
    area: float
    stages: Mapping[str, int]
    arithmetic: Mapping[str, Any] | None = None
    latencies: Mapping[str, int] = field(default_factory=dict)

    def cycles_of(self, function: str) -> int:
        """Return the cycles of a function, by its name."""
        return self.latencies.get(function, self.latency)


@dataclass(frozen=True, slots=True)
class Target:
    """A target: clock in Hz, number format, unit kinds, area of a FIFO bit in adder equivalents.

    `guard_is_open`: the file leaves the guard bits of values between operations to the compiler.
    `device`: the chip, None of a target that is none in particular; `weights`: look-up tables that a
    multiplier block (`dsp`) and a bit of block RAM (`ram_bit`) count for where area is minimised.
    """

    name: str
    description: str
    clock_hz: float
    angle_unit: str
    format: Mapping[str, Any]
    fifo_area_per_bit: float
    units: Mapping[str, UnitKind]
    guard_is_open: bool = False
    device: Device | None = None
    weights: Mapping[str, float] = field(default_factory=dict)

    @property
    def arithmetic(self) -> dict[str, Any]:
        """The plain data from which `Arithmetic.from_spec` builds the target's arithmetic."""
        caus = {k: dict(u.arithmetic) for k, u in self.units.items() if u.arithmetic is not None}
        return {"format": dict(self.format), "units": caus}

    def machine(self) -> Arithmetic:
        """Return the target's arithmetic."""
        return Arithmetic.from_spec(self.arithmetic)

    @property
    def has_implicit(self) -> bool:
        """Whether there are implicit CAUs."""
        return "implicit" in self.units

    def kinds_for(self, function: str) -> tuple[str, ...]:
        """Return the kinds of unit that perform a function, in the file's order."""
        return tuple(kind for kind, unit in self.units.items() if function in unit.functions)


def function_name(op: str, m: int | None = None) -> str:
    """Return the name of an operation among a unit's functions, such as `rotate-circular` or `add`."""
    return op if m is None else f"{op}-{SYSTEMS[m]}"
