"""The implicit mode: own value of the formula, residual, branches, edges, small widths exhaustively."""

import itertools

import mpmath
import numpy as np
import pytest

from cordicc.arith.kernels import micro_rotations, shift_sequences
from cordicc.arith.numbers.formats import SINGLE_PI
from tests.support.single_unit import SingleUnit

mp = mpmath.MPContext()
mp.prec = 300
UNITS = [SingleUnit(rule="single-rotation"), SingleUnit(rule="root-free")]
units = pytest.mark.parametrize("unit", UNITS, ids=["single-rotation", "root-free"])
branches = pytest.mark.parametrize("branch", ["+", "-"])
EDGE = 2.0**-22
"""|C|/R within this of 1: either answer is right, and the end of reach with a rest of 0 too."""


def words(values):
    return np.asarray(values, dtype=np.float32)


def ulp(value):
    return float(np.spacing(np.float32(abs(float(value)))))


def circular_cases():
    rng = np.random.default_rng(11)
    a, b = rng.normal(size=(2, 300))
    c = np.hypot(a, b) * rng.uniform(-1.05, 1.05, size=300)
    rows = list(zip(a, b, c, strict=True))
    rows += [(s * x, s * y, s * z) for x, y, z in rows[:20] for s in (1e-35, 1e30)]
    near = 1 - 2.0 ** -np.arange(4, 26, dtype=float)
    for t, (x, y, _), s in itertools.product(near, rows[:3], (1, -1)):
        rows.append((x, y, s * np.hypot(x, y) * t))
    axis = [-2.0, -1.0, -0.0, 0.0, 1.0, 1e-20, -1e-20]
    rows += list(itertools.product(axis, axis, [-1.0, -0.5, 0.0, 0.5, 1.0]))
    return words(rows).T


def exact_circular(branch, A, B, C):
    A, B, C = (mp.mpf(float(v)) for v in (A, B, C))
    R = mp.hypot(A, B)
    if R == 0:
        return None
    if abs(C) > R:
        return None
    offset = mp.acos(C / R)
    return mp.atan2(A, B) + (offset if branch == "+" else -offset), mp.sqrt((R - C) * (R + C))


@units
@branches
def test_circular_gives_the_formulas_own_value(unit, branch):
    A, B, C = circular_cases()
    angle, rest = unit.implicit(1, branch, A, B, C)
    for i in range(len(A)):
        R = mp.hypot(mp.mpf(float(A[i])), mp.mpf(float(B[i])))
        exact = exact_circular(branch, A[i], B[i], C[i])
        assert np.isnan(angle[i]) == np.isnan(rest[i])
        if R == 0 or abs(abs(float(C[i])) - R) > EDGE * R:
            assert np.isnan(angle[i]) == (exact is None), (A[i], B[i], C[i])
        if exact is None or np.isnan(angle[i]):
            continue
        condition = max(1, min(R / exact[1] if exact[1] else mp.inf, 2**13))
        bound = 2.0**-24 * condition + ulp(exact[0]) / 2 + (2.0**-23 if abs(exact[0]) > 3.14 else 0)
        assert abs(float(angle[i]) - exact[0]) <= bound, (A[i], B[i], C[i])
        allowed = (0.6 + 0.25 * condition) * ulp(R)
        if R - abs(float(C[i])) <= EDGE * R:
            allowed += exact[1]
        assert abs(float(rest[i]) - exact[1]) <= allowed
        assert rest[i] >= 0


@units
@branches
def test_circular_residual_over_a_whole_lattice(unit, branch):
    side = np.arange(-12, 13, dtype=np.float32)
    A, B, C = (t.ravel() for t in np.meshgrid(side, side, side))
    angle, _ = unit.implicit(1, branch, A, B, C)
    a, b, c, t = (v.astype(np.float64) for v in (A, B, C, angle))
    radius = np.hypot(a, b)
    assert np.array_equal(np.isnan(t), (radius == 0) | (np.abs(c) > radius + 1e-12))
    solved = ~np.isnan(t)
    residual = np.abs(b * np.cos(t) + a * np.sin(t) - c)[solved] / radius[solved]
    assert residual.max() < 2.0**-21  # half an ulp of an angle up to 2 pi is 2^-22
    offset = np.arccos(np.clip(c[solved] / radius[solved], -1, 1))
    own = np.arctan2(a, b)[solved] + (offset if branch == "+" else -offset)
    assert np.abs(t[solved] - own).max() < 2.0**-12


@units
@branches
def test_acos_stays_within_pi(unit, branch):
    angle, rest = unit.implicit(1, branch, words([0.0, 0.0]), words([1.0, 1.0]), words([-1.0, 1.0]))
    assert abs(angle[0]) == pytest.approx(np.pi, abs=2e-4)
    assert abs(angle[0]) <= SINGLE_PI
    assert abs(angle[1]) < 2e-4
    assert (rest < 2e-4).all()


