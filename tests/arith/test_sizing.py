"""Sized units are the least ones, and keep all pairs of 8-bit words within the error they were sized for."""

from itertools import product

import numpy as np
import pytest

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.unit import sizing
from cordicc.arith.unit.cau import Cau
from cordicc.arith.unit.sizing import OPERATIONS, adder_bits, error_ulp, internal_errors_ulp, size_unit
from cordicc.targets.target import FUNCTIONS_OF_KIND
from tests.support.selection import quick

BITS = 8
TIGHTNESS = 4
LENGTH, ANGLE = FixedPoint(BITS, BITS - 1), FixedPoint(BITS, BITS - 3)
EXPLICIT = [name for name in OPERATIONS if not name.startswith("implicit")]
IMPLICIT = [name for name in OPERATIONS if name.startswith("implicit")]
RULE = "single-rotation"


def rule_of(operation):
    return RULE if operation in IMPLICIT else None


def pairs(first, second):
    words = np.arange(-LENGTH.largest_word, LENGTH.largest_word + 1)
    return [f.decode(v.ravel()) for f, v in zip((first, second), np.meshgrid(words, words), strict=True)]


def explicit(operation, unit):
    """Return the unit's results over all pairs, exact ones and their format; NaN where there is none."""
    x, y = pairs(LENGTH, LENGTH)
    zero = np.zeros_like(x)
    if operation == "rotate-circular":
        x, z = pairs(LENGTH, ANGLE)
        return zip(unit.rotate(1, x, zero, z), (x * np.cos(z), x * np.sin(z)), (LENGTH, LENGTH), strict=True)
    if operation == "rotate-linear":
        return [(unit.rotate(0, x, zero, y)[1], x * y, LENGTH)]
    if operation == "rotate-hyperbolic":
        x, z = pairs(LENGTH, ANGLE)
        exact = x * np.cosh(z), x * np.sinh(z)
        fits = np.abs(exact[0]) < 1
        exact = [np.where(fits, value, np.nan) for value in exact]
        return zip(unit.rotate(-1, x, zero, z), exact, (LENGTH, LENGTH), strict=True)
    if operation == "vector-circular":
        angle = np.where((x == 0) & (y == 0), np.nan, np.arctan2(y, x))
        return zip(unit.vector(1, 1, x, y, zero), (np.hypot(x, y), angle), (LENGTH, ANGLE), strict=True)
    if operation == "vector-linear":
        return [(unit.vector(0, 1, x, y, zero)[1], y / x, LENGTH)]
    if operation == "vector-hyperbolic":
        exact = np.sqrt((x - y) * (x + y)), np.where(np.abs(y) < np.abs(x), np.arctanh(y / x), np.nan)
        return zip(unit.vector(-1, 1, x, y, zero), exact, (LENGTH, ANGLE), strict=True)
    exact = np.sqrt(x * y), np.where(x * y > 0, np.log(x / y) / 2, np.nan)
    return zip(unit.lightcone(x, y), exact, (LENGTH, ANGLE), strict=True)


@pytest.mark.parametrize("operation", EXPLICIT)
def test_all_pairs_keep_the_error_sized_for(operation):
    unit = size_unit([operation], BITS).unit
    worst = 0.0
    with np.errstate(all="ignore"):
        for value, exact, format_ in explicit(operation, unit):
            rounded = format_.decode(format_.encode(value))
            largest = format_.largest_word * format_.ulp
            assert not np.isnan(rounded[np.abs(exact) <= largest - format_.ulp]).any()
            worst = max(worst, np.nanmax(np.abs(rounded - exact)) / format_.ulp)
    assert worst <= error_ulp(unit, operation, BITS) <= min(1, TIGHTNESS * worst)


@pytest.mark.parametrize("rule", ["single-rotation", "root-free"])
@pytest.mark.parametrize("branch", ["+", "-"])
def test_all_circular_equations_keep_the_error_sized_for(rule, branch):
    unit = size_unit(["implicit-circular"], BITS, rule=rule).unit
    internal = internal_errors_ulp(unit, "implicit-circular", BITS)
    A, B = pairs(LENGTH, LENGTH)
    norm = np.hypot(A, B)
    worst, worst_rounded = 0.0, 0.0
    for share in (-1.0, -0.7, 0.0, 0.1, 1.0):
        top = np.minimum(np.floor(norm / LENGTH.ulp), LENGTH.largest_word) * LENGTH.ulp
        C = np.trunc(share * top / LENGTH.ulp) * LENGTH.ulp
        ok = norm > 0
        t, _ = unit.implicit(1, branch, A[ok], B[ok], C[ok])
        assert not np.isnan(t).any()
        residual = np.abs(B[ok] * np.cos(t) + A[ok] * np.sin(t) - C[ok])
        worst = max(worst, residual.max() / LENGTH.ulp)
        word = ANGLE.decode(ANGLE.encode(t))
        rounded = np.abs(B[ok] * np.cos(word) + A[ok] * np.sin(word) - C[ok]) / norm[ok]
        worst_rounded = max(worst_rounded, np.nanmax(rounded) / ANGLE.ulp)
    assert worst <= internal["residual"] <= min(0.5, TIGHTNESS * worst)
    assert worst_rounded <= 0.5 + internal["angle"] <= min(1, TIGHTNESS * worst_rounded)


