"""Evaluation of a graph in floats, for tests at sample points; nothing is concluded from it alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from cordicc.ir.graph import Node


def _pow(exponent: Any, base: float) -> float:
    return math.nan if base < 0 and exponent.denominator == 2 else base ** float(exponent)


def _solve(m: int, branch: str, A: float, B: float, C: float) -> float:
    sign = -1.0 if branch == "-" else 1.0
    if m == 1:
        return math.atan2(A, B) + sign * math.acos(C / math.hypot(A, B))
    if abs(A) > abs(B):
        return math.asinh(math.copysign(C / math.sqrt(A * A - B * B), A * C)) - math.atanh(B / A)
    if abs(A) == abs(B):
        return math.log(C / B) * math.copysign(1.0, A * B)
    return -math.atanh(A / B) + sign * math.acosh(C / math.copysign(math.sqrt(B * B - A * A), B))


def _solve_pair(A1: float, B1: float, C1: float, A2: float, B2: float, C2: float) -> float:
    determinant = B1 * A2 - B2 * A1
    return math.atan2((B1 * C2 - B2 * C1) / determinant, (C1 * A2 - C2 * A1) / determinant)


def _sign(a: float) -> float:
    return float((a > 0) - (a < 0))


def _wrap(a: float) -> float:
    wrapped = math.remainder(a, 2 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def _atan2(y: float, x: float) -> float:
    return math.nan if x == 0 and y == 0 else math.atan2(y, x)


_MEETS: dict[str, Callable[[float], bool]] = {
    "any": lambda s: True,
    "nonzero": lambda s: s != 0,
    "nonnegative": lambda s: s >= 0,
    "positive": lambda s: s > 0,
}

_OWN: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "neg": lambda a: -a,
    "abs": abs,
    "sign": _sign,
    "min": min,
    "max": max,
    "guard": lambda condition, a, s: a if _MEETS[condition](s) else math.nan,
    "select": lambda s, a, b: a if s >= 0 else b,
    "wrap": _wrap,
    "div": lambda a, b: a / b,
    "pow": _pow,
    "solve": _solve,
    "solve_pair": _solve_pair,
    "atan2": _atan2,
}
_MATH = "sqrt hypot sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log"
_FUNCTIONS = _OWN | {name: getattr(math, name) for name in _MATH.split()}


def evaluate_node(node: Node, operands: Sequence[float], inputs: Mapping[str, float]) -> float:
    """Return the value of a source-level node; nan where it leaves the real domain."""
    if node.op == "const":
        return float(node.params[0])
    if node.op == "input":
        return inputs[str(node.params[0])]
    if not all(math.isfinite(v) for v in operands):
        return math.nan
    try:
        return float(_FUNCTIONS[node.op](*node.params, *operands))
    except (ValueError, OverflowError, ZeroDivisionError):
        return math.nan


def evaluate(nodes: Sequence[Node], order: Sequence[int], inputs: Mapping[str, float]) -> dict[int, float]:
    """Return the values of the source-level nodes in `order`, which has operands before users.

    What leaves the real domain, and what depends on it, is nan.
    """
    values: dict[int, float] = {}
    for index in order:
        node = nodes[index]
        values[index] = evaluate_node(node, [values[v.node] for v in node.operands], inputs)
    return values
