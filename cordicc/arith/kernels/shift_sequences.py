"""Shift sequences with their angles, gains and convergence domains, computed in this one place.

m is the coordinate system: 1 circular, 0 linear, -1 hyperbolic.  The micro-rotation with shift S turns
by alpha = atan 2^-S, 2^-S or atanh 2^-S and stretches by sqrt(1 + m 2^-2S) (J. S. Walther, 1971); the
root-free one turns by 2 alpha (m = 0: 2 * 2^-S) and stretches by 1 + m 2^-2S (Krieger and Hosticka, 1996).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from mpmath import MPContext, libmp

_PRECISION_BITS = 160
_mp = MPContext()
_mp.prec = _PRECISION_BITS

KRIEGER96_SHIFTS = (1, 1, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17)
"""Krieger and Hosticka 1996, tables 2 and 3: the circular sequence of 22 root-free iterations."""

KRIEGER96_ETA = (1, 1, -1, 1, 1, 0, 0, 1, 1, 0, 0, 1, -1, 1, -1, 1, -1, 1, 0, 1, -1, 1)
"""Their scaling: after iteration i the vector is multiplied by 1 - eta(i) 2^-2S(i)."""


@dataclass(frozen=True, slots=True)
class Sequence:
    """A shift sequence: coordinate system, shifts, whether root-free, and scaling digits if any."""

    name: str
    m: int
    shifts: tuple[int, ...]
    root_free: bool = False
    eta: tuple[int, ...] = ()

    @property
    def gain(self) -> float:
        """Factor by which all iterations together stretch the norm, without scaling."""
        return float(exact_gain(self))

    @property
    def domain(self) -> float:
        """Largest angle in radians (ratio for m = 0) that the iterations reach, last angle included."""
        return _domain(self)

    @property
    def resolution(self) -> float:
        """The last angle: the largest error of z, or of the direction, without rounding."""
        return float(exact_angle(self.m, self.shifts[-1], self.root_free))

    @property
    def converges(self) -> bool:
        """Whether each angle is at most the sum of the later ones plus the last.

        A shortfall of a thousandth of the last angle passes: hyperbolic sequences have one of h^3/4.
        """
        return _converges(self)


# Sizing a unit asks these of one sequence for thousands of widths.
@cache
def _domain(sequence: Sequence) -> float:
    angles = _angles(sequence)
    return float(sum(angles) + angles[-1])


@cache
def _converges(sequence: Sequence) -> bool:
    angles = _angles(sequence)
    rest = angles[-1]
    for angle in reversed(angles):
        if angle - rest > angles[-1] / 1024:
            return False
        rest += angle
    return True


def _angles(sequence: Sequence) -> list[Any]:
    return [exact_angle(sequence.m, shift, sequence.root_free) for shift in sequence.shifts]


@dataclass(frozen=True, slots=True)
class StepTable:
    """The constants of a kernel as integers.

    `angles` have `angle_bits` fraction bits; `target_factors` are sqrt(1 + m 2^-2S) - 1, with
    `FACTOR_BITS` fraction bits.  Every coordinate of a kernel in int64 stays within +-2^`coordinate_bits`;
    this saves work and changes no result.  `inverse_gain` is 1/gain with one fraction bit more than that.
    `stretched` are the stretches before each step as a share of the largest, in units of 1/`SHARES`, rounded
    up.  `eta` are the scaling digits of a sequence that has them.
    """

    m: int
    shifts: tuple[int, ...]
    angles: tuple[int, ...]
    target_factors: tuple[int, ...]
    inverse_gain: int
    coordinate_bits: int
    stretched: tuple[int, ...] = ()
    eta: tuple[int, ...] = ()

    @property
    def domain(self) -> int:
        """The largest |z| driven to 0, in units of the angles: their sum plus the last."""
        return sum(self.angles) + self.angles[-1]


FACTOR_BITS = 44

SHARES = 16

COORDINATE_BITS = 44
"""Coordinates of kernels in int64 are at most 2^44 in magnitude: 40 fraction bits, and growth below 16."""


def circular_shifts(count: int) -> tuple[int, ...]:
    """Return 0, 1, 2, ..., `count` of them."""
    return tuple(range(count))


def hyperbolic_shifts(count: int) -> tuple[int, ...]:
    """Return 1, 2, 3, 4, 4, 5, ..., `count` of them; 4, 13, 40, ... occur twice (Walther)."""
    shifts: list[int] = []
    shift, repeat = 1, 4
    while len(shifts) < count:
        shifts.append(shift)
        if shift == repeat:
            shifts.append(shift)
            repeat = 3 * repeat + 1
        shift += 1
    return tuple(shifts[:count])


def standard(m: int, iterations: int) -> Sequence:
    """Return Walther's sequence for a coordinate system."""
    shifts = hyperbolic_shifts(iterations) if m == -1 else circular_shifts(iterations)
    return Sequence({1: "circular", 0: "linear", -1: "hyperbolic"}[m], m, shifts)


