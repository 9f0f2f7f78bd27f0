"""The circuits of adders and sign logic: exact in integers, rounded once to the word of the result."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import greater, within
from cordicc.arith.circuits.uses import NoCircuitError
from cordicc.arith.circuits.words import WordResult
from cordicc.arith.kernels.shift_sequences import pi_fixed, turn_fixed
from cordicc.arith.numbers.fixed_point import SHIFT_LIMIT, WIDTHS, FixedPoint
from cordicc.arith.numbers.fixed_system import WRAP_GUARD_BITS, wraps_in_int64
from cordicc.arith.numbers.slack import slack_of

_MOST_TURNS = 32
"""Turns of an angle that are counted by comparisons."""


class ExactNumber(NamedTuple):
    """An integer that stands for mantissa * 2^-fraction; of a word its width."""

    mantissa: CircuitSignal
    fraction: int
    width: int = 0


def calculated(
    b: CircuitBuilder, op: str, params: Mapping[str, Any], numbers: Sequence[ExactNumber], result: FixedPoint
) -> WordResult:
    """Return an operation's result as a word; `valid` tells of it alone, not of the operands.

    Args:
        b: the builder.
        op: the operation, but for products.
        params: its parameters, and a slack perhaps.
        numbers: its operands.
        result: the format of the result.

    Raises:
        NoCircuitError: an angle of more turns than are counted.
    """
    first = numbers[0]
    valid: CircuitSignal = b.of(1)
    match op:
        case "wrap":
            return _kept_within_pi(b, _wrapped(b, first), result)
        case "shift":
            number = ExactNumber(first.mantissa, first.fraction - int(params["exponent"]))
        case "sign":
            negative = b.negative(first.mantissa)
            number = ExactNumber(b.mux(first.mantissa.equals(0), b.mux(negative, 1, -1), 0), 0)
        case _:
            number, valid = _exact(b, op, params, numbers)
    made = rounded(b, number, result)
    return WordResult(made.word, made.valid & valid)


def rounded(b: CircuitBuilder, number: ExactNumber, format_: FixedPoint) -> WordResult:
    """Return a number rounded to a word, valid if the format holds it."""
    down = number.fraction - format_.fraction_bits
    mantissa = number.mantissa
    if down <= 0:
        word = mantissa << -down
    elif format_.rounding == "half-up":
        word = b.rounded(mantissa, down)
    elif format_.rounding == "floor":
        word = mantissa >> down
    else:
        # Half of the last place, less one unit of what is cut, and that unit where the word would be odd.
        word = b.addc(mantissa, (1 << (down - 1)) - 1, b.bit(mantissa, down)) >> down
    largest = format_.largest_word
    inside = within(b, word, largest)
    return WordResult(b.narrowed(word, -largest, largest, loose=not (inside.lo == inside.hi == 1)), inside)


def _kept_within_pi(b: CircuitBuilder, number: ExactNumber, format_: FixedPoint) -> WordResult:
    result = rounded(b, number, format_)
    if format_.width_bits - format_.fraction_bits < 3:
        return result
    largest = math.floor(math.ldexp(math.pi, format_.fraction_bits))
    # What is compared with pi is the nearest double; between two of them nothing else is as near.
    most = _largest_at_most(math.pi + format_.ulp / 4, number.fraction)
    near = (number.mantissa <= most) & (number.mantissa >= -most)
    word = b.mux(near & (result.word > largest), result.word, largest)
    word = b.mux(near & (word < -largest), word, -largest)
    return WordResult(word, result.valid)


def _largest_at_most(limit: float, fraction: int) -> int:
    """Return the largest integer m whose m 2^-fraction, as the nearest double, is at most a limit."""
    low = math.floor(Fraction(limit) * Fraction(2) ** fraction)
    high = low + (1 << max(0, low.bit_length() - 52))
    while low + 1 < high:
        middle = (low + high) // 2
        if math.ldexp(float(middle), -fraction) <= limit:
            low = middle
        else:
            high = middle
    return low


def _exact(
    b: CircuitBuilder, op: str, params: Mapping[str, Any], numbers: Sequence[ExactNumber]
) -> tuple[ExactNumber, CircuitSignal]:
    fraction = max(number.fraction for number in numbers)
    aligned = [number.mantissa << (fraction - number.fraction) for number in numbers]
    first = aligned[0]
    valid: CircuitSignal = b.of(1)
    match op:
        case "add":
            made = first + aligned[1]
        case "sub":
            made = first - aligned[1]
        case "neg":
            made = -first
        case "abs":
            made = b.size(first)
        case "max":
            made = greater(b, first, aligned[1])
        case "min":
            made = b.mux(first < aligned[1], aligned[1], first)
        case "flip":
            made = b.negif(first, b.negative(aligned[1]))
        case "select":
            made = b.mux(b.negative(first), aligned[1], aligned[2])
        case "guard":
            made, valid = first, _condition(b, params, aligned[1], fraction)
        case _:
            raise NoCircuitError(f"operation {op!r}")
    return ExactNumber(made, fraction), valid


def _condition(
    b: CircuitBuilder, params: Mapping[str, Any], number: CircuitSignal, fraction: int
) -> CircuitSignal:
    slack = math.floor(Fraction(slack_of(params).beyond) * Fraction(2) ** fraction)
    match params["condition"]:
        case "nonzero":
            return ~number.equals(0)
        case "nonnegative":
            return number >= -min(slack, 1 << SHIFT_LIMIT)
        case "positive":
            return number > 0
        case _:
            return b.of(1)


def _wrapped(b: CircuitBuilder, angle: ExactNumber) -> ExactNumber:
    """Return an angle modulo 2 pi, as `fixed_system._wrapped` does."""
    if angle.fraction >= WIDTHS.stop - 2:
        return angle
    mantissa, fraction, guard = angle.mantissa, angle.fraction, WRAP_GUARD_BITS
    quotient_bits = WIDTHS.stop - 1
    if not wraps_in_int64(angle.width, fraction):
        mantissa = mantissa << max(0, -fraction)
        guard = WIDTHS.stop + max(0, angle.width - fraction)
        fraction = max(0, fraction)
        quotient_bits = guard
    # The number of turns is (m q + 2^(s-1)) >> s: at least n where m is at least the threshold of n.
    quotient, down = turn_fixed(0, quotient_bits), fraction + quotient_bits
    half = 1 << (down - 1)
    most = max(abs((end * quotient + half) >> down) for end in (mantissa.lo, mantissa.hi))
    if most > _MOST_TURNS:
        raise NoCircuitError("wrapping of an angle of many turns")
    turn = pi_fixed(fraction + guard + 1)
    count: CircuitSignal = b.of(0)
    for number in range(1, most + 1):
        above = -((half - (number << down)) // quotient)
        below = ((-number + 1 << down) - half - 1) // quotient
        count = count + (mantissa >= above) - (mantissa <= below)
    count = b.narrowed(count, -most, most)
    whole = b.pick(count + most, [number * turn for number in range(-most, most + 1)])
    return ExactNumber((mantissa << guard) - whole, fraction + guard)
