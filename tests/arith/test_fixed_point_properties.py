"""Fixed-point arithmetic is the arithmetic of fractions, rounded once, for any formats."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cordicc.arith.numbers.fixed_point import ROUNDINGS, FixedPoint
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.formats import Signal
from tests.support.selection import examples

OPERATIONS = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "min": min,
    "max": max,
    "flip": lambda a, s: a if s >= 0 else -a,
}


@st.composite
def formats(draw):
    width = draw(st.integers(4, 32))
    return FixedPoint(width, draw(st.integers(-40, 60)), draw(st.sampled_from(ROUNDINGS)))


@st.composite
def signals(draw, format_):
    extremes = [format_.invalid_word, -format_.largest_word, -1, 0, 1, format_.largest_word]
    word = st.one_of(st.sampled_from(extremes), st.integers(-format_.largest_word, format_.largest_word))
    return Signal(np.array([draw(word)], dtype=np.int64), format_)


def number(word, format_):
    return None if word == format_.invalid_word else Fraction(word) / Fraction(2) ** format_.fraction_bits


def rounded(value, format_):
    if value is None:
        return None
    scaled = value * Fraction(2) ** format_.fraction_bits
    word = {"half-up": math.floor(scaled + Fraction(1, 2)), "half-even": round(scaled)}.get(
        format_.rounding, math.floor(scaled)
    )
    return number(word, format_) if abs(word) <= format_.largest_word else None


@pytest.mark.parametrize("op", OPERATIONS)
@given(data=st.data())
@settings(deadline=None, max_examples=examples(200))
def test_operations_of_any_formats(op, data):
    first, second, result = data.draw(formats()), data.draw(formats()), data.draw(formats())
    a, b = data.draw(signals(first)), data.draw(signals(second))
    (word,) = FixedSystem(24).calculate(op, {}, [a, b], result).tolist()
    x, y = number(int(a.words[0]), first), number(int(b.words[0]), second)
    exact = None if x is None or y is None else OPERATIONS[op](x, y)
    assert number(word, result) == rounded(exact, result)


@given(formats(), st.floats(allow_nan=True, allow_infinity=True))
@settings(deadline=None, max_examples=examples(500))
def test_values_are_rounded_once(format_, value):
    (word,) = format_.encode(np.array([value])).tolist()
    exact = Fraction(value) if math.isfinite(value) else None
    assert number(word, format_) == rounded(exact, format_)


@given(data=st.data())
@settings(deadline=None, max_examples=examples(200))
def test_a_change_of_format_through_integers_and_through_floats_is_the_same(data):
    source, target = data.draw(formats()), data.draw(formats())
    signal = data.draw(signals(source))
    through_integers = target.rounded(source.exact(signal.words))
    assert through_integers.tolist() == target.encode(signal.values).tolist()
