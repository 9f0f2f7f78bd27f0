"""Hyperbolic rotation and vectoring, on the light cone, around the iterations of a standard unit."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import clipped, greater
from cordicc.arith.circuits.scaled import Floating, added, normalised
from cordicc.arith.circuits.shifting import shlv
from cordicc.arith.circuits.uses import (
    Coordinates,
    Modes,
    NoCircuitError,
    Raw,
    Raws,
    Turned,
    UnitFunction,
    Use,
    Wanted,
    Word,
)
from cordicc.arith.circuits.words import at_fraction
from cordicc.arith.kernels.blocks import WIDE_BITS
from cordicc.arith.kernels.reduction import LN2_BITS, SCALE_BITS
from cordicc.arith.kernels.shift_sequences import inverse_ln2_fixed, ln2_fixed
from cordicc.arith.unit.cau import Cau

Words = tuple[Word, ...]

_SATURATED = 512
"""What |z| of a rotation is limited to, far beyond any result."""


def rotation(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what turning (x, y) by z begins with, and what makes results of its end."""
    x, y, z = words
    limit = _SATURATED << unit.angle_bits
    fixed = b.named("fixed", clipped(b, at_fraction(b, z, unit.angle_bits), -limit, limit))
    down = unit.angle_bits - 16
    coarse = fixed >> down if down >= 0 else fixed << -down
    doublings = b.named("doublings", b.rounded(coarse * inverse_ln2_fixed(30), 46))
    rest = fixed - ln2_multiple(b, doublings, unit)
    within = math.ceil(math.ldexp(0.36, unit.angle_bits))
    alone = all(use.function == "rotate_hyperbolic" for use in modes.uses)
    rest = b.narrowed(rest, -within, within, loose=not alone)
    u, v = sum_and_difference(b, modes, unit, x, y)
    start = Turned(
        b.rounded(u.mantissa + v.mantissa, 1), b.rounded(u.mantissa - v.mantissa, 1), b.named("angle", rest)
    )
    no_u, no_v = u.mantissa.equals(0), v.mantissa.equals(0)

    def coordinates(last: Turned, wanted: Wanted) -> Coordinates:
        return b.mux(no_u, last.x + last.y, 0), b.mux(no_v, last.x - last.y, 0)

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        assert scaled[0] is not None
        assert scaled[1] is not None
        grown = Floating(scaled[0], u.exponent + doublings - SCALE_BITS)
        shrunk = Floating(scaled[1], v.exponent - doublings - SCALE_BITS)
        # Half of the sum and of the difference.
        results = []
        for mantissa, taken in zip((shrunk.mantissa, -shrunk.mantissa), wanted, strict=True):
            total = added(b, grown, Floating(mantissa, shrunk.exponent)) if taken else None
            results.append(None if total is None else Raw(total.mantissa, total.exponent - 1, b.of(1)))
        return results[0], results[1]

    return UnitFunction(start, coordinates, finish)


