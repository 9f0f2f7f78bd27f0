"""A rotation by t + c is one by t, and products with the cosine and sine of c."""

from __future__ import annotations

from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import fold
from cordicc.rewrite.rules.products import turned
from cordicc.rewrite.rules.rule import Given, Rule


def _add_offsets(given: Given) -> None:
    """Add rotations by an angle and a constant as rotations by the angle alone."""
    store = given.store
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op != "rotate" or node.m != 1:
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


OFFSETS = Rule(
    name="constant offsets",
    mathematics="cos(t + c) = cos t cos c - sin t sin c and sin(t + c) = sin t cos c + cos t sin c",
    apply=_add_offsets,
    words="rotation by an angle and a constant: a rotation by the angle, and constant factors",
)
