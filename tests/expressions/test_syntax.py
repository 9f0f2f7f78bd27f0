"""Precedence, associativity and the mistakes the parser explains."""

from fractions import Fraction

import pytest

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import (
    Call,
    Name,
    Neg,
    Number,
    Power,
    Product,
    Sum,
    parse_definition,
    parse_expression,
    parse_relation,
)

a, b, c, x = (Name(n) for n in "abcx")
one, two, three = (Number(Fraction(n)) for n in (1, 2, 3))


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a - b + c", Sum((a, b, c), (1, -1, 1))),
        ("a - (b + c)", Sum((a, Sum((b, c), (1, 1))), (1, -1))),
        ("a/b*c", Product((a, b, c), (1, -1, 1))),
        ("a + b*c", Sum((a, Product((b, c), (1, 1))), (1, 1))),
        ("-x**2", Neg(Power(x, two))),
        ("(-x)**2", Power(Neg(x), two)),
        ("2**-1", Power(two, Neg(one))),
        ("2**-x**2", Power(two, Neg(Power(x, two)))),
        ("2**3**x", Power(two, Power(three, x))),
        ("-a*b", Product((Neg(a), b), (1, 1))),
        ("a*-b", Product((a, Neg(b)), (1, 1))),
        ("a - -b", Sum((a, Neg(b)), (1, -1))),
        ("+a", a),
        ("min(a, b, c)", Call("min", (a, b, c))),
        ("atan2(-a, b)", Call("atan2", (Neg(a), b))),
    ],
)
def test_trees(text, tree):
    assert parse_expression(text) == tree


def test_long_sums_and_products_are_flat():
    assert len(parse_expression("+".join("a" * 5000)).terms) == 5000
    assert len(parse_expression("*".join("a" * 5000)).factors) == 5000


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [
        ("", "E112", (0, 1)),
        ("a +", "E112", (3, 4)),
        ("a * / b", "E112", (4, 5)),
        ("(a + b", "E113", (6, 7)),
        ("a + b)", "E113", (5, 6)),
        ("erf(x)", "E114", (0, 3)),
        ("sin", "E115", (0, 3)),
        ("sin()", "E115", (0, 5)),
        ("atan2(a)", "E115", (0, 8)),
        ("hypot(a, b, c)", "E115", (0, 14)),
        ("min(a)", "E115", (0, 6)),
        ("2x", "E116", (1, 2)),
        ("2(a)", "E116", (1, 2)),
        ("a b", "E116", (2, 3)),
        ("(a)(b)", "E116", (3, 4)),
        ("a^2", "E117", (1, 2)),
        ("a == b", "E117", (2, 4)),
        ("a = b", "E118", (2, 3)),
        ("(a, b)", "E112", (2, 3)),
        ("(" * 10_000, "E104", (101, 102)),
        ("-" * 10_000, "E104", (101, 102)),
        ("**".join("2" * 9_000), "E104", (303, 304)),
    ],
)
def test_mistakes(text, code, place):
    with pytest.raises(ExpressionError) as caught:
        parse_expression(text)
    assert (caught.value.code, (caught.value.start, caught.value.end)) == (code, place)


def test_unknown_functions_have_a_near_one():
    with pytest.raises(ExpressionError) as caught:
        parse_expression("arctan2(a, b)")
    assert caught.value.hint == "did you mean 'atan2'?"


def test_definition_and_relation():
    assert parse_definition(" y = a + b ") == (Name("y"), Sum((a, b), (1, 1)))
    relation = parse_relation("a + b >= c", (">=",))
    assert (relation.relation, relation.right, relation.at) == (">=", c, (0, 10))


@pytest.mark.parametrize("text", ["a + b", "2*y = x", "y == x", "", "=", "y = a = b", "y ="])
def test_not_a_definition(text):
    with pytest.raises(ExpressionError):
        parse_definition(text)
