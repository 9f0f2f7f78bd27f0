"""Implicit operations over pairs of 8-bit words: residuals within their bounds, and no solution lost.

The reference is double precision, whose own error, below 2^-40 of a word, is nothing beside the units'.
"""

import numpy as np
import pytest

from cordicc.arith.unit.cau import Cau
from cordicc.arith.unit.implicit_bounds import implicit_bound
from tests.support.selection import slow

BITS = 8
TIGHTNESS = 4
LARGEST = (1 << (BITS - 1)) - 1
WORDS = np.arange(-LARGEST, LARGEST + 1, dtype=float)
RULES = ["single-rotation", "root-free"]
SHAPES = [
    pytest.param(16, 12, 18, id="angle-and-rounding"),
    pytest.param(16, 18, 24, id="rounding"),
    pytest.param(24, 10, 24, id="angle"),
]


def triples(circular):
    """Every pair (A, B) with zero, drawn and, circular, the largest solvable C; every (A, C) and (B, C)."""
    A, B = (v.ravel() for v in np.meshgrid(WORDS, WORDS))
    zero = np.zeros_like(A)
    drawn = np.random.default_rng(8).integers(-LARGEST, LARGEST + 1, len(A)).astype(float)
    rows = [(A, B, drawn), (A, zero, B), (zero, A, B), (A, B, zero)]
    if circular:
        top = np.minimum(np.floor(np.hypot(A, B)), LARGEST)
        rows += [(A, B, top), (A, B, -top), (A, B, np.round(top * drawn / LARGEST))]
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


def block_place(unit, A, B, C):
    largest = np.max(np.abs([A, B, C]), axis=0)
    return np.ldexp(1.0, np.frexp(largest)[1] - unit.fraction_bits)


def compare(error, bound, tightness=TIGHTNESS):
    assert (np.abs(error) <= bound).all()
    assert (bound <= tightness * np.abs(error)).any()


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("branch", ["+", slow("-")])
@pytest.mark.parametrize(("fraction_bits", "iterations", "angle_bits"), SHAPES)
def test_circular(rule, branch, fraction_bits, iterations, angle_bits):
    unit = Cau(fraction_bits, iterations, rule, BITS, angle_bits)
    A, B, C = triples(circular=True)
    norm = np.hypot(A, B)
    solvable = (C * C <= A * A + B * B) & (norm > 0)
    A, B, C, norm = A[solvable], B[solvable], C[solvable], norm[solvable]
    t, rest = unit.implicit(1, branch, A, B, C)
    assert not np.isnan(t).any()
    bound, place = implicit_bound(unit, 1), block_place(unit, A, B, C)
    # Nearer to the end of reach than the depth it may be the end instead.
    depth = np.where((A == 0) | (B == 0), 0.0, bound.depth(place, 0.0, alone=False))
    allowed = bound.residual.error(norm, place)
    beside = norm - np.abs(C) <= depth
    compare(B * np.cos(t) + A * np.sin(t) - C, np.where(beside, np.maximum(allowed, depth), allowed))
    exact = np.sqrt(A * A + B * B - C * C)
    assert (np.abs(rest - exact) <= bound.rest(norm, C, exact, place, np.where(beside, depth, 0.0))).all()


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("branch", ["-", slow("+")])
@pytest.mark.parametrize(("fraction_bits", "iterations", "angle_bits"), SHAPES)
def test_hyperbolic(rule, branch, fraction_bits, iterations, angle_bits):
    unit = Cau(fraction_bits, iterations, rule, BITS, angle_bits)
    A, B, C = triples(circular=False)
    same_sign, square = B * C > 0, A * A - B * B + C * C
    solvable = (np.abs(A) > np.abs(B)) | (same_sign & (square >= 0))
    A, B, C, square = A[solvable], B[solvable], C[solvable], square[solvable]
    t, rest = unit.implicit(-1, branch, A, B, C)
    assert not np.isnan(t).any()
    bound, exact = implicit_bound(unit, -1), np.sqrt(square)
    size = np.maximum(np.abs(C), exact)
    # Many iterations and few bits: a sum of the worst cases of all roundings, which do not come together.
    tightness = 12 if iterations > fraction_bits else TIGHTNESS
    compare(B * np.cosh(t) + A * np.sinh(t) - C, bound.residual.error(size, np.zeros_like(size)), tightness)
    assert (np.abs(rest - exact) <= bound.rest(size, C, exact, np.zeros_like(size))).all()


@pytest.mark.parametrize("m", [1, -1])
def test_a_unit_without_a_rule_has_no_bound(m):
    with pytest.raises(ValueError, match="no implicit mode"):
        implicit_bound(Cau(), m)


@pytest.mark.parametrize(("m", "fraction_bits"), [(1, 4), (-1, 8)])
def test_too_few_fraction_bits_have_no_bound(m, fraction_bits):
    with pytest.raises(ValueError, match="too few"):
        implicit_bound(Cau(fraction_bits, 20, "root-free", 4, 24), m)
