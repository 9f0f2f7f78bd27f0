"""Root-free kernels scaled within the iterations: results against mathematics, validity, domains."""

import math

import numpy as np
import pytest

from cordicc.arith.kernels import shift_sequences
from cordicc.studies import iterations
from cordicc.studies.scaled_kernels import implicit_scaled, rotate_scaled, vector_scaled

ANGLE_BITS = 40
BITS = 30
PAPER = shift_sequences.krieger96()
TABLE = shift_sequences.step_table(PAPER, ANGLE_BITS)
LAST = PAPER.resolution
ROUNDING = 2.5 * len(PAPER.shifts)
"""Units: an iteration errs by at most sqrt(2) (5/4 + 1/2), and no later product of norms exceeds 1.07."""

HYPERBOLIC = shift_sequences.Sequence(
    "hyperbolic", -1, shift_sequences.hyperbolic_shifts(15), True, (-1,) * 15
)
"""Not a scaling to 1: (1 - h^2)(1 + h^2) = 1 - h^4 of each step remains."""


def fixed(values, bits=BITS):
    return np.rint(np.ldexp(np.asarray(values, dtype=float), bits)).astype(np.int64)


def real(values, bits=BITS):
    return np.ldexp(values.astype(float), -bits)


def circle(count=4001):
    t = np.linspace(-math.pi, math.pi, count)
    return t, fixed(np.cos(t)), fixed(np.sin(t))


def test_rotation_over_the_whole_circle():
    t, _, _ = circle()
    x, y = np.full_like(t, 0.6), np.full_like(t, -0.8)
    x_end, y_end, z_end, valid = rotate_scaled(fixed(x), fixed(y), fixed(t, ANGLE_BITS), TABLE)
    assert valid.all()
    bound = LAST + math.ldexp(ROUNDING, -BITS) + 1e-10  # 1e-10: the product of scaling and gain is not 1
    assert np.abs(real(x_end) - (x * np.cos(t) - y * np.sin(t))).max() <= bound
    assert np.abs(real(y_end) - (y * np.cos(t) + x * np.sin(t))).max() <= bound
    assert np.abs(z_end).max() <= TABLE.angles[-1] + 1


def test_rotation_domain():
    edge = TABLE.domain
    z = np.array([edge, -edge, edge + 1, -edge - 1, 2 * edge])
    one = fixed(np.ones(5))
    result = rotate_scaled(one, one, z, TABLE)
    assert result.valid.tolist() == [True, True, False, False, False]
    assert np.abs(result.z[:2]).max() <= TABLE.angles[-1] + 1
    assert np.abs(result.z[2:]).min() > TABLE.angles[-1]
    assert math.ldexp(edge, -ANGLE_BITS) == pytest.approx(PAPER.domain, abs=1e-9)


def test_vectoring_over_the_whole_circle():
    _, x, y = circle()
    start = np.full_like(x, 12345)
    x_end, y_end, z_end, valid = vector_scaled(x, y, start, TABLE)
    assert valid.all()
    rounding = math.ldexp(ROUNDING, -BITS)
    side = np.where(x < 0, -1, 1)
    assert np.abs(real(x_end) - side).max() <= LAST**2 + rounding + 1e-10
    assert np.abs(real(y_end)).max() <= LAST + rounding
    with np.errstate(divide="ignore"):
        exact = np.arctan(y / x)
    exact[np.abs(x) < 4] = math.pi / 2 * np.sign(y[np.abs(x) < 4])
    assert np.abs(real(z_end - start, ANGLE_BITS) - exact).max() <= LAST + 2 * rounding
    zero = np.zeros(1, dtype=np.int64)
    assert not vector_scaled(zero, zero, zero, TABLE).valid[0]


def test_the_papers_rule_reports_its_failures():
    """Valid means that the target is reached, to the last angle."""
    rng = np.random.default_rng(1996)
    psi, t = rng.uniform(-math.pi, math.pi, 50_000), rng.uniform(-math.pi / 2, math.pi / 2, 50_000)
    x, y, target = fixed(np.cos(psi)), fixed(np.sin(psi)), fixed(np.sin(t))
    x_end, _, z_end, valid = implicit_scaled(x, y, target, np.zeros_like(x), TABLE)
    share = 1 - valid.mean()
    assert 0.005 < share < 0.03
    turned = real(z_end, ANGLE_BITS)
    residual = np.abs(np.sin(psi + turned) - np.sin(t))
    allowed = 2 * LAST + math.ldexp(4 * ROUNDING, -BITS)  # |x| + |y| is up to sqrt(2) R
    assert (residual[valid] <= allowed).all()
    assert residual[~valid].min() > LAST / 2
    assert residual.max() > 2e-4
    root = np.sqrt(np.maximum(1 - real(target) ** 2, 0))
    well = valid & (root > 0.01)
    assert np.abs(np.abs(real(x_end)) - root)[well].max() <= 200 * LAST


