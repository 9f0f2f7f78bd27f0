"""Lengths of vectors with several components, as rules make them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from cordicc.ir.graph import Value
from cordicc.ir.meaning.exact import fold
from cordicc.rewrite.exact.field import square_root_of
from cordicc.rewrite.exact.values import Store


def leg(store: Store, value: Value, square: Fraction) -> Value:
    """Return the root of a positive multiple of a value's square, whatever its sign."""
    return store.scale(root_of(square), value)


def root_of(square: Fraction) -> Fraction:
    """Return the root of a positive number, exact where it is rational."""
    return square_root_of(square) or fold("sqrt", (), (square,))


def length(store: Store, legs: Sequence[Value]) -> Value:
    """Return the length of a vector with some components, in order."""
    total, *rest = legs
    for other in rest:
        total = store.make("vector", (total, other, store.const(0)), (1, 1))[0]
    return total