@pytest.mark.parametrize("rule", ["single-rotation", "root-free"])
def test_equations_without_a_solution_by_two_ulp_are_invalid(rule):
    A, B = pairs(LENGTH, LENGTH)
    C = (np.ceil(np.hypot(A, B) / LENGTH.ulp) + 2) * LENGTH.ulp
    C = np.where(A < B, -C, C)
    ok = np.abs(C) < 1
    unit = size_unit(["implicit-circular", "implicit-hyperbolic"], BITS, rule=rule).unit
    assert np.isnan(unit.implicit(1, "+", A[ok], B[ok], C[ok])).all()
    A, B = pairs(LENGTH, LENGTH)
    C = (np.sqrt(np.maximum(B * B - A * A, 0)) // LENGTH.ulp - 2) * LENGTH.ulp * np.sign(B)
    ok = (np.abs(B) > np.abs(A)) & (B * C > 0)
    assert np.isnan(unit.implicit(-1, "+", A[ok], B[ok], C[ok])).all()


@pytest.mark.parametrize("rule", ["single-rotation", "root-free"])
def test_all_hyperbolic_equations_keep_the_error_sized_for(rule):
    unit = size_unit(["implicit-hyperbolic"], BITS, rule=rule).unit
    internal = internal_errors_ulp(unit, "implicit-hyperbolic", BITS)
    B, C = pairs(LENGTH, LENGTH)
    worst = 0.0
    for A in (-1.0, -0.3, 0.5):
        A = np.full_like(B, round(A * LENGTH.largest_word)) * LENGTH.ulp
        square = A * A - B * B + C * C
        ok = ((np.abs(A) > np.abs(B)) | ((B * C > 0) & (square >= 0))) & (square < 1)
        t, _ = unit.implicit(-1, "-", A[ok], B[ok], C[ok])
        residual = np.abs(B[ok] * np.cosh(t) + A[ok] * np.sinh(t) - C[ok])
        worst = max(worst, residual.max() / LENGTH.ulp)
    assert worst <= internal["residual"] <= min(0.5, TIGHTNESS * worst)


@pytest.mark.parametrize("operation", quick(OPERATIONS, "rotate-circular", "implicit-circular"))
def test_no_unit_with_fewer_adder_bits_keeps_the_error(operation):
    rule = rule_of(operation)
    size = size_unit([operation], 12, 0.8, rule)
    assert size.error_ulp == error_ulp(size.unit, operation, 12) <= 0.8
    assert size.adder_bits == adder_bits(size.unit)
    for iterations, fraction_bits, angle_bits in product(range(8, 22), range(12, 26), range(16, 27)):
        unit = Cau(fraction_bits, iterations, rule, 12, angle_bits)
        if adder_bits(unit) < size.adder_bits:
            assert error_ulp(unit, operation, 12) > 0.8


def test_a_unit_for_several_operations_keeps_them_all():
    size = size_unit(EXPLICIT, 24)
    errors = [error_ulp(size.unit, operation, 24) for operation in EXPLICIT]
    assert max(errors) == size.error_ulp <= 1
    assert all(size_unit([operation], 24).adder_bits <= size.adder_bits for operation in EXPLICIT)


@pytest.mark.exhaustive(reason="sizes nine units; other tests size one for each operation")
def test_tighter_errors_and_wider_words_need_more():
    bits = [size_unit(EXPLICIT, 24, error).adder_bits for error in (2.0, 1.0, 0.75, 0.6)]
    assert bits == sorted(set(bits))
    bits = [size_unit(EXPLICIT, width).adder_bits for width in (12, 16, 20, 24, 28)]
    assert bits == sorted(set(bits))


def test_operations_are_those_of_units():
    functions = FUNCTIONS_OF_KIND
    assert set(OPERATIONS) == functions["standard"] | functions["implicit"]


def test_what_cannot_be_sized():
    with pytest.raises(ValueError, match=r"no unit keeps rotate-circular within 0\.5 ulp of 24 bits"):
        size_unit(["rotate-circular"], 24, 0.5)
    with pytest.raises(ValueError, match="no unit keeps"):
        size_unit(["rotate-circular"], sizing.MOST_FRACTION_BITS + 1)
    with pytest.raises(ValueError, match="unknown operation 'rotate'"):
        size_unit(["rotate"], 24)
    with pytest.raises(ValueError, match="no implicit mode"):
        size_unit(["implicit-circular"], 24)
