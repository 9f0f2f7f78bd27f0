"""Angles in the frame of a rotation: what is measured after a turn by an angle needs no turn.

If (x, y) is (x0, y0) turned by t, its angle is that of (x0, y0) plus t and its norm is the same.  Mirrored
and by quarter turns, with components exchanged or with other signs, it is so up to a sign and a multiple
of pi/2.  B cos u + A sin u = C with (B, A) turned by t is the same equation for u - t with (B0, A0).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from cordicc.ir.graph import Node, Value, factored
from cordicc.ir.meaning.exact import PI
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.rules.rule import Given, Rule

OTHER_BRANCH = {"+": "-", "-": "+"}
"""The branch of an equation for the mirror image of its angle."""


def _add_frames(given: Given) -> None:
    """Add the angles of turned vectors, and of equations with turned coefficients, as sums of angles."""
    store = given.store
    rotations: dict[Value, list[Value]] = {}
    for index, node in enumerate(store.algebra.nodes):
        if node.op == "rotate" and node.m == 1:
            if all(store.constant(v) is not None for v in node.operands[:2]):
                continue  # the angle of a sine and cosine is another matter: inverse functions that cancel
            for result in range(2):
                rotations.setdefault(store.find(Value(index, result)), []).append(Value(index, result))
    for index, node in enumerate(tuple(store.algebra.nodes)):
        if node.op not in ("vector", "implicit") or node.m != 1:
            continue
        # The vector of an equation is (B, A): B cos u + A sin u is its product with (cos u, sin u).
        legs = node.operands[:2] if node.op == "vector" else node.operands[1::-1]
        for turn in _turns(store, rotations, legs):
            store.begin(node.origin)
            _add_frame(store, index, node, *turn)


def _turns(
    store: Store, rotations: dict[Value, list[Value]], legs: Sequence[Value]
) -> list[tuple[int, Fraction, int, int]]:
    """Return (rotation, k, s, q): the vector is k times as long, and its angle s psi + q pi/2 for psi."""
    (p, x), (r, y) = (factored(store.algebra.nodes, v) for v in legs)
    if abs(p) != abs(r):
        return []
    found = []
    for first in rotations.get(store.find(x), ()):
        for second in rotations.get(store.find(y), ()):
            if first.node != second.node or first.result == second.result:
                continue
            same = 1 if p * r > 0 else -1
            if first.result == 0:
                found.append((first.node, abs(p), same, 0 if p > 0 else 2))
            else:
                found.append((first.node, abs(p), -same, 1 if r > 0 else -1))
    return found


def _add_frame(
    store: Store, index: int, node: Node, rotation: int, k: Fraction, sign: int, quarters: int
) -> None:
    x, y, turn = store.algebra.nodes[rotation].operands
    x, y = store.scale(k, x), store.scale(k, y)
    if node.op == "vector":
        norm, own = store.make("vector", (x, y, store.const(0)), (1, 1))
        store.union(Value(index, 0), norm)
        angle = Value(index, 1)
    else:
        branch = node.branch if sign == 1 else OTHER_BRANCH[node.branch]
        own, rest = store.make("implicit", (y, x, node.operands[2]), (1, branch))
        store.union(Value(index, 1), rest)
        angle = Value(index, 0)
    total = store.add(own, turn)
    if node.op == "vector" and node.sign != 1:
        sign, quarters = -sign, -quarters
    if sign == -1:
        total = store.make("neg", (total,))[0]
    total = store.add(total, store.const(PI / 2 * quarters))
    if node.op == "vector" and store.constant(node.operands[2]) != 0:
        total = store.add(total, node.operands[2])
    store.same_turn(angle, total)
    store.same_domain(angle, own)


FRAMES = Rule(
    name="frames",
    mathematics="the angle of (x, y) turned by t is atan2(y, x) + t modulo 2 pi",
    apply=_add_frames,
    words="in the frame before the rotation: the angle of its unit is added",
)
