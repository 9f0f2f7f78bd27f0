"""What surrounds the iterations of an implicit unit for B cos t + A sin t = C."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import clipped
from cordicc.arith.circuits.near_end import NearColumns
from cordicc.arith.circuits.uses import Modes, Word
from cordicc.arith.circuits.words import block
from cordicc.arith.kernels.shift_sequences import pi_fixed
from cordicc.arith.unit.cau import Cau, implicit_table


class Start(NamedTuple):
    """What the iterations begin with: the vector, the target, the angle, and thresholds of the end of reach.

    `may_end` tells whether they apply; `short` is how far y may end from a target that it reaches.
    """

    x: CircuitSignal
    y: CircuitSignal
    target: CircuitSignal
    z: CircuitSignal
    height: CircuitSignal
    width: CircuitSignal
    may_end: CircuitSignal
    short: CircuitSignal


class Solved(NamedTuple):
    """The angle with the unit's angle bits, the second result with places of 2^place, before the gain."""

    angle: CircuitSignal
    rest: CircuitSignal
    place: CircuitSignal
    possible: CircuitSignal


Begun = tuple[Start, Callable[[Start], Solved]]


def circular(b: CircuitBuilder, modes: Modes, unit: Cau, words: tuple[Word, ...]) -> Begun:
    """Return what the iterations begin with, and what makes results of their end, as in `unit.implicit`."""
    A, B = words[0].bits, words[1].bits
    plus = modes.which(lambda use: use.branch == "+")
    tables = {n: implicit_table(unit, 1, use.slack) for n, use in enumerate(modes.uses) if use.m == 1}
    half_turn = pi_fixed(unit.angle_bits)
    quarter = (half_turn + 1) >> 1
    joined = block(b, words, unit.fraction_bits)
    place = joined.exponent - unit.fraction_bits
    no_a, no_b = A.equals(0), B.equals(0)
    alone, none = no_a | no_b, no_a & no_b
    one_sign = no_a & (B > 0)
    negated = b.named("negated", b.mux(plus, b.negative(A), (A > 0) | (no_a & b.negative(B))))
    near = NearColumns.of(modes, {n: table.reach for n, table in tables.items()}, place)
    x, y, target = joined.mantissas
    # The start is turned to x >= 0; branch "+" is the mirror image.
    x = b.narrowed(b.negif(x, negated ^ plus), 0, x.hi)
    y = b.negif(y, negated)
    z = b.mux(negated, 0, -half_turn)
    size = b.size(target)
    excess = size - x - b.size(y)
    at_end = b.named("at_end", alone & (excess <= near.slack) & (-excess <= near.within))
    beyond = excess > near.slack
    across = b.mux(no_a, quarter, b.mux(b.negative(y) ^ b.negative(target), 0, half_turn))
    # Of a target that is not negative the sign is +1, of 0 too.
    end = z + b.negif(across, b.negative(target))
    width = near.width(size, unit.fraction_bits)
    if next(iter(tables.values())).quarter_turns:
        up = b.negative(y) & ~b.negative(target)
        back = ~b.negative(y) & b.negative(target)
        flat = b.mux(back, b.mux(up, x, -y), y)
        y = b.mux(back, b.mux(up, y, x), -x)
        x = b.narrowed(flat, 0, flat.hi)
        z = b.mux(back, b.mux(up, z, z + quarter), z - quarter)
    start = Start(x, y, target, z, near.column("height"), width, ~alone, near.short)

    def finish(last: Start) -> Solved:
        unreached = b.size(last.target) - b.size(last.y) > near.short
        possible = b.named("solved", ~b.mux(alone, unreached, beyond) & ~none)
        angle = b.mux(at_end, last.z, end)
        angle = clipped(
            b, angle, b.mux(one_sign, -2 * half_turn, -half_turn), b.mux(one_sign, 2 * half_turn, 0)
        )
        rest = b.narrowed(b.mux(at_end | b.negative(last.x), last.x, 0), 0, last.x.hi)
        return Solved(b.negif(angle, plus), rest, place, possible)

    return start, finish
