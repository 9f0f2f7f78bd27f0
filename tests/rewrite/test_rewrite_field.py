"""The field behind the proofs: arithmetic, roots, half angles, relations."""

from fractions import Fraction
from math import cos, cosh, isclose, sin, sinh, tan, tanh

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cordicc.rewrite.exact.field import Element, Field, TooLarge, monic, square_root_of
from tests.support.selection import examples


def field() -> tuple[Field, Element, Element]:
    made = Field(6, 3, 3)
    x, y = (Element(made.generator(made.free()), made.one) for _ in range(2))
    return made, x, y


def value(poly, numbers: dict[int, float]) -> float:
    total = 0.0
    for powers, factor in poly.terms():
        term = float(Fraction(int(factor.numerator), int(factor.denominator)))
        for index, power in enumerate(powers):
            term *= numbers.get(index, 0.0) ** int(power) if power else 1
        total += term
    return total


def test_the_square_of_a_root_is_its_radicand() -> None:
    f, x, y = field()
    squares = f.add(f.mul(x, x), f.mul(y, y))
    root = f.root(squares.num)
    assert f.mul(root, root).key == squares.key
    assert f.root(f.scale(Fraction(9, 4), squares).num).key == f.scale(Fraction(3, 2), root).key


def test_roots_leave_denominators() -> None:
    f, x, y = field()
    root = f.root(f.add(f.mul(x, x), f.mul(y, y)).num)
    inverse = f.inverse(f.add(root, x))
    assert not f.roots_of(Element(inverse.den, f.one))
    assert f.mul(inverse, f.add(root, x)).constant == 1


def test_equal_elements_have_equal_keys() -> None:
    f, x, y = field()
    difference = f.sub(f.mul(x, x), f.mul(y, y))
    assert f.div(difference, f.add(x, y)).key == f.sub(x, y).key


def test_division_by_zero() -> None:
    f, x, _ = field()
    with pytest.raises(ZeroDivisionError):
        f.inverse(f.sub(x, x))
    sign = Element(f.generator(f.sign()), f.one)
    with pytest.raises(ZeroDivisionError):
        f.inverse(f.add(sign, f.number(Fraction(1))))


@pytest.mark.parametrize("m", [1, -1])
def test_cosine_and_sine_are_a_pair(m: int) -> None:
    f, *_ = field()
    *_, c, s = f.pair(m)
    assert f.add(f.mul(c, c), f.scale(Fraction(m), f.mul(s, s))).constant == 1


@settings(max_examples=examples(40), deadline=None)
@given(st.sampled_from([1, -1]), st.floats(-1, 1), st.lists(st.integers(-3, 3), min_size=4, max_size=4))
def test_display_keeps_the_value(m: int, angle: float, factors: list[int]) -> None:
    f, x, _ = field()
    cosine, sine, c, s = f.pair(m)
    tangent = next(i for i in f.generators(c.num) if i not in (cosine, sine))
    element = f.number(Fraction(0))
    for factor, part in zip(factors, (f.mul(c, s), f.mul(s, s), f.mul(x, c), x), strict=True):
        element = f.add(element, f.scale(Fraction(factor), part))
    shown = f.display(element)
    assert shown is not None
    half = tan(angle / 2) if m == 1 else tanh(angle / 2)
    pair = (cos(angle), sin(angle)) if m == 1 else (cosh(angle), sinh(angle))
    first = next(f.generators(x.num))
    numbers = {first: 0.7, tangent: half, cosine: pair[0], sine: pair[1]}
    exact = value(element.num, numbers) / value(element.den, numbers)
    assert isclose(value(shown, numbers), exact, rel_tol=1e-9, abs_tol=1e-9)
    assert tangent not in f.generators(shown)


def test_a_fact_is_used_and_one_of_another_shape_is_not() -> None:
    f, x, y = field()
    one = f.number(Fraction(1))
    norm = f.sub(f.add(f.mul(x, x), f.mul(y, y)), one)
    assert not f.relate(f.mul(x, y).num)
    assert not f.relate(f.add(f.mul(x, x), x).num)
    assert f.relate(norm.num)
    assert f.add(f.mul(x, x), f.mul(y, y)).constant == 1
    assert not f.relate(f.add(f.mul(x, x), y).num), "one relation a generator"


