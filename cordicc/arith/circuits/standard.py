"""The circuit of a standard unit: rotations and vectorings, by the functions that it is used for."""

from __future__ import annotations

from typing import NamedTuple

from cordicc.arith.circuits.builder import Builder, Signal
from cordicc.arith.circuits.shifting import shifted, times
from cordicc.arith.circuits.uses import Format, Modes, Use, Word, format_of, word
from cordicc.arith.circuits.words import Result, at_fraction, block, encoded, encoded_angle
from cordicc.arith.kernels.reduction import SCALE_BITS, QuarterTurns, quarter_turns
from cordicc.arith.kernels.shift_sequences import StepTable, pi_fixed
from cordicc.arith.unit.cau import Cau, standard_table


class NoCircuitError(ValueError):
    """A unit has a use of which there is no circuit."""


class _Start(NamedTuple):
    """What the iterations begin with."""

    x: Signal
    y: Signal
    z: Signal


def standard_unit(
    b: Builder, unit: Cau, uses: tuple[Use, ...], operands: tuple[Signal, ...], mode: Signal, *, scale: int = 3
) -> tuple[Result | None, Result | None]:
    """Return both results as words.

    Args:
        b: the builder.
        unit: the sizes of the unit.
        uses: what it is used for.
        operands: the words at its ports.
        mode: the number of the use.
        scale: registers in the products with the reciprocal gain.

    Raises:
        NoCircuitError: a use has none.
    """
    if any(use.m != 1 for use in uses):
        raise NoCircuitError(f"a {next(use.function for use in uses if use.m != 1)} operation")
    modes = Modes(b, mode, uses)
    x, y, z = (word(modes, bits, number) for number, bits in enumerate(operands))
    turning = modes.which(lambda use: use.op == "rotate")
    table = standard_table(unit, 1)
    half_turn = pi_fixed(unit.angle_bits)
    begin = b.now
    zero = x.bits.equals(0) & y.bits.equals(0)
    left, down, up = b.negative(x.bits), b.negative(y.bits), y.bits > 0
    starts = []
    end = b.now
    if any(use.op == "rotate" for use in uses):
        quadrant, angle = _reduced(b, modes, z, unit)
        end, b.now = b.now, begin
    joined = block(b, (x, y), unit.fraction_bits)
    b.step()
    b.now = max(b.now, end)
    p, q = joined.mantissas
    if any(use.op == "rotate" for use in uses):
        odd, half = b.bit(quadrant, 0), b.bit(quadrant, 1)
        first, second = b.mux(odd, p, q), b.mux(odd, q, p)
        starts.append(_Start(b.negif(first, odd ^ half), b.negif(second, half), angle))
    if any(use.op == "vector" for use in uses):
        ahead, across = (b.negif(each, left) for each in (p, q))
        start = b.mux(left, 0, b.mux(down, half_turn, -half_turn))
        starts.append(_Start(b.narrowed(ahead, 0, ahead.hi, loose=len(starts) > 0), across, start))
    state = starts[0] if len(starts) == 1 else _Start(*(b.mux(turning, v, r) for r, v in zip(*starts, strict=True)))
    b.step()
    formats = [format_of(modes, number, unit.angle_bits) for number in range(2)]
    x_end, y_end, z_end = _steps(b, state, table, unit, turning)
    scaling = _Scaling(b, table, joined.exponent - (unit.fraction_bits + SCALE_BITS), scale)
    begin = b.now
    results: list[Result | None] = [None, None]
    if formats[0] is not None:
        # The norm of no vector is 0.
        coordinate = b.mux(zero & ~turning, x_end, 0)
        results[0] = scaling.result(coordinate, formats[0])
    end, b.now = b.now, begin
    if formats[1] is not None:
        found = []
        if any(use.op == "rotate" and use.results[1] is not None for use in uses):
            found.append(scaling.result(y_end, formats[1]))
            end = max(end, b.now)
        if any(use.op == "vector" and use.results[1] is not None for use in uses):
            b.now = begin
            least = b.mux(down, 0, -half_turn)
            most = b.mux(up | left, 0, half_turn)
            total = b.clipped(b.narrowed(z_end, -2 * half_turn, 2 * half_turn, loose=len(found) > 0), least, most)
            angle = _angle(b, modes, z, total, unit, formats[1])
            found.append(Result(angle.word, angle.valid & ~zero))
            end = max(end, b.now)
        b.now = end
        results[1] = found[0] if len(found) == 1 else _either(b, turning, found[1], found[0])
    b.now = end
    return results[0], results[1]


def _either(b: Builder, choice: Signal, a: Result, other: Result) -> Result:
    return Result(b.mux(choice, a.word, other.word), b.mux(choice, a.valid, other.valid))


