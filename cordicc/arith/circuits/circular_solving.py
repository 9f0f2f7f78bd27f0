"""What surrounds the iterations of an implicit unit for B cos t + A sin t = C."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.near_end import Limit, NearColumns
from cordicc.arith.circuits.uses import Modes, Word
from cordicc.arith.circuits.words import block
from cordicc.arith.kernels.shift_sequences import pi_fixed
from cordicc.arith.unit.cau import Cau, implicit_table


class Start(NamedTuple):
    """What the iterations begin with: the vector, the target and the angle.

    `may_end` tells whether there is an end of reach to turn to.
    """

    x: CircuitSignal
    y: CircuitSignal
    target: CircuitSignal
    z: CircuitSignal
    may_end: CircuitSignal


class Last(NamedTuple):
    """What the iterations end with: `gap` is the target less y, anything where y is `lost` from it."""

    x: CircuitSignal
    gap: CircuitSignal
    z: CircuitSignal
    lost: CircuitSignal


class Solved(NamedTuple):
    """The angle with the unit's angle bits, the second result with places of 2^place, before the gain.

    The angle is 0 where `zero` says so.
    """

    angle: CircuitSignal
    zero: CircuitSignal
    rest: CircuitSignal
    place: CircuitSignal
    possible: CircuitSignal


class Begun(NamedTuple):
    """What the iterations begin with, and what makes results of their end.

    `height` and `width` are the thresholds of the end of reach; `largest_gap` that of what is solved.
    """

    start: Start
    height: Limit
    width: Limit
    largest_gap: int
    finish: Callable[[Last], Solved]


def circular(b: CircuitBuilder, modes: Modes, unit: Cau, words: tuple[Word, ...]) -> Begun:
    """Return what stands around the iterations, as in `unit.implicit`."""
    A, B = words[0].bits, words[1].bits
    plus = modes.which(lambda use: use.branch == "+")
    tables = {n: implicit_table(unit, 1, use.slack) for n, use in enumerate(modes.uses) if use.m == 1}
    half_turn = pi_fixed(unit.angle_bits)
    quarter = (half_turn + 1) >> 1
    joined = block(b, words, unit.fraction_bits)
    place = joined.exponent - unit.fraction_bits
    no_a, no_b = A.equals(0), B.equals(0)
    alone, none = no_a | no_b, no_a & no_b
    one_sign = no_a & ~b.negative(B)  # of B = 0 there is no solution anyway
    positive = b.mux(no_a, ~b.negative(A), b.negative(B))
    negated = b.named("negated", b.mux(plus, b.negative(A), positive))
    near = NearColumns.of(modes, {n: table.reach for n, table in tables.items()}, place)
    # The start is turned to x >= 0, branch "+" is the mirror image; so is a target below 0.
    x, size, target = joined.sizes
    down = b.named("down", b.negative(words[2].bits))
    opposite = b.named("opposite", b.negative(B) ^ negated ^ down)
    y = b.negif(size, opposite)
    excess = target - (x | size)  # of A or B alone
    beyond = excess > near.slack
    at_end = b.named("at_end", alone & ~beyond & (excess >= -near.within))
    height, width = near.limits(target, 1, unit.fraction_bits)
    z = b.of(0)
    if next(iter(tables.values())).quarter_turns:
        x, y = b.mux(opposite, x, -y), b.mux(opposite, y, x)
        x, z = b.narrowed(x, 0, x.hi), b.mux(opposite, 0, quarter)
    start = Start(x, y, target, z, ~alone)

    def finish(last: Last) -> Solved:
        solved = (last.gap <= near.short) & ~last.lost
        possible = b.named("solved", ~b.mux(alone, ~solved, beyond) & ~none)
        # Flags wait, not the angles that they stand for.
        kept = b.together((last.z, negated, no_a, opposite, one_sign), 0.0)
        turned, negated_, no_a_, opposite_, one_sign_ = kept
        end = b.mux(no_a_, quarter, b.mux(opposite_, 0, half_turn))
        # The angle is from -pi to 0 for A = 0 < B, else at least -2 pi; for branch "+" it is the negative.
        beneath = down & (one_sign_ | negated_) & (turned > half_turn)
        turned = b.mux(beneath, b.mux(at_end, turned, end), half_turn)
        first = b.mux(negated_, 0, b.mux(plus, -half_turn, half_turn))
        angle = b.addsub(first, turned, down ^ plus)
        above = one_sign_ & ~(b.negative(angle) ^ plus)
        rest = b.narrowed(b.mux(at_end | b.negative(last.x), last.x, 0), 0, last.x.hi)
        return Solved(angle, above, rest, place, possible)

    return Begun(start, height, width, near.short.hi, finish)
