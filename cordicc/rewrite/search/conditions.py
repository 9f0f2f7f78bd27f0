"""Which inputs a realisation must refuse: the conditions of the operations it replaces.

A condition is proven over the whole range, or met by an operation that has it too, or kept by a guard.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from cordicc.ir.graph import Graph, Node, Value
from cordicc.rewrite.exact.demands import (
    Demands,
    always_solvable,
    circle_demands,
    holds,
    proven,
    root_demands,
    root_proven,
    zeros_of,
)
from cordicc.rewrite.exact.field import Element
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.search.options import Alternatives, Option


@dataclass(frozen=True, slots=True)
class Requirement:
    """A condition: (class, option) pairs that meet it, else a guard of a class, if there is one."""

    met_by: tuple[tuple[int, int], ...]
    subject: int | None
    condition: str


def requirements(
    store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]], choice: Alternatives
) -> list[Requirement]:
    """Return the conditions of a graph, whose nodes became the values `moved`, over the alternatives."""
    used = graph.used_results()
    offers = _offers(store, choice)
    found: list[Requirement] = []
    for index in sorted(graph.live()):
        node = graph.nodes[index]
        if node.definition.partial:
            results = tuple(v for r, v in enumerate(moved[index]) if Value(index, r) in used)
            operands = tuple(moved[v.node][v.result] for v in node.operands)
            found += _of_node(store, choice, offers, node, operands, results)
    return list(dict.fromkeys(found))


_Offers = list[tuple[int, Option, Demands]]


def _offers(store: Store, choice: Alternatives) -> _Offers:
    """Return, for each option that is a CAU, what it demands of its operands."""
    offers: _Offers = []
    for number, option in enumerate(choice.options):
        if option.op not in ("vector", "implicit", "lightcone"):
            continue
        node, demands = store.algebra.nodes[option.node], None
        if node.op == "lightcone" or node.m == -1:
            demands = root_demands(store, node, node.operands)
        elif node.m == 1:
            demands = circle_demands(store, node.op, node.operands)
        offers.append((number, option, demands or Demands(known=False)))
    return offers


def _of_node(
    store: Store,
    choice: Alternatives,
    offers: _Offers,
    node: Node,
    operands: Sequence[Value],
    results: Sequence[Value],
) -> Iterable[Requirement]:
    """Yield the conditions of a node whose operands became some values; `results` are those that are used."""
    op = node.op
    angles = tuple(v for v in results if v.result == node.angle)
    if op == "vector" and node.m == 1:
        results = angles  # the norm of (0, 0) has a value
    alike = [other for v in results for other in store.domains.get(v, ())]
    wanted = [choice.class_of(v) for v in (*results, *alike)]
    same = tuple(
        (k, number)
        for number, option, _ in offers
        if option.op == op and (op == "lightcone" or option.m == node.m)
        for k in wanted
        if any(k in result for result in option.results)
    )
    if op == "guard":
        subject, condition = operands[1], node.condition
        if condition != "any" and not holds(store, subject, condition):
            subject = _numerator(store, choice, subject) if condition == "nonzero" else subject
            yield Requirement((), _provided(choice, subject), condition)
        return
    if op == "vector" and node.m == 0:
        if not holds(store, operands[0], "nonzero"):
            subject = _numerator(store, choice, operands[0])
            zeros = zeros_of(store, operands[0])
            # A vectoring whose angle is taken refuses a vector of which all of these would be 0.
            told = () if zeros is None else _offering(offers, lambda other: zeros <= other.nonzero)
            met = {*same, *_dividing(offers, choice.class_of(operands[0])), *told}
            yield Requirement(tuple(sorted(met)), _provided(choice, subject), "nonzero")
        return
    if op in ("vector", "implicit") and node.m == 1:
        if op == "implicit" or angles:
            yield from _circular(store, choice, offers, op, operands, same)
        return
    if op == "implicit" and always_solvable(store, operands):
        return
    demands = root_demands(store, node, operands)
    angle_used = any(v.result == 1 for v in results)
    if demands is not None and not angle_used:
        if demands.square or root_proven(store, op, operands):
            return
        (radicand,) = demands.radicands
        met = {*same, *_offering(offers, lambda other: radicand in other.radicands)}
        yield Requirement(tuple(sorted(met)), None, "nonnegative")
        return
    yield Requirement(same, None, "any")


def _provided(choice: Alternatives, value: Value) -> int | None:
    """Return the class of a value that a guard may take, None if nothing yields it."""
    k = choice.class_of(value)
    return k if k in choice.providers else None


def _dividing(offers: _Offers, divisor: int) -> Iterable[tuple[int, int]]:
    """Yield (class, option) for the quotients by a divisor."""
    for number, option, _ in offers:
        if option.op == "vector" and option.m == 0 and option.operands[0] == divisor:
            yield from ((k, number) for k in option.results[1])


def _numerator(store: Store, choice: Alternatives, value: Value) -> Value:
    """Return a value that is 0 where this one is: its numerator, if something makes that, else itself."""
    element = store.element(value)
    if element is None or element.is_polynomial:
        return value
    poly = store.field.display(Element(element.num, store.field.one))
    found = None if poly is None else store.affine(poly)
    if found is None or found[2] != 0 or choice.class_of(found[0]) not in choice.providers:
        return value
    return found[0]


def _circular(
    store: Store,
    choice: Alternatives,
    offers: _Offers,
    op: str,
    operands: Sequence[Value],
    same: tuple[tuple[int, int], ...],
) -> Iterable[Requirement]:
    nonzero, real = proven(store, op, operands)
    demands = circle_demands(store, op, operands)
    if demands is None or (op == "implicit" and not demands.radicands and not real):
        if not (nonzero and real):
            yield Requirement(same, None, "any")
        return
    size = store.size(operands[0], operands[1])
    subject = None if size is None else _provided(choice, size)
    for factor in () if nonzero else sorted(demands.nonzero):
        met = {*same, *_offering(offers, lambda other, f=factor: f in other.nonzero)}  # type: ignore[misc]
        yield Requirement(tuple(sorted(met)), subject, "nonzero")
    if op == "implicit" and not real and not demands.square:
        (radicand,) = demands.radicands
        met = {*same, *_offering(offers, lambda other: radicand in other.radicands)}
        yield Requirement(tuple(sorted(met)), None, "nonnegative")


def _offering(offers: _Offers, test: Callable[[Demands], bool]) -> Iterable[tuple[int, int]]:
    """Yield (class, option) for the options whose demands pass a test; the class is that of the result."""
    for number, option, demands in offers:
        if demands.known and test(demands):
            result = 1 if option.op == "vector" and option.m == 1 else 0
            yield from ((k, number) for k in option.results[result])
