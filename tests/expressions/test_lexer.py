"""Tokens and the mistakes found on the way to them."""

from fractions import Fraction

import pytest

from cordicc.expressions.lexer import MAX_TOKENS, ExpressionError, Kind, tokenize


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("0", 0),
        ("1.5", Fraction(3, 2)),
        (".5", Fraction(1, 2)),
        ("5.", 5),
        ("1e-5", Fraction(1, 100000)),
        ("2.5E+1", 25),
        ("0e99999999", 0),
        ("1e-0000002", Fraction(1, 100)),
        ("1e300", 10**300),
    ],
)
def test_numbers_are_exact(text, number):
    token, end = tokenize(text)
    assert (token.kind, token.number, token.end) == (Kind.NUMBER, number, len(text))
    assert end.kind is Kind.END


def test_places():
    assert [(t.text, t.start, t.end) for t in tokenize(" a**-b2 ")] == [
        ("a", 1, 2),
        ("**", 2, 4),
        ("-", 4, 5),
        ("b2", 5, 7),
        ("", 8, 8),
    ]


@pytest.mark.parametrize(
    ("text", "code", "start"),
    [
        ("1e301", "E111", 0),
        ("1e-301", "E111", 0),
        ("1e99999", "E111", 0),
        ("9" * 401, "E111", 0),
        ("0x1F", "E111", 0),
        ("1_000", "E111", 1),
        ("1.2.3", "E111", 0),
        (".nan", "E111", 0),
        ("a # b", "E110", 2),
        ("a@b", "E110", 1),
        ("x\u0445", "E110", 1),
        ("\u03c0", "E110", 0),
        ("a \u2212 b", "E110", 2),
        ("\u0661", "E110", 0),
        ("a" + "+a" * MAX_TOKENS, "E104", MAX_TOKENS),
    ],
)
def test_mistakes(text, code, start):
    with pytest.raises(ExpressionError) as caught:
        tokenize(text)
    assert (caught.value.code, caught.value.start) == (code, start)


def test_look_alikes_are_named():
    with pytest.raises(ExpressionError) as caught:
        tokenize("2\u00d7x")
    assert "U+00D7 MULTIPLICATION SIGN" in caught.value.message
    assert caught.value.hint == "write '*' instead"
