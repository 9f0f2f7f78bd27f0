"""The unit's functions on words against mpmath, with the error bounds the unit states."""

import mpmath
import numpy as np
import pytest

from cordicc.arith.numbers.formats import SINGLE_PI
from cordicc.arith.unit.cau import Cau
from tests.support.single_unit import SingleUnit

ANGLE_BOUND = 2.0**-24
SAMPLES = 400
SINGLE_ROTATION = SingleUnit(rule="single-rotation")
ROOT_FREE = SingleUnit(rule="root-free")
UNIT = SINGLE_ROTATION
mp = mpmath.MPContext()
mp.prec = 300


def words(values):
    return np.asarray(values, dtype=np.float32)


def bits(pattern):
    return np.uint32(pattern).view(np.float32)


def ulp(value):
    return float(np.spacing(np.float32(min(abs(float(value)), 3e38))))


def triples(seed, spread=1.0):
    """Random operands, then axes, tiny and huge ones."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(SAMPLES, 3)) * spread
    edge = [0.0, -0.0, 1.0, -1.0, 1e-30, -1e-30, 1e-42, 1e30, -1e30, 0.75, 3.0]
    grid = [(x, y, z) for x in edge for y in edge for z in (0.0, 0.5, -3.0)]
    return words(np.concatenate([rows, grid])).T


def angle_tolerance(value):
    return ANGLE_BOUND + ulp(value) / 2


@pytest.mark.parametrize("scale", [1.0, 1e-3, 100.0, 1e6, 1e20, 3e37])
def test_circular_rotation_reduces_any_argument(scale):
    x, y, z = triples(1)
    z = words(z.astype(float) * scale)
    z[~np.isfinite(z)] = 2.5
    first, second = UNIT.rotate(1, x, y, z)
    for i in range(len(x)):
        X, Y, Z = mp.mpf(float(x[i])), mp.mpf(float(y[i])), mp.mpf(float(z[i]))
        bound = 1.0 * ulp(mp.hypot(X, Y))
        assert abs(float(first[i]) - (X * mp.cos(Z) - Y * mp.sin(Z))) <= bound
        assert abs(float(second[i]) - (Y * mp.cos(Z) + X * mp.sin(Z))) <= bound


def test_linear_rotation_is_a_product_and_sum():
    x, y, z = triples(2)
    first, second = UNIT.rotate(0, x, y, z)
    assert np.array_equal(first, x)
    for i in range(len(x)):
        product = mp.mpf(float(x[i])) * mp.mpf(float(z[i]))
        exact = product + mp.mpf(float(y[i]))
        assert abs(float(second[i]) - exact) <= 0.75 * max(ulp(exact), ulp(product))


@pytest.mark.parametrize("scale", [1.0, 10.0, 60.0])
def test_hyperbolic_rotation_of_any_argument(scale):
    x, y, z = triples(3)
    z = words(z.astype(float) * scale)
    first, second = UNIT.rotate(-1, x, y, z)
    for i in range(len(x)):
        X, Y, Z = mp.mpf(float(x[i])), mp.mpf(float(y[i])), mp.mpf(float(z[i]))
        for got, exact in (
            (first[i], X * mp.cosh(Z) + Y * mp.sinh(Z)),
            (second[i], Y * mp.cosh(Z) + X * mp.sinh(Z)),
        ):
            if abs(exact) > 3.4028235e38:
                assert np.isnan(got) or abs(exact) < 3.402824e38
                continue
            size = max(abs((X + Y) * mp.exp(Z)), abs((X - Y) * mp.exp(-Z))) / 2
            if size < 3e38:
                assert abs(float(got) - exact) <= 1.25 * ulp(size)


@pytest.mark.parametrize("angle_bits", [8, 12, 15, 16])
def test_hyperbolic_rotation_with_few_bits_of_the_angle(angle_bits):
    unit = Cau(fraction_bits=20, iterations=18, operand_bits=8, angle_bits=angle_bits)
    z = np.array([-6.0, -1.5, 0.5, 2.0, 3.0, 10.0])
    grown, other = unit.rotate(-1, np.ones(6), np.zeros(6), z)
    share = (unit.iterations + 3) * 2.0 ** (-angle_bits - 1)
    np.testing.assert_allclose(grown, np.cosh(z), rtol=share)
    np.testing.assert_allclose(other, np.sinh(z), rtol=2 * share)


@pytest.mark.parametrize("exponent", [-190, -150, 0, 100, 150, 183])
def test_circular_rotation_of_any_word(exponent):
    """Words of the fewest fraction bits reach 2^184; the angle is reduced exactly there too."""
    z = np.array([1.0, 0.625, -0.875]) * 2.0**exponent
    first, second = Cau().rotate(1, np.ones(3), np.zeros(3), z)
    for i, angle in enumerate(z):
        exact = mp.mpf(float(angle))
        assert abs(float(first[i]) - mp.cos(exact)) < 2.0**-24
        assert abs(float(second[i]) - mp.sin(exact)) < 2.0**-24


@pytest.mark.parametrize(("x", "y"), [(1.0, 1.0), (1.0, -1.0), (1.0, 0.99999994), (3.0, -2.9999998)])
def test_hyperbolic_rotation_keeps_a_small_light_cone_coordinate(x, y):
    z = words([-8.0, -1.0, 0.3, 5.0, 20.0])
    first, second = UNIT.rotate(-1, words(x), words(y), z)
    X, Y = mp.mpf(float(words(x))), mp.mpf(float(words(y)))
    for i, t in enumerate(z):
        exact = X * mp.cosh(float(t)) + Y * mp.sinh(float(t))
        assert abs(float(first[i]) - exact) <= 2.0 * ulp(exact)
        exact = Y * mp.cosh(float(t)) + X * mp.sinh(float(t))
        assert abs(float(second[i]) - exact) <= 2.0 * ulp(max(abs(exact), abs(float(first[i])) / 2**20))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("with_z", [True, False])
def test_circular_vectoring(sign, with_z):
    x, y, z = triples(4)
    z = z if with_z else np.zeros_like(z)
    norm, angle = UNIT.vector(1, sign, x, y, z)
    for i in range(len(x)):
        X, Y, Z = mp.mpf(float(x[i])), mp.mpf(float(y[i])), mp.mpf(float(z[i]))
        exact = mp.hypot(X, Y)
        assert abs(float(norm[i]) - exact) <= 0.8 * ulp(exact)
        if X == 0 and Y == 0:
            assert np.isnan(angle[i])
            continue
        exact = Z + sign * mp.atan2(Y, X)
        assert abs(float(angle[i]) - exact) <= angle_tolerance(exact) + (2.0**-22 if abs(exact) > 3.14 else 0)
        if abs(exact) <= mp.pi:
            assert abs(angle[i]) <= SINGLE_PI


def test_angle_of_the_negative_axis_is_the_largest_single_below_pi():
    y = words([0.0, -0.0, 1e-30, -1e-30, -1e-12, 1e-9])
    _, angle = UNIT.vector(1, 1, words(-1.0), y, words(0.0))
    assert angle.view(np.uint32).tolist() == [0x40490FDA] * 3 + [0xC0490FDA] * 2 + [0x40490FDA]


def test_an_angle_beyond_pi_is_kept_when_the_sum_says_so():
    _, angle = UNIT.vector(1, 1, words(-1.0), words(0.0), words([2.0**-21, -(2.0**-21), 1.0]))
    assert angle[0] > np.pi > angle[1]
    assert angle[2] == pytest.approx(np.pi + 1)


def test_vectoring_adds_to_large_angles():
    _, angle = UNIT.vector(1, 1, words([1.0, 1.0, 0.0]), words([1.0, 1.0, -2.0]), words([1e6, 1e30, -100.0]))
    assert angle.tolist() == words([1e6 + np.pi / 4, 1e30, -100 - np.pi / 2]).tolist()


@pytest.mark.parametrize("sign", [1, -1])
def test_linear_vectoring_divides(sign):
    x, y, z = triples(5)
    norm, quotient = UNIT.vector(0, sign, x, y, z)
    assert np.array_equal(norm, x)
    for i in range(len(x)):
        if x[i] == 0:
            assert np.isnan(quotient[i])
            continue
        ratio = mp.mpf(float(y[i])) / mp.mpf(float(x[i]))
        exact = mp.mpf(float(z[i])) + sign * ratio
        if abs(exact) > 3.4e38:
            assert np.isnan(quotient[i])
        else:
            assert abs(float(quotient[i]) - exact) <= 0.75 * max(ulp(exact), ulp(ratio))


def test_hyperbolic_vectoring_over_its_whole_domain():
    rng = np.random.default_rng(6)
    x = words(rng.normal(size=SAMPLES) * 10.0 ** rng.uniform(-20, 20, size=SAMPLES))
    y = words(x.astype(float) * np.tanh(rng.uniform(-9, 9, size=SAMPLES)))
    z = words(rng.normal(size=SAMPLES))
    norm, angle = UNIT.vector(-1, -1, x, y, z)
    for i in range(SAMPLES):
        X, Y = mp.mpf(float(x[i])), mp.mpf(float(y[i]))
        exact = mp.sqrt(X * X - Y * Y)
        assert abs(float(norm[i]) - exact) <= 1.0 * ulp(exact)
        if abs(X) == abs(Y):
            assert np.isnan(angle[i])
            continue
        exact = mp.mpf(float(z[i])) - mp.atanh(Y / X)
        assert abs(float(angle[i]) - exact) <= angle_tolerance(exact)


@pytest.mark.parametrize(
    ("x", "y", "norm", "angle"),
    [
        (1, 1, 0.0, None),
        (1, -1, 0.0, None),
        (0, 0, 0.0, None),
        (1, 2, None, None),
        (0, 1, None, None),
        (-5, 4, 3.0, -np.log(3)),
        (1e-40, 0, 1e-40, 0.0),
        (3e38, 0, 3e38, 0.0),
    ],
)
def test_hyperbolic_vectoring_at_the_edges(x, y, norm, angle):
    got = UNIT.vector(-1, 1, words([x]), words([y]), words([0.0]))
    for value, expected in zip(got, (norm, angle), strict=True):
        if expected is None:
            assert np.isnan(value[0])
        else:
            assert abs(float(value[0]) - expected) <= angle_tolerance(0) * max(1, abs(expected))


def test_light_cone_gives_roots_and_logarithms():
    rng = np.random.default_rng(7)
    u, v = words(np.exp(rng.uniform(-85, 85, size=(2, SAMPLES))))
    flip = rng.choice([-1, 1], size=SAMPLES).astype(np.float32)
    root, angle = UNIT.lightcone(u * flip, v * flip)
    for i in range(SAMPLES):
        exact = mp.sqrt(mp.mpf(float(u[i])) * mp.mpf(float(v[i])))
        assert abs(float(root[i]) - exact) <= 0.8 * ulp(exact)
        exact = mp.log(mp.mpf(float(u[i])) / mp.mpf(float(v[i]))) / 2
        assert abs(float(angle[i]) - exact) <= angle_tolerance(exact)


def test_light_cone_domain():
    root, angle = UNIT.lightcone(words([0, 1, 0, 1, -1, 0, np.nan]), words([1, 0, 0, -1, 1, -1, 1]))
    assert np.nan_to_num(root, nan=9).tolist() == [0, 0, 0, 9, 9, 0, 9]
    assert np.isnan(angle).all()


def test_light_cone_of_subnormal_numbers():
    w = words([1e-45, 1e-40, 1.1754944e-38])
    root, angle = UNIT.lightcone(w, words(1.0))
    assert root == pytest.approx(np.sqrt(w.astype(float)), rel=1e-7)
    assert 2 * angle == pytest.approx(np.log(w.astype(float)), abs=1e-5)


@pytest.mark.parametrize("call", [lambda a: UNIT.rotate(1, a, words(1), words(1)),
                                  lambda a: UNIT.vector(0, 1, words(1), words(1), a),
                                  lambda a: UNIT.lightcone(a, words(1)),
                                  lambda a: UNIT.implicit(1, "-", words(1), a, words(0))])  # fmt: skip
def test_an_invalid_operand_makes_both_results_invalid(call):
    first, second = call(words([np.nan, 1.0]))
    assert np.isnan(first).tolist() == [True, False] == np.isnan(second).tolist()


def test_overflow_is_invalid():
    assert np.isnan(UNIT.vector(1, 1, words([3e38]), words([3e38]), words([0.0]))[0][0])
    assert np.isnan(UNIT.rotate(-1, words([1.0]), words([0.0]), words([100.0]))[0][0])


def test_a_unit_without_a_rule_has_no_implicit_mode():
    with pytest.raises(ValueError, match="no implicit mode"):
        SingleUnit().implicit(1, "-", words(1), words(1), words(0))


def test_a_result_beyond_the_exponent_inside_is_infinite_and_one_below_it_zero():
    unit = SINGLE_ROTATION.cau
    big, small = np.array([2.0**127]), np.array([2.0**-149])
    grown, _ = unit.rotate(-1, big, big, np.array([300.0]))
    assert grown[0] == np.inf
    shrunk, _ = unit.rotate(-1, small, -small, np.array([300.0]))
    assert shrunk[0] == 0.0
    product, _ = unit.vector(0, 1, small, big, np.array([0.0]))[::-1]
    assert product[0] == pytest.approx(2.0**276, rel=1e-6)  # within the unit, although no single holds it


@pytest.mark.parametrize("special", [np.nan, np.inf])
def test_words_that_are_no_numbers_make_every_result_invalid(special):
    from cordicc.arith.numbers.formats import SINGLE

    bad = SINGLE.encode(np.array([special, 1.0]))
    good = words([1.0, 1.0])
    for operands in ((bad, good, good), (good, bad, good), (good, good, bad)):
        for results in (
            UNIT.rotate(1, *operands),
            UNIT.vector(1, 1, *operands),
            UNIT.rotate(-1, *operands),
            UNIT.implicit(1, "-", *operands),
        ):
            assert all(np.isnan(result[0]) and not np.isnan(result[1]) for result in results)


def test_results_underflow_gradually_and_overflow_to_invalid():
    least = words([2.0**-149])
    norm, _ = UNIT.vector(1, 1, least, 0 * least, 0 * least)
    assert norm == least
    huge = words([3.4e38])
    assert np.isnan(UNIT.vector(1, 1, huge, huge, 0 * huge)[0])[0]
