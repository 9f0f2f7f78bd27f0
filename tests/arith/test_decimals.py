"""Exact numbers of any size as doubles."""

import math
from fractions import Fraction

import numpy as np
import pytest

from cordicc.arith.numbers.decimals import double_shift, nearest_double


@pytest.mark.parametrize("number", ["1/3", "-2", "0", "1e-400"])
def test_numbers_that_doubles_can_hold(number: str) -> None:
    assert nearest_double(Fraction(number)) == float(Fraction(number))


@pytest.mark.parametrize("sign", [1, -1])
def test_numbers_beyond(sign: int) -> None:
    assert nearest_double(sign * Fraction(10) ** 400) == sign * math.inf


@pytest.mark.parametrize("places", [0, 5, -5, 2000, -2000, 10**900, -(10**900)])
def test_shifts(places: int) -> None:
    with np.errstate(over="ignore"):
        shifted = float(np.ldexp(1.0, double_shift(Fraction(places))))
    assert shifted == (2.0**places if abs(places) < 10 else math.inf if places > 0 else 0.0)
