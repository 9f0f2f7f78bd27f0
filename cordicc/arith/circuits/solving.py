"""The circuit of an implicit unit: B cos t + A sin t = C solved by turning (A, B) until y = C."""

from __future__ import annotations

from typing import NamedTuple

from cordicc.arith.circuits.builder import Builder, Signal
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.uses import Modes, NoCircuitError, Use, format_of, word
from cordicc.arith.circuits.words import Result, block, encoded, encoded_angle
from cordicc.arith.kernels.end_of_reach import ROOT_SCALE, ROOTS, SIXTEENTHS
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, SHARES, StepTable, pi_fixed
from cordicc.arith.unit.cau import Cau, implicit_table
from cordicc.arith.unit.reach import ReachTable


def implicit_unit(
    b: Builder, unit: Cau, uses: tuple[Use, ...], operands: tuple[Signal, ...], mode: Signal, *, scale: int = 3
) -> tuple[Result | None, Result | None]:
    """Return t and sqrt(A^2 + B^2 - C^2) as words.

    Args:
        b: the builder.
        unit: the sizes of the unit, and its rule.
        uses: what it is used for.
        operands: the words A, B and C.
        mode: the number of the use.
        scale: registers in the product with the reciprocal gain.

    Raises:
        NoCircuitError: a use has none.
    """
    if any(use.m != 1 for use in uses):
        raise NoCircuitError(f"a {next(use.function for use in uses if use.m != 1)} operation")
    modes = Modes(b, mode, uses)
    words = tuple(word(modes, bits, number) for number, bits in enumerate(operands))
    A, B = words[0].bits, words[1].bits
    plus = modes.which(lambda use: use.branch == "+")
    tables = [implicit_table(unit, 1, use.slack) for use in uses]
    steps = tables[0].steps
    half_turn = pi_fixed(unit.angle_bits)
    quarter = (half_turn + 1) >> 1
    joined = block(b, words, unit.fraction_bits)
    no_a, no_b = A.equals(0), B.equals(0)
    alone, none = no_a | no_b, no_a & no_b
    one_sign = no_a & (B > 0)
    negated = b.named("negated", b.mux(plus, b.negative(A), (A > 0) | (no_a & b.negative(B))))
    b.step()
    near = _Near.of(modes, [table.reach for table in tables], joined.exponent - unit.fraction_bits)
    x, y, target = joined.mantissas
    # The start is turned to x >= 0; branch "+" is the mirror image.
    x = b.narrowed(b.negif(x, negated ^ plus), 0, x.hi)
    y = b.negif(y, negated)
    z = b.mux(negated, 0, -half_turn)
    size = b.size(target)
    excess = size - x - b.size(y)
    at_end = alone & (excess <= near.slack) & (-excess <= near.within)
    beyond = excess > near.slack
    across = b.mux(no_a, quarter, b.mux(b.negative(y) ^ b.negative(target), 0, half_turn))
    # Of a target that is not negative the sign is +1, of 0 too.
    across = b.negif(across, b.negative(target))
    end = z + across
    width = near.width(size, unit.fraction_bits)
    b.step()
    if tables[0].quarter_turns:
        up = b.negative(y) & ~b.negative(target)
        back = ~b.negative(y) & b.negative(target)
        flat = b.mux(back, b.mux(up, x, -y), y)
        y = b.mux(back, b.mux(up, y, x), -x)
        x = b.narrowed(flat, 0, flat.hi)
        z = b.mux(back, b.mux(up, z, z + quarter), z - quarter)
        b.step()
    x, y, target, z = _steps(b, _State(x, y, target, z), steps, unit, near, width, ~alone)
    unreached = b.size(target) - b.size(y) > near.short
    solved = b.named("solved", ~b.mux(alone, unreached, beyond) & ~none)
    formats = [format_of(modes, number, unit.angle_bits) for number in range(2)]
    results: list[Result | None] = [None, None]
    begin = b.now
    if formats[0] is not None:
        z = b.mux(at_end, z, end)
        z = b.clipped(z, b.mux(one_sign, -2 * half_turn, -half_turn), b.mux(one_sign, 2 * half_turn, 0))
        b.step()
        found = encoded_angle(b, b.negif(z, plus), -unit.angle_bits, formats[0], unit.angle_bits)
        results[0] = Result(found.word, found.valid & solved)
    finish, b.now = b.now, begin
    if formats[1] is not None:
        root = b.narrowed(b.mux(at_end | b.negative(x), x, 0), 0, x.hi)
        product = times(b, root, steps.inverse_gain, scale)
        scaled = b.rounded(product, steps.coordinate_bits + 1 - SCALE_BITS)
        b.step()
        found = encoded(b, scaled, joined.exponent - (unit.fraction_bits + SCALE_BITS), formats[1])
        results[1] = Result(found.word, found.valid & solved)
    b.now = max(b.now, finish)
    return results[0], results[1]


