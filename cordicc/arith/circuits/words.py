"""Blocks of circuits: words of fixed point into the numbers inside a unit, and back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from cordicc.arith.circuits.builder import Builder, Operand, Signal
from cordicc.arith.circuits.shifting import greater, length_of, shifted
from cordicc.arith.numbers.fixed_point import FixedPoint


class Word(NamedTuple):
    """A word as it enters a unit: two's complement with a binary point."""

    bits: Signal
    fraction: int


class Block(NamedTuple):
    """Mantissas of numbers under a common exponent: mantissa * 2^(exponent - bits)."""

    mantissas: tuple[Signal, ...]
    exponent: Signal


class Result(NamedTuple):
    """A word that leaves a unit, and whether it stands for a number."""

    word: Signal
    valid: Signal


def block(b: Builder, words: Sequence[Word], bits: int) -> Block:
    """Bring words to one exponent, the largest with `bits` bits; of zeros alone the exponent is the least."""
    sizes = [b.size(word.bits) for word in words]
    finest = max(word.fraction for word in words)
    if len({word.fraction for word in words}) == 1:
        every = sizes[0]
        for size in sizes[1:]:
            every = every | size
        exponent = length_of(b, every) - finest
    else:
        least = -finest
        ends = [
            b.mux(word.bits.equals(0), length_of(b, size) - word.fraction, least)
            for word, size in zip(words, sizes, strict=True)
        ]
        exponent = ends[0]
        for end in ends[1:]:
            exponent = greater(b, exponent, end)
    b.step()
    made = []
    for word in words:
        moved = shifted(b, word.bits, exponent + (word.fraction - bits), word.bits.width + 1)
        made.append(b.narrowed(moved, -(1 << bits), 1 << bits))
    return Block(tuple(made), exponent)


def at_fraction(b: Builder, word: Word, fraction: int) -> Signal:
    """Return a word with another number of fraction bits, rounded half up."""
    return b.rounded(word.bits, word.fraction - fraction)


def encoded(b: Builder, mantissa: Signal, exponent: Operand, format_: FixedPoint) -> Result:
    """Return mantissa * 2^exponent rounded to a word of a format, valid if the format holds it."""
    right = b.of(-exponent - format_.fraction_bits if isinstance(exponent, int) else -(exponent + format_.fraction_bits))
    lift = max(0, -right.lo)
    wide, right = mantissa << lift, right + lift
    most = wide.width + 1
    if right.hi > most:
        right = b.narrowed(b.mux(right > most, right, most), right.lo, most)
    largest = format_.largest_word
    match format_.rounding:
        case "half-up":
            word = b.rounded(wide, right.lo) if right.lo == right.hi else b.roundedv(wide, right)
        case "floor":
            word = b.shr(wide, right.lo) if right.lo == right.hi else b.shrv(wide, right)
        case _:
            raise NotImplementedError(format_.rounding)
    inside = (word <= largest) & (word >= -largest)
    return Result(b.narrowed(b.mux(inside, 0, word), -largest, largest), inside)


def encoded_angle(b: Builder, angle: Signal, fraction: int, format_: FixedPoint) -> Result:
    """Return an angle with some fraction bits as `encoded` does, one of at most pi as a word of at most pi."""
    result = encoded(b, angle, -fraction, format_)
    if format_.width_bits - format_.fraction_bits < 3:
        return result
    largest = math.floor(math.ldexp(math.pi, format_.fraction_bits))
    still = math.floor(Fraction(math.pi + format_.ulp / 4) * 2**fraction)
    near = (angle <= still) & (angle >= -still)
    word = result.word
    word = b.mux(near & (word > largest), word, largest)
    word = b.mux(near & (word < -largest), word, -largest)
    return Result(word, result.valid)
