"""Size a unit: the least iterations, fraction bits and angle bits that the proven error bounds allow.

The bounds are those of `unit_bounds` and `implicit_bounds`; the last rounding, to the nearest word, adds half
an ulp. They are expressed here for w-bit words, as in two's complement: lengths in ulp of a word whose
largest value is 2^(w-1) ulp, angles in ulp of one that holds +-4 rad, 2^(3-w) rad. IEEE single counts as
w = 25 (24 bits and the sign), its ulp then being that of the norm, or of the larger result.

Lengths. Operands and results are words of one binary point, so the norm of a rotation or of (A, B) is at most
2^(w-1/2) ulp, a block's last place at most 2^(w-1-F) ulp, and every other result, and S, at most 2^(w-1) ulp.
A sum y + x z or z + y/x is a word, and so is its addend, so the product or quotient is at most 2^w ulp. A
result with a finer binary point than that has its error in ulp of a word that would hold the norm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from cordicc.arith.kernels.step_errors import NoBoundError
from cordicc.arith.unit.cau import INTEGER_BITS, Cau, implicit_iterations
from cordicc.arith.unit.implicit_bounds import implicit_bound
from cordicc.arith.unit.unit_bounds import (
    LengthBound,
    VectoringBound,
    lightcone_bound,
    rotation_bound,
    vectoring_bound,
)

LAST_ROUNDING_ULP = 0.5
"""Largest error of the rounding of a result to the nearest word.

Not counted: `encode_angle` takes an angle of at most pi (and a quarter ulp), whose nearest word is beyond pi,
to the last word before it.
"""

MOST_FRACTION_BITS = 40
MOST_ANGLE_BITS = 44
"""What a unit may have: every product of the emulation still fits."""

FEWEST_ITERATIONS = 4
FEWEST_ANGLE_BITS = 16

_ANGLE_INTEGER_BITS = 4
"""Of an angle: the sign, and two turns."""


@dataclass(frozen=True, slots=True)
class Size:
    """A sized unit, its proven error in ulp of a word, and the adder bits of its iterations."""

    unit: Cau
    error_ulp: float
    adder_bits: int


def internal_errors_ulp(unit: Cau, operation: str, word_bits: int) -> dict[str, float]:
    """Return the proven error of each result before its last rounding, in ulp of a word.

    An implicit operation has two: `residual`, |B cos t + A sin t - C| in ulp of its operands; and `angle`,
    the residual over the norm (m = -1: over S) in ulp of an angle. Its second result is as ill-conditioned
    as a root, and has no bound in ulp, but that of `ImplicitUnitBound.rest`.

    Raises:
        ValueError: unknown operation, an implicit one on a unit without its rule, or too few fraction bits.
    """
    if operation not in _ERRORS:
        raise ValueError(f"unknown operation {operation!r}")
    return _ERRORS[operation](unit, word_bits)


def error_ulp(unit: Cau, operation: str, word_bits: int) -> float:
    """Return the largest proven error of an operation's results, last rounding included, in ulp of a word.

    Raises as `internal_errors_ulp`.
    """
    return LAST_ROUNDING_ULP + max(internal_errors_ulp(unit, operation, word_bits).values())


def size_unit(
    operations: Sequence[str], word_bits: int, largest_error_ulp: float = 1.0, rule: str | None = None
) -> Size:
    """Return the unit with the fewest adder bits that keeps all results of the operations within an error.

    Adders are those of `adder_bits`.  Of units with as many adder bits, that of the fewest iterations is
    taken, then of the fewest fraction bits.

    Args:
        operations: names in `OPERATIONS`.
        word_bits: of operands and results, w of the module's text.
        largest_error_ulp: allowed, last rounding included.
        rule: the implicit rule, for implicit operations.

    Raises:
        ValueError: no unit keeps the error, or as `internal_errors_ulp`.
    """
    best: Size | None = None
    iterations = FEWEST_ITERATIONS
    while iterations <= MOST_FRACTION_BITS and (
        best is None or _least_bits(iterations, word_bits, rule) < best.adder_bits
    ):
        best = _narrowest(operations, word_bits, largest_error_ulp, rule, iterations, best)
        iterations += 1
    if best is None:
        raise ValueError(
            f"no unit keeps {', '.join(operations)} within {largest_error_ulp:g} ulp of {word_bits} bits"
        )
    return best


def _narrowest(
    operations: Sequence[str],
    word_bits: int,
    allowed_ulp: float,
    rule: str | None,
    iterations: int,
    best: Size | None,
) -> Size | None:
    """Return the best unit with a number of iterations if it has fewer adder bits than `best`, else that."""
    # Shifts by more than all the bits move nothing.
    for fraction_bits in range(max(word_bits, iterations - 2), MOST_FRACTION_BITS + 1):
        widest = Cau(fraction_bits, iterations, rule, word_bits, MOST_ANGLE_BITS)
        if not _error_within(widest, operations, word_bits, allowed_ulp):
            continue
        for angle_bits in range(max(word_bits, FEWEST_ANGLE_BITS), MOST_ANGLE_BITS + 1):
            unit = Cau(fraction_bits, iterations, rule, word_bits, angle_bits)
            if best is not None and adder_bits(unit) >= best.adder_bits:
                break
            error = _error_within(unit, operations, word_bits, allowed_ulp)
            if error is not None:
                best = Size(unit, error, adder_bits(unit))
                break
    return best


def _error_within(unit: Cau, operations: Sequence[str], word_bits: int, allowed_ulp: float) -> float | None:
    """Return the largest error of the operations, None if it is more than allowed or has no bound."""
    largest = 0.0
    for operation in operations:
        try:
            largest = max(largest, error_ulp(unit, operation, word_bits))
        except NoBoundError:
            return None
        if largest > allowed_ulp:
            return None
    return largest


def adder_bits(unit: Cau) -> int:
    """Return the bits of all adders of the iterations.

    A standard iteration has two for coordinates and one for the angle, a single-rotation one compares and
    adds to the target besides.  Root-free ones have four for coordinates, two besides and a quarter of one
    for the angle, whose directions a table knows; with single rotations two fewer; where the target stands
    for y one for x and half of one for its distance.
    """
    coordinate, angle = unit.fraction_bits + INTEGER_BITS, unit.angle_bits + _ANGLE_INTEGER_BITS
    if unit.rule != "root-free":
        return unit.iterations * ((2 if unit.rule is None else 4) * coordinate + angle)
    sequence = implicit_iterations(unit, 1)
    doubles = unit.iterations - sequence.singles
    halves = 12 * doubles + 8 * (sequence.singles - sequence.settled) + 3 * sequence.settled
    return halves * coordinate // 2 + unit.iterations * angle // 4


def _least_bits(iterations: int, word_bits: int, rule: str | None) -> int:
    """Return the adder bits of the narrowest unit with a number of iterations."""
    return adder_bits(Cau(word_bits, iterations, rule, word_bits, max(word_bits, FEWEST_ANGLE_BITS)))


def _length(bound: LengthBound, unit: Cau, word_bits: int, largest: float = 1.0) -> float:
    """Return a length's bound in ulp; `largest` is the largest norm in units of the largest word."""
    full = math.ldexp(1.0, word_bits - 1)
    return bound.error(largest * full, math.ldexp(full, -unit.fraction_bits))


