"""Other ways to an angle, and from it: sums of two angles, principal values, constant offsets, unit vectors.

The sum of the angles of two vectors is the angle of their complex product.  acos(C/B) is the angle of
(C, w) for the second result w = sqrt(B^2 - C^2), if something else yields that; asin(C/A) that of (w, C).
A rotation by t + c is one by t, and products with the cosine and sine of c.  (x, y) divided by its norm
is the cosine and sine of its angle.
"""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import fold
from cordicc.rewrite.exact.field import TooLarge
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.products import turned


def add_principal_values(store: Store) -> None:
    """Add the angles of circular equations with one coefficient as those of vectors."""
    store.reason = ("acos(C/B) is the angle of (C, w), asin(C/A) that of (w, C), w = sqrt(B^2 - C^2)",)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "implicit" or node.params[0] != 1:
            continue
        A, B, C = node.operands
        rest = Value(index, 1)
        store.begin(node.origin)
        if store.constant(A) == 0 and node.params[1] == "+" and store.sign(B) > 0:
            made, size = store.make("vector", (C, rest, store.const(0)), (1, 1)), B
        elif store.constant(B) == 0 and node.params[1] == "-" and store.sign(A) > 0:
            made, size = store.make("vector", (rest, C, store.const(0)), (1, 1)), A
        else:
            continue
        store.union(made[0], size)
        store.union(made[1], Value(index, 0))
        store.rotors.rotor(made[1])


def add_unit_vectors(store: Store) -> None:
    """Add the cosine and sine of each vector that is divided by its norm."""
    divisors = {
        store.find(node.operands[0])
        for node in store.algebra.nodes
        if node.op == "vector" and node.params[0] == 0
    }
    store.reason = ("a vector divided by its norm: cosine and sine of its angle",)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        plain = node.op == "vector" and node.params == (1, 1) and store.constant(node.operands[2]) == 0
        if plain and store.find(Value(index, 0)) in divisors:
            store.begin(node.origin)
            store.make("rotate", (store.const(1), store.const(0), Value(index, 1)), (1,))


def add_offsets(store: Store) -> None:
    """Add rotations by an angle and a constant as rotations by the angle alone."""
    store.reason = ("rotation by an angle and a constant: a rotation by the angle, and constant factors",)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "rotate" or node.params[0] != 1:
            continue
        x, y, angle = node.operands
        outer = store.node(angle)
        constant = [store.constant(v) for v in outer.operands]
        if outer.op not in ("add", "sub") or (constant[0] is None) == (constant[1] is None):
            continue
        port = 0 if constant[1] is None else 1
        inner, number = outer.operands[1 - port], constant[port]
        assert number is not None
        store.begin(node.origin)
        if outer.op == "sub" and port == 0:
            # Turned by c - t: the mirror image of what (x, -y) becomes, turned by t.
            a, b = store.make("rotate", (x, store.make("neg", (y,))[0], inner), (1,))
            b = store.make("neg", (b,))[0]
        else:
            number = -number if outer.op == "sub" else number
            a, b = store.make("rotate", (x, y, inner), (1,))
        cosine, sine = (store.const(fold(name, (), (number,))) for name in ("cos", "sin"))
        for result, value in enumerate(turned(store, (a, b), (cosine, sine))):
            store.union(Value(index, result), value)


def add_sums_of_vectors(store: Store) -> None:
    """Add the sum or difference of the angles of two vectors as the angle of one."""
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op not in ("add", "sub"):
            continue
        first, second = (_vector(store, v) for v in node.operands)
        if first is None or second is None or first == second:
            continue
        sign = 1 if node.op == "add" else -1
        (x, y), (u, v) = first, second
        store.begin(node.origin)
        store.reason = ("the sum of two angles is the angle of the complex product of their vectors",)
        try:
            made = turned(store, (x, y), (u, v if sign == 1 else store.make("neg", (v,))[0]))
        except TooLarge:
            continue
        angle = store.make("vector", (*made, store.const(0)), (1, 1))[1]
        store.same_turn(Value(index), angle)


def _vector(store: Store, value: Value) -> tuple[Value, Value] | None:
    """Return the vector of which a value is the angle."""
    node = store.node(value)
    if node.op != "vector" or value.result != 1 or node.params[0] != 1:
        return None
    x, y, start = node.operands
    if store.constant(start) != 0:
        return None
    return (x, y) if node.params[1] == 1 else (x, store.make("neg", (y,))[0])
