"""The circuit of circular vectoring: the norm of (x, y), and z plus or minus its angle."""

from __future__ import annotations

from collections.abc import Callable

from cordicc.arith.circuits.builder import Builder, Signal
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.words import Result, Word, at_fraction, block, encoded, encoded_angle
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import StepTable, pi_fixed
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.unit.cau import Cau, standard_table


def vector_circular(
    b: Builder,
    unit: Cau,
    sign: int,
    words: tuple[Word, Word, Word],
    norm: FixedPoint | None,
    angle: FixedPoint | None,
    *,
    wraps: bool = True,
    scale_stages: int = 3,
) -> tuple[Result | None, Result | None]:
    """Return norm and z + sign * angle as words.

    Args:
        b: the builder.
        unit: the sizes of the unit.
        sign: 1 or -1.
        words: x, y and z.
        norm: the format of the norm, None if nobody takes it.
        angle: the format of the angle, None if nobody takes it.
        wraps: whether the second result is an angle, which no word takes beyond pi.
        scale_stages: registers in the product with the reciprocal gain.
    """
    x, y, z = words
    table = standard_table(unit, 1)
    half_turn = pi_fixed(unit.angle_bits)
    zero = x.bits.equals(0) & y.bits.equals(0)
    left, down, up = b.negative(x.bits), b.negative(y.bits), y.bits > 0
    joined = block(b, (x, y), unit.fraction_bits)
    b.step()
    a, c = (b.negif(each, left) for each in joined.mantissas)
    a = b.narrowed(a, 0, a.hi)
    turned = b.mux(left, 0, b.mux(down, half_turn, -half_turn))
    a, total = _steps(b, a, c, turned, table, unit.fraction_bits, norm is not None, angle is not None)
    found_norm = found_angle = None
    start = b.now
    if angle is not None:
        least = b.mux(down, 0, -half_turn)
        most = b.mux(up | left, 0, half_turn)
        total = b.clipped(total, least, most)
        whole = at_fraction(b, z, unit.angle_bits)
        whole = whole + total if sign > 0 else whole - total
        b.step()
        if wraps:
            found_angle = encoded_angle(b, whole, unit.angle_bits, angle)
        else:
            found_angle = encoded(b, whole, -unit.angle_bits, angle)
        found_angle = Result(found_angle.word, found_angle.valid & ~zero)
    end, b.now = b.now, start
    if norm is not None:
        product = times(b, a, table.inverse_gain, scale_stages)
        scaled = b.rounded(product, table.coordinate_bits + 1 - SCALE_BITS)
        scaled = b.mux(zero, scaled, 0)
        b.step()
        found_norm = encoded(b, scaled, joined.exponent - (unit.fraction_bits + SCALE_BITS), norm)
    b.now = max(b.now, end)
    return found_norm, found_angle


def _steps(
    b: Builder, x: Signal, y: Signal, z: Signal, table: StepTable, bits: int, wants_x: bool, wants_z: bool
) -> tuple[Signal, Signal]:
    """Turn (x, y) step by step until y is nearly 0; return x and z plus the angle."""
    largest = 4 << bits
    for number, (shift, angle) in enumerate(zip(table.shifts, table.angles, strict=True), 1):
        with b.scope(f"step{number}"):
            b.note(f"Step {number}: by arctan 2^-{shift}.")
            up = b.named("up", ~b.negative(y))
            dx, dy = b.rounded(y, shift), b.rounded(x, shift)
            longer = b.named("x", b.narrowed(b.addsub(x, dx, ~up), 0, largest))
            y = b.named("y", b.narrowed(b.addsub(y, dy, up), -largest, largest))
            x = longer
            if wants_z:
                z = b.named("z", b.addsub(z, angle, ~up))
            b.step()
    return x, z


__all__: list[str] = ["vector_circular"]
Make = Callable[[Builder], None]
