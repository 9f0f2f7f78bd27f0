"""What the algebra of values asks of whoever knows them."""

from __future__ import annotations

from fractions import Fraction
from typing import Protocol

from cordicc.ir.graph import Node, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.rewrite.exact.field import Element, Field, Poly


class EnclosedValues(Protocol):
    """What values are made by, and their ranges."""

    def node(self, value: Value) -> Node:
        """Return the node that makes a value."""
        ...

    def range(self, value: Value) -> Interval | None:
        """Return the enclosure of a value."""
        ...


class KnownValues(EnclosedValues, Protocol):
    """What is known about values besides: equal ones, elements of the field, signs."""

    field: Field

    def find(self, value: Value) -> Value:
        """Return the representative of the values equal to one."""
        ...

    def factored(self, value: Value) -> tuple[Fraction, Value]:
        """Return (k, v) with value = k v, all constant factors in k."""
        ...

    def element(self, value: Value) -> Element | None:
        """Return a value as an element."""
        ...

    def poly_sign(self, poly: Poly) -> int:
        """Return the sign of a polynomial."""
        ...

    def is_total(self, value: Value) -> bool:
        """Tell whether a value exists for every input within its range."""
        ...

    def reopened(self, index: int) -> bool:
        """Find the results of a node anew from simpler operands; tell whether they could be made simpler."""
        ...
