"""Operations in double precision, on whole arrays: a quick look at many samples, no yardstick.

Each operation is that of `cordicc.ir.ops` on float64 arrays of shape (n,), not finite where it has no value.
Nothing is proven by these numbers; how far they are from `cordicc.ir.meaning.reference` is measured where
both are computed, never assumed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from cordicc.arith.numbers.decimals import double_shift, nearest_double
from cordicc.base import elementary
from cordicc.base.arrays import Bools, Floats
from cordicc.ir.graph import Graph, Node, Param
from cordicc.ir.ops import OPS

Results = tuple[Floats, ...]
Noise = Callable[[Node, Sequence[Floats], Results], Results]
"""Returns what becomes of the results of a node, given its operands."""


def results(op: str, params: Sequence[Param], operands: Sequence[Floats], count: int) -> Results:
    """Return the results of an operation on `count` samples.

    Args:
        op: any operation but `input`.
        params: its parameters in the order of its definition.
        operands: arrays of shape (count,).
        count: of samples.
    """
    with np.errstate(all="ignore"):
        made = OPERATIONS[op](*operands, **OPS[op].named(params))
    made = made if isinstance(made, tuple) else (made,)
    return tuple(x if x.shape == (count,) else np.broadcast_to(x, (count,)) for x in made)


def all_results(
    graph: Graph, inputs: Mapping[str, Floats], noise: Noise = lambda _, __, made: made
) -> list[Results]:
    """Return the results of every node of a graph; `noise` is applied to each of them.

    A guard hands on its operand whatever the condition: who has a value is not judged here.
    """
    count = len(next(iter(inputs.values()), np.zeros(1)))
    found: list[Results] = []
    for node in graph.nodes:
        operands = [found[v.node][v.result] for v in node.operands]
        if node.op == "input":
            made: Results = (inputs[node.name],)
        elif node.op == "guard":
            made = (operands[0],)
        else:
            made = results(node.op, node.params, operands, count)
        found.append(noise(node, operands, made))
    return found


def screen(
    graph: Graph, inputs: Mapping[str, Floats], broken: Callable[[Node, Bools], None] | None = None
) -> tuple[dict[str, Floats], Bools]:
    """Return the outputs of a graph on samples, and which samples have a value in every operation of it.

    `broken` is told of each operation that is the first without a value, and for which samples.
    """
    count = len(next(iter(inputs.values()), np.zeros(1)))
    found: list[Results] = []
    defined = np.ones(count, dtype=bool)
    for node in graph.nodes:
        if node.op == "input":
            made: Results = (inputs[node.name],)
        else:
            operands = [found[v.node][v.result] for v in node.operands]
            made = results(node.op, node.params, operands, count)
        found.append(made)
        for column in made:
            finite = np.isfinite(column)
            if broken is not None and (fresh := defined & ~finite).any():
                broken(node, fresh)
            defined &= finite
    return {name: found[v.node][v.result] for name, v in graph.outputs.items()}, defined


def value_of(node: Node, operands: Sequence[Floats], inputs: Mapping[str, Floats], count: int) -> Floats:
    """Return the first result of a node on samples, NaN where it or an operand has no value."""
    if node.op == "input":
        return inputs[node.name]
    made = results(node.op, node.params, operands, count)[0]
    return _only(np.logical_and.reduce([np.isfinite(x) for x in (made, *operands)]), made)


def values_of(nodes: Sequence[Node], order: Iterable[int], inputs: Mapping[str, Floats]) -> dict[int, Floats]:
    """Return `value_of` each of the nodes in `order`, which has operands before users."""
    count = len(next(iter(inputs.values()), np.zeros(1)))
    values: dict[int, Floats] = {}
    for index in order:
        operands = [values[v.node] for v in nodes[index].operands]
        values[index] = value_of(nodes[index], operands, inputs, count)
    return values


def _only(condition: Bools, value: Floats) -> Floats:
    return np.where(condition, value, np.nan)


def _angle(y: Floats, x: Floats) -> Floats:
    # Adding 0 turns -0 into 0, which the equations do not tell apart.
    return _only((x != 0) | (y != 0), elementary.arctan2(y + 0.0, x + 0.0))


def _power(a: Floats, exponent: Fraction) -> Floats:
    if exponent.denominator == 1:
        return elementary.power(a, nearest_double(exponent))
    return elementary.power(np.sqrt(a), nearest_double(Fraction(exponent.numerator)))


def _guard(a: Floats, s: Floats, condition: str) -> Floats:
    holds = {"any": s == s, "nonzero": s != 0, "nonnegative": s >= 0, "positive": s > 0}
    return _only(holds[condition], a)


def _wrap(a: Floats) -> Floats:
    wrapped = a - math.tau * np.ceil((a - math.pi) / math.tau)
    return np.where((-math.pi < a) & (a <= math.pi), a, wrapped)


def _solve_pair(A1: Floats, B1: Floats, C1: Floats, A2: Floats, B2: Floats, C2: Floats) -> Floats:
    determinant = B1 * A2 - B2 * A1
    return _angle((B1 * C2 - B2 * C1) / determinant, (C1 * A2 - C2 * A1) / determinant)


def _implicit(A: Floats, B: Floats, C: Floats, m: int, branch: str) -> Results:
    """Return the solution and the root.

    A circle's solution is the angle of (A, B) and that of (C, root), a hyperbola's the logarithm of the
    root E > 0 of p E^2 - C E + q = 0, p = (B+A)/2, q = (B-A)/2.
    """
    rest = np.sqrt(A * A + m * (B * B - C * C))
    if m == 1:
        offset = elementary.arctan2(rest, C)
        return _angle(A, B) + (offset if branch == "+" else -offset), rest
    p, q = (B + A) / 2, (B - A) / 2
    p, q = np.where(C < 0, -p, p), np.where(C < 0, -q, q)
    total = (np.abs(C) + rest) / 2
    both = (p > 0) & (q > 0)
    first = (p > 0) & ~(both & (branch == "-"))
    exponential = np.where(first, total / p, _only(q > 0, q / total))
    return _only(~both | (branch != "none"), elementary.log(exponential)), rest


def _rotate(x: Floats, y: Floats, z: Floats, m: int) -> Results:
    if m == 0:
        return x, y + x * z
    c, s = (elementary.cos(z), elementary.sin(z)) if m == 1 else (elementary.cosh(z), elementary.sinh(z))
    return x * c - m * y * s, y * c + x * s


def _vector(x: Floats, y: Floats, z: Floats, m: int, sign: int) -> Results:
    if m == 0:
        return x, z + sign * (y / x)
    angle = _angle(y, x) if m == 1 else elementary.arctanh(y / x)
    return np.sqrt(x * x + m * y * y), z + sign * angle


OPERATIONS: dict[str, Callable[..., Any]] = {
    "const": lambda value: np.array(nearest_double(value)),
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "cmul": lambda a, factor: nearest_double(factor) * a,
    "shift": lambda a, exponent: np.ldexp(a, double_shift(exponent)),
    "neg": np.negative,
    "abs": np.abs,
    "sign": np.sign,
    "min": np.minimum,
    "max": np.maximum,
    "flip": lambda a, s: np.where(s < 0, -a, a),
    "select": lambda s, a, b: np.where(s < 0, b, a),
    "guard": _guard,
    "wrap": _wrap,
    "div": np.divide,
    "pow": _power,
    "sqrt": np.sqrt,
    "hypot": np.hypot,
    "sin": elementary.sin,
    "cos": elementary.cos,
    "tan": elementary.tan,
    "asin": elementary.arcsin,
    "acos": elementary.arccos,
    "atan": elementary.arctan,
    "atan2": _angle,
    "sinh": elementary.sinh,
    "cosh": elementary.cosh,
    "tanh": elementary.tanh,
    "asinh": elementary.arcsinh,
    "acosh": elementary.arccosh,
    "atanh": elementary.arctanh,
    "exp": elementary.exp,
    "log": elementary.log,
    "solve": lambda A, B, C, m, branch: _implicit(A, B, C, m, branch)[0],
    "solve_pair": _solve_pair,
    "rotate": _rotate,
    "vector": _vector,
    "lightcone": lambda u, v: (np.sqrt(u * v), elementary.log(u / v) / 2),
    "implicit": _implicit,
}
"""Functions of the operands in their order and of the parameters by name."""
