"""Inputs whose ranges look like degrees: angles are in radians everywhere."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cordicc.ir.graph import Graph, Value
from cordicc.ir.problem import InputSpec

_TURNED = ("sin", "cos", "tan")
_SUMS = ("add", "sub", "neg")

_MOST = 4 * math.pi
"""Radians: few angles in equations go through more than two turns either way, most in degrees do."""


def in_degrees(graph: Graph, inputs: Sequence[InputSpec]) -> list[InputSpec]:
    """Return the inputs of which only sines, cosines and tangents are used, beyond two turns."""
    turned = _turned(graph)
    return [i for i in inputs if i.name in turned and max(abs(i.lo), abs(i.hi)) > _MOST]


def _turned(graph: Graph) -> set[str]:
    """Return the inputs of which, or of sums with which, only sines, cosines and tangents are used."""
    other = set(graph.outputs.values())
    used: set[Value] = set()
    for index in reversed(range(len(graph.nodes))):
        node = graph.nodes[index]
        fine = node.op in _TURNED or (node.op in _SUMS and Value(index) not in other)
        used.update(node.operands)
        if not fine:
            other.update(node.operands)
    return {
        node.name
        for index, node in enumerate(graph.nodes)
        if node.op == "input" and Value(index) in used - other
    }
