"""Enclosures over the valid samples alone: operands narrowed by what must hold for a result to exist.

A sample that leaves the domain of one operation is invalid as a whole, so no other value needs to be held
for it.  Conditions (|C| <= hypot(A, B) of an implicit equation, the sign of a guard) narrow operands, and
narrowed results narrow their operands in turn, from the outputs to the inputs and forth again (hull
consistency, F. Benhamou et al., "Revising hull and box consistency", ICLP 1999).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cordicc.ir.graph import Graph, Node, Value
from cordicc.ir.meaning.enclosures import result_ranges
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.ranges.forward import Enclosures, refreshed

_ROUNDS = 3
_INF = float("inf")

Enclose = Callable[[Value], Interval]
Narrowing = tuple[Value, "Interval | None"]


def contracted(graph: Graph, enclosures: Enclosures) -> Enclosures:
    """Return enclosures that hold for the samples for which every operation has its value."""
    found = list(enclosures)
    everything = range(len(graph.nodes))
    for _ in range(_ROUNDS):
        before = list(found)
        for index in reversed(everything):
            if all(result is not None for result in found[index]):
                _narrow(graph.nodes[index], index, found)
        refreshed(graph, (i for i in everything if graph.nodes[i].operands), found)
        if found == before:
            break
    return found


def _narrow(node: Node, index: int, found: Enclosures) -> None:
    """Narrow the operands of a node in place."""

    def enclosure(value: Value) -> Interval:
        interval = found[value.node][value.result]
        return Interval(-_INF, _INF) if interval is None else interval

    for value, interval in _narrowings(node, enclosure(Value(index)), enclosure):
        old = found[value.node][value.result]
        if old is not None and interval is not None:
            results = list(found[value.node])
            results[value.result] = old.intersect(interval)
            found[value.node] = tuple(results)


def _narrowings(node: Node, result: Interval, enclosure: Enclose) -> Iterator[Narrowing]:
    """Yield enclosures of operands that follow from the others, from the result or from a condition."""
    operands = node.operands
    match node.op:
        case "add":
            a, b = operands
            yield a, _of("sub", result, enclosure(b))
            yield b, _of("sub", result, enclosure(a))
        case "sub":
            a, b = operands
            yield a, _of("add", result, enclosure(b))
            yield b, _of("sub", enclosure(a), result)
        case "neg":
            yield operands[0], _of("neg", result)
        case "cmul":
            factor = node.factor
            if factor:
                yield operands[0], result_ranges("cmul", (1 / factor,), [result])[0]
        case "shift":
            yield operands[0], result_ranges("shift", (-node.exponent,), [result])[0]
        case "mul":
            a, b = operands
            if a == b:
                yield a, _within(_of("sqrt", result))
            else:
                yield a, _of("div", result, enclosure(b)) if _signed(enclosure(b)) else None
                yield b, _of("div", result, enclosure(a)) if _signed(enclosure(a)) else None
        case "abs":
            yield operands[0], _within(result)
        case "vector" if node.m == 1:
            yield operands[0], _within(result)
            yield operands[1], _within(result)
        case "vector" if node.m == -1:
            yield operands[1], _within(enclosure(operands[0]))
        case "implicit" if node.m == 1:
            A, B, C = operands
            yield C, _within(_of("hypot", enclosure(A), enclosure(B)))
        case "guard":
            yield operands[0], result
            if node.condition in ("nonnegative", "positive"):
                yield operands[1], Interval(0.0, _INF)


def _of(op: str, *operands: Interval) -> Interval | None:
    return result_ranges(op, (), operands)[0]


def _signed(interval: Interval) -> bool:
    return interval.lo > 0 or interval.hi < 0


def _within(bound: Interval | None) -> Interval | None:
    """Return the numbers whose magnitude is at most that of some number of an interval."""
    return None if bound is None else Interval(-bound.magnitude, bound.magnitude)