def vectoring(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what sqrt(x^2 - y^2) and z + artanh(y/x) begin with, and what makes them of its end."""
    x, y, z = words
    finest = b.named("finest", greater(b, x.fraction, y.fraction))
    a, c = (shlv(b, each.bits, b.narrowed(finest - each.fraction, 0, 400)) for each in (x, y))
    defined = b.size(c) < b.size(a)
    u, v = sum_and_difference(b, modes, unit, x, y)
    sizes = [normalised(b, b.size(each.bits), -each.fraction, unit.operand_bits) for each in (x, y)]
    # The last place of the larger operand.
    least = min(size.exponent.lo for size in sizes)
    ends = [
        b.mux(each.bits.equals(0), size.exponent, least) for each, size in zip((x, y), sizes, strict=True)
    ]
    place = b.mux(modes.which(lambda use: use.slack.relative), 0, greater(b, *ends))
    measured = _Measured.of(b, modes, unit, u, v, place)

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        def total(angle: CircuitSignal) -> CircuitSignal:
            minus = modes.which(lambda use: use.sign < 0)
            return b.addsub(at_fraction(b, z, unit.angle_bits), angle, minus)

        return measured.results(last, scaled, wanted, total, defined)

    return UnitFunction(measured.start, measured.coordinates, finish)


def lightcone(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what sqrt(u v) and ln(u/v)/2 begin with, and what makes them of its end."""
    u, v = (normalised(b, word.bits, -word.fraction, unit.operand_bits) for word in words[:2])
    p, q = words[0].bits, words[1].bits
    defined = ~(b.negative(p) ^ b.negative(q)) & ~p.equals(0) & ~q.equals(0)
    measured = _Measured.of(b, modes, unit, u, v, b.of(0))

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        return measured.results(last, scaled, wanted, lambda angle: angle, defined)

    return UnitFunction(measured.start, measured.coordinates, finish)


class _Measured(NamedTuple):
    """A measurement on the light cone."""

    b: CircuitBuilder
    unit: Cau
    start: Turned
    zero: CircuitSignal
    apart: CircuitSignal
    half: CircuitSignal
    doublings: CircuitSignal

    @classmethod
    def of(
        cls, b: CircuitBuilder, modes: Modes, unit: Cau, u: Floating, v: Floating, place: CircuitSignal
    ) -> _Measured:
        """Bring u and v to one size by powers of two, as `Cau` does."""
        bits = unit.fraction_bits
        sizes = [normalised(b, b.size(each.mantissa), each.exponent, bits) for each in (u, v)]
        no_u, no_v = u.mantissa.equals(0), v.mantissa.equals(0)
        odd = b.low(sizes[0].exponent + sizes[1].exponent, 1)
        smaller = sizes[0].mantissa < sizes[1].mantissa
        lifts = (odd & smaller, odd & ~smaller)
        p, q = (
            b.mux(lift, each.mantissa, each.mantissa << 1) for lift, each in zip(lifts, sizes, strict=True)
        )
        ends = [each.exponent - lift for lift, each in zip(lifts, sizes, strict=True)]
        zero = no_u | no_v
        apart = ~zero & (b.negative(u.mantissa) ^ b.negative(v.mantissa))
        near: CircuitSignal = b.of(0)
        for size in sizes:
            near = near | _within_slack(b, modes, unit, Floating(size.mantissa, size.exponent - place))
        near = near & apart
        zero, apart = zero | near, apart & ~near
        start = Turned(b.rounded(p + q, 1), b.rounded(p - q, 1), b.of(0))
        half, doublings = (ends[0] + ends[1]) >> 1, (ends[0] - ends[1]) >> 1
        return cls(b, unit, start, zero, apart, half, b.mux(zero, doublings, 0))

    def coordinates(self, last: Turned, wanted: Wanted) -> Coordinates:
        """Return what is left of x."""
        return self.b.mux(self.zero, last.x, 0) if wanted[0] else None, None

    def results(
        self,
        last: Turned,
        scaled: Coordinates,
        wanted: Wanted,
        total: Callable[[CircuitSignal], CircuitSignal],
        defined: CircuitSignal,
    ) -> Raws:
        """Return root and angle."""
        b = self.b
        root = angle = None
        if scaled[0] is not None:
            root = Raw(scaled[0], self.half - SCALE_BITS, ~self.apart)
        if wanted[1]:
            turned = last.z + ln2_multiple(b, self.doublings, self.unit)
            angle = Raw(total(turned), b.of(-self.unit.angle_bits), defined)
        return root, angle


def _within_slack(b: CircuitBuilder, modes: Modes, unit: Cau, size: Floating) -> CircuitSignal:
    """Return whether a size, in places of what the slack is relative to, counts as nothing."""
    found: CircuitSignal = b.of(0)
    for number, use in enumerate(modes.uses):
        if use.m != -1 or not use.slack.beyond:
            continue
        rows, places = unit.root_slack(use.slack)
        row = clipped(b, size.exponent - rows.first, 0, rows.count - 1)
        limit = b.pick(row, places.tolist())
        found = found | ((size.mantissa <= limit) & modes.mode.equals(number))
    return found


def ln2_multiple(b: CircuitBuilder, count: CircuitSignal, unit: Cau) -> CircuitSignal:
    """Return count * ln 2 with the angle bits of the unit."""
    return b.rounded(count * ln2_fixed(LN2_BITS), LN2_BITS - unit.angle_bits)


def sum_and_difference(
    b: CircuitBuilder, modes: Modes, unit: Cau, x: Word, y: Word
) -> tuple[Floating, Floating]:
    """Return x + y and x - y with mantissas of the unit's bits."""
    if any(_spread(use) + unit.operand_bits > WIDE_BITS for use in modes.uses if use.m == -1):
        raise NoCircuitError("a hyperbolic operation on binary points far apart")
    finest = greater(b, x.fraction, y.fraction)
    a, c = (shlv(b, each.bits, b.narrowed(finest - each.fraction, 0, 400)) for each in (x, y))
    total, difference = b.named("total", a + c), b.named("difference", a - c)
    u, v = (normalised(b, each, -finest, unit.fraction_bits) for each in (total, difference))
    return u, v


def _spread(use: Use) -> int:
    fractions = [format_.fraction_bits for format_ in use.operands[:2]]
    return max(fractions) - min(fractions)
