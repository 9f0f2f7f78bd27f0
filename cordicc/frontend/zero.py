"""Whether a value is zero for all inputs: floats to suspect it, SymPy to prove it."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from heapq import heapify, heappop, heappush
from typing import Any

from cordicc.frontend.numeric import evaluate_node
from cordicc.ir.graph import Builder, Node, Value

_POINTS = 24
_SUSPICIOUS = 1e-9
_MAX_NODES = 400
_MAX_TERMS = 2000
_NOISE = Fraction(1, 1 << 150)  # constants are rounded to 256 bits


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
class _Point:
    """A point of the input box: the values found so far, and the largest number on the way to each."""

    inputs: Mapping[str, float]
    values: dict[int, float] = field(default_factory=dict)
    scales: dict[int, float] = field(default_factory=dict)

    def evaluate(self, nodes: Sequence[Node], value: Value) -> tuple[float, float]:
        """Return a value and its scale."""
        todo = [value.node]
        while todo:
            node = nodes[todo[-1]]
            missing = [v.node for v in node.operands if v.node not in self.values]
            if missing:
                todo += missing
                continue
            index = todo.pop()
            result = evaluate_node(node, [self.values[v.node] for v in node.operands], self.inputs)
            self.values[index] = result
            own = abs(result) if math.isfinite(result) else 0.0
            self.scales[index] = max([own, *(self.scales[v.node] for v in node.operands)])
        return self.values[value.node], self.scales[value.node]


@dataclass(slots=True)
class ZeroTest:
    """Decides whether values of a graph under construction are identically zero.

    `ranges` are those of the inputs.  What cannot be proven within the work limits counts as non-zero.
    """

    builder: Builder
    ranges: Mapping[str, tuple[float, float]]
    _points: list[_Point] = field(default_factory=list)
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
        if not self._points:
            source = random.Random(0)
            for _ in range(_POINTS):
                point = {name: source.uniform(lo, hi) for name, (lo, hi) in self.ranges.items()}
                self._points.append(_Point(point))
        seen = False
        for at in self._points:
            result, scale = at.evaluate(self.builder.nodes, value)
            if not math.isfinite(result):
                continue
            seen = True
            if abs(result) > _SUSPICIOUS * scale:
                return False
        return seen

    def _is_proven(self, value: Value) -> bool:
        order = cone(self.builder.nodes, value)
        if len(order) > _MAX_NODES or _terms(self.builder.nodes, order) > _MAX_TERMS:
            return False
        import sympy  # slow to import, and rarely needed

        expr = _to_sympy(sympy, self.builder.nodes, order)
        try:
            return _vanishes(sympy, expr)
        except RecursionError:
            return False


def _terms(nodes: Sequence[Node], order: Sequence[int]) -> int:
    """Return a bound of the number of terms the last node has when multiplied out."""
    counts: dict[int, int] = {}
    for index in order:
        node = nodes[index]
        parts = [counts[v.node] for v in node.operands]
        if node.op in ("add", "sub"):
            count = sum(parts)
        elif node.op in ("mul", "div"):
            count = math.prod(parts)
        elif node.op == "pow":
            exponent = Fraction(node.params[0])
            count = 1 if parts[0] == 1 else parts[0] ** math.ceil(abs(exponent))
        else:
            count = max(parts, default=1)
        counts[index] = min(count, _MAX_TERMS + 1)
    return max(counts.values())


_WITH_ALGEBRA = "sqrt sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log"
_DIRECT = frozenset(_WITH_ALGEBRA.split())


def _to_sympy(sympy: Any, nodes: Sequence[Node], order: Sequence[int]) -> Any:
    """Return the last node as a SymPy expression; operations without algebra become symbols."""
    made: dict[int, Any] = {}
    for index in order:
        node = nodes[index]
        args = [made[v.node] for v in node.operands]
        match node.op:
            case "const":
                number = Fraction(node.params[0])
                result = sympy.Rational(number.numerator, number.denominator)
            case "add":
                result = args[0] + args[1]
            case "sub":
                result = args[0] - args[1]
            case "mul":
                result = args[0] * args[1]
            case "div":
                result = args[0] / args[1]
            case "neg":
                result = -args[0]
            case "pow":
                exponent = Fraction(node.params[0])
                result = args[0] ** sympy.Rational(exponent.numerator, exponent.denominator)
            case "guard":
                result = args[0]
            case "hypot":
                result = sympy.sqrt(args[0] ** 2 + args[1] ** 2)
            case op if op in _DIRECT:
                result = getattr(sympy, op)(args[0])
            case _:
                result = sympy.Dummy(f"v{index}", real=True)
        if result.has(sympy.nan, sympy.zoo, sympy.oo):
            result = sympy.Dummy(f"v{index}", real=True)
        made[index] = result
    return made[order[-1]]


def _vanishes(sympy: Any, expr: Any) -> bool:
    for step in (lambda e: e, sympy.expand_trig, lambda e: sympy.together(e).as_numer_denom()[0]):
        expr = _without_squares(sympy, sympy.expand(step(expr)))
        if all(abs(k) < _NOISE for k in expr.as_coefficients_dict().values()):
            return True
        if expr.count_ops() > 4 * _MAX_TERMS:
            return False
    return False


def _without_squares(sympy: Any, expr: Any) -> Any:
    """Return the expression with sin**2 and sinh**2 replaced by the cosines, multiplied out."""
    signs = {sympy.sin: -1, sympy.sinh: 1}

    def lowered(base: Any, exponent: Any) -> Any:
        sign = signs[base.func]
        cosine = (sympy.cos if sign < 0 else sympy.cosh)(base.args[0])
        half, rest = divmod(int(exponent), 2)
        return (sign * (cosine**2 - 1)) ** half * base**rest

    return sympy.expand(
        expr.replace(
            lambda e: e.is_Pow and e.base.func in signs and e.exp.is_Integer and e.exp > 1,
            lambda e: lowered(e.base, e.exp),
        )
    )
