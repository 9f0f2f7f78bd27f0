"""The hyperbolic implicit rules over every input of a small format end within their proven bound."""

import math

import numpy as np
import pytest

from cordicc.arith.kernels import micro_rotations, shift_sequences
from cordicc.arith.kernels.hyperbolic_bound import hyperbolic_residual_bound

GUARD_BITS = 10
ANGLE_BITS = 34


def solvable_inputs(bits, domain):
    """Every (A, B, C) with a solution, in reach: A >= |B|, A > 0, or |B| > |A| and C beyond sqrt(B^2 - A^2).

    The start that a unit gives the kernel: A < 0 with |A| >= |B| is negated, and the other branch mirrored.
    Returns A, B, C and the exact angle.
    """
    side = 1 << (bits - 1)
    numbers = np.arange(-side, side + 1, dtype=np.int64)
    A, B, C = (v.ravel() for v in np.meshgrid(numbers, numbers, numbers))
    square = A * A - B * B + C * C
    one = (np.abs(A) > np.abs(B)) & (A > 0)
    two = (np.abs(B) > np.abs(A)) & (square >= 0) & (C * B > 0)
    edge = (np.abs(A) == np.abs(B)) & (A > 0) & (C * B > 0)
    a, b, c = (v.astype(float) for v in (A, B, C))
    with np.errstate(divide="ignore", invalid="ignore"):
        norm = np.sqrt(np.abs(a * a - b * b))
        angle = np.where(one, np.arcsinh(c / norm) - np.arctanh(b / a), np.nan)
        upper = np.arccosh(np.maximum(np.abs(c) / norm, 1)) - np.arctanh(a / np.abs(b))
        angle = np.where(two, np.sign(b) * upper, angle)
        angle = np.where(edge, np.sign(b) * np.log(c / b), angle)
    reached = np.abs(angle) <= domain
    return A[reached], B[reached], C[reached], angle[reached]


PLAIN = shift_sequences.Sequence("plain", -1, tuple(range(1, 15)))
"""No shift twice: 1/16 to 1/8192 fall short of 1/8 by more than the last angle."""


@pytest.mark.parametrize(
    ("sequence", "bits", "inputs", "tightness"),
    [
        (shift_sequences.standard(-1, 12), 7, 472_560, 2),
        (shift_sequences.root_free(-1, 12), 7, 681_902, 2),
        (shift_sequences.standard(-1, 20), 6, 60_622, 4),
        (shift_sequences.root_free(-1, 20), 6, 87_380, 5),
        (PLAIN, 6, 58_154, 2),
    ],
    ids=["angle", "root-free-angle", "rounding", "root-free-rounding", "plain"],
)
def test_every_input_ends_within_the_bound(sequence, bits, inputs, tightness):
    table = shift_sequences.step_table(sequence, ANGLE_BITS)
    side = float(1 << (bits - 1))
    bound = hyperbolic_residual_bound(sequence, GUARD_BITS, ANGLE_BITS, side)
    assert bound.smallest_start < 1
    A, B, C, exact = solvable_inputs(bits, sequence.domain)
    assert len(A) == inputs
    kernel = micro_rotations.implicit_root_free if sequence.root_free else micro_rotations.implicit
    x, _, _, z = kernel(*(v << GUARD_BITS for v in (A, B, C)), np.zeros_like(A), table)
    z = np.ldexp(z.astype(float), -ANGLE_BITS)
    x = np.ldexp(x.astype(float), -GUARD_BITS) / sequence.gain
    a, b, c = (v.astype(float) for v in (A, B, C))
    residual = np.abs(b * np.cosh(z) + a * np.sinh(z) - c)
    allowed = bound.residual(a, b, c)
    assert (residual <= allowed).all()
    assert allowed.max() <= tightness * residual.max()
    root = np.sqrt((A * A - B * B + C * C).astype(float))
    assert (np.abs(np.abs(x) - root) <= bound.root(a, b, c)).all()
    assert (x >= bound.smallest_end_x(a, b, c)).all()
    well = root > 4
    assert (np.abs(z - exact)[well] <= 2 * allowed[well] / root[well]).all()  # dt = dC / root


def test_bound_is_for_hyperbolic_sequences():
    with pytest.raises(ValueError, match="no bound for circular"):
        hyperbolic_residual_bound(shift_sequences.standard(1, 20), 20, ANGLE_BITS)


def test_the_edge_of_two_branches_stays_near():
    """C = sqrt(B^2 - A^2) exactly (3-4-5): the double solution, where x ends near 0 from either side."""
    sequence = shift_sequences.standard(-1, 26)
    table = shift_sequences.step_table(sequence, ANGLE_BITS)
    start = [np.array([n * s << 20 for s in (1, 2, 5)], dtype=np.int64) for n in (-3, 5, 4)]
    x, _, _, z = micro_rotations.implicit(*start, np.zeros(3, dtype=np.int64), table)
    assert np.abs(np.ldexp(z.astype(float), -ANGLE_BITS) - math.atanh(3 / 5)).max() < 2e-3
    assert np.abs(np.ldexp(x.astype(float), -20)).max() < 0.02
