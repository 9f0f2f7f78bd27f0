"""Why samples have no value in the equations: the first operation on the way that has none, in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph, Node
from cordicc.ir.meaning.doubles import screen

REASONS = {
    "div": "a division by 0",
    "sqrt": "the root of a negative number",
    "pow": "a power that has no real value",
    "tan": "a tangent at its pole",
    "asin": "asin of a number beyond 1",
    "acos": "acos of a number beyond 1",
    "atan2": "atan2(0, 0)",
    "acosh": "acosh of a number below 1",
    "atanh": "atanh of a number beyond 1",
    "log": "the logarithm of a number that is not positive",
    "solve": "no solution",
    "solve_pair": "no single solution",
    "guard": "a sample outside its domain",
}
_TOO_LARGE = "a value beyond double precision"


class Cause(NamedTuple):
    """The equation and what in it has no value."""

    equation: str
    reason: str


@dataclass(slots=True)
class Causes:
    """How many samples have each cause, and the first of them, from 0."""

    graph: Graph
    samples: dict[Cause, int] = field(default_factory=dict)
    first: dict[Cause, int] = field(default_factory=dict)

    def screened(
        self, inputs: Mapping[str, Floats]
    ) -> tuple[dict[str, Floats], NDArray[np.bool_], list[tuple[Node, NDArray[np.bool_]]]]:
        """Evaluate the equations as `screen` does; also return where operations were first without value."""
        found: list[tuple[Node, NDArray[np.bool_]]] = []
        values, defined = screen(self.graph, inputs, lambda node, where: found.append((node, where)))
        return values, defined, found

    def count(
        self, found: list[tuple[Node, NDArray[np.bool_]]], undefined: NDArray[np.bool_], begin: int
    ) -> None:
        """Count the samples that are undefined indeed; the first of the part has the number `begin`."""
        for node, where in found:
            rows = np.flatnonzero(where & undefined)
            if rows.size:
                cause = Cause(node.origin, REASONS.get(node.op, _TOO_LARGE))
                self.samples[cause] = self.samples.get(cause, 0) + rows.size
                first = begin + int(rows[0])
                self.first[cause] = min(first, self.first.get(cause, first))

    def listed(self) -> tuple[tuple[Cause, int, int], ...]:
        """Return causes, numbers of samples and first samples, those with most samples first."""
        order = sorted(self.samples, key=lambda cause: (-self.samples[cause], self.first[cause]))
        return tuple((cause, self.samples[cause], self.first[cause]) for cause in order)
