"""Every rewriting keeps what the equations mean: values, and which inputs are valid."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cordicc.ir.graph import Builder, Value
from cordicc.ir.meaning.reference import reference_outputs
from tests.support.pass_graphs import NAMES, assert_same, build, rewritten, samples
from tests.support.selection import examples

UNARY = (
    *("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
    *("exp", "log", "abs", "neg", "sign", "wrap"),
)
BINARY = ["add", "sub", "mul", "div", "hypot", "atan2", "min", "max"]


@pytest.mark.parametrize("op", UNARY)
def test_function_of_one_operand(op: str) -> None:
    assert_same(build(lambda b, x, y, w: b.emit(op, (x,))), samples())


@pytest.mark.parametrize("op", BINARY)
def test_function_of_two_operands(op: str) -> None:
    assert_same(build(lambda b, x, y, w: b.emit(op, (x, y))), samples())


@pytest.mark.parametrize("exponent", ["-2", "-3/2", "-1", "-1/2", "1/2", "3/2", "2", "3", "5", "7/2"])
def test_power(exponent: str) -> None:
    assert_same(build(lambda b, x, y, w: b.emit("pow", (x,), (Fraction(exponent),))), samples())


@pytest.mark.parametrize("branch", ["+", "-"])
def test_circular_solve(branch: str) -> None:
    assert_same(
        build(lambda b, x, y, w: b.emit("wrap", (b.emit("solve", (x, y, w), (1, branch)),))), samples()
    )


@pytest.mark.parametrize("branch", ["+", "-", "none"])
def test_hyperbolic_solve(branch: str) -> None:
    assert_same(build(lambda b, x, y, w: b.emit("solve", (x, y, w), (-1, branch))), samples(200))


@pytest.mark.parametrize("port", [0, 1])
@pytest.mark.parametrize("m", [1, -1])
def test_solve_with_one_coefficient(port: int, m: int) -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        operands = [b.const(0), b.const(0), w]
        operands[port] = x
        return b.emit("solve", operands, (m, "+" if (m, port) != (-1, 0) else "none"))

    assert_same(build(make), samples(100))


@pytest.mark.parametrize("branch", ["+", "-"])
def test_no_unit_computes_what_is_constant(branch: str) -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        coefficients = (b.const(Fraction(-3, 7)), b.const(Fraction(2, 7)), w)
        return b.emit("wrap", (b.emit("solve", coefficients, (1, branch)),))

    graph = build(make)
    assert_same(graph, samples(100))
    caus = [node.op for node in rewritten(graph, implicit=False).nodes if node.op == "vector"]
    assert len(caus) == 2  # the root, then the angle: norm and angle of (B, A) are constants


def test_solve_pair() -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        return b.emit("solve_pair", (x, y, w, b.const(1), x, y))

    assert_same(build(make), samples())


@pytest.mark.parametrize("op", ["acos", "asin", "acosh", "asinh", "atanh", "atan", "log"])
def test_quotient_inside(op: str) -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        quotient = b.emit("div", (x, y))
        return b.emit(op, (b.emit("mul", (b.const(Fraction(-3, 2)), quotient)),))

    assert_same(build(make), samples(100))
    plan = rewritten(build(make))
    assert not [n for n in plan.nodes if n.op == "vector" and n.m == 0], "the division stayed"


def test_division_by_zero_stays_invalid() -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        return b.emit("atan", (b.emit("div", (x, y)),))

    zero = {"x": np.array([1.0, 0.0]), "y": np.array([0.0, 0.0]), "w": np.zeros(2)}
    assert_same(build(make), zero)


def test_lost_operand_keeps_its_validity() -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        root = b.emit("sqrt", (x,))
        return b.emit("add", (y, b.emit("sub", (root, root))))

    assert_same(build(make), samples())


def sums(
    b: Builder, x: Value, y: Value, w: Value, sine: str = "sin", cosine: str = "cos"
) -> dict[str, Value]:
    c, s = b.emit(cosine, (w,)), b.emit(sine, (w,))
    mul = lambda p, q: b.emit("mul", (p, q))  # noqa: E731
    last = b.emit("sub", (mul(y, c), mul(x, s))) if sine == "sin" else b.emit("add", (mul(y, c), mul(x, s)))
    return {"one": b.emit("add", (mul(x, c), mul(y, s))), "two": last}


@pytest.mark.parametrize("names", [("sin", "cos"), ("sinh", "cosh")])
def test_both_components_of_a_turned_vector_share_a_rotation(names: tuple[str, str]) -> None:
    graph = build(lambda b, x, y, w: sums(b, x, y, w, *names))
    assert_same(graph, samples())
    assert sorted(n.op for n in rewritten(graph).nodes if n.op != "input") in (
        ["neg", "rotate"],
        ["rotate"],
        ["neg", "neg", "rotate"],
    )


def test_sine_and_cosine_share_a_rotation() -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> dict[str, Value]:
        return {"c": b.emit("cos", (x,)), "s": b.emit("sin", (x,))}

    assert [n.op for n in rewritten(build(make)).nodes].count("rotate") == 1


def test_several_vectors_turned_by_one_angle() -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> dict[str, Value]:
        first = sums(b, x, y, w)
        second = sums(b, y, b.const(2), w)
        return {**first, "three": second["one"], "four": second["two"]}

    graph = build(make)
    assert_same(graph, samples())
    count = {
        goal: [n.op for n in rewritten(graph, goal).nodes].count("rotate")
        for goal in ("processors", "latency")
    }
    assert count == {"processors": 1, "latency": 2}


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("minus", [False, True])
def test_length_and_angle_share_a_vectoring(order: tuple[int, int], minus: bool) -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> dict[str, Value]:
        legs = [x, y]
        squares = [b.emit("pow", (legs[i],), (Fraction(2),)) for i in order]
        y_leg = b.emit("neg", (y,)) if minus else y
        return {
            "length": b.emit("sqrt", (b.emit("add", squares),)),
            "hypot": b.emit("hypot", (x, y)),
            "angle": b.emit("atan2", (y_leg, x)),
        }

    graph = build(make)
    assert_same(graph, samples())
    assert [n.op for n in rewritten(graph).nodes].count("vector") == 1


@pytest.mark.parametrize("factor", ["2", "3", "-1/3"])
def test_a_length_and_an_angle_share_a_vectoring_through_factors(factor: str) -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> dict[str, Value]:
        scaled = b.emit("mul", (b.const(Fraction(factor)), x))
        square = b.emit("pow", (scaled,), (Fraction(2),))
        radicand = b.emit("add", (square, b.emit("mul", (y, y))))
        return {"length": b.emit("sqrt", (radicand,)), "angle": b.emit("atan2", (y, scaled))}

    graph = build(make)
    assert_same(graph, samples())
    operations = [n.op for n in rewritten(graph).nodes]
    assert operations.count("vector") == 1
    assert "mul" not in operations


def test_tanh_saturates_before_its_parts_overflow() -> None:
    graph = build(lambda b, x, y, w: b.emit("tanh", (b.emit("mul", (b.const(1000), x)),)))
    assert_same(graph, samples())
    assert [n.op for n in rewritten(graph).nodes].count("max") == 1


@pytest.mark.parametrize("factor", [Fraction(2), Fraction(1, 2), Fraction(3)])
def test_factors_stay_inside_powers_that_would_underflow_without(factor: Fraction) -> None:
    def tower(b: Builder, x: Value, y: Value, w: Value) -> Value:
        inner = b.emit("pow", (b.emit("mul", (b.const(factor), x)),), (Fraction(32),))
        return b.emit("pow", (inner,), (Fraction(32),))

    graph = rewritten(build(tower))
    outer = [n.exponent if n.op == "shift" else n.factor for n in graph.nodes if n.op in ("shift", "cmul")]
    assert outer
    assert all(abs(Fraction(number)) <= 2**64 for number in outer)


def test_difference_of_squares_is_hyperbolic_vectoring() -> None:
    def make(b: Builder, x: Value, y: Value, w: Value) -> Value:
        square = b.emit("mul", (x, x))
        return b.emit("sqrt", (b.emit("sub", (b.const(1), square)),))

    graph = build(make)
    assert_same(graph, samples())
    assert [(n.op, n.params) for n in rewritten(graph).nodes if n.op == "vector"] == [("vector", (-1, 1))]


POWERS = ("-2", "-1", "-1/2", "1/2", "3/2", "2", "3")
EXPRESSIONS = st.recursive(
    st.sampled_from(NAMES) | st.integers(-3, 3).map(Fraction) | st.just(Fraction(1, 3)),
    lambda inner: (
        st.tuples(st.sampled_from(UNARY), inner)
        | st.tuples(st.sampled_from(BINARY), inner, inner)
        | st.tuples(st.just("pow"), inner, st.sampled_from(POWERS))
        | st.tuples(
            st.just("solve"),
            st.sampled_from([(1, "+"), (1, "-"), (-1, "+"), (-1, "none")]),
            inner,
            inner,
            inner,
        )
        | st.tuples(st.just("turned"), inner, inner, inner)
    ),
    max_leaves=8,
)


def emit(builder: Builder, expression) -> Value:
    if isinstance(expression, str):
        return builder.input(expression)
    if isinstance(expression, Fraction):
        return builder.const(expression)
    op, *parts = expression
    if op == "pow":
        return builder.emit("pow", (emit(builder, parts[0]),), (Fraction(parts[1]),))
    if op == "solve":
        return builder.emit("solve", [emit(builder, part) for part in parts[1:]], parts[0])
    if op == "turned":
        a, b, angle = (emit(builder, part) for part in parts)
        cosine = builder.emit("mul", (a, builder.emit("cos", (angle,))))
        return builder.emit("sub", (cosine, builder.emit("mul", (b, builder.emit("sin", (angle,))))))
    return builder.emit(op, [emit(builder, part) for part in parts])


SHAKES = 12


@settings(max_examples=examples(200), deadline=None)
@given(EXPRESSIONS)
def test_any_expression_keeps_its_meaning(expression) -> None:
    """Values and validity agree, save where the expression itself hangs on the last of 113 bits."""
    graph = build(lambda b, x, y, w: emit(b, expression))
    points = samples(12)
    exact, defined = reference_outputs(graph, points)
    shaken, still = reference_outputs(graph, {n: np.tile(p, SHAKES) for n, p in points.items()}, jitter=True)
    with np.errstate(all="ignore"):
        near = np.abs(shaken["out"] - np.tile(exact["out"], SHAKES)) <= 1e-9 * (1 + np.abs(shaken["out"]))
    agree = (still == np.tile(defined, SHAKES)) & (near | ~still)
    steady = agree.reshape(SHAKES, -1).all(axis=0) & ~(np.abs(exact["out"]) > 1e12)
    for implicit in (True, False):
        value, valid = reference_outputs(rewritten(graph, implicit=implicit), points)
        np.testing.assert_array_equal(valid[steady], defined[steady])
        both = defined & steady
        np.testing.assert_allclose(value["out"][both], exact["out"][both], rtol=1e-6, atol=1e-6)
