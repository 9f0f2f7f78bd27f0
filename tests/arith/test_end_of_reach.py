"""The end of reach, |C| = R: exact on every small word, by the rule derived in `kernels.end_of_reach`."""

import itertools
import math

import numpy as np
import pytest

from cordicc.arith.compiled import compiled_cau
from cordicc.arith.kernels import micro_rotations, shift_sequences
from cordicc.arith.kernels.end_of_reach import end_of_reach
from cordicc.arith.kernels.micro_rotations import NEVER, NearEnd
from cordicc.arith.numbers.slack import Slack
from cordicc.arith.unit.cau import Cau
from tests.support.selection import quick, slow

RULES = ["single-rotation", "root-free"]
BITS = 8
LARGEST = (1 << (BITS - 1)) - 1
WORDS = np.arange(-LARGEST, LARGEST + 1)


def sequence_of(rule, m, iterations):
    return (shift_sequences.root_free if rule == "root-free" else shift_sequences.standard)(m, iterations)


def started(rule, x, y, target):
    """Return a rule's kernel, and start and angle after its first turn."""
    z = np.zeros_like(x)
    if rule == "root-free":
        return micro_rotations.implicit_root_free, x, y, z
    quarter = (shift_sequences.pi_fixed(24) + 1) >> 1
    return micro_rotations.implicit, *micro_rotations.quarter_turn(x, y, target, z, quarter)


def triples():
    """Every A, B, C of 8 bits with C^2 = A^2 + B^2."""
    A, B = (v.ravel() for v in np.meshgrid(WORDS, WORDS))
    C = np.rint(np.hypot(A, B)).astype(int)
    kept = (C * C == A * A + B * B) & (C > 0) & (C <= LARGEST)
    A, B, C = A[kept], B[kept], C[kept]
    return [np.concatenate(pair).astype(float) for pair in ((A, A), (B, B), (C, -C))]


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("branch", ["+", "-"])
def test_every_exact_norm_gives_the_angle_of_the_end(rule, branch):
    unit = Cau(16, 16, rule, BITS, 24)
    A, B, C = triples()
    t, rest = unit.implicit(1, branch, A, B, C)
    exact = np.arctan2(A, B) + np.where(C > 0, 0, np.pi if branch == "+" else -np.pi)
    end = end_of_reach(sequence_of(rule, 1, 16), 16, 24)
    last = 2.0**-14  # of the angles, twice that of the standard step
    allowed = last + math.asin(end.along / end.smallest)
    assert np.abs(t - exact).max() <= allowed < math.sqrt(1 / end.smallest)
    alone = (A == 0) | (B == 0)
    assert np.array_equal(rest[alone], np.zeros(alone.sum()))
    assert np.abs(t - exact)[alone].max() <= 2.0**-23
    assert alone.sum() == 4 * (2 * LARGEST)


@pytest.mark.parametrize("rule", RULES)
def test_without_the_rule_the_end_is_missed(rule):
    """The same kernel by comparison alone: what it decides by chance leaves a hundred times as much."""
    table = shift_sequences.step_table(sequence_of(rule, 1, 16), 24)
    A, B, C = triples()
    blocks = (np.abs(C) > LARGEST / 2) & (A > 0)
    x, y, C = (v[blocks].astype(int) << 9 for v in (A, B, C))
    kernel, x, y, z = started(rule, x, y, C)
    end = end_of_reach(sequence_of(rule, 1, 16), 16, 24)
    near = NearEnd(math.ceil(end.height(0.0)), math.ceil(end.rise(0.0) + end.room(0.0)))
    plain, exact = (np.abs(kernel(x, y, C, z, table, each)[0]) for each in (None, near))
    assert plain.max() > 50 * exact.max()


@pytest.mark.parametrize("rule", quick(RULES, "single-rotation"))
def test_elsewhere_nothing_changes(rule):
    """Every x > 0, y and C of 7 bits: where the rule decides otherwise C is within the depth of R."""
    bits, guard, iterations = 7, 8, 16
    sequence = sequence_of(rule, 1, iterations)
    table = shift_sequences.step_table(sequence, 24)
    end = end_of_reach(sequence, bits - 1 + guard, 24)
    near = NearEnd(math.ceil(end.height(0.0)), math.ceil(end.rise(0.0) + end.room(0.0)))
    side = np.arange(-(1 << (bits - 1)) + 1, 1 << (bits - 1))
    changed = 0
    for column in range(1, 1 << (bits - 1)):
        y, C = (v.ravel() for v in np.meshgrid(side, side))
        x = np.full_like(y, column)
        # Of blocks: the largest number has all the bits.
        whole = (np.maximum(np.maximum(x, np.abs(y)), np.abs(C)) >= 1 << (bits - 2)) & (
            x * x + y * y >= C * C
        )
        x, y, C = (v[whole] << guard for v in (x, y, C))
        gap = np.hypot(x, y) - np.abs(C)
        kernel, x, y, z = started(rule, x, y, C)
        differs = kernel(x, y, C, z, table)[3] != kernel(x, y, C, z, table, near)[3]
        assert (gap[differs] <= end.depth(0.0)).all()
        changed += differs.sum()
    assert changed > 0


