"""The equations in double precision, on whole arrays: a quick look at many samples, no yardstick.

Each operation is that of `cordicc.ir.meaning.reference` in float64, nan where it has no value.  How far it is
from the reference is measured where both are computed, never assumed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.arith.numbers.decimals import double_shift, nearest_double
from cordicc.base.arrays import Bools, Floats
from cordicc.ir.graph import Graph, Node, Param, Value


def screen(
    graph: Graph,
    inputs: Mapping[str, Floats],
    broken: Callable[[Node, Bools], None] | None = None,
) -> tuple[dict[str, Floats], Bools]:
    """Evaluate the outputs of a graph of equations on samples, float64 of shape (n,), in double precision.

    Returns the outputs, and which samples have a value in every operation of the graph.  `broken` is told
    of each operation that is the first without a value, and for which samples.
    """
    count = len(next(iter(inputs.values()))) if inputs else 1
    values: dict[Value, Floats] = {}
    defined = np.ones(count, dtype=bool)
    with np.errstate(all="ignore"):
        for index, node in enumerate(graph.nodes):
            if node.op == "input":
                made: Any = inputs[str(node.params[0])]
            elif node.op == "const":
                made = np.full(count, nearest_double(Fraction(node.params[0])))
            else:
                made = _OPERATIONS[node.op](node.params, *(values[operand] for operand in node.operands))
            for result, column in enumerate(made if isinstance(made, tuple) else (made,)):
                values[Value(index, result)] = column
                finite = np.isfinite(column)
                if broken is not None and (fresh := defined & ~finite).any():
                    broken(node, fresh)
                defined &= finite
    return {name: values[value] for name, value in graph.outputs.items()}, defined


def _only(condition: Bools, value: Floats) -> Floats:
    return np.where(condition, value, np.nan)


def _angle(y: Floats, x: Floats) -> Floats:
    # Adding 0 turns -0 into 0, which the equations do not tell apart.
    return _only((x != 0) | (y != 0), np.arctan2(y + 0.0, x + 0.0))


def _power(params: tuple[Param, ...], a: Floats) -> Floats:
    exponent = Fraction(params[0])
    if exponent.denominator == 1:
        return np.power(a, nearest_double(exponent))
    return np.power(np.sqrt(a), nearest_double(Fraction(exponent.numerator)))


def _guard(params: tuple[Param, ...], a: Floats, s: Floats) -> Floats:
    holds = {"any": s == s, "nonzero": s != 0, "nonnegative": s >= 0, "positive": s > 0}
    return _only(holds[str(params[0])], a)


def _wrap(params: tuple[Param, ...], a: Floats) -> Floats:
    wrapped = a - math.tau * np.ceil((a - math.pi) / math.tau)
    return np.where((-math.pi < a) & (a <= math.pi), a, wrapped)


def _circular(branch: Param, A: Floats, B: Floats, C: Floats) -> Floats:
    offset = np.arccos(C / np.hypot(A, B))
    return _angle(A, B) + (offset if branch == "+" else -offset)


def _hyperbolic(branch: Param, A: Floats, B: Floats, C: Floats) -> Floats:
    """Return the logarithm of the root E > 0 of p E^2 - C E + q = 0, p = (B+A)/2, q = (B-A)/2."""
    flip = np.where(C < 0, -1.0, 1.0)
    p, q = flip * (B + A) / 2, flip * (B - A) / 2
    total = np.abs(C) + np.sqrt(C * C - 4 * p * q)
    both = (p > 0) & (q > 0)
    first = (p > 0) & ~(both & (branch == "-"))
    solution = np.where(first, np.log(total / (2 * p)), _only(q > 0, np.log(2 * q / total)))
    return _only(~both | (branch != "none"), solution)


def _solve(params: tuple[Param, ...], A: Floats, B: Floats, C: Floats) -> Floats:
    return (_circular if params[0] == 1 else _hyperbolic)(params[1], A, B, C)


def _pair(
    params: tuple[Param, ...], A1: Floats, B1: Floats, C1: Floats, A2: Floats, B2: Floats, C2: Floats
) -> Floats:
    determinant = B1 * A2 - B2 * A1
    return _angle((B1 * C2 - B2 * C1) / determinant, (C1 * A2 - C2 * A1) / determinant)


_Operation = Callable[..., Floats]


def _plain(function: Callable[..., Any]) -> _Operation:
    """Make a row of an operation without parameters."""
    return lambda params, *operands: function(*operands)


_OPERATIONS: dict[str, _Operation] = {
    "add": _plain(np.add),
    "sub": _plain(np.subtract),
    "mul": _plain(np.multiply),
    "cmul": lambda params, a: a * nearest_double(Fraction(params[0])),
    "shift": lambda params, a: np.ldexp(a, double_shift(Fraction(params[0]))),
    "neg": _plain(np.negative),
    "abs": _plain(np.abs),
    "sign": _plain(np.sign),
    "min": _plain(np.minimum),
    "max": _plain(np.maximum),
    "flip": _plain(lambda a, s: np.where(s < 0, -a, a)),
    "select": _plain(lambda s, a, b: np.where(s < 0, b, a)),
    "guard": _guard,
    "wrap": _wrap,
    "div": _plain(np.divide),
    "pow": _power,
    "sqrt": _plain(np.sqrt),
    "hypot": _plain(np.hypot),
    "sin": _plain(np.sin),
    "cos": _plain(np.cos),
    "tan": _plain(np.tan),
    "asin": _plain(np.arcsin),
    "acos": _plain(np.arccos),
    "atan": _plain(np.arctan),
    "atan2": _plain(_angle),
    "sinh": _plain(np.sinh),
    "cosh": _plain(np.cosh),
    "tanh": _plain(np.tanh),
    "asinh": _plain(np.arcsinh),
    "acosh": _plain(np.arccosh),
    "atanh": _plain(np.arctanh),
    "exp": _plain(np.exp),
    "log": _plain(np.log),
    "solve": _solve,
    "solve_pair": _pair,
}
"""Operations of equations; units occur in plans only."""
