"""Values of operations on sample points in double precision, to find relations and to judge accuracy.

Nothing is proven by these numbers.  An undefined result is NaN.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from cordicc.arith.numbers.decimals import double_shift, nearest_double
from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node, Param


def _solve(m: int, branch: str, A: Floats, B: Floats, C: Floats) -> tuple[Floats, Floats]:
    rest = np.sqrt(A * A + m * (B * B - C * C))
    if m == 1:
        angle = np.arctan2(rest, C)
        return np.arctan2(A, B) + (angle if branch == "+" else -angle), rest
    p, q = (B + A) / 2, (B - A) / 2
    p, q = np.where(C < 0, -p, p), np.where(C < 0, -q, q)
    total = (np.abs(C) + rest) / 2
    first = p > 0 if branch != "-" else (p > 0) & (q <= 0)
    exponential = np.where(first, total / p, np.where(q > 0, q / total, np.nan))
    return np.log(exponential), rest


def _rotate(m: int, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
    if m == 0:
        return x, y + x * z
    c, s = (np.cos(z), np.sin(z)) if m == 1 else (np.cosh(z), np.sinh(z))
    return x * c - m * y * s, y * c + x * s


def _vector(m: int, sign: int, x: Floats, y: Floats, z: Floats) -> tuple[Floats, Floats]:
    if m == 0:
        return x, z + sign * (y / x)
    angle = np.arctan2(y, x) if m == 1 else np.arctanh(y / x)
    return np.sqrt(x * x + m * y * y), z + sign * angle


def _wrap(a: Floats) -> Floats:
    return np.pi - np.mod(np.pi - a, 2 * np.pi)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "const": lambda value: np.array(nearest_double(value)),
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "cmul": lambda factor, a: nearest_double(factor) * a,
    "shift": lambda exponent, a: np.ldexp(a, double_shift(exponent)),
    "neg": np.negative,
    "abs": np.abs,
    "sign": np.sign,
    "min": np.minimum,
    "max": np.maximum,
    "flip": lambda a, s: np.where(s < 0, -a, a),
    "select": lambda s, a, b: np.where(s < 0, b, a),
    "guard": lambda condition, a, s: a,
    "wrap": _wrap,
    "rotate": _rotate,
    "vector": _vector,
    "lightcone": lambda u, v: (np.sqrt(u * v), np.log(u / v) / 2),
    "implicit": _solve,
}


def results(op: str, params: Sequence[Param], operands: Sequence[Floats], shape: int) -> tuple[Floats, ...]:
    """Return the results of an operation of a graph of unit operations, arrays of `shape` numbers."""
    with np.errstate(all="ignore"):
        made = _FUNCTIONS[op](*params, *operands)
    made = made if isinstance(made, tuple) else (made,)
    return tuple(x if x.shape == (shape,) else np.broadcast_to(x, (shape,)) for x in made)


Results = tuple[Floats, ...]
Noise = Callable[[Node, Sequence[Floats], Results], Results]
"""Returns what becomes of the results of a node, given its operands."""


def evaluate(
    graph: Graph, inputs: Mapping[str, Floats], noise: Noise = lambda _, __, made: made
) -> list[Results]:
    """Return the values of every result of every node; `noise` is applied to each of them."""
    count = len(next(iter(inputs.values()), np.zeros(1)))
    found: list[Results] = []
    for node in graph.nodes:
        if node.op == "input":
            found.append(noise(node, (), (inputs[str(node.params[0])],)))
            continue
        operands = [found[v.node][v.result] for v in node.operands]
        found.append(noise(node, operands, results(node.op, node.params, operands, count)))
    return found