@pytest.mark.parametrize("rule", RULES)
def test_the_least_of_a_hyperbola(rule):
    unit = Cau(24, 24, rule, 16, 30)
    B, A, C = np.array(
        [(5, 3, 4), (5, 4, 3), (13, 12, 5), (13, -5, 12), (17, 8, 15), (1, 0, 1), (-1, 0, -1)]
    ).T
    for branch, sign in itertools.product("+-", (1, -1)):
        t, rest = unit.implicit(
            -1, branch, sign * A.astype(float), sign * B.astype(float), sign * C.astype(float)
        )
        exact = -np.arctanh(A / B)
        assert np.abs(t - exact).max() < 2e-6
        assert np.abs(rest).max() < 1e-4
        assert (t[A == 0] == 0).all()


@pytest.mark.parametrize("rule", RULES)
def test_a_slack_makes_the_end_of_what_is_beyond_and_no_more(rule):
    unit = Cau(29, 30, rule, 24, 32)
    slack = Slack(2.0**-12, 2.0**-13)
    offsets = np.array([-(2.0**-9), -(2.0**-13), 2.0**-13, 2.0**-12, 2.0**-11])
    for A, B in ((0.0, 5.0), (3.0, 4.0)):
        for m, branch in itertools.product((1, -1), "+-"):
            norm = 5.0 if m == 1 else math.sqrt(B * B - A * A)
            norm = float(np.float32(norm))
            C = norm + m * offsets
            t, _ = unit.implicit(m, branch, A, B, C, slack=slack)
            end = math.atan2(A, B) if m == 1 else -math.atanh(A / B)
            assert np.isnan(t).tolist() == [False, False, False, False, True]
            assert np.abs(t - end)[1:4].max() < 1e-6
            assert abs(t[0] - end) > 1e-2
            assert np.isnan(unit.implicit(m, branch, A, B, C)[0]).tolist()[2:] == [True, True, True]


def test_a_relative_slack_is_one_of_the_operands_size():
    unit = Cau(29, 30, "single-rotation", 24, 32)
    slack = Slack(2.0**-14, 2.0**-14, relative=True)
    for scale in (2.0**-60, 1.0, 2.0**60):
        C = scale * np.array([5 + 2.0**-12, 5 + 2.0**-8])
        t, _ = unit.implicit(1, "+", 3 * scale, 4 * scale, C, slack=slack)
        assert np.isnan(t).tolist() == [False, True]


def test_roots_of_what_is_negative_by_the_slack_are_0():
    unit = Cau(29, 30, None, 24, 32)
    slack = Slack(2.0**-16)
    y = np.array([1.0, 1 + 2.0**-17, 1 + 2.0**-15])
    assert unit.vector(-1, 1, 1.0, y, 0.0, slack=slack)[0].tolist()[:2] == [0.0, 0.0]
    assert np.isnan(unit.vector(-1, 1, 1.0, y, 0.0, slack=slack)[0]).tolist() == [False, False, True]
    u = -np.array([0.0, 2.0**-17, 2.0**-15])
    assert np.isnan(unit.lightcone(u, 1.0, slack=slack)[0]).tolist() == [False, False, True]
    assert np.isnan(unit.lightcone(u, 1.0)[0]).tolist() == [False, True, True]
    small = np.array([2.0**-17, 2.0**-20])
    assert unit.lightcone(small, 1.0, slack=slack)[0] == pytest.approx(np.sqrt(small), rel=1e-6)


@pytest.mark.parametrize("size", [(0.1, 0.2), (-1.0, 0.0), (math.inf, 0.0), (math.nan, 0.0), (1e-300, 0.0)])
def test_sizes_that_are_no_slack(size):
    with pytest.raises(ValueError, match=r"no slack|within reach"):
        Slack(*size)


def test_a_height_of_never_stays_below_0():
    assert all(NearEnd(NEVER, 0).before(share).height < 0 for share in range(1, shift_sequences.SHARES + 1))


@pytest.mark.skipif(not compiled_cau.available(), reason="numba is optional")
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("rule", ["single-rotation", slow("root-free")])
def test_compiled_units_have_the_same_bits_at_the_end(rule):
    unit = Cau(29, 30, rule, 24, 32)
    fast = compiled_cau.CompiledCau(29, 30, rule, 24, 32)
    rng = np.random.default_rng(5)
    A, B, C = (np.resize(v, 3000) for v in triples())
    C = C + rng.integers(-3, 4, C.size) * rng.choice([0.0, 2.0**-6, 1.0], C.size)
    for slack in (Slack(), Slack(2.0**-6, 2.0**-7), Slack(0.001, 0.0003, relative=True)):
        for m, branch in ((1, "+"), (1, "-"), (-1, "+"), (-1, "-"), (-1, "none")):
            made = [each.implicit(m, branch, A, B, C, slack=slack) for each in (unit, fast)]
            made += [each.implicit(m, branch, A, C, B, slack=slack) for each in (unit, fast)]
            for first, second in (made[:2], made[2:]):
                assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(first, second, strict=True))
        roots = [each.vector(-1, 1, A, C, B, slack=slack) for each in (unit, fast)]
        assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(*roots, strict=True))
