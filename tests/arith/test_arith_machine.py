"""Operations on words, constants, and the plain-data description of an arithmetic."""

import copy
from fractions import Fraction

import numpy as np
import pytest

from cordicc.arith.numbers.floating import SingleSystem
from cordicc.arith.numbers.formats import SINGLE, SINGLE_PI, Signal
from cordicc.arith.unit.arithmetic import Arithmetic, system_from_spec
from cordicc.ir.ops import angle_result

CAU = {"mantissa_bits": 32, "exponent_bits": 10, "iterations": 30}
SPEC = {
    "format": {"kind": "ieee-single"},
    "units": {"standard": CAU, "implicit": {**CAU, "rule": "single-rotation"}},
}
ARITHMETIC = Arithmetic.from_spec(SPEC)
NAN = float("nan")


SYSTEM = SingleSystem()


def signals(*words):
    return [Signal(np.asarray(w, dtype=np.float32), SINGLE) for w in words]


def run(op, *operands, kind="add", **params):
    (result,) = ARITHMETIC.execute(op, params, kind, signals(*operands), [SINGLE], None)
    return result.words.tolist()


def unit(op, params, kind, *operands):
    formats = [SINGLE, SINGLE]
    results = ARITHMETIC.execute(op, params, kind, signals(*operands), formats, angle_result(op, params))
    return [result.words for result in results]


def same(got, expected):
    return np.array_equal(got, np.array(expected, dtype=np.float32), equal_nan=True)


@pytest.mark.parametrize(
    ("op", "params", "operands", "expected"),
    [
        ("add", {}, ([1, 3e38, NAN], [2, 3e38, 1]), [3, NAN, NAN]),
        ("sub", {}, ([1, 1e-45], [2, 1e-45]), [-1, 0]),
        ("mul", {}, ([3, 1e-30, 1e30], [0.1, 1e-15, 1e30]), [np.float32(0.3), 1e-45, NAN]),
        ("cmul", {"factor": "0.33333334"}, ([3, 0, NAN],), [1, 0, NAN]),
        ("cmul", {"factor": "0.1"}, ([10],), [1]),
        ("shift", {"exponent": -3}, ([8, NAN],), [1, NAN]),
        ("shift", {"exponent": 5000}, ([8, 0],), [NAN, 0]),
        ("neg", {}, ([1, -2],), [-1, 2]),
        ("abs", {}, ([1, -2],), [1, 2]),
        ("sign", {}, ([5, -0.0, 0, -2, NAN],), [1, 0, 0, -1, NAN]),
        ("min", {}, ([1, NAN], [2, 2]), [1, NAN]),
        ("max", {}, ([1, 1], [2, NAN]), [2, NAN]),
        ("flip", {}, ([1, 1, 1, 1], [1, -1, -0.0, NAN]), [1, -1, 1, NAN]),
        ("select", {}, ([0, -1, 1, -0.0], [1, 1, 1, 1], [2, 2, NAN, 2]), [1, 2, NAN, 1]),
        ("guard", {"condition": "any"}, ([1, 1], [0, NAN]), [1, NAN]),
        ("guard", {"condition": "nonzero"}, ([1, 1], [-0.0, -1]), [NAN, 1]),
        ("guard", {"condition": "nonnegative"}, ([1, 1], [-0.0, -1]), [1, NAN]),
        ("guard", {"condition": "positive"}, ([1, 1], [0, 1]), [NAN, 1]),
    ],
)
def test_operations(op, params, operands, expected):
    assert same(run(op, *operands, **params), expected)


def test_sums_and_products_are_rounded_once():
    a, b = np.random.default_rng(0).normal(size=(2, 20000)).astype(np.float32)
    assert same(run("add", a, b), a + b)
    assert same(run("mul", a, b), a * b)


def test_wrap_never_crosses_pi_and_keeps_what_rounds_to_it():
    nearest = np.nextafter(SINGLE_PI, np.float32(4))
    above = float(np.nextafter(nearest, np.float32(4)))
    assert same(run("wrap", [SINGLE_PI, nearest, above]), [SINGLE_PI, SINGLE_PI, above - 2 * np.pi])
    assert same(run("wrap", [-SINGLE_PI, -nearest, -above]), [-SINGLE_PI, -SINGLE_PI, 2 * np.pi - above])


@pytest.mark.parametrize("scale", [1, 10, 1e4, 1e7, 1e12, 1e30])
def test_wrap_of_any_angle(scale):
    import mpmath

    mp = mpmath.MPContext()
    mp.prec = 200
    angles = (np.random.default_rng(1).normal(size=300) * scale).astype(np.float32)
    for angle, got in zip(angles.tolist(), run("wrap", angles), strict=True):
        exact = mp.mpf(angle) - 2 * mp.pi * mp.nint(mp.mpf(angle) / (2 * mp.pi))
        assert abs(got - exact) <= 0.51 * float(np.spacing(np.float32(abs(exact)))) + 1e-11 * (scale > 1e6)


