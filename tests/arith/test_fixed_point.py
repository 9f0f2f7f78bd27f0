"""Fixed point: words and values, rounding, exact operations, constants; small widths exhaustively."""

import itertools
import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from cordicc.arith.numbers.fixed_point import ROUNDINGS, FixedPoint, ScaledIntegers, fraction_bits_for
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.formats import BinaryPoint, Signal
from cordicc.arith.unit.arithmetic import system_from_spec

SYSTEM = FixedSystem(24, 4)


def words(format_):
    return np.arange(-format_.largest_word, format_.largest_word + 1)


def values(format_, array):
    """The numbers of words as fractions, None for the invalid one."""
    scale = Fraction(2) ** -format_.fraction_bits
    return [None if w == format_.invalid_word else int(w) * scale for w in np.asarray(array).tolist()]


def rounded(number, format_):
    """The definition of rounding, in fractions."""
    if number is None:
        return None
    scaled = number * Fraction(2) ** format_.fraction_bits
    word = {
        "half-up": lambda: math.floor(scaled + Fraction(1, 2)),
        "half-even": lambda: round(scaled),
        "floor": lambda: math.floor(scaled),
    }[format_.rounding]()
    if abs(word) > format_.largest_word:
        return None
    return word / Fraction(2) ** format_.fraction_bits


@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize(("fine", "coarse"), [(7, 3), (3, 3), (2, 5), (-2, -4), (9, -1)])
def test_every_change_of_format_rounds_as_defined(rounding, fine, coarse):
    source, target = FixedPoint(8, fine), FixedPoint(6, coarse, rounding)
    every = words(source)
    expected = [rounded(v, target) for v in values(source, every)]
    assert values(target, target.encode(source.decode(every))) == expected
    assert values(target, target.rounded(source.exact(every))) == expected
    wide = ScaledIntegers(every.astype(object), fine, np.ones(every.shape, dtype=bool))
    assert values(target, target.rounded(wide)) == expected


@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_a_shift_of_any_distance_rounds_to_zero_or_down(rounding):
    target = FixedPoint(8, -100, rounding)
    source = FixedPoint(8, 60)
    expected = [rounded(v, target) for v in values(source, words(source))]
    assert values(target, target.rounded(source.exact(words(source)))) == expected


def test_words_round_trip_and_the_invalid_one_is_nan():
    format_ = FixedPoint(8, 5)
    every = words(format_)
    assert np.array_equal(format_.encode(format_.decode(every)), every)
    assert np.isnan(format_.decode(np.array([format_.invalid_word]))).all()
    assert format_.encode(np.array([np.nan, np.inf, -np.inf, 4.0, -4.0])).tolist() == [-128] * 5
    assert format_.decode(np.array([127, -127])).tolist() == [127 / 32, -127 / 32]


@pytest.mark.parametrize(
    ("op", "exact"),
    [
        ("add", lambda a, b: a + b),
        ("sub", lambda a, b: a - b),
        ("mul", lambda a, b: a * b),
        ("min", min),
        ("max", max),
        ("flip", lambda a, s: a if s >= 0 else -a),
    ],
)
@pytest.mark.parametrize(("first", "second", "third"), [(4, 4, 4), (5, 2, 3), (-1, 6, 4), (70, 4, 5)])
def test_operations_of_two_are_exact_and_rounded_once(op, exact, first, second, third):
    a, b, result = FixedPoint(5, first), FixedPoint(5, second), FixedPoint(6, third)
    x, y = (np.array(column) for column in zip(*itertools.product(words(a), words(b)), strict=True))
    system = FixedSystem(6)
    got = system.calculate(op, {}, [Signal(x, a), Signal(y, b)], result)
    pairs = zip(values(a, x), values(b, y), strict=True)
    assert values(result, got) == [rounded(exact(p, q), result) for p, q in pairs]


@pytest.mark.parametrize(
    ("op", "params", "exact"),
    [
        ("neg", {}, lambda a: -a),
        ("abs", {}, abs),
        ("sign", {}, lambda a: Fraction((a > 0) - (a < 0))),
        ("shift", {"exponent": 3}, lambda a: 8 * a),
        ("shift", {"exponent": -7}, lambda a: a / 128),
        ("cmul", {"factor": "-0.75"}, lambda a: Fraction(-3, 4) * a),
    ],
)
def test_operations_of_one_are_exact_and_rounded_once(op, params, exact):
    a, result = FixedPoint(7, 4), FixedPoint(7, 3)
    got = FixedSystem(7).calculate(op, params, [Signal(words(a), a)], result)
    assert values(result, got) == [rounded(exact(v), result) for v in values(a, words(a))]


def test_select_and_guard():
    a = FixedPoint(6, 3)
    s = Signal(np.array([-1, 0, 1, a.invalid_word]), a)
    first, second = Signal(np.full(4, 5), a), Signal(np.full(4, 7), a)
    system = FixedSystem(6)
    assert system.calculate("select", {}, [s, first, second], a).tolist() == [7, 5, 5, -32]
    keeps = {"any": [5, 5, 5], "nonzero": [5, -32, 5], "nonnegative": [-32, 5, 5], "positive": [-32, -32, 5]}
    for condition, kept in keeps.items():
        got = system.calculate("guard", {"condition": condition}, [first, s], a)
        assert got.tolist() == [*kept, -32], condition
    with pytest.raises(ValueError, match="condition"):
        system.calculate("guard", {"condition": "odd"}, [first, s], a)
    with pytest.raises(ValueError, match="unknown operation"):
        system.calculate("sin", {}, [first], a)


