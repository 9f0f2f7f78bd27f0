"""The sum of the angles of two vectors is the angle of their complex product."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.field import TooLarge
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.products import turned
from cordicc.rewrite.rules.rule import Given, Rule


def _add_sums_of_vectors(given: Given) -> None:
    """Add the sum or difference of the angles of two vectors as the angle of one."""
    store = given.store
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op not in ("add", "sub"):
            continue
        first, second = (_vector(store, v) for v in node.operands)
        if first is None or second is None or first == second:
            continue
        sign = 1 if node.op == "add" else -1
        (x, y), (u, v) = first, second
        store.begin(node.origin)
        try:
            made = turned(store, (x, y), (u, v if sign == 1 else store.make("neg", (v,))[0]))
        except TooLarge:
            continue
        angle = store.make("vector", (*made, store.const(0)), (1, 1))[1]
        store.same_turn(Value(index), angle)


def _vector(store: Store, value: Value) -> tuple[Value, Value] | None:
    """Return the vector of which a value is the angle."""
    node = store.node(value)
    if node.op != "vector" or value.result != 1 or node.m != 1:
        return None
    x, y, start = node.operands
    if store.constant(start) != 0:
        return None
    return (x, y) if node.sign == 1 else (x, store.make("neg", (y,))[0])


VECTOR_SUMS = Rule(
    name="sums of the angles of vectors",
    mathematics="atan2(y, x) + atan2(v, u) = atan2(y u + x v, x u - y v) modulo 2 pi",
    apply=_add_sums_of_vectors,
    words="the sum of two angles is the angle of the complex product of their vectors",
)