def test_wrap_keeps_the_relative_accuracy_of_small_results():
    assert run("wrap", [6.2831855]) == [np.float32(1.7484555e-07)]


def test_unit_operations_pick_the_unit_by_kind():
    one = np.ones(3, dtype=np.float32)
    norm, angle = unit("vector", {"m": 1, "sign": 1}, "standard", one, one, one)
    assert norm == pytest.approx(2**0.5)
    assert angle == pytest.approx(1 + np.pi / 4)
    angle, rest = unit("implicit", {"m": 1, "branch": "+"}, "implicit", one, one, 0 * one)
    assert angle == pytest.approx(np.pi * 3 / 4)
    assert rest == pytest.approx(2**0.5)
    x, _ = unit("rotate", {"m": 0}, "standard", one, one, one)
    assert x.tolist() == [1, 1, 1]
    root, _ = unit("lightcone", {}, "standard", 4 * one, one)
    assert root == pytest.approx(2)


def test_scalars_broadcast():
    one = np.float32(1)
    norm, _ = unit("vector", {"m": 1, "sign": 1}, "standard", np.ones(4, np.float32), one, one)
    assert norm.shape == (4,)


@pytest.mark.parametrize(
    ("op", "params", "kind", "message"),
    [
        ("sin", {}, "standard", "unknown operation"),
        ("rotate", {"m": 2}, "standard", "coordinate system"),
        ("vector", {"m": 1, "sign": 0}, "standard", "sign"),
        ("implicit", {"m": 1, "branch": "none"}, "implicit", "branch"),
        ("implicit", {"m": 0, "branch": "+"}, "implicit", "branch"),
        ("rotate", {"m": 1}, "mul", "kind 'mul'"),
        ("guard", {"condition": "odd"}, "sign", "condition"),
        ("cmul", {"factor": "1/2"}, "cmul", "decimal"),
    ],
)
def test_execute_refuses(op, params, kind, message):
    count = {"sin": 1, "cmul": 1, "guard": 2}.get(op, 3)
    results = 1 if count < 3 else 2
    with pytest.raises(ValueError, match=message):
        ARITHMETIC.execute(op, params, kind, signals(*[[1]] * count), [SINGLE] * results, None)


def test_a_result_that_nobody_takes_is_not_made():
    one = signals([1], [1], [1])
    norm, angle = ARITHMETIC.execute("vector", {"m": 1, "sign": 1}, "standard", one, [None, SINGLE], 1)
    assert norm is None
    assert angle.format is SINGLE


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("format",), {"kind": "posit"}, "known: ieee-single, fixed-point"),
        (("format",), "single", "needs a 'kind'"),
        (("units",), [], "must be a mapping"),
        (("units", "standard"), {"mantissa_bits": 32}, "lacks exponent_bits, iterations"),
        (("units", "standard"), {**CAU, "colour": 1}, "unknown keys: colour"),
        (("units", "standard"), {**CAU, "mantissa_bits": 64}, "from 27 to 43"),
        (("units", "standard"), {**CAU, "iterations": True}, "integer"),
        (("units", "implicit"), {**CAU, "rule": "magic"}, "must be one of"),
    ],
)
def test_a_bad_description_is_refused(path, value, message):
    spec = copy.deepcopy(SPEC)
    inner = spec
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    with pytest.raises(ValueError, match=message):
        Arithmetic.from_spec(spec)


def test_constants_are_rounded_once():
    def constant(number):
        return SYSTEM.constant(SYSTEM.constant_text(number)).words

    half_way = Fraction(1) + Fraction(1, 2**24)
    assert constant(half_way) == 1
    assert constant(half_way + Fraction(1, 2**80)) == np.nextafter(np.float32(1), np.float32(2))
    least = Fraction(1, 2**126)
    assert constant(least) == constant(least - Fraction(1, 2**151)) == np.float32(2.0**-126)
    for small in (least - Fraction(1, 2**150), Fraction(1, 2**149), -Fraction(1, 10**400)):
        with pytest.raises(OverflowError, match="too small for IEEE single"):
            constant(small)
    assert constant(Fraction(0)) == 0
    assert constant(Fraction(2**128 - 2**104)) == np.finfo(np.float32).max
    assert SYSTEM.constant_text(Fraction(1, 10)) == "0.1"
    assert SYSTEM.constant("0.1").words == np.float32(0.1)


@pytest.mark.parametrize("text", ["1e40", "-1e400000000"])
def test_a_constant_beyond_the_format_overflows(text):
    with pytest.raises(OverflowError):
        SYSTEM.constant(text)


@pytest.mark.parametrize("text", ["1/3", "x", "nan", "1" * 300])
def test_a_constant_must_be_decimal(text):
    with pytest.raises(ValueError, match=r"."):
        SYSTEM.constant(text)


def test_system_spec_round_trips():
    assert system_from_spec(SYSTEM.spec()) == SYSTEM
