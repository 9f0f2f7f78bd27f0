"""Products and quotients around the iterations of a standard unit."""

from __future__ import annotations

from cordicc.arith.circuits.builder import CircuitBuilder
from cordicc.arith.circuits.scaled import Floating, added, normalised, widened
from cordicc.arith.circuits.uses import (
    Coordinates,
    Modes,
    Raw,
    Raws,
    Turned,
    UnitFunction,
    Wanted,
    Word,
    no_coordinates,
)
from cordicc.arith.kernels.blocks import WIDE_BITS
from cordicc.arith.unit.cau import Cau

Words = tuple[Word, ...]


def rotation(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what y + x z begins with, and what makes results of its end."""
    x, y, z = (normalised(b, word.bits, -word.fraction, unit.operand_bits) for word in words)
    bits = unit.fraction_bits + 1
    start = Turned(
        x.mantissa << (bits - unit.operand_bits), b.of(0), z.mantissa << (unit.angle_bits - unit.operand_bits)
    )
    zero = words[0].bits.equals(0) | words[2].bits.equals(0)

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        first = Raw(words[0].bits, -words[0].fraction, b.of(1)) if wanted[0] else None
        if not wanted[1]:
            return first, None
        product = Floating(b.mux(zero, last.y, 0), x.exponent + z.exponent + (2 * unit.operand_bits - bits))
        total = _sum(b, unit, product, bits, y)
        return first, Raw(total.mantissa, total.exponent, b.of(1))

    return UnitFunction(start, no_coordinates, finish)


def vectoring(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what y/x begins with, and what makes results of its end."""
    x, y, z = (normalised(b, word.bits, -word.fraction, unit.operand_bits) for word in words)
    bits = unit.fraction_bits + 1
    lift = bits - unit.operand_bits
    start = Turned(b.size(x.mantissa) << lift, y.mantissa << lift, b.of(0))
    none, zero, left = words[0].bits.equals(0), words[1].bits.equals(0), b.negative(words[0].bits)

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        first = Raw(words[0].bits, -words[0].fraction, b.of(1)) if wanted[0] else None
        if not wanted[1]:
            return first, None
        minus = left ^ modes.which(lambda use: use.sign < 0)
        quotient = b.mux(zero, b.negif(last.z, minus), 0)
        exponent = y.exponent - x.exponent - unit.angle_bits
        total = _sum(b, unit, Floating(quotient, exponent), unit.angle_bits + 2, z)
        return first, Raw(total.mantissa, total.exponent, ~none)

    return UnitFunction(start, no_coordinates, finish)


def _sum(b: CircuitBuilder, unit: Cau, result: Floating, bits: int, addend: Floating) -> Floating:
    """Return a result of `bits` bits plus an operand, as `Cau` does."""
    if addend.mantissa.lo == addend.mantissa.hi == 0:
        return result
    room = WIDE_BITS - 2
    return added(b, widened(result, room - bits), widened(addend, room - unit.operand_bits))