@pytest.mark.parametrize("fraction", [-6, -1, 0, 1, 3, 4])
def test_every_angle_is_wrapped(fraction):
    mp = mpmath.MPContext()
    mp.prec = 200
    angle, result = FixedPoint(9, fraction), FixedPoint(9, 6)
    got = FixedSystem(9).calculate("wrap", {}, [Signal(words(angle), angle)], result)
    for value, turned in zip(angle.decode(words(angle)), result.decode(got), strict=True):
        exact = mp.mpf(value) - 2 * mp.pi * mp.nint(mp.mpf(value) / (2 * mp.pi))
        error = abs(turned - exact)
        assert min(error, abs(2 * mp.pi - error)) <= 0.5001 * result.ulp
        assert abs(turned) <= mp.pi


def test_pi_is_never_exceeded():
    format_ = FixedPoint(8, 5)  # pi is 100.53 ulp
    near_pi = np.array([math.pi, -math.pi, math.pi + 0.2 / 32])
    assert format_.encode_angle(near_pi).tolist() == [100, -100, 100]
    assert format_.encode_angle(np.array([math.pi + 0.6 / 32, 3.5])).tolist() == [101, 112]
    assert FixedPoint(8, 6).encode_angle(np.array([1.5])).tolist() == [96]


@pytest.mark.parametrize(
    ("magnitude", "fraction"), [(0.0, 7), (1.0, 6), (0.99, 7), (127 / 128, 7), (0.5, 7), (3.2, 5), (1e3, -3)]
)
def test_a_format_has_the_most_fraction_bits_that_hold_the_magnitude(magnitude, fraction):
    assert fraction_bits_for(magnitude, 8) == fraction
    assert FixedPoint(8, fraction).encode(np.array([magnitude, -magnitude])).min() > -128


@pytest.mark.parametrize("magnitude", [math.inf, math.nan, 1e300])
def test_a_magnitude_that_no_format_holds(magnitude):
    with pytest.raises(OverflowError):
        fraction_bits_for(magnitude, 8)


@pytest.mark.parametrize("number", [*map(Fraction, ("1/3", "-22/7", "1", "0", "1e-9"))])
def test_constants_are_the_nearest_words_and_their_text_reads_back(number):
    text = SYSTEM.constant_text(number)
    word, format_ = SYSTEM.constant(text)
    value = Fraction(int(word)) / Fraction(2) ** format_.fraction_bits
    assert abs(value - number) <= Fraction(1, 2) / Fraction(2) ** format_.fraction_bits
    assert number == 0 or abs(int(word)).bit_length() == format_.width_bits - 1 == 27
    assert SYSTEM.constant_text(Fraction(text)) == text


def test_a_constant_just_below_a_power_of_two_rounds_up_to_it():
    word, format_ = FixedSystem(8).constant("0.9999")
    assert format_.decode(word) == 1.0


@pytest.mark.parametrize("number", [Fraction(10) ** 60, Fraction(1, 10**60)])
def test_constants_outside_every_format_overflow(number):
    with pytest.raises(OverflowError):
        SYSTEM.constant_text(number)


def test_the_description_round_trips():
    assert system_from_spec(SYSTEM.spec()) == SYSTEM
    assert SYSTEM.format(FixedPoint(28, 5).binary_point) == FixedPoint(28, 5)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ({"kind": "fixed-point"}, "lacks width"),
        ({"kind": "fixed-point", "width": 24, "colour": 1}, "unknown keys: colour"),
        ({"kind": "fixed-point", "width": 24.0}, "integers"),
        ({"kind": "fixed-point", "width": 24, "guard": "auto"}, "integers"),
        ({"kind": "fixed-point", "width": 24, "guard": 20}, "4 to 32 bits"),
        ({"kind": "fixed-point", "width": 24, "rounding": "up"}, "unknown rounding"),
        ({"kind": "ieee-single", "width": 24}, "unknown keys: width"),
    ],
)
def test_a_bad_description_is_refused(spec, message):
    with pytest.raises(ValueError, match=message):
        system_from_spec(spec)


@pytest.mark.parametrize("spec", [None, BinaryPoint(25, 3), BinaryPoint(24, 999)])
def test_a_bad_format_of_a_value_is_refused(spec):
    with pytest.raises(ValueError, match=r"bits|format"):
        SYSTEM.format(spec)


@pytest.mark.parametrize(
    ("width", "fraction"), [(24, 21), (24, 14), (24, 0), (24, -8), (30, 6), (32, 0), (32, 27)]
)
def test_long_words_are_wrapped_to_half_an_ulp_and_the_invalid_one_stays(width, fraction):
    mp = mpmath.MPContext()
    mp.prec = 300
    angle, result = FixedPoint(width, fraction), FixedPoint(24, 21)
    rng = np.random.default_rng(7)
    every = rng.integers(-angle.largest_word, angle.largest_word + 1, 300)
    every[:4] = [angle.invalid_word, angle.largest_word, -angle.largest_word, 0]
    got = FixedSystem(width).calculate("wrap", {}, [Signal(every, angle)], result)
    assert got[0] == result.invalid_word
    for value, turned in zip(angle.decode(every)[1:], result.decode(got)[1:], strict=True):
        exact = mp.mpf(value) - 2 * mp.pi * mp.nint(mp.mpf(value) / (2 * mp.pi))
        error = abs(turned - exact)
        assert min(error, abs(2 * mp.pi - error)) <= 0.52 * result.ulp
