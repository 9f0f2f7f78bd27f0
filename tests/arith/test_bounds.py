"""Rotations and vectorings over all pairs of 8-bit words stay within their proven bounds, which are tight.

The reference is double precision, whose own error, below 2^-45 here, is nothing beside the units': their
last places are 2^-20 of the operands and more.
"""

import math

import numpy as np
import pytest

from cordicc.arith.unit.cau import Cau
from cordicc.arith.unit.unit_bounds import lightcone_bound, rotation_bound, vectoring_bound

BITS = 8
TIGHTNESS = 4
WORDS = np.arange(1 - (1 << (BITS - 1)), 1 << (BITS - 1), dtype=float)

UNITS = [
    pytest.param(Cau(14, 11, None, BITS, 18), id="angle-and-rounding"),
    pytest.param(Cau(12, 14, None, BITS, 20), id="rounding"),
    pytest.param(Cau(16, 9, None, BITS, 16), id="angle"),
]


def pairs():
    first, second = (v.ravel() for v in np.meshgrid(WORDS, WORDS))
    return first, second


def angles(seed):
    """One angle of 8 bits in (-4, 4) for each pair; every angle occurs."""
    count = len(WORDS) ** 2
    return np.random.default_rng(seed).permutation(np.resize(WORDS, count)) / 32


def place_of(unit, *operands):
    """Return the last place of the operands' block."""
    largest = np.max(np.abs(operands), axis=0)
    return np.ldexp(1.0, np.frexp(largest)[1] - unit.fraction_bits)


def compare(error, bound, counts):
    """Check every sample, and that one of them comes near the bound."""
    error, bound = np.broadcast_arrays(np.abs(error), bound)
    error, bound = error[counts], bound[counts]
    assert not np.isnan(error).any()
    assert (error <= bound).all()
    assert (bound <= TIGHTNESS * error).any()


def turned():
    """Every (x, y) turned by an angle, and every x turned by every angle, y being 0."""
    x, y = pairs()
    rows = (x, y, angles(1)), (x, np.zeros_like(x), y / 32)
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


@pytest.mark.parametrize("unit", UNITS)
def test_circular_rotation(unit):
    x, y, z = turned()
    a, b = unit.rotate(1, x, y, z)
    error = np.hypot(a - (x * np.cos(z) - y * np.sin(z)), b - (y * np.cos(z) + x * np.sin(z)))
    bound = rotation_bound(unit, 1).error(np.hypot(x, y), place_of(unit, x, y))
    compare(error, bound, (x != 0) | (y != 0))


@pytest.mark.parametrize("unit", UNITS)
def test_circular_vectoring(unit):
    x, y = pairs()
    bound = vectoring_bound(unit, 1)
    norm, angle = unit.vector(1, 1, x, y, np.zeros_like(x))
    counts = (x != 0) | (y != 0)
    compare(norm - np.hypot(x, y), bound.norm.error(np.hypot(x, y), place_of(unit, x, y)), counts)
    compare(angle - np.arctan2(y, x), bound.angle, counts)


@pytest.mark.parametrize("unit", UNITS)
def test_angles_are_added_with_their_sign(unit):
    x, y = pairs()
    z = angles(2)
    counts = (x != 0) | (y != 0)
    _, angle = unit.vector(1, -1, x, y, z)
    compare(angle - (z - np.arctan2(y, x)), vectoring_bound(unit, 1).angle, counts)
    counts = np.abs(y) < np.abs(x)
    _, angle = unit.vector(-1, -1, x, y, z)
    with np.errstate(all="ignore"):
        exact = z - np.arctanh(y / x)
    compare(angle - exact, vectoring_bound(unit, -1).angle, counts)


@pytest.mark.parametrize("unit", UNITS)
def test_product_and_quotient(unit):
    x, z = pairs()
    _, product = unit.rotate(0, x, np.zeros_like(x), z)
    compare(product - x * z, rotation_bound(unit, 0).relative * np.abs(x * z), x * z != 0)
    assert (product[x * z == 0] == 0).all()
    _, quotient = unit.vector(0, 1, x, z, np.zeros_like(x))
    with np.errstate(all="ignore"):
        exact = z / x
    compare(quotient - exact, vectoring_bound(unit, 0).angle * np.abs(exact), (x != 0) & (z != 0))
    assert (quotient[(x != 0) & (z == 0)] == 0).all()


@pytest.mark.parametrize("unit", UNITS)
def test_hyperbolic_rotation(unit):
    x, y, z = turned()
    results = unit.rotate(-1, x, y, z)
    grown, shrunk = (x + y) * np.exp(z), (x - y) * np.exp(-z)
    exact = (grown + shrunk) / 2, (grown - shrunk) / 2
    error = np.max(np.abs(np.subtract(results, exact)), axis=0)
    larger = np.max(np.abs(exact), axis=0)
    compare(error, rotation_bound(unit, -1).error(larger, 0.0), larger > 0)


@pytest.mark.parametrize("unit", UNITS)
def test_hyperbolic_vectoring(unit):
    x, y = pairs()
    bound = vectoring_bound(unit, -1)
    norm, angle = unit.vector(-1, 1, x, y, np.zeros_like(x))
    inside = np.abs(y) < np.abs(x)
    with np.errstate(all="ignore"):
        exact_norm, exact_angle = np.sqrt((x - y) * (x + y)), np.arctanh(y / x)
    compare(norm - exact_norm, bound.norm.error(exact_norm, 0.0), inside)
    compare(angle - exact_angle, bound.angle, inside)


@pytest.mark.parametrize("unit", UNITS)
def test_lightcone(unit):
    u, v = pairs()
    bound = lightcone_bound(unit)
    root, angle = unit.lightcone(u, v)
    inside = u * v > 0
    with np.errstate(all="ignore"):
        exact_root, exact_angle = np.sqrt(u * v), np.log(u / v) / 2
    compare(root - exact_root, bound.norm.error(exact_root, 0.0), inside)
    compare(angle - exact_angle, bound.angle, inside)


@pytest.mark.parametrize("m", [1, 0, -1])
def test_more_bits_and_iterations_have_smaller_bounds(m):
    coarse, fine = Cau(20, 18, None, 16, 22), Cau(26, 24, None, 16, 28)
    place = math.ldexp(1.0, -20), math.ldexp(1.0, -26)
    assert rotation_bound(fine, m).error(1.0, place[1]) < rotation_bound(coarse, m).error(1.0, place[0]) / 32
    assert vectoring_bound(fine, m).angle < vectoring_bound(coarse, m).angle / 32


def test_bounds_need_blocks_that_hold_operands():
    with pytest.raises(ValueError, match="20 fraction bits do not hold operands of 24 bits"):
        rotation_bound(Cau(20, 18, None, 24, 30), 1)
    with pytest.raises(ValueError, match="do not hold"):
        vectoring_bound(Cau(20, 18, None, 24, 30), 0)
    with pytest.raises(ValueError, match="do not hold"):
        lightcone_bound(Cau(20, 18, None, 24, 30))
