"""Which values of a store are angles of circular units, or sums with one in them."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.rewrite.exact.values import Store

SUMS = ("add", "sub", "neg", "wrap", "cmul", "shift")
"""Operations that make angles of angles."""


def angles_of(store: Store) -> list[Value]:
    """Return the angles that circular units make."""
    angles = ((index, node.angle) for index, node in enumerate(store.algebra.nodes))
    return [Value(index, angle) for index, angle in angles if angle is not None]


def is_angle(store: Store, value: Value) -> bool:
    """Tell whether a value is a sum with an angle of a circular unit in it."""
    node = store.node(value)
    if node.op in SUMS:
        return any(is_angle(store, v) for v in node.operands)
    return value.result == node.angle
