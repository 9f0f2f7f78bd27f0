"""What rounding makes of the results of a unit: each is moved as far as the unit may err, at samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node
from cordicc.ir.meaning.doubles import Results, results
from cordicc.ir.meaning.roundings import SINGLE, Words, errors


class Disturbances:
    """Moves the results of the operations of a graph, one after the other, as words round them.

    Words without exponents have one step for all that they hold, which is known of all samples alone.
    """

    def __init__(self, words: Words, graph: Graph, values: Sequence[Results]) -> None:
        """Look at a graph.

        Args:
            words: how numbers are rounded.
            graph: a graph of unit operations.
            values: the exact results of its nodes on all samples.
        """
        self._rounding = words.rounding
        made = zip(graph.nodes, values, strict=True)
        self._steps = [words.steps(node, result) for node, result in made] if words.fixed else None

    def step(self, index: int, result: int) -> float:
        """Return how far words without exponents round a result of a node."""
        assert self._steps is not None
        return self._rounding * float(np.max(self._steps[index][result]))

    def disturbed(
        self,
        index: int,
        node: Node,
        operands: Sequence[Floats],
        made: Results,
        inside: Floats,
        outside: Sequence[Floats],
    ) -> Results:
        """Return the results of an operation, rounded.

        An implicit unit leaves a residual: angle and second result are those of an equation a little beside
        its own, and go together however near the two solutions are.  Other results err by themselves.

        Args:
            index: the number of the node.
            node: the operation.
            operands: its operands, float64 of shape (n,).
            made: its exact results.
            inside: how far the residual is from 0, in the largest there may be.
            outside: the same of the rounding of each result.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # of what is beyond every double
            if node.op == "implicit":
                return self._solved(index, node, operands, inside, outside)
            steps = SINGLE.steps(node, made) if self._steps is None else self._steps[index]
            moves = zip(made, outside, _own_errors(node, operands, made, steps), strict=True)
            return tuple(x + self._rounding * u * size for x, u, size in moves)

    def _solved(
        self, index: int, node: Node, operands: Sequence[Floats], inside: Floats, outside: Sequence[Floats]
    ) -> Results:
        """Return the results of an implicit operation, rounded."""
        steps = None if self._steps is None else self._steps[index]
        A, B, C = operands
        length = np.hypot(A, B)
        moved = C + self._rounding * (length if steps is None else np.maximum(length, steps[1])) * inside
        if node.m == 1:
            # The unit itself takes no equation out of its domain.
            moved = np.where(np.abs(C) <= length, np.clip(moved, -length, length), moved)
        angle, rest = results(node.op, node.params, (A, B, moved), C.size)
        of_angle, of_rest = (1.0, rest) if steps is None else steps
        along = self._rounding * outside[1] * of_rest
        return angle + self._rounding * outside[0] * of_angle, rest + along


def _own_errors(node: Node, operands: Sequence[Floats], made: Results, steps: Results) -> list[Floats]:
    """Return how far an operation itself moves its results, in roundings."""
    own = errors(node.op, node.params, operands, [np.zeros_like(x) for x in operands], made, steps)
    # An error without bound tells that the sample lies at an edge, and nothing else.
    return [np.nan_to_num(size, posinf=0.0) for size in own]