def test_the_papers_rule_without_a_solution_is_invalid():
    x, y, target = fixed([0.6, 0.0, 1.0, 0.0]), fixed([0.8, 0.0, 0.0, 0.25]), fixed([1.01, 0.0, -1.5, 0.3])
    assert not implicit_scaled(x, y, target, np.zeros_like(x), TABLE).valid.any()


@pytest.mark.parametrize("mode", ["rotation", "implicit"])
def test_every_row_is_that_of_high_precision(mode):
    """The paper's Tables 2 and 3 in integers: no row differs by more than its rounding."""
    number = iterations.mp.mpf
    for count in range(1, 23):
        part = shift_sequences.Sequence("part", 1, PAPER.shifts[:count], True, PAPER.eta[:count])
        table = shift_sequences.step_table(part, ANGLE_BITS)
        one = fixed([1.0])
        if mode == "rotation":
            angle = number("1.1780972451")
            state = iterations.rotate(part, iterations.State(number(1), number(1), angle)).end
            ends = rotate_scaled(one, one, fixed([2 * float(angle)], ANGLE_BITS), table)
        else:
            start = iterations.State(number(1), number(2), number(0), number(0.5))
            state = iterations.implicit_by_eq9(part, start).end
            ends = implicit_scaled(one, 2 * one, one >> 1, 0 * one, table)
        assert abs(float(state.x) - real(ends.x)[0]) <= math.ldexp(ROUNDING, -BITS)
        assert abs(float(state.y) - real(ends.y)[0]) <= math.ldexp(ROUNDING, -BITS)
        assert abs(2 * float(state.z) - real(ends.z, ANGLE_BITS)[0]) <= math.ldexp(count + 1, -ANGLE_BITS)


def test_hyperbolic_rotation_and_vectoring():
    table = shift_sequences.step_table(HYPERBOLIC, ANGLE_BITS)
    assert HYPERBOLIC.converges
    left = float(shift_sequences.exact_gain(HYPERBOLIC) * shift_sequences.exact_scaling(HYPERBOLIC))
    t = np.linspace(-HYPERBOLIC.domain, HYPERBOLIC.domain, 801)[1:-1]
    one, zero = fixed(np.full_like(t, 1.0)), fixed(np.zeros_like(t))
    turned = rotate_scaled(one, zero, fixed(t, ANGLE_BITS), table)
    last, growth = HYPERBOLIC.resolution, math.exp(HYPERBOLIC.domain)
    bound = growth * (last + math.ldexp(4 * len(HYPERBOLIC.shifts), -BITS))
    assert turned.valid.all()
    assert np.abs(real(turned.x) - left * np.cosh(t)).max() <= bound
    assert np.abs(real(turned.y) - left * np.sinh(t)).max() <= bound
    for side in (1, -1):
        x, y = fixed(side * np.cosh(t)), fixed(side * np.sinh(t))
        ends = vector_scaled(x, y, zero, table)
        assert ends.valid.all()
        assert np.abs(real(ends.z, ANGLE_BITS) - t).max() <= last + 1e-6
        assert np.abs(real(ends.x) - side * left).max() <= last**2 + 1e-6
    far = fixed([1.0, 1.0, 1.0, 0.0]), fixed([0.999, 1.0, -1.5, 0.0])
    assert not vector_scaled(*far, np.zeros(4, dtype=np.int64), table).valid.any()


def test_every_small_vector_is_measured_and_turned():
    """7 bits and 12 guard bits: norm and angle of every vector, and the way back, to the last angle."""
    guard = 12
    side = np.arange(-64, 65, dtype=np.int64)
    x, y = (v.ravel() for v in np.meshgrid(side, side))
    zero = np.zeros_like(x)
    norm, rest, angle, valid = vector_scaled(x << guard, y << guard, zero, TABLE)
    assert np.array_equal(valid, (x != 0) | (y != 0))
    x, y, norm, rest, angle = (v[valid] for v in (x, y, norm, rest, angle))
    exact = np.hypot(x, y)
    rounding = math.ldexp(ROUNDING, -guard)
    assert np.abs(np.abs(real(norm, guard)) - exact).max() <= rounding + 64 * LAST**2
    assert np.array_equal(norm < 0, x < 0)
    assert (np.abs(real(rest, guard)) <= exact * LAST + rounding).all()
    wanted = np.arctan2(np.where(x < 0, -y, y), np.abs(x))
    bound = LAST + 1.01 * np.arcsin(np.minimum(rounding / exact, 1)) + 1e-9
    assert (np.abs(real(angle, ANGLE_BITS) - wanted) <= bound).all()
    back = rotate_scaled(norm, np.zeros_like(norm), angle, TABLE)
    assert back.valid.all()
    assert np.abs(real(back.x, guard) - x).max() <= 3 * rounding + 64 * 2 * LAST
    assert np.abs(real(back.y, guard) - y).max() <= 3 * rounding + 64 * 2 * LAST