@pytest.mark.parametrize("root_free", [False, True])
def test_every_small_vector_and_target_converges(root_free):
    """6-bit operands with guard bits: the residual stays below a tenth of a unit in the last place."""
    guard, iterations = 8, 14
    make = shift_sequences.root_free if root_free else shift_sequences.standard
    table = shift_sequences.step_table(make(1, iterations), 20)
    kernel = micro_rotations.implicit_root_free if root_free else micro_rotations.implicit
    side = np.arange(-31, 32, dtype=np.int64)
    x, y, t = (v.ravel() for v in np.meshgrid(side[31:], side, side))
    solvable = (t * t <= x * x + y * y) & ((x != 0) | (y != 0))
    x, y, t = (v[solvable] << guard for v in (x, y, t))
    z = np.zeros_like(x)
    start_x, start_y = x, y
    if not root_free:
        x, y, z = micro_rotations.quarter_turn(x, y, t, z, shift_sequences.pi_fixed(20) // 2)
    end_x, end_y, end_t, z = kernel(x, y, t, z, table)
    gain = float(shift_sequences.exact_gain(make(1, iterations)))
    assert np.abs(end_y - end_t).max() <= 0.1 * gain * 2**guard
    turned = np.ldexp(z.astype(float), -20)
    residual = start_y * np.cos(turned) + start_x * np.sin(turned) - t
    assert np.abs(residual).max() <= 0.1 * 2**guard
    exact_x = np.sqrt((start_x**2 + start_y**2 - t**2).astype(float)) * gain
    well = exact_x > 8 * 2**guard
    assert np.abs(end_x - exact_x)[well].max() <= 0.5 * gain * 2**guard
    assert end_x.min() >= -0.75 * gain * 2**guard


def hyperbolic_cases():
    rng = np.random.default_rng(12)
    rows = list(rng.normal(size=(250, 3)))
    rows += list(rng.normal(size=(150, 3)) * 10.0 ** rng.uniform(-12, 12, size=(150, 3)))
    for theta in rng.uniform(-30, 30, size=60):
        a, b = rng.normal(size=2)
        a, b = float(np.float32(a)), float(np.float32(b))
        rows.append((a, b, b * np.cosh(theta) + a * np.sinh(theta)))
    values = [-2.0, -1.0, 0.0, 0.5, 1.0]
    rows += list(itertools.product(values, values, values))
    return words(rows).T


def exact_hyperbolic(branch, A, B, C):
    """The contract's formulas; the logarithm where |A| = |B|.  None without a solution."""
    A, B, C = (mp.mpf(float(v)) for v in (A, B, C))
    square = A * A - B * B + C * C
    if abs(A) == abs(B):
        if A == 0 or C / B <= 0:
            return None
        t = mp.log(C / B)
        return (t if A == B else -t), abs(C)
    if square < 0:
        return None
    if abs(A) > abs(B):
        norm = mp.sqrt(A * A - B * B) * mp.sign(A)
        return mp.asinh(C / norm) - mp.atanh(B / A), mp.sqrt(square)
    if branch == "none":
        return None
    ratio = C / (mp.sign(B) * mp.sqrt(B * B - A * A))
    if ratio < 1:
        return None
    return -mp.atanh(A / B) + (1 if branch == "+" else -1) * mp.acosh(ratio), mp.sqrt(square)


@units
@pytest.mark.parametrize("branch", ["+", "-", "none"])
def test_hyperbolic_against_the_formula(unit, branch):
    A, B, C = hyperbolic_cases()
    angle, rest = unit.implicit(-1, branch, A, B, C)
    for i in range(len(A)):
        a, b, c = (mp.mpf(float(v[i])) for v in (A, B, C))
        exact = exact_hyperbolic(branch, A[i], B[i], C[i])
        edge = abs(a * a - b * b + c * c) <= 2.0**-20 * (c * c) and abs(b) > abs(a)
        if not edge:
            assert np.isnan(angle[i]) == (exact is None), (A[i], B[i], C[i])
        if exact is None or np.isnan(angle[i]):
            continue
        t, w = exact
        condition = max(1, min(max(abs(c), w) / w if w else mp.inf, 2**13))
        assert abs(float(angle[i]) - t) <= 2.0**-24 * condition + ulp(t) / 2, (A[i], B[i], C[i])
        assert abs(float(rest[i]) - w) <= 1.5 * condition * ulp(max(w, abs(c))), (A[i], B[i], C[i])


@units
def test_hyperbolic_without_a_vector_is_invalid(unit):
    zero = words([0.0])
    assert np.isnan(unit.implicit(-1, "none", zero, zero, zero)).all()
    assert np.isnan(unit.implicit(-1, "none", zero, zero, words([1.0]))).all()
