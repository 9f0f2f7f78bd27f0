"""Blocks of circuits: words of fixed point into the numbers inside a unit, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal, Operand
from cordicc.arith.circuits.limits import greater, limited, within
from cordicc.arith.circuits.shifting import length_of, shifted, shlv, shrv
from cordicc.arith.circuits.uses import Format, Word


class Block(NamedTuple):
    """Mantissas of numbers under a common exponent: mantissa * 2^(exponent - bits); and their sizes."""

    mantissas: tuple[CircuitSignal, ...]
    sizes: tuple[CircuitSignal, ...]
    exponent: CircuitSignal


class WordResult(NamedTuple):
    """A word that leaves a unit, and whether it stands for a number."""

    word: CircuitSignal
    valid: CircuitSignal


def block(b: CircuitBuilder, words: Sequence[Word], bits: int) -> Block:
    """Bring words to one exponent, the largest with `bits` bits; that of zeros is the least."""
    sizes = [b.size(word.bits) for word in words]
    if len({word.fraction.number for word in words}) == 1:
        every = sizes[0]
        for size in sizes[1:]:
            every = every | size
        exponent = length_of(b, every) - words[0].fraction
    else:
        least = min(-word.fraction.hi for word in words)
        ends = [
            b.mux(word.bits.equals(0), length_of(b, size) - word.fraction, least)
            for word, size in zip(words, sizes, strict=True)
        ]
        exponent = ends[0]
        for end in ends[1:]:
            exponent = greater(b, exponent, end)
    exponent = b.named("exponent", exponent)
    made, magnitudes = [], []
    for word, size in zip(words, sizes, strict=True):
        # Nothing of it is left below the last place, and no number is longer than its word.
        right = exponent + word.fraction - bits
        right = b.narrowed(right, -bits, right.hi, loose=True)  # of zeros alone it is less, and all the same
        most = word.bits.width + 1
        made.append(shifted(b, word.bits, right, most, (-(1 << bits), 1 << bits)))
        # Where nothing is rounded the size has the same shift.
        exact = right.hi <= 0
        magnitudes.append(shifted(b, size, right, most, (0, 1 << bits)) if exact else b.size(made[-1]))
    return Block(tuple(made), tuple(magnitudes), exponent)


def at_fraction(b: CircuitBuilder, word: Word, fraction: int) -> CircuitSignal:
    """Return a word with another number of fraction bits, rounded half up."""
    return shifted(b, word.bits, word.fraction - fraction, word.bits.width + 1)


def encoded(b: CircuitBuilder, mantissa: CircuitSignal, exponent: Operand, format_: Format) -> WordResult:
    """Return mantissa * 2^exponent rounded to a word of a format, valid if the format holds it."""
    right = -(format_.fraction + exponent)
    match format_.rounding:
        case "half-up":
            word = shifted(b, mantissa, right, mantissa.width + 1)
        case "floor":
            lift = max(0, -right.lo)
            word = shrv(b, mantissa << lift, limited(b, right + lift, mantissa.width + lift + 1))
        case _:
            word = _to_even(b, mantissa, right)
    inside = within(b, word, format_.largest)
    return WordResult(b.narrowed(word, -format_.largest.hi, format_.largest.hi, loose=True), inside)


def _to_even(b: CircuitBuilder, mantissa: CircuitSignal, right: CircuitSignal) -> CircuitSignal:
    """Return mantissa / 2^right rounded to nearest, ties to even."""
    lift = max(0, -right.lo) + 1
    wide = mantissa << lift
    count = limited(b, right + (lift - 1), wide.width + 1)
    # One bit is kept below the last place, and whether anything was cut.
    kept = shrv(b, wide, count)
    cut = ~shlv(b, kept, count).equals(wide)
    half, odd = b.low(kept, 1), b.bit(kept, 1)
    return (kept >> 1) + (half & (cut | odd))


def encoded_angle(
    b: CircuitBuilder, mantissa: CircuitSignal, exponent: Operand, format_: Format, angle_bits: int
) -> WordResult:
    """Return what `encoded` does, but an angle of at most pi, with angle bits, as a word of at most pi."""
    result = encoded(b, mantissa, exponent, format_)
    if format_.still.hi < 0:
        return result
    near = (mantissa <= format_.still) & (mantissa >= -format_.still)
    near = near & b.of(exponent).equals(-angle_bits)
    above, below = result.word > format_.pi, result.word < -format_.pi
    word = b.mux(near & above, b.mux(near & below, result.word, -format_.pi), format_.pi)
    return WordResult(word, result.valid)
