"""What surrounds the iterations of an implicit unit for B cosh t + A sinh t = C."""

from __future__ import annotations

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.circular_solving import Begun, Last, Solved, Start
from cordicc.arith.circuits.hyperbolic import ln2_multiple, sum_and_difference
from cordicc.arith.circuits.limits import clipped, greater
from cordicc.arith.circuits.near_end import NearColumns
from cordicc.arith.circuits.scaled import Floating, normalised
from cordicc.arith.circuits.shifting import shifted
from cordicc.arith.circuits.uses import Modes, Word
from cordicc.arith.circuits.words import block
from cordicc.arith.kernels.blocks import ZERO_EXPONENT
from cordicc.arith.unit.cau import Cau, implicit_table
from cordicc.arith.unit.implicit import GUARD_BITS, LOG_BITS


def hyperbolic(b: CircuitBuilder, modes: Modes, unit: Cau, words: tuple[Word, ...]) -> Begun:
    """Return what stands around the iterations, as in `unit.implicit`."""
    A, B, C = words
    bits = unit.fraction_bits
    tables = {n: implicit_table(unit, -1, use.slack) for n, use in enumerate(modes.uses) if use.m == -1}
    reaches = {n: table.reach for n, table in tables.items()}
    vertex = block(b, (B, C), bits)
    known = NearColumns.of(modes, reaches, vertex.exponent - bits)
    flipped = b.negative(C.bits)
    a, d, c = (Word(b.negif(each.bits, flipped), each.fraction) for each in (A, B, C))
    target = normalised(b, c.bits, -c.fraction, unit.operand_bits)
    p, q = sum_and_difference(b, modes, unit, d, a)  # twice p and q of `unit.implicit.hyperbolic`
    short = b.size(vertex.mantissas[0]) - b.size(vertex.mantissas[1])
    positive, other = p.mantissa > 0, q.mantissa > 0
    both = positive & other
    minus = modes.which(lambda use: use.branch == "-")
    mirrored = b.named("mirrored", ~positive | (minus & other))
    possible = b.mux(mirrored, positive, other)
    possible = possible & ~(both & modes.which(lambda use: use.branch == "none"))
    p, q = (
        Floating(b.mux(mirrored, x.mantissa, y.mantissa), b.mux(mirrored, x.exponent, y.exponent))
        for x, y in ((p, q), (q, p))
    )
    doublings = b.named("doublings", _estimate(b, p, q, target))
    vector = _vector_of(
        b,
        unit,
        Floating(p.mantissa, p.exponent + doublings),
        Floating(q.mantissa, q.exponent - doublings),
        Floating(target.mantissa, target.exponent + 1),
    )
    x, y, goal, exponent = vector
    near = NearColumns.of(modes, reaches, exponent - 1)
    no_a = A.bits.equals(0)
    height, width = near.limits(b.size(goal), -1, bits)
    start = Start(x, y, goal, b.of(0), both & ~no_a)
    alone = both & no_a
    at_end = b.named("at_vertex", alone & (short <= known.slack) & (-short <= known.within))
    there = short <= known.slack
    none = c.bits.equals(0) & q.mantissa.equals(0)

    def finish(last: Last) -> Solved:
        angle = b.negif(last.z + ln2_multiple(b, doublings, unit), mirrored)
        reached = (-last.gap <= near.short) & (last.gap <= near.beyond) & ~last.lost
        solved = possible & b.mux(alone, reached, there) & ~none
        rest = b.narrowed(b.mux(at_end | b.negative(last.x), last.x, 0), 0, last.x.hi)
        return Solved(angle, at_end, rest, exponent - 1, solved)

    return Begun(start, height, width, max(near.short.hi, near.beyond.hi), finish)


def _estimate(b: CircuitBuilder, p: Floating, q: Floating, c: Floating) -> CircuitSignal:
    """Return log2 of N/(2p) to the nearest integer, within 0.8 more."""
    log_p, log_q, log_c = (_log2(b, each) for each in (p, q, c))
    log_n = greater(b, log_c, (log_p + log_q) >> 1)
    middle = 5 << (LOG_BITS - 3)
    log_e = log_n - log_p + (middle + (1 << (LOG_BITS - 1)))
    return clipped(b, log_e >> LOG_BITS, -1024, 1024)


def _log2(b: CircuitBuilder, number: Floating) -> CircuitSignal:
    """Return log2 |number| with `LOG_BITS`, from the leading bits."""
    top = normalised(b, b.size(number.mantissa), number.exponent, LOG_BITS + 1)
    exponent = b.mux(number.mantissa.equals(0), top.exponent, ZERO_EXPONENT)
    return ((exponent + LOG_BITS) << LOG_BITS) + top.mantissa - (1 << LOG_BITS)


def _vector_of(
    b: CircuitBuilder, unit: Cau, p: Floating, q: Floating, c: Floating
) -> tuple[CircuitSignal, CircuitSignal, CircuitSignal, CircuitSignal]:
    """Return (p - q, p + q, c) as a block below 1 with the unit's fraction bits, and its exponent."""
    bits = unit.fraction_bits
    least = min(p.exponent.lo + bits, q.exponent.lo + bits, c.exponent.lo + unit.operand_bits)
    sizes = [
        b.mux(each.mantissa.equals(0), each.exponent + own, least)
        for each, own in ((p, bits), (q, bits), (c, unit.operand_bits))
    ]
    largest = greater(b, greater(b, sizes[0], sizes[1]), sizes[2])
    wide = largest - (bits + GUARD_BITS)
    moved = []
    for each, own in ((p, bits), (q, bits), (c, unit.operand_bits)):
        right = wide - each.exponent
        # None is longer than the largest, but for zeros.
        right = b.narrowed(b.mux(each.mantissa.equals(0), right, 0), own - bits - GUARD_BITS, right.hi)
        limit = 1 << (bits + GUARD_BITS)
        moved.append(b.narrowed(shifted(b, each.mantissa, right, each.mantissa.width + 1), -limit, limit))
    first, second, target = moved
    x, y = first - second, first + second
    size = greater(b, greater(b, b.size(x), b.size(y)), b.size(target))
    over = size > 1 << (bits + GUARD_BITS)
    x, y, target = (
        b.mux(over, b.rounded(each, GUARD_BITS), b.rounded(each, GUARD_BITS + 1)) for each in (x, y, target)
    )
    return x, y, target, wide + GUARD_BITS + over