class _State(NamedTuple):
    x: Signal
    y: Signal
    target: Signal
    z: Signal


class _Near(NamedTuple):
    """The columns of `Near` as signals, by the use and the exponent of the block."""

    modes: Modes
    tables: list[ReachTable]
    row: Signal
    slack: Signal
    within: Signal
    short: Signal

    @classmethod
    def of(cls, modes: Modes, tables: list[ReachTable], exponent: Signal) -> _Near:
        """Return the rows of blocks with places of 2^exponent."""
        b = modes.builder
        first = b.pick(modes.mode, [table.rows.first for table in tables])
        last = b.pick(modes.mode, [table.rows.count - 1 for table in tables])
        row = b.named("row", b.clipped(exponent - first, 0, last))
        bare = cls(modes, tables, row, row, row, row)
        return bare._replace(**{name: bare.column(name) for name in ("slack", "within", "short")})

    def column(self, name: str, stretched: int = SHARES) -> Signal:
        """Return a column, perhaps as it is before a step, from the gain so far as a share of the whole one."""
        b = self.modes.builder
        found: Signal | None = None
        for number, table in enumerate(self.tables):
            values = [_share(value, stretched) for value in getattr(table.columns, name).tolist()]
            own = b.pick(b.narrowed(self.row, 0, table.rows.count - 1, loose=True), values)
            found = own if found is None else b.mux(self.modes.mode.equals(number), found, own)
        assert found is not None
        return found

    def width(self, size: Signal, fraction_bits: int) -> Signal:
        """Return the width of the kernel for a target's size."""
        b = self.modes.builder
        root = b.pick(b.narrowed(size >> (fraction_bits - 4), 0, SIXTEENTHS), list(ROOTS))
        product = self.column("rise") * root + (ROOT_SCALE - 1)
        return (product >> (ROOT_SCALE.bit_length() - 1)) + self.column("room")


def _share(size: int, stretched: int) -> int:
    return (size * stretched + SHARES - 1) // SHARES


def _steps(
    b: Builder, state: _State, table: StepTable, unit: Cau, near: _Near, width: Signal, may_end: Signal
) -> _State:
    """Turn (x, y) step by step until y is the target and x >= 0."""
    largest = 8 << unit.fraction_bits
    x, y, target, z = state
    root_free = unit.rule == "root-free"
    steps = zip(table.shifts, table.angles, table.target_factors, table.stretched, strict=True)
    for number, (shift, angle, factor, stretched) in enumerate(steps, 1):
        with b.scope(f"step{number}"):
            turn = "2 arctan" if root_free else "arctan"
            b.note(f"Step {number}: by {turn} 2^-{shift}.")
            gap = b.named("gap", target - y)
            share = width
            if stretched != SHARES:
                share = (width * stretched + (SHARES - 1)) >> (SHARES.bit_length() - 1)
            height = near.column("height", stretched)
            close = (gap <= height) & (gap >= -height) & (x > 0) & (x <= share) & may_end
            forward = b.mux(close, ~b.negative(gap), ~b.negative(target))
            up = b.named("up", b.mux(b.negative(x), forward, b.negative(y)))
            if root_free:
                dx, dy = b.rounded(y, shift - 1), b.rounded(x, shift - 1)
                flat = b.addsub(x - b.rounded(x, 2 * shift), dx, up)
                tall = b.addsub(y - b.rounded(y, 2 * shift), dy, ~up)
                target = target + b.rounded(target, 2 * shift)
            else:
                flat = b.addsub(x, b.rounded(y, shift), up)
                tall = b.addsub(y, b.rounded(x, shift), ~up)
                if factor:
                    target = target + b.rounded(target * factor, FACTOR_BITS)
            x = b.named("x", b.narrowed(flat, -largest, largest))
            y = b.named("y", b.narrowed(tall, -largest, largest))
            target = b.named("target", b.narrowed(target, -largest, largest))
            turned = b.narrowed(b.addsub(z, angle, ~up), -(12 << unit.angle_bits), 12 << unit.angle_bits)
            z = b.named("z", turned)
            b.step()
    return _State(x, y, target, z)
