"""The product of two roots is the root of the product."""

from __future__ import annotations

from cordicc.ir.graph import Node, Value
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Rule


def _add_roots_of_products(given: Given) -> None:
    """Add the product of two roots as the root of the product."""
    store = given.store
    roots = _roots(store)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "mul" or node.operands[0] == node.operands[1]:
            continue
        first, second = (roots.get(store.find(v)) for v in node.operands)
        if first is not None and second is not None:
            store.begin(node.origin)
            made = store.make("lightcone", (_square(store, first), _square(store, second)))
            store.union(made[0], Value(index))


def _roots(store: Store) -> dict[Value, Node]:
    """Return the values that are roots of a sum or product of two, with what makes them."""
    found: dict[Value, Node] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "lightcone" or (node.op == "vector" and node.m == 1):
            found.setdefault(store.find(Value(index)), node)
    return found


def _square(store: Store, root: Node) -> Value:
    """Return the square of a root."""
    x, y = root.operands[:2]
    return store.mul(x, y) if root.op == "lightcone" else store.add(store.mul(x, x), store.mul(y, y))


ROOTS_OF_PRODUCTS = Rule(
    name="roots of products",
    mathematics="sqrt(a) sqrt(b) = sqrt(a b)",
    apply=_add_roots_of_products,
    words="the product of two roots is the root of the product",
)
