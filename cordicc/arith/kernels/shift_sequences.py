"""Shift sequences with their angles, gains and convergence domains, computed in this one place.

m is the coordinate system: 1 circular, 0 linear, -1 hyperbolic.  The micro-rotation with shift S turns
by alpha = atan 2^-S, 2^-S or atanh 2^-S and stretches by sqrt(1 + m 2^-2S) (J. S. Walther, 1971); the
root-free one turns by 2 alpha (m = 0: 2 * 2^-S) and stretches by 1 + m 2^-2S (Krieger and Hosticka, 1996).

Of root-free iterations a unit takes only those whose stretch as single ones is no sum of two powers of two
for its target: sqrt(1 + m 2^-2S) is 1 + m 2^-(2S+1) but for 2^-(4S+3), which vanishes in later steps, and a
single rotation has one adder a coordinate.  So later iterations of `blended` sequences are single.
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
    """A shift sequence: coordinate system, shifts, whether root-free, and scaling digits if any.

    `singles` are the last iterations of a root-free sequence that are single rotations, see `blended`; in
    the last `settled` ones of them the target stands for y.
    """

    name: str
    m: int
    shifts: tuple[int, ...]
    root_free: bool = False
    eta: tuple[int, ...] = ()
    singles: int = 0
    settled: int = 0

    def is_double(self, number: int) -> bool:
        """Return whether an iteration, counted from 0, turns by twice the angle of its shift."""
        return self.root_free and number < len(self.shifts) - self.singles

    def is_settled(self, number: int) -> bool:
        """Return whether in an iteration, counted from 0, the target stands for y."""
        return number >= len(self.shifts) - self.settled

    @property
    def angles(self) -> tuple[Any, ...]:
        """The angles of the iterations as 160-bit numbers."""
        return tuple(
            exact_angle(self.m, shift, self.is_double(number)) for number, shift in enumerate(self.shifts)
        )

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
        return float(self.angles[-1])

    @property
    def converges(self) -> bool:
        """Whether each angle is at most the sum of the later ones plus the last.

        A shortfall of a thousandth of the last angle passes: hyperbolic sequences have one of h^3/4.
        """
        return _converges(self)


# Sizing a unit asks these of one sequence for thousands of widths.
@cache
def _domain(sequence: Sequence) -> float:
    angles = sequence.angles
    return float(sum(angles) + angles[-1])


@cache
def _converges(sequence: Sequence) -> bool:
    angles = sequence.angles
    rest = angles[-1]
    for angle in reversed(angles):
        if angle - rest > angles[-1] / 1024:
            return False
        rest += angle
    return True


@dataclass(frozen=True, slots=True)
class StepTable:
    """The constants of a kernel as integers.

    `angles` have `angle_bits` fraction bits; `target_factors` are sqrt(1 + m 2^-2S) - 1, with
    `FACTOR_BITS` fraction bits.  Every coordinate of a kernel in int64 stays within +-2^`coordinate_bits`;
    this saves work and changes no result.  `inverse_gain` is 1/gain with one fraction bit more than that.
    `stretched` are the stretches before each step as a share of the largest, in units of 1/`SHARES`, rounded
    up.  `eta`, `singles` and `settled` are those of the sequence.
    """

    m: int
    shifts: tuple[int, ...]
    angles: tuple[int, ...]
    target_factors: tuple[int, ...]
    inverse_gain: int
    coordinate_bits: int
    stretched: tuple[int, ...] = ()
    eta: tuple[int, ...] = ()
    singles: int = 0
    settled: int = 0

    @property
    def doubles(self) -> int:
        """How many of the first iterations are double rotations, of a root-free sequence."""
        return len(self.shifts) - self.singles

    @property
    def unsettled(self) -> int:
        """How many of the first iterations have y in its own place."""
        return len(self.shifts) - self.settled

    @property
    def domain(self) -> int:
        """The largest |z| driven to 0, in units of the angles: their sum plus the last."""
        return sum(self.angles) + self.angles[-1]


FACTOR_BITS = 44

SHARES = 8

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


@cache
def blended(m: int, iterations: int, fraction_bits: int) -> Sequence:
    """Return the root-free sequence whose later double rotations are single ones by 2^-(S-1).

    A single one, by atan 2^(1-S) instead of 2 atan 2^-S, has no squares for the coordinates.  The target's
    stretch is then 1 + m 2^(1-2S) but for 2^(1-4S), at most half a place.  Where the squares of the target
    are below half a place it is settled, and y so near to it that a shift of it tells the same to half a
    place; then it stands for y.

    Args:
        m: 1 or -1.
        iterations: of them all.
        fraction_bits: of coordinates: a place is 2^-fraction_bits of a block.
    """
    whole = root_free(m, iterations)
    doubles = (fraction_bits + 1) // 4
    turns = [(shift, False) if shift <= doubles else (shift - 1, True) for shift in whole.shifts]
    return replace(
        whole,
        shifts=tuple(shift for shift, _ in turns),
        singles=sum(single for _, single in turns),
        settled=sum(single and 2 * shift >= fraction_bits + 4 for shift, single in turns),
    )


def implicit_sequence(rule: str, m: int, iterations: int, fraction_bits: int) -> Sequence:
    """Return the sequence of a unit with an implicit rule; `fraction_bits` as in `blended`."""
    return blended(m, iterations, fraction_bits) if rule == "root-free" else standard(m, iterations)


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
def exact_stretch(m: int, shift: int, double: bool) -> Any:
    """Return the factor by which one micro-rotation stretches as a 160-bit number."""
    square = 1 + m * _mp.ldexp(_mp.mpf(1), -2 * shift)
    return square if double else _mp.sqrt(square)


@cache
def exact_gain(sequence: Sequence) -> Any:
    """Return the product of the stretch factors as a 160-bit number."""
    gain = _mp.mpf(1)
    for number, shift in enumerate(sequence.shifts):
        gain *= exact_stretch(sequence.m, shift, sequence.is_double(number))
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
def target_factor(m: int, shift: int) -> int:
    """Return sqrt(1 + m 2^-2S) - 1, by which a target grows, with `FACTOR_BITS` fraction bits."""
    return fixed(exact_stretch(m, shift, False) - 1, FACTOR_BITS)


def _stretched(sequence: Sequence) -> tuple[int, ...]:
    gain = _mp.mpf(1)
    before = [gain]
    for number, shift in enumerate(sequence.shifts):
        gain *= exact_stretch(sequence.m, shift, sequence.is_double(number))
        before.append(gain)
    largest = max(before)
    return tuple(int(_mp.ceil(SHARES * gain / largest)) for gain in before[:-1])


@cache
def step_table(sequence: Sequence, angle_bits: int, coordinate_bits: int = COORDINATE_BITS) -> StepTable:
    """Return the integer constants of a sequence for a kernel.

    `coordinate_bits` bounds the coordinates, as `StepTable` says, growth by the gain included.
    """
    return StepTable(
        m=sequence.m,
        shifts=sequence.shifts,
        angles=tuple(fixed(angle, angle_bits) for angle in sequence.angles),
        target_factors=tuple(target_factor(sequence.m, shift) for shift in sequence.shifts),
        inverse_gain=fixed(1 / exact_gain(sequence), coordinate_bits + 1),
        coordinate_bits=coordinate_bits,
        stretched=_stretched(sequence),
        eta=sequence.eta,
        singles=sequence.singles,
        settled=sequence.settled,
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
