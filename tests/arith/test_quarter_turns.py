"""Angles of fixed-point words reduced by a table: every word of narrow formats against exact numbers."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest
from mpmath import MPContext

from cordicc.arith.kernels.blocks import unpack
from cordicc.arith.kernels.micro_rotations import rotate
from cordicc.arith.kernels.reduction import (
    LARGEST_REMAINDER,
    THRESHOLD_BITS,
    quarter_turns,
    reduce_by_table,
)
from cordicc.arith.numbers.fixed_point import FRACTIONS, FixedPoint
from cordicc.arith.numbers.formats import SINGLE, Signal
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.arith.unit.cau import Cau, standard_table
from cordicc.arith.unit.unit_bounds import rotation_bound

_mp = MPContext()
_mp.prec = 200
_mantissa, _exponent = (+_mp.pi).man_exp
PI = Fraction(int(_mantissa)) * Fraction(2) ** int(_exponent)
HALF = Fraction(1, 2)

FORMATS = [
    pytest.param(angle_bits, width, fraction, id=f"{width} bits with {fraction}, {angle_bits} in the unit")
    for width, angle_bits in ((8, 8), (10, 10), (10, 8))
    for fraction in (width - 5, width - 4, width - 3, width - 2, width - 1, width, width + 2, width + 6, 40)
]
"""From 16 rad on; all ways of rounding: no bit too many, some, and more than the table has."""


def nearest(number: Fraction) -> int:
    return floor(number + HALF)


def every_word(width: int) -> range:
    return range(1 - (1 << (width - 1)), 1 << (width - 1))


@pytest.mark.parametrize(("angle_bits", "width", "fraction"), FORMATS)
def test_quadrant_and_remainder_of_every_word(angle_bits: int, width: int, fraction: int) -> None:
    table = quarter_turns(angle_bits, width, fraction)
    assert table is not None
    bits = table.fraction_bits
    assert bits == max(angle_bits, min(fraction, angle_bits + 4))
    scale, unit = 2**bits, Fraction(1, 2**angle_bits)
    allowed = HALF
    if bits > angle_bits:
        allowed += Fraction(1, 16) if bits == angle_bits + 4 else HALF * Fraction(2) ** (angle_bits - bits)
    words = every_word(width)
    format_ = FixedPoint(width, fraction)
    quadrants, remainders = reduce_by_table(unpack(format_.decode(np.array(words)), width), table, angle_bits)
    for word, quadrant, remainder in zip(words, quadrants.tolist(), remainders.tolist(), strict=True):
        exact = word / Fraction(2) ** fraction
        z = nearest(exact * scale)
        places = Fraction(scale, 2**THRESHOLD_BITS)
        thresholds = [nearest((2 * j - 1) * PI / 4 * scale / places) * places for j in range(1, 12)]
        reached = [threshold for threshold in thresholds if z >= threshold or z < -threshold]
        turns = len(reached) if z >= 0 else -len(reached)
        rest = z - (1 if turns >= 0 else -1) * nearest(abs(turns) * PI / 2 * scale)
        assert quadrant == turns % 4
        assert remainder == nearest(Fraction(rest, 2 ** (bits - angle_bits)))
        assert abs(exact - turns * PI / 2 - remainder * unit) <= allowed * unit
        assert abs(remainder) * unit <= LARGEST_REMAINDER


def test_no_table_is_longer_than_the_format_needs() -> None:
    lengths = {}
    for fraction in FRACTIONS:
        table = quarter_turns(32, 24, fraction)
        lengths[23 - fraction] = None if table is None else len(table.thresholds)
        if table is not None:
            assert len(table.multiples) == len(table.thresholds) + 1
    assert all((count is None) == (places > 4) for places, count in lengths.items())
    assert [lengths[places] for places in (-120, -1, 0, 1, 2, 3, 4)] == [0, 0, 1, 1, 3, 5, 10]


@pytest.mark.parametrize("angle_bits", [8, 20, 44])
def test_micro_rotations_converge_for_the_largest_remainder(angle_bits: int) -> None:
    unit = Cau(iterations=angle_bits - 2, angle_bits=angle_bits)
    table = standard_table(unit, 1)
    edge = floor(LARGEST_REMAINDER * 2**angle_bits) + 1
    start = np.array([edge, -edge])
    x, y, left = rotate(np.full(2, 1 << 40), np.zeros(2, np.int64), start, table)
    assert np.all(np.abs(left) <= table.angles[-1])
    wanted = np.ldexp(start.astype(float), -angle_bits)
    assert np.allclose(np.arctan2(y, x), wanted, rtol=0, atol=2.0 ** (4 - angle_bits))


@pytest.mark.parametrize("fraction", [5, 6, 7, 8, 10, 12, 14, 30])
def test_rotations_by_every_word_are_within_their_bound(fraction: int) -> None:
    """The bound of the product holds for every table, and is what is left where the format is not known."""
    unit = Cau(18, 14, None, 10, 10)
    table = quarter_turns(10, 10, fraction)
    z = FixedPoint(10, fraction).decode(np.array(every_word(10)))
    x, y = np.full_like(z, 300.0), np.full_like(z, -411.0)
    first, second = unit.rotate(1, x, y, z, quarters=table)
    error = np.hypot(first - (x * np.cos(z) - y * np.sin(z)), second - (y * np.cos(z) + x * np.sin(z)))
    size, place = np.hypot(300, 411), 2.0 ** (9 - 18)
    bound = rotation_bound(unit, 1, table).error(size, place)
    assert np.all(error <= bound)
    assert bound < rotation_bound(unit, 1).error(size, place)


def test_words_choose_the_table_by_their_format() -> None:
    unit = {"mantissa_bits": 32, "exponent_bits": 10, "angle_bits": 28, "iterations": 28}
    fixed, single = (
        Arithmetic.from_spec({"format": format_, "units": {"standard": unit}})
        for format_ in ({"kind": "fixed-point", "width": 24}, {"kind": "ieee-single"})
    )
    assert fixed.quarters("standard", FixedPoint(24, 19)) == quarter_turns(28, 24, 19)
    assert fixed.quarters("standard", FixedPoint(24, 18)) is None
    assert single.quarters("standard", SINGLE) is None
    sides = [Signal(np.array([2**22]), FixedPoint(24, 22)), Signal(np.array([0]), FixedPoint(24, 22))]
    for fraction in (18, 19):
        turn = Signal(np.array([2**23 - 1]), FixedPoint(24, fraction))
        results = [FixedPoint(32, 30)] * 2
        made = fixed.execute("rotate", {"m": 1}, "standard", [*sides, turn], results, None)
        table = quarter_turns(28, 24, fraction)
        values = fixed.caus["standard"].rotate(1, *(s.values for s in (*sides, turn)), quarters=table)
        assert [s.words[0] for s in made] == [results[0].encode(v)[0] for v in values]
