"""Constant folding: exactness, domains, noise."""

import math
from fractions import Fraction

import mpmath
import pytest

from cordicc.ir.meaning.exact import DEG, PI, FoldError, fold
from cordicc.ir.ops import OPS, Level

F = Fraction
CASES = {
    "add": ((), (1, F(1, 3)), F(4, 3)),
    "sub": ((), (1, F(1, 3)), F(2, 3)),
    "mul": ((), (F(2, 3), F(3, 2)), 1),
    "cmul": ((F(2),), (F(3, 2),), 3),
    "shift": ((F(-3),), (1,), F(1, 8)),
    "neg": ((), (2,), -2),
    "abs": ((), (-2,), 2),
    "sign": ((), (F(-1, 7),), -1),
    "min": ((), (1, 2), 1),
    "max": ((), (1, 2), 2),
    "flip": ((), (3, -1), -3),
    "select": ((), (0, 5, 6), 5),
    "guard": (("positive",), (3, 1), 3),
    "wrap": ((), (7 * PI,), PI),
    "div": ((), (1, 3), F(1, 3)),
    "pow": ((F(-3, 2),), (F(4, 9),), F(27, 8)),
    "sqrt": ((), (F(9, 4),), F(3, 2)),
    "hypot": ((), (3, 4), 5),
    "sin": ((), (PI / 6,), F(1, 2)),
    "cos": ((), (PI,), -1),
    "tan": ((), (PI / 4,), 1),
    "asin": ((), (0,), 0),
    "acos": ((), (1,), 0),
    "atan": ((), (0,), 0),
    "atan2": ((), (0, -1), PI),
    "sinh": ((), (0,), 0),
    "cosh": ((), (0,), 1),
    "tanh": ((), (0,), 0),
    "asinh": ((), (0,), 0),
    "acosh": ((), (1,), 0),
    "atanh": ((), (0,), 0),
    "exp": ((), (0,), 1),
    "log": ((), (1,), 0),
    "solve": ((1, "+"), (0, 2, 2), 0),
    "solve_pair": ((), (0, 1, 1, 1, 0, 0), 0),
}


@pytest.mark.parametrize("op", CASES)
def test_exact(op):
    params, args, result = CASES[op]
    assert fold(op, params, [Fraction(a) for a in args]) == result


def test_every_operation_on_numbers_is_covered():
    wanted = {name for name, d in OPS.items() if d.level in (Level.ARITHMETIC, Level.FUNCTION)}
    assert wanted == set(CASES)


@pytest.mark.parametrize(
    ("op", "params", "args"),
    [
        ("sqrt", (), (-1,)),
        ("div", (), (1, 0)),
        ("pow", (F(-1),), (0,)),
        ("pow", (F(1, 2),), (-2,)),
        ("pow", (F(64),), (10**10,)),
        ("acos", (), (2,)),
        ("asin", (), (-2,)),
        ("acosh", (), (F(1, 2),)),
        ("atanh", (), (1,)),
        ("log", (), (0,)),
        ("log", (), (-1,)),
        ("atan2", (), (0, 0)),
        ("tan", (), (PI / 2,)),
        ("exp", (), (1000,)),
        ("exp", (), (-(10**300),)),
        ("sinh", (), (10**300,)),
        ("mul", (), (10**200, 10**200)),
        ("div", (), (F(1, 10**200), 10**200)),
        ("guard", ("nonzero",), (1, 0)),
        ("solve", (1, "+"), (1, 1, 2)),
        ("solve", (1, "+"), (0, 0, 1)),
        ("solve", (-1, "+"), (0, 2, 1)),
        ("solve", (-1, "none"), (0, 1, 2)),
        ("solve", (-1, "+"), (1, 1, -1)),
        ("solve_pair", (), (1, 1, 1, 2, 2, 1)),
    ],
)
def test_outside_the_domain(op, params, args):
    with pytest.raises(FoldError):
        fold(op, params, [Fraction(a) for a in args])


@pytest.mark.parametrize(
    "name", ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "atanh", "exp"]
)
def test_elementary_functions(name):
    x = Fraction(3, 10)
    with mpmath.workprec(300):
        exact = getattr(mpmath, name)(mpmath.mpf(3) / 10)
        got = fold(name, (), [x])
        assert abs(mpmath.mpf(got.numerator) / got.denominator - exact) < mpmath.mpf(2) ** -255 * abs(exact)


@pytest.mark.parametrize(
    ("params", "A", "B", "C"),
    [
        ((-1, "none"), 3, 1, 2),
        ((-1, "none"), -3, 1, 2),
        ((-1, "+"), 1, 3, 5),
        ((-1, "-"), 1, -3, -5),
        ((-1, "none"), 2, 2, 5),
        ((-1, "none"), 2, -2, -5),
        ((1, "-"), 1, 3, 2),
    ],
)
def test_solutions_satisfy_the_equation(params, A, B, C):
    t = float(fold("solve", params, [Fraction(v) for v in (A, B, C)]))
    cosine, sine = (math.cos, math.sin) if params[0] == 1 else (math.cosh, math.sinh)
    assert B * cosine(t) + A * sine(t) == pytest.approx(C)


def test_noise_of_rounded_constants_cancels():
    root = fold("sqrt", (), [Fraction(2)])
    square = fold("mul", (), [root, root])
    assert fold("sub", (), [square, Fraction(2)]) == 0
    assert fold("acos", (), [fold("mul", (), [root, root]) / 2]) in (0, fold("acos", (), [Fraction(1)]))
    assert fold("sin", (), [PI]) == 0
    assert DEG * 180 == PI


def test_large_arguments_are_reduced_exactly():
    got = fold("sin", (), [Fraction(10) ** 100])
    with mpmath.workprec(1000):
        assert abs(mpmath.mpf(got.numerator) / got.denominator - mpmath.sin(mpmath.mpf(10) ** 100)) < 1e-70


def test_long_rationals_are_rounded():
    third = Fraction(1, 3)
    for _ in range(12):
        third = fold("mul", (), [third, Fraction(10**40 + 1, 10**40 + 3)])
        third = fold("pow", (Fraction(1),), [third])
    long = fold("pow", (Fraction(64),), [Fraction(10**30 + 1, 10**30 + 7)])
    assert long.denominator & (long.denominator - 1) == 0
