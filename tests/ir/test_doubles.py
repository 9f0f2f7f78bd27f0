"""Double precision against the yardstick, and the ways in which it is asked."""

from fractions import Fraction

import numpy as np
import pytest

from cordicc.ir.graph import Builder, Node
from cordicc.ir.meaning.doubles import all_results, screen, values_of
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ops import OPS, Level
from tests.support.operations import Case, cases, graph_of


@pytest.mark.parametrize("case", cases(Level.ARITHMETIC, Level.FUNCTION, Level.UNIT), ids=str)
def test_every_operation_is_near_the_reference(case: Case) -> None:
    graph = graph_of(*case)
    generator = np.random.default_rng(5)
    for scale in (0.9, 6.0):
        inputs = {f"x{i}": generator.uniform(-scale, scale, 300) for i in range(OPS[case[0]].arity)}
        values, defined = screen(graph, inputs)
        exact, valid = reference_outputs(graph, inputs)
        assert np.array_equal(defined, valid)
        for name, column in exact.items():
            assert np.allclose(values[name][valid], column[valid], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("op", "params", "point"),
    [
        ("atan2", (), (0.0, 0.0)),
        ("vector", (1, 1), (0.0, -0.0, 1.0)),
        ("implicit", (1, "+"), (0.0, 0.0, 0.0)),
        ("implicit", (-1, "none"), (0.0, 1.0, 2.0)),
        ("guard", ("positive",), (1.0, 0.0)),
        ("div", (), (1.0, 0.0)),
        ("pow", (Fraction(-1, 2),), (0.0,)),
    ],
)
def test_edges_have_no_value(op: str, params: tuple, point: tuple[float, ...]) -> None:
    graph = graph_of(op, params)
    inputs = {f"x{i}": np.array([number]) for i, number in enumerate(point)}
    assert not screen(graph, inputs)[1].any()


def test_what_hangs_on_no_value_has_none() -> None:
    builder = Builder()
    root = builder.emit("sqrt", [builder.input("x")])
    rest = builder.emit("min", [root, builder.const(1)])
    values = values_of(builder.nodes, range(len(builder.nodes)), {"x": np.array([-1.0, 4.0, np.inf])})
    np.testing.assert_array_equal(values[root.node], [np.nan, 2, np.nan])
    np.testing.assert_array_equal(values[rest.node], [np.nan, 1, np.nan])


def test_zeros_have_no_sign() -> None:
    inputs = {"x0": np.array([-0.0]), "x1": np.array([-1.0])}
    assert screen(graph_of("atan2"), inputs)[0]["r0"].tolist() == [np.pi]


def test_the_first_operation_without_a_value_is_told() -> None:
    builder = Builder()
    root = builder.emit("sqrt", [builder.input("x")])
    graph = builder.build({"out": builder.emit("add", [builder.emit("log", [root]), root])})
    told: list[tuple[str, list[bool]]] = []

    def broken(node: Node, where: np.ndarray) -> None:
        told.append((node.op, where.tolist()))

    screen(graph, {"x": np.array([-1.0, 0.0, 1.0])}, broken)
    assert told == [("sqrt", [True, False, False]), ("log", [False, True, False])]


def test_guards_hand_on_and_noise_is_applied_to_all() -> None:
    builder = Builder()
    x = builder.input("x")
    graph = builder.build({"out": builder.emit("guard", [builder.const(2), x], ("positive",))})
    inputs = {"x": np.array([-1.0, 1.0])}
    out = graph.outputs["out"].node
    assert all_results(graph, inputs)[out][0].tolist() == [2.0, 2.0]
    noisy = all_results(graph, inputs, lambda node, operands, made: tuple(x + 1 for x in made))
    assert [results[0].tolist() for results in noisy][out] == [4.0, 4.0]
