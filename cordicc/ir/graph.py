"""The hash-consed graph of operations and its builder.

A graph is immutable: nodes in topological order (operands before their users), equal nodes stored
once, and named outputs.  A pass walks one graph and builds another.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, NamedTuple, cast

from cordicc.ir.ops import OPS, OpDef, angle_result

Param = Fraction | int | str


class Value(NamedTuple):
    """Result number `result` of node number `node`."""

    node: int
    result: int = 0


@dataclass(frozen=True, slots=True)
class Node:
    """An operation, its parameters in the order of its definition, its operands.

    `origin` names the equation that first asked for the node; it takes no part in equality.
    """

    op: str
    params: tuple[Param, ...] = ()
    operands: tuple[Value, ...] = ()
    origin: str = field(default="", compare=False)

    @property
    def definition(self) -> OpDef:
        """Return the row of the operation table."""
        return OPS[self.op]

    def param(self, name: str) -> Param:
        """Return a parameter by its name in the operation table; raises ValueError."""
        return self.params[OPS[self.op].params.index(name)]

    @property
    def named(self) -> dict[str, Any]:
        """Return the parameters by name."""
        return self.definition.named(self.params)

    @property
    def angle(self) -> int | None:
        """Return the number of the result that is an angle in radians, None if none is."""
        return angle_result(self.op, self.named)

    @property
    def hyperbolic_angle(self) -> int | None:
        """Return the number of the result that is a hyperbolic angle, None if none is."""
        return angle_result(self.op, self.named, -1)

    @property
    def name(self) -> str:
        """Return the name of an input."""
        return cast(str, self.param("name"))

    @property
    def number(self) -> Fraction:
        """Return the number of a constant."""
        return cast(Fraction, self.param("value"))

    @property
    def m(self) -> int:
        """Return the coordinate system: 1 circular, 0 linear, -1 hyperbolic."""
        return cast(int, self.param("m"))

    @property
    def sign(self) -> int:
        """Return the sign with which a vectoring adds its angle, 1 or -1."""
        return cast(int, self.param("sign"))

    @property
    def branch(self) -> str:
        """Return the branch of an implicit operation or `solve`, of `BRANCHES`."""
        return cast(str, self.param("branch"))

    @property
    def condition(self) -> str:
        """Return the condition of a guard, of `GUARD_CONDITIONS`."""
        return cast(str, self.param("condition"))

    @property
    def factor(self) -> Fraction:
        """Return the factor of a product with a constant."""
        return cast(Fraction, self.param("factor"))

    @property
    def exponent(self) -> Fraction:
        """Return the exponent of a shift, a whole number, or of a power, a multiple of 1/2."""
        return Fraction(cast(Fraction | int, self.param("exponent")))


def factored(nodes: Sequence[Node], value: Value) -> tuple[Fraction, Value]:
    """Return (k, v) with value = k v, all constant factors, shifts and signs in k."""
    factor = Fraction(1)
    while True:
        node = nodes[value.node]
        match node.op:
            case "neg":
                factor = -factor
            case "cmul":
                factor *= node.factor
            case "shift":
                factor *= Fraction(2) ** int(node.exponent)
            case _:
                return factor, value
        value = node.operands[0]


@dataclass(frozen=True, slots=True)
class Graph:
    """Operations in topological order, and the outputs by name."""

    nodes: tuple[Node, ...]
    outputs: Mapping[str, Value]

    def node(self, value: Value) -> Node:
        """Return the node that makes a value."""
        return self.nodes[value.node]

    def constant(self, value: Value) -> Fraction | None:
        """Return the number of a constant, else None."""
        node = self.nodes[value.node]
        return node.number if node.op == "const" else None

    def users(self) -> list[list[int]]:
        """Return, for each node, the nodes that take one of its results, in order and once each."""
        found: list[list[int]] = [[] for _ in self.nodes]
        for index, node in enumerate(self.nodes):
            for operand in dict.fromkeys(v.node for v in node.operands):
                found[operand].append(index)
        return found

    def live(self, roots: Iterable[Value] | None = None) -> set[int]:
        """Return the nodes on the way to `roots` (default: the outputs)."""
        todo = [v.node for v in (self.outputs.values() if roots is None else roots)]
        seen: set[int] = set()
        while todo:
            index = todo.pop()
            if index not in seen:
                seen.add(index)
                todo.extend(v.node for v in self.nodes[index].operands)
        return seen

    def leading_to(self, value: Value) -> Graph:
        """Return the graph of one value alone, under the name "out"."""
        return _restricted(self.nodes, sorted(self.live([value])), {"out": value})

    def downstream(self, node: int) -> list[int]:
        """Return the nodes that depend on a node, in order."""
        reached = {node}
        for index in range(node + 1, len(self.nodes)):
            if any(operand.node in reached for operand in self.nodes[index].operands):
                reached.add(index)
        return sorted(reached - {node})

    def used_results(self) -> set[Value]:
        """Return the values that an operation or an output takes."""
        used = {operand for node in self.nodes for operand in node.operands}
        return used | set(self.outputs.values())


class Builder:
    """Builds a graph; equal operations become one node.

    `origin` is stamped on new nodes: set it to the equation at hand.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.origin = ""
        self._index: dict[Node, int] = {}

    def emit(self, op: str, operands: Iterable[Value] = (), params: Iterable[Param] = ()) -> Value:
        """Return the first result of the operation, adding it if it is new."""
        operands = tuple(operands)
        definition = OPS[op]
        if definition.commutative:
            operands = tuple(sorted(operands))
        node = Node(op, tuple(params), operands, self.origin)
        assert len(operands) == definition.arity, node
        assert len(node.params) == len(definition.params), node
        index = self._index.get(node)
        if index is None:
            index = self._index[node] = len(self.nodes)
            self.nodes.append(node)
        return Value(index)

    def const(self, number: Fraction | int) -> Value:
        """Return a constant."""
        return self.emit("const", (), (Fraction(number),))

    def input(self, name: str) -> Value:
        """Return an input."""
        return self.emit("input", (), (name,))

    def constant(self, value: Value) -> Fraction | None:
        """Return the number of a constant, else None."""
        node = self.nodes[value.node]
        return node.number if node.op == "const" else None

    def build(self, outputs: Mapping[str, Value]) -> Graph:
        """Return the graph of what the outputs need, in a stable order; inputs are all kept."""
        whole = Graph(tuple(self.nodes), dict(outputs))
        live = whole.live()
        kept = [i for i, node in enumerate(self.nodes) if i in live or node.op == "input"]
        return _restricted(self.nodes, kept, outputs)


def _restricted(nodes: Sequence[Node], kept: Sequence[int], outputs: Mapping[str, Value]) -> Graph:
    """Return the graph of some nodes, in order, among them all that they depend on."""
    renumber = {old: new for new, old in enumerate(kept)}

    def move(value: Value) -> Value:
        return Value(renumber[value.node], value.result)

    moved = tuple(
        Node(node.op, node.params, tuple(move(v) for v in node.operands), node.origin)
        for node in (nodes[i] for i in kept)
    )
    return Graph(moved, {name: move(value) for name, value in outputs.items()})
