"""How long the evaluation of a graph in high precision takes."""

from __future__ import annotations

from cordicc.ir.graph import Graph

_TIMES = {
    4: "sin cos tan atan atan2 sinh cosh tanh exp log pow wrap solve_pair",
    6: "asin acos asinh acosh atanh rotate vector lightcone",
    12: "solve implicit",
}
_HEAVY = {op: times for times, ops in _TIMES.items() for op in ops.split()}
"""How many times as long as a product operations take."""


def effort(graph: Graph) -> int:
    """Return how many products take as long as evaluating a graph for one sample."""
    return sum(_HEAVY.get(node.op, 1) for node in graph.nodes)