def test_work_is_limited() -> None:
    f = Field(1, 0, 1)
    f.free()
    with pytest.raises(TooLarge):
        f.free()
    f.root(f.generator(1))
    with pytest.raises(TooLarge):
        f.root(f.generator(1) + 1)


def test_roots_of_rationals() -> None:
    assert square_root_of(Fraction(9, 4)) == Fraction(3, 2)
    assert square_root_of(Fraction(2)) is None
    assert square_root_of(Fraction(-1)) is None


def test_monic() -> None:
    f, x, y = field()
    factor, base = monic(f.add(f.scale(Fraction(-3), x), y).num)
    assert factor == -3
    assert base.leading_coefficient() == 1


def parts(f: Field) -> list[Element]:
    """Return numbers, generators, a root and the cosine and sine of an angle."""
    x, y = (Element(f.generator(f.free()), f.one) for _ in range(2))
    root = f.root(f.add(f.mul(x, x), f.mul(y, y)).num)
    *_, cosine, sine = f.pair(1)
    return [f.number(Fraction(2, 3)), f.number(Fraction(-1)), x, y, root, cosine, sine]


STEPS = st.lists(st.tuples(st.sampled_from("+-*/"), st.integers(0, 6)), min_size=1, max_size=7)


@given(STEPS)
@settings(max_examples=examples(60), deadline=None)
def test_elements_stay_in_lowest_terms(steps: list[tuple[str, int]]) -> None:
    f = Field(6, 3, 3)
    known = parts(f)
    element = known[2]
    for op, index in steps:
        try:
            element = {"+": f.add, "-": f.sub, "*": f.mul, "/": f.div}[op](element, known[index])
        except ZeroDivisionError:
            continue
        assert element.num.gcd(element.den).is_one() or element.is_zero
        assert element.den.leading_coefficient() == 1
        assert f.fraction(element.den, f.one).powers == ()
        assert f.fraction(f.one, element.den).powers == element.powers
        assert all(power <= 1 for power, _ in zip(element.num.degrees(), range(6), strict=False))


@given(STEPS)
@settings(max_examples=examples(60), deadline=None)
def test_the_least_number_of_displayed_terms(steps: list[tuple[str, int]]) -> None:
    f = Field(6, 3, 3)
    known = parts(f)
    element = known[2]
    for op, index in steps:
        element = {"+": f.add, "-": f.sub, "*": f.mul, "/": f.mul}[op](element, known[index])
        shown = f.display(element)
        if shown is not None:
            assert f.half_angles.least_terms(element.num) <= len(shown)
            assert f.display(element) is shown


def test_a_long_denominator_is_given_up() -> None:
    f = Field(12, 0, 0)
    total = f.number(Fraction(1))
    for index in range(10):
        each = Element(f.generator(f.free()), f.one)
        total = f.mul(total, f.add(each, f.number(Fraction(index + 1))))
    assert len(total.num) == 1024
    with pytest.raises(TooLarge):
        f.inverse(total)


def test_no_relation_for_what_a_denominator_holds() -> None:
    f, x, y = field()
    f.inverse(f.add(x, y))
    assert not f.relate(f.sub(f.mul(x, x), f.number(Fraction(2))).num)


def test_products_that_are_known_name_the_facts_they_rest_on() -> None:
    f, x, y = field()
    before = f.mul(x, x)
    assert f.relate(f.sub(f.add(before, f.mul(y, y)), f.number(Fraction(1))).num, "x^2 + y^2 = 1")
    assert f.mul(x, x).key != before.key, "a relation makes products new"
    for _ in range(2):
        f.touched.clear()
        assert f.mul(x, x).key == f.sub(f.number(Fraction(1)), f.mul(y, y)).key
        assert f.touched == {"x^2 + y^2 = 1"}


def test_long_relations_without_division() -> None:
    f = Field(40, 0, 2)
    one = f.number(Fraction(1))
    total = one
    for index in range(30):
        total = f.add(total, f.scale(Fraction(index + 1), Element(f.generator(f.free()), f.one)))
    root = f.root(total.num)
    assert len(total.num) > 30
    assert f.mul(f.add(root, total), root).key == f.add(total, f.mul(total, root)).key
    cube = f.mul(f.mul(root, root), root)
    assert cube.key == f.mul(total, root).key
