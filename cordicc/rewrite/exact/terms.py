"""Sums of products as their terms, and products as their factors, of the nodes of a graph or a store."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from cordicc.ir.graph import Node, Value, factored

Term = tuple[Fraction, tuple[Value, ...]]
"""A coefficient, and the factors of a product."""

_TERMS = 12
"""Longer sums are left as they are."""

_FACTORS = 8
"""What a product has more of stays together."""


def terms_of(nodes: Sequence[Node], value: Value) -> list[Term] | None:
    """Return a value as a sum of products in the order as written, None if it is long."""
    todo, found = [(Fraction(1), value)], list[Term]()
    while todo:
        factor, value = todo.pop()
        own, base = factored(nodes, value)
        factor *= own
        node = nodes[base.node]
        if node.op in ("add", "sub"):
            second = -factor if node.op == "sub" else factor
            todo += [(second, node.operands[1]), (factor, node.operands[0])]
        elif node.op == "const":
            found.append((factor * node.number, ()))
        else:
            inner, factors = product_of(nodes, base)
            found.append((factor * inner, factors))
        if len(found) + len(todo) > _TERMS:
            return None
    return found


def product_of(nodes: Sequence[Node], value: Value) -> Term:
    """Return a value as a product."""
    total, todo, found = Fraction(1), [value], list[Value]()
    while todo:
        factor, base = factored(nodes, todo.pop())
        total *= factor
        node = nodes[base.node]
        if node.op == "mul" and len(todo) + len(found) < _FACTORS:
            todo += node.operands[::-1]
        else:
            found.append(base)
    return total, tuple(found)
