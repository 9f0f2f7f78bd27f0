"""Whether a value is zero for all inputs: floats to suspect it, SymPy to prove it."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from heapq import heapify, heappop, heappush

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.frontend.solving.identities import ZeroProof, verdict
from cordicc.ir.graph import Builder, Node, Value
from cordicc.ir.meaning.doubles import value_of

_POINTS = 24
_SUSPICIOUS = 1e-9


def cone(nodes: Sequence[Node], value: Value) -> list[int]:
    """Return the nodes a value depends on, operands first, its own node last."""
    todo, seen = [value.node], {value.node}
    while todo:
        for operand in nodes[todo.pop()].operands:
            if operand.node not in seen:
                seen.add(operand.node)
                todo.append(operand.node)
    return sorted(seen)


def adds_to_domain(nodes: Sequence[Node], value: Value, kept: Sequence[Value]) -> bool:
    """Return whether an operation that may have no value is on the way to `value` but to none of `kept`.

    Nodes are visited from the last one backwards, and only as far as something is not covered.
    """
    covered = {v.node for v in kept}
    own = {value.node} - covered
    heap = [-index for index in covered | own]
    heapify(heap)
    while own:
        index = -heappop(heap)
        if index in own:
            own.remove(index)
            if nodes[index].definition.partial:
                return True
            reached = own
        else:
            reached = covered
        for operand in nodes[index].operands:
            if operand.node not in covered:
                if operand.node not in own:
                    heappush(heap, -operand.node)
                if reached is covered:
                    own.discard(operand.node)
                reached.add(operand.node)
    return False


@dataclass(slots=True)
class _Points:
    """Points of the input box: the values found so far, and the largest numbers on the way to each."""

    inputs: Mapping[str, Floats]
    values: dict[int, Floats] = field(default_factory=dict)
    scales: dict[int, Floats] = field(default_factory=dict)

    def evaluate(self, nodes: Sequence[Node], value: Value) -> tuple[Floats, Floats]:
        """Return a value and its scale, float64 of shape (_POINTS,)."""
        todo = [value.node]
        while todo:
            node = nodes[todo[-1]]
            missing = [v.node for v in node.operands if v.node not in self.values]
            if missing:
                todo += missing
                continue
            index = todo.pop()
            operands = [self.values[v.node] for v in node.operands]
            result = value_of(node, operands, self.inputs, _POINTS)
            self.values[index] = result
            own = np.where(np.isfinite(result), np.abs(result), 0.0)
            self.scales[index] = np.maximum.reduce([own, *(self.scales[v.node] for v in node.operands)])
        return self.values[value.node], self.scales[value.node]


@dataclass(slots=True)
class ZeroTest:
    """Decides whether values of a graph under construction are identically zero.

    `ranges` are those of the inputs.  What cannot be proven within the budgets of `identities` counts as
    non-zero; `given_up` has the values that look like zero but were too large for a proof, with the
    equation for which they were made.
    """

    builder: Builder
    ranges: Mapping[str, tuple[float, float]]
    given_up: dict[Value, str] = field(default_factory=dict)
    _points: _Points | None = None
    _found: dict[Value, bool] = field(default_factory=dict)

    def is_zero(self, value: Value) -> bool:
        """Return whether the value is proven to be zero wherever it exists."""
        number = self.builder.constant(value)
        if number is not None:
            return number == 0
        if value not in self._found:
            self._found[value] = self._looks_zero(value) and self._is_proven(value)
        return self._found[value]

    def _looks_zero(self, value: Value) -> bool:
        if self._points is None:
            source = random.Random(0)
            drawn = [[source.uniform(lo, hi) for lo, hi in self.ranges.values()] for _ in range(_POINTS)]
            columns = np.reshape(drawn, (_POINTS, len(self.ranges))).T
            self._points = _Points(dict(zip(self.ranges, columns, strict=True)))
        result, scale = self._points.evaluate(self.builder.nodes, value)
        exists = np.isfinite(result)
        return bool(exists.any() and (np.abs(result) <= _SUSPICIOUS * scale)[exists].all())

    def _is_proven(self, value: Value) -> bool:
        found = verdict(self.builder.nodes, cone(self.builder.nodes, value))
        if found is ZeroProof.TOO_LARGE:
            self.given_up[value] = self.builder.origin
        return found is ZeroProof.ZERO