def _angle(b: Builder, modes: Modes, z: Word, turned: Signal, unit: Cau, format_: Format) -> Result:
    """Return z + sign * angle as a word."""
    minus = modes.which(lambda use: use.op == "vector" and use.sign < 0)
    total = b.addsub(at_fraction(b, z, unit.angle_bits), turned, minus)
    b.step()
    return encoded_angle(b, total, unit.angle_bits, format_)


class _Scaling(NamedTuple):
    """Division by the gain, and the way back to words."""

    b: Builder
    table: StepTable
    exponent: Signal
    stages: int

    def result(self, coordinate: Signal, format_: Format) -> Result:
        """Return a coordinate as a word."""
        product = times(self.b, coordinate, self.table.inverse_gain, self.stages)
        scaled = self.b.rounded(product, self.table.coordinate_bits + 1 - SCALE_BITS)
        self.b.step()
        return encoded(self.b, scaled, self.exponent, format_)


def _reduced(b: Builder, modes: Modes, z: Word, unit: Cau) -> tuple[Signal, Signal]:
    """Return the quadrant of an angle, 0 to 3, and the rest with the angle bits of the unit, in two cycles."""
    tables = [_quarters(use, unit) for use in modes.uses]
    finest = max(table.fraction_bits for table in tables)
    most = max(len(table.thresholds) for table in tables)

    def of(number: int, what: str) -> Signal:
        # Thresholds that a use lacks are beyond its words.
        def value(use: Use) -> int:
            table = _quarters(use, unit)
            values = table.thresholds if what == "thresholds" else table.multiples
            lift = finest - table.fraction_bits
            return values[number] << lift if number < len(values) else 1 << (finest + 6)

        return modes.pick(value)

    own = modes.pick(lambda use: _quarters(use, unit).fraction_bits)
    fine = shifted(b, z.bits, z.fraction - own, z.bits.width + 1)
    fine = b.shlv(fine, finest - own)
    count: Signal = b.of(0)
    for number in range(most):
        threshold = of(number, "thresholds")
        count = count + (fine >= threshold) - (fine <= -threshold)
    count = b.named("quarters", b.narrowed(count, -most, most))
    quadrant = b.low(count, 2)
    b.step()
    whole: Signal = b.of(0)
    size = b.size(count)
    for number in range(1, most + 1):
        whole = b.mux(size.equals(number), whole, of(number, "multiples"))
    rest = b.addsub(fine, whole, ~b.negative(count)) if most else fine
    if most:
        eighth = (3 << finest) // 4 + (3 << finest) // 64  # beyond pi/4 by more than all roundings
        rest = b.narrowed(rest, -eighth, eighth, loose=any(use.op != "rotate" for use in modes.uses))
    angle = b.rounded(rest, finest - unit.angle_bits)
    b.step()
    return quadrant, b.named("angle", angle)


def _quarters(use: Use, unit: Cau) -> QuarterTurns:
    format_ = use.operands[2] if use.op == "rotate" else use.operands[0]
    if use.op != "rotate":
        return QuarterTurns(unit.angle_bits, (), (0,))
    found = quarter_turns(unit.angle_bits, format_.width_bits, format_.fraction_bits)
    if found is None:
        raise NoCircuitError("a rotation by angles of many turns")
    return found


def _steps(b: Builder, start: _Start, table: StepTable, unit: Cau, turning: Signal) -> _Start:
    """Turn (x, y) step by step: by z, or until y is nearly 0."""
    largest = 4 << unit.fraction_bits
    x, y, z = start
    for number, (shift, angle) in enumerate(zip(table.shifts, table.angles, strict=True), 1):
        with b.scope(f"step{number}"):
            b.note(f"Step {number}: by arctan 2^-{shift}.")
            # Against the angle that is left, or towards the x axis.
            back = b.named("back", b.mux(turning, ~b.negative(y), b.negative(z)))
            dx, dy = b.rounded(y, shift), b.rounded(x, shift)
            lo = 0 if x.lo == 0 and turning.hi == 0 else -largest
            turned = b.named("x", b.narrowed(b.addsub(x, dx, ~back), lo, largest))
            y = b.named("y", b.narrowed(b.addsub(y, dy, back), -largest, largest))
            x = turned
            left = b.addsub(z, angle, ~back)
            if turning.lo == 1:
                left = b.narrowed(left, min(-angle, z.lo + angle), max(angle - 1, z.hi - angle))
            else:
                left = b.narrowed(left, -(7 << unit.angle_bits), 7 << unit.angle_bits)
            z = b.named("z", left)
            b.step()
    return _Start(x, y, z)
