"""What a unit is used for: an operation with the formats of its words.  A shared unit has several uses."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.numbers.slack import EXACT, Slack


class NoCircuitError(ValueError):
    """A unit has a use of which there is no circuit."""


class Turned(NamedTuple):
    """What iterations begin and end with."""

    x: CircuitSignal
    y: CircuitSignal
    z: CircuitSignal


class Raw(NamedTuple):
    """A result before it is rounded: mantissa * 2^exponent, and whether it stands for a number."""

    mantissa: CircuitSignal
    exponent: CircuitSignal
    valid: CircuitSignal


Raws = tuple[Raw | None, Raw | None]
"""Both results, None of one that nobody takes."""

Wanted = tuple[bool, bool]
"""Which results are taken."""

Coordinates = tuple[CircuitSignal | None, CircuitSignal | None]
"""At most two coordinates, or what they are over the gain of their system, with `SCALE_BITS` more bits."""


class UnitFunction(NamedTuple):
    """What a function is around the iterations of a unit.

    Attributes:
        start: what they begin with.
        coordinates: of what they end with, those that are divided by the gain.
        finish: makes the results from what they end with, and from the quotients.
    """

    start: Turned
    coordinates: Callable[[Turned, Wanted], Coordinates]
    finish: Callable[[Turned, Coordinates, Wanted], Raws]


def no_coordinates(last: Turned, wanted: Wanted) -> Coordinates:
    """Return nothing: of a function whose results have no gain."""
    return None, None


@dataclass(frozen=True, slots=True)
class Use:
    """An operation of a unit.

    Attributes:
        op: its name, `rotate`, `vector`, `lightcone` or `implicit`.
        m: the coordinate system.
        sign: of the angle that vectoring adds.
        branch: of the implicit mode.
        operands: the formats of its operands.
        results: those of its results, None of one that nobody takes.
        angle: the number of the result that no word takes beyond pi, None if there is none.
        slack: what counts as on the border of its domain.
        constants: the words of operands that are constant, None of those that are not.
    """

    op: str
    m: int
    operands: tuple[FixedPoint, ...]
    results: tuple[FixedPoint | None, ...]
    sign: int = 1
    branch: str = "-"
    angle: int | None = None
    slack: Slack = EXACT
    constants: tuple[int | None, ...] = ()

    def delivered(self, number: int) -> FixedPoint | None:
        """Return the format of a result by its number, None if nobody takes it."""
        return self.results[number]

    @property
    def function(self) -> str:
        """What the unit does, in a word."""
        system = {1: "circular", 0: "linear", -1: "hyperbolic"}[self.m]
        return f"{self.op}_{system}" if self.op != "lightcone" else self.op


@dataclass(frozen=True, slots=True)
class Modes:
    """The uses of a unit, and the signal that tells which of them a sample is for."""

    builder: CircuitBuilder
    mode: CircuitSignal
    uses: tuple[Use, ...]

    def pick(self, value: Callable[[Use], int]) -> CircuitSignal:
        """Return an integer that depends on the use."""
        return self.builder.pick(self.mode, [value(use) for use in self.uses])

    def which(self, holds: Callable[[Use], bool]) -> CircuitSignal:
        """Return a bit that depends on the use."""
        return self.pick(lambda use: int(holds(use)))


@dataclass(frozen=True, slots=True)
class Word:
    """A word as it enters a unit: two's complement with a binary point."""

    bits: CircuitSignal
    fraction: CircuitSignal


@dataclass(frozen=True, slots=True)
class Format:
    """The format of a result: its fraction bits and its largest word; angles of at most pi stay there.

    `pi` is the largest word of an angle, and `still` what counts as pi, with `angle_bits` fraction bits;
    -1 of a result that is none.
    """

    fraction: CircuitSignal
    largest: CircuitSignal
    rounding: str
    pi: CircuitSignal
    still: CircuitSignal


def of_system(m: int) -> Callable[[Use], bool]:
    """Return what tells whether a use is in a coordinate system."""
    return lambda use: use.m == m


def word(modes: Modes, bits: CircuitSignal, number: int) -> Word:
    """Return an operand by its number."""
    return Word(
        bits, modes.pick(lambda use: use.operands[number].fraction_bits if number < len(use.operands) else 0)
    )


def format_of(modes: Modes, number: int, angle_bits: int) -> Format | None:
    """Return the format of a result by its number, None if no use delivers it."""
    taken = [found for use in modes.uses if (found := use.results[number]) is not None]
    if not taken:
        return None
    first = taken[0]

    def own(use: Use) -> FixedPoint:
        return use.results[number] or first

    def held(use: Use) -> bool:
        return use.angle == number and own(use).width_bits - own(use).fraction_bits >= 3

    return Format(
        modes.pick(lambda use: own(use).fraction_bits),
        modes.pick(lambda use: own(use).largest_word),
        first.rounding,
        modes.pick(lambda use: math.floor(math.ldexp(math.pi, own(use).fraction_bits)) if held(use) else 0),
        modes.pick(lambda use: still(own(use), angle_bits) if held(use) else -1),
    )


def still(format_: FixedPoint, angle_bits: int) -> int:
    """Return the largest angle, with some fraction bits, that `FixedPoint.encode_angle` takes for pi."""
    return math.floor(math.ldexp(math.pi + format_.ulp / 4, angle_bits))