def root_free(m: int, iterations: int) -> Sequence:
    """Return the sequence of double rotations that need no scaling of the vector, each shift once.

    The circular one starts at S = 0, a rotation by 90 degrees with factor 2; hyperbolic ones repeat
    4, 13, 40 as the standard sequence does.
    """
    shifts = hyperbolic_shifts(iterations) if m == -1 else circular_shifts(iterations)
    return Sequence({1: "root-free", -1: "root-free-hyperbolic"}[m], m, shifts, root_free=True)


def krieger96() -> Sequence:
    """Return the paper's circular sequence with its scaling digits."""
    return Sequence("krieger96", 1, KRIEGER96_SHIFTS, root_free=True, eta=KRIEGER96_ETA)


def shipped(iterations: int = 30) -> tuple[Sequence, ...]:
    """Return every named sequence."""
    walther = tuple(standard(m, iterations) for m in (1, 0, -1))
    return (*walther, root_free(1, iterations), root_free(-1, iterations), krieger96())


@cache
def exact_angle(m: int, shift: int, double: bool) -> Any:
    """Return the angle of one micro-rotation as a 160-bit number."""
    h = _mp.ldexp(_mp.mpf(1), -shift)
    angle = {1: _mp.atan, 0: lambda t: t, -1: _mp.atanh}[m](h)
    return 2 * angle if double else angle


@cache
def exact_gain(sequence: Sequence) -> Any:
    """Return the product of the stretch factors as a 160-bit number."""
    gain = _mp.mpf(1)
    for shift in sequence.shifts:
        square = 1 + sequence.m * _mp.ldexp(_mp.mpf(1), -2 * shift)
        gain *= square if sequence.root_free else _mp.sqrt(square)
    return gain


def exact_scaling(sequence: Sequence) -> Any:
    """Return the product of 1 - eta 2^-2S, which should be 1/gain, as a 160-bit number."""
    scaling = _mp.mpf(1)
    for shift, eta in zip(sequence.shifts, sequence.eta, strict=True):
        scaling *= 1 - eta * _mp.ldexp(_mp.mpf(1), -2 * shift)
    return scaling


def fixed(value: Any, fraction_bits: int) -> int:
    """Return a real number with a number of fraction bits, rounded to nearest."""
    return int(_mp.nint(_mp.ldexp(_mp.mpf(value), fraction_bits)))


@cache
def _target_factor(m: int, shift: int) -> int:
    return fixed(_mp.sqrt(1 + m * _mp.ldexp(_mp.mpf(1), -2 * shift)) - 1, FACTOR_BITS)


def _stretched(sequence: Sequence) -> tuple[int, ...]:
    before = [
        exact_gain(replace(sequence, shifts=sequence.shifts[:count])) for count in range(len(sequence.shifts))
    ]
    largest = max([*before, exact_gain(sequence)])
    return tuple(int(_mp.ceil(SHARES * gain / largest)) for gain in before)


@cache
def step_table(sequence: Sequence, angle_bits: int, coordinate_bits: int = COORDINATE_BITS) -> StepTable:
    """Return the integer constants of a sequence for a kernel.

    `coordinate_bits` bounds the coordinates, as `StepTable` says, growth by the gain included.
    """
    m = sequence.m
    factors = tuple(_target_factor(m, shift) for shift in sequence.shifts)
    angles = tuple(fixed(exact_angle(m, s, sequence.root_free), angle_bits) for s in sequence.shifts)
    inverse_gain = fixed(1 / exact_gain(sequence), coordinate_bits + 1)
    stretched = _stretched(sequence)
    return StepTable(
        m, sequence.shifts, angles, factors, inverse_gain, coordinate_bits, stretched, sequence.eta
    )


@cache
def pi_fixed(fraction_bits: int) -> int:
    """Return pi with a number of fraction bits."""
    return fixed(+_mp.pi, fraction_bits)


@cache
def ln2_fixed(fraction_bits: int) -> int:
    """Return ln 2 with a number of fraction bits."""
    return fixed(+_mp.ln2, fraction_bits)


@cache
def inverse_ln2_fixed(fraction_bits: int) -> int:
    """Return 1/ln 2 with a number of fraction bits."""
    return fixed(1 / _mp.ln2, fraction_bits)


@cache
def _inverse_turn() -> Any:
    """Return 1/(2 pi) to more bits than any exponent of a single asks for."""
    bits = 512
    return libmp.mpf_div(libmp.fone, libmp.mpf_shift(libmp.mpf_pi(bits), 1), bits, "n")


def turn_fixed(exponent: int, fraction_bits: int) -> int:
    """Return 2^exponent / (2 pi), the turns of that many radians, with a number of fraction bits."""
    return int(libmp.to_int(libmp.mpf_shift(_inverse_turn(), exponent + fraction_bits), "n"))
