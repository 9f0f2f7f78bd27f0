"""Several instances of a graph side by side."""

from __future__ import annotations

from collections.abc import Callable

from cordicc.ir.graph import Graph, Node, Value


def copied(graph: Graph, count: int, name: Callable[[str, int], str]) -> Graph:
    """Return a graph of `count` instances that share their constants and nothing else.

    Args:
        graph: what is copied.
        count: at least 1.
        name: gives the name of an input or output in an instance, numbered from 1.
    """
    nodes: list[Node] = []
    outputs: dict[str, Value] = {}
    constants: dict[int, int] = {}
    for copy in range(1, count + 1):
        place: dict[int, int] = {}
        for index, node in enumerate(graph.nodes):
            if node.op == "const" and index in constants:
                place[index] = constants[index]
                continue
            place[index] = len(nodes)
            if node.op == "const":
                constants[index] = place[index]
            params = (name(str(node.params[0]), copy),) if node.op == "input" else node.params
            operands = tuple(Value(place[v.node], v.result) for v in node.operands)
            nodes.append(Node(node.op, params, operands, node.origin))
        for output, value in graph.outputs.items():
            outputs[name(output, copy)] = Value(place[value.node], value.result)
    return Graph(tuple(nodes), outputs)
