"""What rounding makes of the results of a unit: each is moved as far as the unit may err, at samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Node
from cordicc.ir.meaning.doubles import Results, results
from cordicc.ir.meaning.roundings import errors

ROUNDING = 2.0**-24
"""Of single precision, relative to what an operation errs in."""


def own_errors(node: Node, operands: Sequence[Floats], made: Results) -> list[Floats]:
    """Return how far an operation itself moves its results, in roundings."""
    own = errors(node.op, node.params, operands, [np.zeros_like(x) for x in operands], made)
    # An error without bound tells that the sample lies at an edge, and nothing else.
    return [np.nan_to_num(size, posinf=0.0) for size in own]


def disturbed(
    node: Node,
    operands: Sequence[Floats],
    made: Results,
    inside: Floats,
    outside: Sequence[Floats],
    *,
    guard_bits: int | None = None,
) -> Results:
    """Return the results of an operation, rounded.

    An implicit unit leaves a residual: angle and second result are those of an equation a little beside its
    own, and go together however near the two solutions are.  Other results err by themselves.

    Args:
        node: the operation.
        operands: its operands, float64 of shape (n,).
        made: its exact results.
        inside: how far the residual is from 0, in the largest there may be.
        outside: the same of the rounding of each result.
        guard_bits: of words without exponents, whose errors are those of the largest; None: they have some.
    """
    fixed = guard_bits is not None
    step = ROUNDING if guard_bits is None or node.op == "input" else ROUNDING * 2.0**-guard_bits
    if node.op != "implicit":
        sizes = own_errors(node, operands, made)
        if fixed:
            sizes = [np.full_like(size, _largest(size)) for size in sizes]
        return tuple(x + step * u * size for x, u, size in zip(made, outside, sizes, strict=True))
    A, B, C = operands
    length = np.hypot(A, B)
    moved = C + step * (_largest(length) if fixed else length) * inside
    if node.m == 1:
        # The unit itself takes no equation out of its domain.
        moved = np.where(np.abs(C) <= length, np.clip(moved, -length, length), moved)
    angle, rest = results(node.op, node.params, (A, B, moved), C.size)
    size = _largest(rest) if fixed else rest
    return angle + step * outside[0], rest + step * size * outside[1]


def _largest(values: Floats) -> float:
    """Return the largest magnitude of values, of those that there are."""
    size = np.abs(values)
    return float(np.max(size, where=np.isfinite(size), initial=0.0))
