"""Properties of the front end: no text breaks it, and printed trees parse back."""

from fractions import Fraction

from hypothesis import example, given, settings
from hypothesis import strategies as st

from cordicc.base.codes import CODES
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import (
    FUNCTIONS,
    Call,
    Name,
    Neg,
    Number,
    Power,
    Product,
    Sum,
    parse_expression,
)
from tests.support.diagnosed import check_text

SUM, PRODUCT, UNARY, POWER, ATOM = range(1, 6)


def printed(expr, outer=0):
    """Return the text of a tree, with parentheses where the context needs them."""
    match expr:
        case Number(value):
            text, level = str(value.numerator) if value.denominator == 1 else str(float(value)), ATOM
        case Name(name):
            text, level = name, ATOM
        case Neg(operand):
            text, level = "-" + printed(operand, UNARY), UNARY
        case Sum(terms, signs):
            text, level = printed(terms[0], SUM + 1), SUM
            text += "".join(" +-"[s] + printed(t, SUM + 1) for t, s in zip(terms[1:], signs[1:], strict=True))
        case Product(factors, signs):
            text, level = printed(factors[0], PRODUCT + 1), PRODUCT
            rest = zip(factors[1:], signs[1:], strict=True)
            text += "".join(" */"[s] + printed(f, PRODUCT + 1) for f, s in rest)
        case Power(base, exponent):
            text, level = f"{printed(base, ATOM)}**{printed(exponent, UNARY)}", POWER
        case Call(function, args):
            text, level = f"{function}({', '.join(printed(a) for a in args)})", ATOM
    return f"({text})" if level < outer else text


def nary(make, operand):
    def build(parts):
        operands, signs = zip(*parts, strict=True)
        return make(operands, (1, *signs[1:]))

    return st.lists(st.tuples(operand, st.sampled_from([1, -1])), min_size=2, max_size=4).map(build)


def call(name, operand):
    least, most = FUNCTIONS[name]
    return st.lists(operand, min_size=least, max_size=most or 4).map(lambda args: Call(name, tuple(args)))


leaves = st.one_of(
    st.integers(0, 99).map(lambda n: Number(Fraction(n, 4))),
    st.sampled_from("xyab").map(Name),
    st.sampled_from(["pi", "deg"]).map(Name),
)
trees = st.recursive(
    leaves,
    lambda inner: st.one_of(
        inner.map(Neg),
        nary(Sum, inner),
        nary(Product, inner),
        st.builds(Power, inner, inner),
        st.sampled_from(sorted(FUNCTIONS)).flatmap(lambda name: call(name, inner)),
    ),
    max_leaves=25,
)


@given(trees)
def test_printed_trees_parse_back(tree):
    assert parse_expression(printed(tree)) == tree


WORDS = (
    "x y t a sin( cos( cosh( sqrt( atan2( ( ) ) , + - * / ** = == ^ "
    "1 2 0.5 1e-5 pi 1e999 . _ : # ' \" [ ] { } é"
)
TOKENS = st.sampled_from(WORDS.split())
expressions = st.lists(TOKENS, max_size=15).map(" ".join)


@given(st.text(max_size=200))
@example("{a: &a [*a]}")
@example("equations: [x = 1\ninputs: {")
@example("inputs: {x: [0, 1]}\nequations: [y = x]\noutputs: {y: }")
@example("? ? ?")
@example("- - - -")
@example("!!binary x")
@example("%TAG ! x\n---\na")
def test_any_text(text):
    check_text(text)


@given(expressions)
def test_any_expression(text):
    try:
        parse_expression(text)
    except ExpressionError as error:
        place = (error.code in CODES, error.start >= 0, error.start < error.end)
    else:
        return
    assert all(place)


@settings(deadline=None)
@given(st.lists(expressions, min_size=1, max_size=3), expressions, expressions)
def test_any_equations(equations, left, right):
    lines = ["inputs: {x: [0.5, 1], y: [-1, 1]}", "constants: {a: 2}", "equations:"]
    lines += [f"  - z{i} = {e}" for i, e in enumerate(equations)]
    lines += [f"  - solve: {left} = {right}", "    for: t", '    branch: "+"']
    check_text("\n".join(lines))


@settings(deadline=None)
@given(trees)
def test_lowered_trees_are_valid_graphs(tree):
    head = "inputs: {x: [0.5, 1], y: [-1, 1], b: [1, 2]}\nconstants: {a: 2}\nequations:\n"
    check_text(f"{head}  - z = {printed(tree)}\n")


@settings(deadline=None)
@given(trees)
def test_solving_any_tree(tree):
    lines = ["inputs: {x: [0.5, 1], b: [1, 2]}", "constants: {a: 2}", "equations:"]
    lines += [f"  - solve: {printed(tree)} + cos(y) = x", "    for: y", '    branch: "+"']
    check_text("\n".join(lines))


sections = st.recursive(
    st.sampled_from(
        ["x", "1", "[0, 1]", "y = x", "~", "true", "{}", "[]", "'q'", "{solve: cos(t) = x, for: t}"]
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(lambda v: "[" + ", ".join(v) + "]"),
        st.dictionaries(
            st.sampled_from(["x", "y", "solve", "for", "branch", "range", "unit", "wrap"]), inner, max_size=3
        ).map(lambda d: "{" + ", ".join(f"{k}: {v}" for k, v in d.items()) + "}"),
    ),
    max_leaves=8,
)


@settings(deadline=None)
@given(
    st.dictionaries(
        st.sampled_from(
            ["name", "description", "constants", "inputs", "equations", "outputs", "samples", "assume"]
        ),
        sections,
    )
)
def test_any_structure(parts):
    check_text("".join(f"{key}: {value}\n" for key, value in parts.items()))
