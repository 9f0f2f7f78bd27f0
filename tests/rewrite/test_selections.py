"""Selections that are decided: their meaning and who has a value stay."""

from collections.abc import Callable

import pytest

from cordicc.ir.graph import Builder, Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.selections import Selections
from tests.support.pass_graphs import NAMES, assert_same, build, samples


def square(b: Builder, v: Value) -> Value:
    return b.emit("mul", (v, v))


def sum_of_squares(b: Builder, x: Value, y: Value) -> Value:
    return b.emit("add", (square(b, x), square(b, y)))


def below(b: Builder, x: Value) -> Value:
    return b.emit("sub", (b.const(-5), x))


def solutions(b: Builder, x: Value, y: Value, w: Value) -> list[Value]:
    return [b.emit("solve", (x, y, w), (1, branch)) for branch in ("+", "-")]


CASES: dict[str, tuple[Callable[..., Value], list[str]]] = {
    "two solutions": (
        lambda b, x, y, w: b.emit("select", (sum_of_squares(b, x, y), *solutions(b, x, y, w))),
        ["solve"],
    ),
    "below": (lambda b, x, y, w: b.emit("select", (below(b, x), *solutions(b, x, y, w))), ["solve"]),
    "values of inputs": (lambda b, x, y, w: b.emit("select", (square(b, x), y, w)), []),
    "one that may fail": (
        lambda b, x, y, w: b.emit("select", (square(b, x), y, b.emit("sqrt", (w,)))),
        ["sqrt", "guard"],
    ),
    "a condition that may fail": (
        lambda b, x, y, w: b.emit("select", (square(b, b.emit("log", (x,))), y, w)),
        ["log", "mul", "guard"],
    ),
    "no less than 0": (
        lambda b, x, y, w: b.emit("max", (b.const(0), sum_of_squares(b, x, y))),
        ["mul", "mul", "add"],
    ),
    "the size of what is not negative": (
        lambda b, x, y, w: b.emit("abs", (sum_of_squares(b, x, y),)),
        ["mul", "mul", "add"],
    ),
    "no less than 1": (lambda b, x, y, w: b.emit("max", (b.const(1), square(b, x))), ["mul", "max"]),
    "the size of a number": (lambda b, x, y, w: b.emit("abs", (x,)), ["abs"]),
    "open": (lambda b, x, y, w: b.emit("select", (x, y, w)), ["select"]),
    "other equations": (
        lambda b, x, y, w: b.emit(
            "select", (square(b, x), solutions(b, x, y, w)[0], solutions(b, y, x, w)[1])
        ),
        ["solve", "solve", "guard"],
    ),
}


def operations(graph: Graph) -> list[str]:
    live = graph.live()
    return [n.op for i, n in enumerate(graph.nodes) if i in live and n.op not in ("input", "const")]


@pytest.mark.parametrize("name", CASES)
def test_selections(name: str) -> None:
    make, left = CASES[name]
    graph = build(make)
    context = PassContext({each: Interval(-2.0, 2.0) for each in NAMES})
    made = Selections().apply(graph, context)
    assert sorted(operations(made)) == sorted(left)
    assert_same(graph, samples())
