"""Circular rotation and vectoring around the iterations of a standard unit."""

from __future__ import annotations

import math

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import clipped
from cordicc.arith.circuits.shifting import shifted, shlv
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
from cordicc.arith.circuits.words import at_fraction, block
from cordicc.arith.kernels.reduction import (
    LARGEST_REMAINDER,
    SCALE_BITS,
    THRESHOLD_BITS,
    QuarterTurns,
    quarter_turns,
)
from cordicc.arith.kernels.shift_sequences import pi_fixed
from cordicc.arith.unit.arithmetic import least_exponent
from cordicc.arith.unit.cau import Cau

Words = tuple[Word, ...]


def rotation(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what turning (x, y) by z begins with, and what makes results of its end."""
    x, y, z = words
    quadrant, angle = _reduced(b, modes, z, unit)
    # Results err by places of the largest words, however short the vector is: no number is normalised.
    bits = unit.operand_bits
    exponent = modes.pick(lambda use: least_exponent(use.operands[0], use.operands[1], bits) + bits)
    within = -(1 << unit.fraction_bits), 1 << unit.fraction_bits
    p, q = (
        shifted(b, each.bits, exponent + each.fraction - unit.fraction_bits, each.bits.width + 1, within)
        for each in (x, y)
    )
    odd, half = b.bit(quadrant, 0), b.bit(quadrant, 1)
    start = Turned(b.negif(b.mux(odd, p, q), odd ^ half), b.negif(b.mux(odd, q, p), half), angle)

    def coordinates(last: Turned, wanted: Wanted) -> Coordinates:
        return last.x if wanted[0] else None, last.y if wanted[1] else None

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        below = exponent - (unit.fraction_bits + SCALE_BITS)
        first, second = (None if each is None else Raw(each, below, b.of(1)) for each in scaled)
        return first, second

    return UnitFunction(start, coordinates, finish)


def vectoring(b: CircuitBuilder, modes: Modes, unit: Cau, words: Words) -> UnitFunction:
    """Return what turning (x, y) to the x axis begins with, and what makes norm and angle of its end."""
    x, y, z = words
    half_turn = pi_fixed(unit.angle_bits)
    zero = x.bits.equals(0) & y.bits.equals(0)
    left, down, up = b.negative(x.bits), b.negative(y.bits), y.bits > 0
    joined = block(b, (x, y), unit.fraction_bits)
    ahead, across = (b.negif(each, left) for each in joined.mantissas)
    alone = all(use.function == "vector_circular" for use in modes.uses)
    ahead = b.narrowed(ahead, 0, ahead.hi, loose=not alone)
    start = Turned(ahead, across, b.mux(left, 0, b.mux(down, half_turn, -half_turn)))

    def coordinates(last: Turned, wanted: Wanted) -> Coordinates:
        # The norm of no vector is 0.
        return b.mux(zero, last.x, 0) if wanted[0] else None, None

    def finish(last: Turned, scaled: Coordinates, wanted: Wanted) -> Raws:
        norm = angle = None
        if scaled[0] is not None:
            norm = Raw(scaled[0], joined.exponent - (unit.fraction_bits + SCALE_BITS), b.of(1))
        if wanted[1]:
            least, most = b.mux(down, 0, -half_turn), b.mux(up | left, 0, half_turn)
            turned = clipped(b, last.z, least, most)
            minus = modes.which(lambda use: use.sign < 0)
            total = b.addsub(at_fraction(b, z, unit.angle_bits), turned, minus)
            angle = Raw(total, b.of(-unit.angle_bits), ~zero)
        return norm, angle

    return UnitFunction(start, coordinates, finish)


def _reduced(b: CircuitBuilder, modes: Modes, z: Word, unit: Cau) -> tuple[CircuitSignal, CircuitSignal]:
    """Return the quadrant of an angle, 0 to 3, and the rest with the unit's angle bits."""
    tables = [_quarters(use, unit) for use in modes.uses]
    finest = max(table.fraction_bits for table in tables)
    most = max(len(table.thresholds) for table in tables)

    def entry(number: int, what: str) -> CircuitSignal:
        # Thresholds that a use lacks are beyond its words.
        def value(use: Use) -> int:
            table = _quarters(use, unit)
            values = table.thresholds if what == "thresholds" else table.multiples
            lift = finest - table.fraction_bits
            return values[number] << lift if number < len(values) else 1 << (finest + 6)

        return modes.pick(value)

    own = modes.pick(lambda use: _quarters(use, unit).fraction_bits)
    fine = shlv(b, shifted(b, z.bits, z.fraction - own, z.bits.width + 1), finest - own)
    # The leading bits tell as well: thresholds have no more.
    coarse = finest - THRESHOLD_BITS
    lead = fine >> coarse
    count: CircuitSignal = b.of(0)
    for number in range(most):
        threshold = entry(number, "thresholds") >> coarse
        count = count + (lead >= threshold) - (lead < -threshold)
    count = b.named("quarters", b.narrowed(count, -most, most))
    quadrant = b.low(count, 2)
    whole: CircuitSignal = b.of(0)
    size = b.size(count)
    for number in range(1, most + 1):
        whole = b.mux(size.equals(number), whole, entry(number, "multiples"))
    rest = fine
    if most:
        eighth = math.ceil(math.ldexp(LARGEST_REMAINDER, finest))
        alone = all(use.function == "rotate_circular" for use in modes.uses)
        rest = b.narrowed(b.addsub(fine, whole, ~b.negative(count)), -eighth, eighth, loose=not alone)
    angle = b.rounded(rest, finest - unit.angle_bits)
    return quadrant, b.named("angle", angle)


def _quarters(use: Use, unit: Cau) -> QuarterTurns:
    if use.function != "rotate_circular":
        return QuarterTurns(unit.angle_bits, (), (0,))
    format_ = use.operands[2]
    found = quarter_turns(unit.angle_bits, format_.width_bits, format_.fraction_bits)
    if found is None:
        raise NoCircuitError("a rotation by angles of many turns")
    return found