def _angle(radians: float, word_bits: int) -> float:
    return math.ldexp(radians, word_bits - 3)


def _rotated(m: int, largest: float) -> Callable[[Cau, int], dict[str, float]]:
    return lambda unit, bits: {"vector": _length(rotation_bound(unit, m), unit, bits, largest)}


def _measured(bound: Callable[[Cau], VectoringBound]) -> Callable[[Cau, int], dict[str, float]]:
    def errors(unit: Cau, bits: int) -> dict[str, float]:
        both = bound(unit)
        return {"norm": _length(both.norm, unit, bits), "angle": _angle(both.angle, bits)}

    return errors


def _divided(unit: Cau, bits: int) -> dict[str, float]:
    return {"quotient": math.ldexp(vectoring_bound(unit, 0).angle, bits)}


def _solved(m: int, largest: float) -> Callable[[Cau, int], dict[str, float]]:
    def errors(unit: Cau, bits: int) -> dict[str, float]:
        residual = implicit_bound(unit, m).residual
        relative = residual.error(1.0, math.ldexp(1.0, 1 - unit.fraction_bits))
        return {"residual": _length(residual, unit, bits, largest), "angle": _angle(relative, bits)}

    return errors


_ERRORS: Mapping[str, Callable[[Cau, int], dict[str, float]]] = {
    "rotate-circular": _rotated(1, math.sqrt(2)),
    "rotate-linear": _rotated(0, 2.0),
    "rotate-hyperbolic": _rotated(-1, 1.0),
    "vector-circular": _measured(lambda unit: vectoring_bound(unit, 1)),
    "vector-linear": _divided,
    "vector-hyperbolic": _measured(lambda unit: vectoring_bound(unit, -1)),
    "lightcone": _measured(lightcone_bound),
    "implicit-circular": _solved(1, math.sqrt(2)),
    "implicit-hyperbolic": _solved(-1, 1.0),
}

OPERATIONS = tuple(_ERRORS)
"""Operations that a unit performs, named as the functions of a target's units."""
