"""Facts about the inputs that a problem assumes, and which samples keep them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from cordicc.base.arrays import Bools, Floats, Samples
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.doubles import values_of

_TOLERANCE = 1e-6
_ROUNDING = 1e-12
STRICT = ("<", ">")
SIDES = ("left", "right")


@dataclass(frozen=True, slots=True)
class Assumption:
    """A fact about the inputs, `left relation right`, relation one of = > < >= <=.

    The sides are values of a graph of the facts alone.
    """

    text: str
    relation: str
    left: Value
    right: Value


class Sides(NamedTuple):
    """The sides of a fact on samples, nan where one has no value, and the largest number on the way."""

    left: Floats
    right: Floats
    scale: Floats


@dataclass(frozen=True, slots=True)
class InputFacts:
    """The facts of a problem, and the graph of their sides: `left0` and `right0` are those of the first."""

    items: tuple[Assumption, ...] = ()
    graph: Graph = field(default_factory=lambda: Graph((), {}))

    @classmethod
    def of(cls, stated: Iterable[tuple[str, str]], graph: Graph) -> InputFacts:
        """Return the facts of a graph, given the text and the relation of each."""
        items = (
            Assumption(text, relation, *(graph.outputs[f"{side}{index}"] for side in SIDES))
            for index, (text, relation) in enumerate(stated)
        )
        return cls(tuple(items), graph)

    @property
    def dependent(self) -> bool:
        """Tell whether an equation ties inputs to one another, which samples drawn from ranges break."""
        return any(fact.relation == "=" for fact in self.items)

    def sides(self, fact: Assumption, samples: Samples) -> Sides:
        """Return the sides of one of the facts; `samples` has a column for each input."""
        order = sorted(self.graph.live([fact.left, fact.right]))
        values = values_of(self.graph.nodes, order, samples)
        scale = np.fmax.reduce([np.abs(value) for value in values.values()])
        return Sides(values[fact.left.node], values[fact.right.node], scale)

    def kept_one(self, fact: Assumption, samples: Samples) -> Bools:
        """Return which samples keep one of the facts; see `kept`."""
        return _holds(fact.relation, self.sides(fact, samples))

    def kept(self, samples: Samples) -> Bools:
        """Return which samples keep every fact.

        An equation is kept to 1e-6 of the largest number on the way, `<=` and `>=` to the rounding of
        double precision, `<` and `>` strictly.  A side without a value keeps nothing.
        """
        count = len(next(iter(samples.values()), np.zeros(1)))
        kept = np.ones(count, dtype=bool)
        for fact in self.items:
            kept &= np.broadcast_to(self.kept_one(fact, samples), kept.shape)
        return kept

    def exactly(self, samples: Samples) -> Bools:
        """Return which samples keep every equation to the rounding of double precision, as proofs take it."""
        count = len(next(iter(samples.values()), np.zeros(1)))
        kept = np.ones(count, dtype=bool)
        for fact in self.items:
            if fact.relation == "=":
                left, right, scale = self.sides(fact, samples)
                kept &= np.broadcast_to(np.abs(left - right) <= _ROUNDING * scale, kept.shape)
        return kept

    def only(self, samples: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return those of samples that keep every fact, perhaps none."""
        if not self.items:
            return dict(samples)
        kept = self.kept(samples)
        return {name: column[kept] for name, column in samples.items()}

    def among(self, samples: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return those of samples that keep every fact; where there is none, all of them."""
        found = self.only(samples)
        return found if all(column.size for column in found.values()) else dict(samples)


def _holds(relation: str, sides: Sides) -> Bools:
    left, right, scale = sides
    if relation == "=":
        return np.asarray(np.abs(left - right) <= _TOLERANCE * scale)
    if relation in STRICT:
        return np.asarray(left < right if relation == "<" else left > right)
    slack = _ROUNDING * scale
    return np.asarray(left <= right + slack if relation == "<=" else left >= right - slack)
