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
    node: Node, operands: Sequence[Floats], made: Results, inside: Floats, outside: Sequence[Floats]
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
    """
    if node.op != "implicit":
        sizes = own_errors(node, operands, made)
        return tuple(x + ROUNDING * u * size for x, u, size in zip(made, outside, sizes, strict=True))
    A, B, C = operands
    length = np.hypot(A, B)
    moved = C + ROUNDING * length * inside
    if node.m == 1:
        # The unit itself takes no equation out of its domain.
        moved = np.where(np.abs(C) <= length, np.clip(moved, -length, length), moved)
    angle, rest = results(node.op, node.params, (A, B, moved), C.size)
    return angle + ROUNDING * outside[0], rest * (1 + ROUNDING * outside[1])
