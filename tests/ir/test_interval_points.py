"""Sums, products, quotients and roots of floats, rounded both ways without ball arithmetic."""

from __future__ import annotations

import math
from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from cordicc.ir.meaning.intervals import product_of, quotient_of, root_of, sum_of

NUMBERS = (
    st.floats(-1e6, 1e6)
    | st.integers(-1000, 1000).map(float)
    | st.floats(allow_nan=False, allow_infinity=False)
)


def tight(pair: tuple[float, float], exact: Fraction, *numbers: float) -> bool:
    """Tell whether two floats are around a rational, and the nearest ones if it is of usual numbers."""
    lo, hi = pair
    below = lo == -math.inf or Fraction(lo) <= exact
    above = hi == math.inf or exact <= Fraction(hi)
    usual = all(not number or 1e-100 < abs(number) < 1e100 for number in numbers)
    return below and above and (not usual or lo == hi or math.nextafter(lo, math.inf) == hi)


@given(NUMBERS, NUMBERS)
def test_sums(p: float, q: float) -> None:
    assert tight(sum_of(p, q), Fraction(p) + Fraction(q), p, q)
    assert not math.copysign(1.0, sum_of(p, -p)[0]) < 0


@given(NUMBERS, NUMBERS)
def test_products(p: float, q: float) -> None:
    assert tight(product_of(p, q), Fraction(p) * Fraction(q), p, q)


@given(NUMBERS, NUMBERS.filter(bool))
def test_quotients(p: float, q: float) -> None:
    assert tight(quotient_of(p, q), Fraction(p) / Fraction(q), p, q)


@given(NUMBERS.map(abs))
def test_roots(p: float) -> None:
    lo, hi = root_of(p)
    assert Fraction(lo) ** 2 <= Fraction(p) <= Fraction(hi) ** 2
    assert lo == hi or math.nextafter(lo, math.inf) == hi or p < 1e-100


@given(st.integers(1, 2**26).map(float))
def test_exact_results_stay_points(n: float) -> None:
    assert root_of(n * n) == (n, n)
    assert quotient_of(n * 7.0, n) == (7.0, 7.0)
    assert product_of(n, n) == (n * n, n * n)
