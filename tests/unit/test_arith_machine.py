"""Operations on words, constants, and the plain-data description of an arithmetic."""

import copy
from fractions import Fraction

import numpy as np
import pytest

from cordicc.arith.formats import SINGLE, SINGLE_PI, format_from_spec
from cordicc.arith.machine import Arithmetic

CAU = {"mantissa_bits": 32, "exponent_bits": 10, "iterations": 30}
SPEC = {
    "format": {"kind": "ieee-single"},
    "units": {"standard": CAU, "implicit": {**CAU, "rule": "single-rotation"}},
}
ARITHMETIC = Arithmetic.from_spec(SPEC)
NAN = float("nan")


def run(op, *operands, kind="add", **params):
    (result,) = ARITHMETIC.execute(op, params, kind, [np.array(v, dtype=np.float32) for v in operands])
    return result.tolist()


def same(got, expected):
    return np.array_equal(got, np.array(expected, dtype=np.float32), equal_nan=True)


@pytest.mark.parametrize(
    ("op", "params", "operands", "expected"),
    [
        ("add", {}, ([1, 3e38, NAN], [2, 3e38, 1]), [3, NAN, NAN]),
        ("sub", {}, ([1, 1e-45], [2, 1e-45]), [-1, 0]),
        ("mul", {}, ([3, 1e-30, 1e30], [0.1, 1e-15, 1e30]), [np.float32(0.3), 1e-45, NAN]),
        ("cmul", {"factor": Fraction(1, 3)}, ([3, 0, NAN],), [1, 0, NAN]),
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


def test_wrap_never_crosses_pi():
    above = np.nextafter(SINGLE_PI, np.float32(4))
    assert same(
        run("wrap", [SINGLE_PI, above, -SINGLE_PI, -above]), [SINGLE_PI, -SINGLE_PI, -SINGLE_PI, SINGLE_PI]
    )


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
    norm, angle = ARITHMETIC.execute("vector", {"m": 1, "sign": 1}, "standard", [one, one, one])
    assert norm == pytest.approx(2**0.5)
    assert angle == pytest.approx(1 + np.pi / 4)
    angle, rest = ARITHMETIC.execute("implicit", {"m": 1, "branch": "+"}, "implicit", [one, one, 0 * one])
    assert angle == pytest.approx(np.pi * 3 / 4)
    assert rest == pytest.approx(2**0.5)
    x, _ = ARITHMETIC.execute("rotate", {"m": 0}, "standard", [one, one, one])
    assert x.tolist() == [1, 1, 1]
    root, _ = ARITHMETIC.execute("lightcone", {}, "standard", [4 * one, one])
    assert root == pytest.approx(2)


def test_scalars_broadcast():
    one = np.float32(1)
    norm, _ = ARITHMETIC.execute(
        "vector", {"m": 1, "sign": 1}, "standard", [np.ones(4, np.float32), one, one]
    )
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
        ("cmul", {"factor": 0.5}, "cmul", "rational"),
    ],
)
def test_execute_refuses(op, params, kind, message):
    word = np.ones(1, dtype=np.float32)
    count = {"sin": 1, "cmul": 1, "guard": 2}.get(op, 3)
    with pytest.raises(ValueError, match=message):
        ARITHMETIC.execute(op, params, kind, [word] * count)


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("format",), {"kind": "posit"}, "unknown number format"),
        (("format",), "single", "needs a 'kind'"),
        (("units",), [], "must be a mapping"),
        (("units", "standard"), {"mantissa_bits": 32}, "lacks exponent_bits, iterations"),
        (("units", "standard"), {**CAU, "colour": 1}, "unknown keys: colour"),
        (("units", "standard"), {**CAU, "mantissa_bits": 64}, "from 24 to 32"),
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
    half_way = Fraction(1) + Fraction(1, 2**24)
    assert SINGLE.constant(half_way) == 1
    assert SINGLE.constant(half_way + Fraction(1, 2**80)) == np.nextafter(np.float32(1), np.float32(2))
    least = Fraction(1, 2**126)
    assert SINGLE.constant(least) == SINGLE.constant(least - Fraction(1, 2**151)) == np.float32(2.0**-126)
    for small in (least - Fraction(1, 2**150), Fraction(1, 2**149), -Fraction(1, 10**400)):
        with pytest.raises(OverflowError, match="too small for IEEE single"):
            SINGLE.constant(small)
    assert SINGLE.constant(Fraction(0)) == 0
    assert SINGLE.constant(Fraction(2**128 - 2**104)) == np.finfo(np.float32).max
    assert SINGLE.constant_text(Fraction(1, 10)) == "0.1"
    assert SINGLE.parse_constant("0.1") == np.float32(0.1)


@pytest.mark.parametrize("text", ["1e40", "-1e400000000"])
def test_a_constant_beyond_the_format_overflows(text):
    with pytest.raises(OverflowError):
        SINGLE.parse_constant(text)


@pytest.mark.parametrize("text", ["1/3", "x", "nan", "1" * 300])
def test_a_constant_must_be_decimal(text):
    with pytest.raises(ValueError, match=r"."):
        SINGLE.parse_constant(text)


def test_format_spec_round_trips():
    assert format_from_spec(SINGLE.spec()) is SINGLE
