"""The verifier: what every graph satisfies, checked after each pass."""

from __future__ import annotations

from fractions import Fraction

from cordicc.ir.graph import Graph, Node
from cordicc.ir.ops import BRANCHES, GUARD_CONDITIONS, OPS, Level


def verify(graph: Graph, levels: frozenset[Level] | None = None) -> None:
    """Check order, arity, parameters, uniqueness, outputs and, if given, the allowed levels.

    Raises AssertionError: a graph that fails is a bug of the pass that made it.
    """
    seen: set[Node] = set()
    for index, node in enumerate(graph.nodes):
        definition = OPS.get(node.op)
        assert definition is not None, f"%{index}: unknown operation {node.op}"
        assert len(node.operands) == definition.arity, (
            f"%{index}: {node.op} takes {definition.arity} operands"
        )
        assert len(node.params) == len(definition.params), f"%{index}: {node.op} parameters {node.params}"
        for value in node.operands:
            assert 0 <= value.node < index, f"%{index}: operand %{value.node} is not defined before"
            results = OPS[graph.nodes[value.node].op].results
            assert 0 <= value.result < len(results), f"%{index}: %{value.node} has no result {value.result}"
        _verify_params(index, node)
        assert node not in seen, f"%{index}: a duplicate of an earlier {node.op}"
        seen.add(node)
        if levels is not None:
            assert definition.level in levels, f"%{index}: {node.op} is not allowed at this stage"
    assert graph.outputs, "no outputs"
    for name, value in graph.outputs.items():
        assert 0 <= value.node < len(graph.nodes), f"output {name} is not defined"


def _verify_params(index: int, node: Node) -> None:
    for name, param in zip(node.definition.params, node.params, strict=True):
        ok = {
            "name": isinstance(param, str) and param.isidentifier(),
            "value": isinstance(param, Fraction),
            "factor": isinstance(param, Fraction) and param != 0,
            "exponent": isinstance(param, Fraction) and (2 * param).denominator == 1,
            "condition": param in GUARD_CONDITIONS,
            "m": param in (1, 0, -1),
            "sign": param in (1, -1),
            "branch": param in BRANCHES,
        }[name]
        assert ok, f"%{index}: {node.op} has {name}={param!r}"
