"""The high-precision evaluation, against the independent constant folding and against itself."""

from fractions import Fraction

import numpy as np
import pytest
from mpmath import libmp

from cordicc.ir.graph import Builder, Value
from cordicc.ir.meaning import rounded_operations
from cordicc.ir.meaning.exact import FoldError, fold
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ops import OPS, Level
from tests.support.operations import cases, graph_of

POINTS = [Fraction(n, 4) for n in (-9, -4, -2, -1, 0, 1, 3, 4, 6)]


@pytest.mark.parametrize(("op", "params"), cases(Level.ARITHMETIC, Level.FUNCTION))
def test_agrees_with_constant_folding(op: str, params: tuple) -> None:
    """On rational points, edges of domains among them, both say the same, or both say nothing."""
    arity = OPS[op].arity
    generator = np.random.default_rng(5)
    chosen = generator.integers(0, len(POINTS), (120, arity))
    rows = [[POINTS[i] for i in row] for row in chosen]
    graph = graph_of(op, params)
    inputs = {f"x{i}": np.array([float(row[i]) for row in rows]) for i in range(arity)}
    value, valid = reference_outputs(graph, inputs)
    for index, row in enumerate(rows):
        try:
            expected = fold(op, params, row)
        except FoldError:
            assert not valid[index], row
        else:
            assert valid[index], row
            assert value["r0"][index] == pytest.approx(float(expected), rel=1e-15, abs=1e-30), row


def test_beyond_every_double_is_the_largest_one() -> None:
    builder = Builder()
    power = builder.emit("pow", (builder.input("x"),), (Fraction(9),))
    value, valid = reference_outputs(builder.build({"out": power}), {"x": np.array([-1e40, 2.0, 1e300])})
    largest = np.finfo(np.float64).max
    assert value["out"].tolist() == [-largest, 512, largest]
    assert valid.tolist() == [True, True, True]


def test_correctly_rounded() -> None:
    """1/3 + 1/3 + 1/3 is 1: the work is done in more than double precision."""
    builder = Builder()
    third = builder.emit("div", (builder.input("x"), builder.const(3)))
    total = builder.emit("add", (builder.emit("add", (third, third)), third))
    difference = builder.emit("sub", (total, builder.input("x")))
    value, _ = reference_outputs(builder.build({"out": difference}), {"x": np.array([0.1, 7.0])})
    assert np.all(np.abs(value["out"]) < 1e-32)


def test_results_of_one_operation_fail_apart() -> None:
    """The null vector has a length and no angle."""
    builder = Builder()
    zero, x = builder.const(0), builder.input("x")
    made = builder.emit("vector", (x, x, zero), (1, 1))
    graph = builder.build({"norm": made, "angle": Value(made.node, 1)})
    value, valid = reference_outputs(graph, {"x": np.array([0.0])})
    assert value["norm"][0] == 0
    assert np.isnan(value["angle"][0])
    assert not valid[0]


@pytest.mark.parametrize("n", [10**900, 10**900 + 1, -(10**900) - 1])
def test_huge_exponents_give_a_size(n: int) -> None:
    half, two = libmp.from_float(0.5), libmp.from_float(-2.0)
    power = rounded_operations.OPERATIONS["pow"](Fraction(n))
    small, large = (half, two) if n > 0 else (two, half)
    assert power(large) is None
    assert libmp.mpf_cmp(libmp.mpf_abs(power(small)), libmp.from_man_exp(1, -(10**6))) < 0
    assert libmp.mpf_sign(power(small)) == (-1 if n % 2 and small == two else 1)
    assert power(libmp.fone) == libmp.fone
    assert power(libmp.fnone) == (libmp.fnone if n % 2 else libmp.fone)
    assert power(libmp.fzero) == (libmp.fzero if n > 0 else None)
