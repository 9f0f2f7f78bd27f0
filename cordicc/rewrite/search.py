"""Search for the cheapest operations: alternatives around the realisation of the passes, then a choice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np

from cordicc.arith.intervals import Interval
from cordicc.ir.graph import Graph, Value, factored
from cordicc.ir.ops import Level
from cordicc.ir.problem import Problem
from cordicc.rewrite.angles import add_offsets, add_principal_values, add_sums_of_vectors, add_unit_vectors
from cordicc.rewrite.base import Context
from cordicc.rewrite.chains import add_chains, add_halves
from cordicc.rewrite.circles import circles, realise, squared_lengths
from cordicc.rewrite.conditions import nonzero_factors, proven, requirements
from cordicc.rewrite.costs import Costs
from cordicc.rewrite.explanation import circle_steps, name_of
from cordicc.rewrite.extraction import extract
from cordicc.rewrite.field import Field, TooLarge
from cordicc.rewrite.frames import add_frames
from cordicc.rewrite.lifting import Lifting
from cordicc.rewrite.numeric import Floats, evaluate
from cordicc.rewrite.options import alternatives
from cordicc.rewrite.products import turned
from cordicc.rewrite.rebuilding import facts_of, rebuild
from cordicc.rewrite.rotors import MOST_TURNS
from cordicc.rewrite.sharing import add_multiples, add_norm_chains, add_norms, add_orders, add_pairs
from cordicc.rewrite.simplify import Simplify
from cordicc.rewrite.squares import add_squares
from cordicc.rewrite.store import Store
from cordicc.rewrite.synthesis import Synthesis

POINTS = 24
_NEAREST = 3
_CRITICAL = {"vector": 0, "lightcone": 0, "implicit": 1}
"""The result of a unit that is 0 where the others are ill-conditioned."""
_DRAWN = 6_000
_GENERATORS = 120
_NODES = 400
_SUBSETS = 16
_OPAQUE = 16
"""Values that may become generators because what they are made of is too large."""

_WORSE = (16.0, 12.0, 8.0, 4.0)
"""How many times the error bound of a value in the realisation of the passes an operation is allowed."""

_SUMS = ("add", "sub", "neg", "wrap", "cmul", "shift")
"""Operations that make angles of angles."""


@dataclass(frozen=True, slots=True)
class Found:
    """The chosen graph, whether it is proven best over the alternatives, steps by node, facts used."""

    graph: Graph
    proven: bool
    steps: Mapping[int, tuple[str, ...]]
    facts: tuple[str, ...] = ()


def sample_points(problem: Problem, graphs: Sequence[Graph], count: int = POINTS) -> dict[str, Floats] | None:
    """Return points of the workspace at which graphs have values, None if there are too few.

    Besides `count` random ones there are those nearest to the singular points of the units.
    """
    generator = np.random.Generator(np.random.PCG64(7))
    if problem.samples is not None:
        rows = generator.integers(0, problem.samples.rows, _DRAWN)
        drawn = {name: np.asarray(column)[rows] for name, column in problem.samples.columns.items()}
    else:
        drawn = {
            spec.name: generator.uniform(float(spec.lo), float(spec.hi), _DRAWN) for spec in problem.inputs
        }
    good = np.ones(len(next(iter(drawn.values()))), dtype=bool)
    critical = []
    for graph in graphs:
        live = graph.live()
        for index, results in enumerate(evaluate(graph, drawn)):
            if index in live:
                for result in results:
                    good &= np.isfinite(result)
                if graph.nodes[index].op in _CRITICAL:
                    critical.append(np.abs(results[_CRITICAL[graph.nodes[index].op]]))
    if good.sum() < POINTS // 2:
        return None
    first = np.flatnonzero(good)
    nearest = [first[np.argsort(size[first], kind="stable")[:_NEAREST]] for size in critical]
    rows = np.unique(np.concatenate([first[:count], *nearest]))
    return {name: column[rows] for name, column in drawn.items()}


def search(
    problem: Problem,
    ranges: Mapping[str, Interval],
    graphs: Sequence[Graph],
    costs: Costs,
    goal: str,
    *,
    lift: bool = True,
) -> Iterator[Found]:
    """Yield the best realisations found around those given, ever fewer roundings allowed to a value.

    Nothing is yielded where the work limits end the search.

    Args:
        problem: the problem, for its samples.
        ranges: an enclosure of each input.
        graphs: realisations in unit operations, implicit ones included; the first one's conditions are kept.
        costs: what operations cost.
        goal: as `--minimize`.
        lift: whether values may be scaled by common denominators.
    """
    if not problem.inputs or sum(len(g.nodes) for g in graphs) > _NODES:
        return
    points = sample_points(problem, graphs)
    field = _field(graphs)
    if points is None or field is None:
        return
    store = Store(field, ranges, points)
    _name_constants(store, graphs)
    _assume(store, problem)
    store.opaque_left = _OPAQUE
    moved = [_import(store, graphs[0])]
    certain = len(store.algebra.nodes)
    moved += [_import(store, graph) for graph in graphs[1:]]
    for angle in _angles(store):
        store.rotors.rotor(angle)
    store.opaque_left = 0
    outputs = {name: moved[0][v.node][v.result] for name, v in graphs[0].outputs.items()}
    for graph, values in zip(graphs[1:], moved[1:], strict=True):
        for name, value in graph.outputs.items():
            store.union(outputs[name], values[value.node][value.result])
    _join_areas(store)
    _add_forms(store)
    angles = _angles(store)
    _add_circles(store, graphs[0], moved[0], angles)
    add_frames(store)
    add_principal_values(store)
    add_unit_vectors(store)
    add_offsets(store)
    add_sums_of_vectors(store)
    if lift:
        _lift(store, outputs)
    _add_sums(store)
    add_norms(store)
    add_norm_chains(store)
    for graph, values in zip(graphs, moved, strict=True):
        add_squares(store, graph, values)
    add_halves(store, graphs[0], moved[0])
    add_chains(store)
    add_multiples(store)
    add_orders(store)
    add_pairs(store)
    subjects = [
        moved[0][v.node][v.result] for n in graphs[0].nodes if n.definition.partial for v in n.operands
    ]
    for worse in _WORSE:
        choice = alternatives(store, certain, outputs, subjects, worse)
        store.begin("")
        needs = requirements(store, graphs[0], moved[0], choice)
        conditions = frozenset(store.field.touched)
        zeros = frozenset([choice.class_of(store.const(0))])
        extraction = extract(choice, needs, zeros, costs, goal)
        if extraction is None:
            return
        graph, steps = rebuild(store, choice, needs, extraction, graphs[0])
        facts = conditions | facts_of(store, choice, extraction, certain)
        told = tuple(fact.text for fact in problem.assumptions if fact.text in facts)
        yield Found(graph, extraction.proven, steps, told)


def _field(graphs: Sequence[Graph]) -> Field | None:
    operations = [n for g in graphs for n in g.nodes]
    count = {op: sum(1 for n in operations if n.op == op) for op in {n.op for n in operations}}
    inputs = count.get("input", 0) // len(graphs)
    turned = len({n.operands[2] for g in graphs for n in g.nodes if n.op == "rotate"})
    roots = (
        6
        + _OPAQUE // 2
        + sum(
            1
            for n in graphs[0].nodes
            if n.op in ("vector", "implicit", "lightcone") and (not n.params or n.params[0])
        )
    )
    pairs = turned + 4 + (count.get("abs", 0) + count.get("flip", 0)) // len(graphs)
    opaque = sum(count.get(op, 0) for op in ("min", "max", "select", "sign"))
    free = inputs + 2 * pairs + opaque + _OPAQUE
    return Field(free, pairs, roots) if free + pairs + roots <= _GENERATORS else None


def _import(store: Store, graph: Graph) -> list[tuple[Value, ...]]:
    """Copy a graph into the store; a guard's value is that of its operand."""
    moved: list[tuple[Value, ...]] = []
    grains = _grains(graph)
    for index, node in enumerate(graph.nodes):
        store.begin(node.origin)
        operands = [moved[v.node][v.result] for v in node.operands]
        if node.op == "guard":
            moved.append((operands[0],))
        else:
            moved.append(store.make(node.op, operands, node.params))
        for result, value in enumerate(moved[-1]):
            share = grains.get(Value(index, result))
            if share is not None:
                store.rotors.grain(value, share, store.scale(share, value))
    return moved


def _grains(graph: Graph) -> dict[Value, Fraction]:
    """Return, for values that are turned by in several multiples, the one that all are multiples of."""
    factors: dict[Value, set[Fraction]] = {}
    for node in graph.nodes:
        if node.op == "rotate" and node.params[0] != 0:
            factor, base = factored(graph.nodes, node.operands[2])
            if graph.node(base).op not in (*_SUMS, "vector", "implicit", "lightcone", "const", "guard"):
                factors.setdefault(base, set()).add(abs(factor))
    found = {}
    for base, known in factors.items():
        least = min(known)
        if len(known) > 1 and all((k / least).denominator == 1 and k <= MOST_TURNS * least for k in known):
            found[base] = least
    return found


def _name_constants(store: Store, graphs: Sequence[Graph]) -> None:
    """Make the cosine and sine of constant angles known before the numbers themselves are met."""
    for graph in graphs:
        for node in graph.nodes:
            if node.op == "rotate" and node.params[0] == 1:
                for value in graph.node(node.operands[2]).operands:
                    number = graph.constant(value)
                    if number is not None:
                        store.constants.rotor(number, 1)


def _assume(store: Store, problem: Problem) -> None:
    """Let the field know the facts of the problem; all inputs come first, in their order."""
    for spec in problem.inputs:
        store.make("input", (), (spec.name,))
    if not problem.assumptions:
        return
    graph = Simplify().apply(problem.assumption_graph, Context({}))
    if any(n.definition.level is Level.FUNCTION for n in graph.nodes):
        return
    moved = _import(store, graph)
    for index, fact in enumerate(problem.assumptions):
        sides = [graph.outputs[f"{side}{index}"] for side in ("left", "right")]
        left, right = (store.element(moved[v.node][v.result]) for v in sides)
        if left is not None and right is not None:
            store.assume(store.field.sub(left, right), fact.relation, fact.text)


def _angles(store: Store) -> list[Value]:
    """Return the angles that circular units make."""
    port = {"vector": 1, "implicit": 0}
    return [
        Value(index, port[node.op])
        for index, node in enumerate(store.algebra.nodes)
        if node.op in port and node.params[0] == 1
    ]


def _add_forms(store: Store) -> None:
    """Add scalars as sums of terms, and rotations as products with one cosine and sine."""
    synthesis = Synthesis(store)
    store.reason = ("written as a sum of products",)
    for index, node in enumerate(tuple(store.algebra.nodes)):
        store.begin(node.origin)
        if node.op == "rotate" and node.params[0] != 0:
            m = int(node.params[0])
            rotor = store.make("rotate", (store.const(1), store.const(0), node.operands[2]), (m,))
            x, y = node.operands[:2]
            if store.constant(x) is None and store.constant(y) is None:
                for result, value in enumerate(turned(store, (x, y), (rotor[0], rotor[1]), m)):
                    store.union(Value(index, result), value)
            if store.constant(x) == 1 and store.constant(y) == 0:
                _add_multiple_angle(store, synthesis, index)
        element = store.element(Value(index)) if node.op in ("add", "sub") else None
        poly = None if element is None else store.field.display(element)
        if poly is not None:
            with suppress(TooLarge):
                synthesis.expanded(poly)


def _add_multiple_angle(store: Store, synthesis: Synthesis, index: int) -> None:
    """Add cosine and sine of a multiple of an angle as polynomials in those of the angle."""
    for value in (Value(index, 0), Value(index, 1)):
        element = store.element(value)
        poly = None if element is None else store.field.display(element)
        if poly is not None and 1 < poly.total_degree() <= MOST_TURNS:
            with suppress(TooLarge):
                store.union(value, synthesis.expanded(poly))


def _join_areas(store: Store) -> None:
    """Make hyperbolic angles with the same cosine and sine equal: inverse functions that cancel."""
    port = {"vector": 1, "implicit": 0, "lightcone": 1}
    known: dict[tuple[str, str], Value] = {}
    for index, node in enumerate(tuple(store.algebra.nodes)):
        value = None
        if node.op == "rotate" and node.params[0] == -1:
            value = node.operands[2]
        elif node.op == "lightcone" or (node.op in port and node.params[0] == -1):
            value = Value(index, port[node.op])
        rotor = None if value is None else store.rotors.rotor(value, -1)
        if value is not None and rotor is not None:
            store.union(known.setdefault((rotor[0].key, rotor[1].key), value), value)


def _add_circles(
    store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]], angles: Sequence[Value]
) -> None:
    """Add the circle equation of each angle and of each sum of angles, where its vector is never 0."""
    synthesis = Synthesis(store)
    sums = [v for results in moved for v in results if store.node(v).op in _SUMS and _is_angle(store, v)]
    known = _nonzero_factors(store, graph, moved)
    lengths = squared_lengths(store)
    for angle in dict.fromkeys((*angles, *sums)):
        store.begin(store.node(angle).origin)
        for circle in circles(store, angle, lengths):
            store.reason = circle_steps(store, angle, circle)
            try:
                values = [synthesis.polynomial(p) for p in (circle.A, circle.B, circle.C)]
                factors = nonzero_factors(store, values[:2])
                nonzero = proven(store, "implicit", values)[0]
                if not nonzero and (factors is None or not factors <= known):
                    continue
                made = realise(store, *values)
            except TooLarge:
                continue
            store.rotors.rotor(made[0])


def _nonzero_factors(store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]]) -> frozenset[str]:
    """Return the polynomials that the conditions of a graph keep away from 0."""
    found: frozenset[str] = frozenset()
    used = graph.used_results()
    for index in graph.live():
        node = graph.nodes[index]
        if node.op in ("vector", "implicit") and node.params[0] == 1:
            if node.op == "vector" and Value(index, 1) not in used:
                continue
            found |= (
                nonzero_factors(store, [moved[v.node][v.result] for v in node.operands[:2]]) or frozenset()
            )
    return found


def _is_angle(store: Store, value: Value) -> bool:
    """Tell whether a value is a sum with an angle of a circular unit in it."""
    node = store.node(value)
    if node.op in ("vector", "implicit"):
        return bool(node.params[0] == 1 and value.result == (1 if node.op == "vector" else 0))
    return node.op in _SUMS and any(_is_angle(store, v) for v in node.operands)


def _lift(store: Store, outputs: Mapping[str, Value]) -> None:
    """Add homogeneous versions of all values, for sets of angles whose rotations are replaced."""
    turned = sorted(
        {n.operands[2] for n in store.algebra.nodes if n.op == "rotate" and n.params[0] == 1},
    )
    lifted = [z for z in turned if _is_angle(store, z)]
    size = len(store.algebra.nodes)
    own: dict[tuple[str, str], Value] = {}
    for value in _angles(store):
        rotor = store.rotors.rotor(value) if store.node(value).op == "implicit" else None
        if rotor is not None:
            own.setdefault((rotor[0].key, rotor[1].key), value)
    for lifting in [Lifting(store, frozenset(lifted), own)] + [
        Lifting(store, frozenset(chosen)) for chosen in _subsets(lifted)
    ]:
        for value in outputs.values():
            lifting.realise(value)
        for index in range(size):
            if store.node(Value(index)).op in ("vector", "lightcone", "implicit"):
                lifting.lift(Value(index))


def _subsets(items: Sequence[Value]) -> list[tuple[Value, ...]]:
    """Return all subsets, or for many items the empty, full, nearly empty and nearly full ones."""
    if 2 ** len(items) <= _SUBSETS:
        return [c for size in range(len(items) + 1) for c in combinations(items, size)]
    sizes = (0, 1, len(items) - 1, len(items))
    return [c for size in sizes for c in combinations(items, size)]


def _add_sums(store: Store) -> None:
    """Add angles as sums of two others, where the sample points show a relation and rotors prove it."""
    angles = [v for v in _angles(store) if store.rotors.rotor(v) is not None]
    angles += [n.operands[2] for n in store.algebra.nodes if n.op == "rotate" and n.params[0] == 1]
    distinct: dict[str, Value] = {}
    for value in angles:
        rotor = store.rotors.rotor(value)
        if rotor is not None:
            distinct.setdefault(rotor[0].key + rotor[1].key, value)
    values = list(distinct.values())[:24]
    turns = [np.exp(1j * store.numbers(v)) for v in values]
    for (i, p), (j, q) in combinations(enumerate(values), 2):
        for sign in (1, -1):
            both = turns[i] * (turns[j] if sign == 1 else np.conj(turns[j]))
            for k, r in enumerate(values):
                if k in (i, j):
                    continue
                for whole in (1, -1):
                    rest = (turns[k] if whole == 1 else np.conj(turns[k])) * np.conj(both)
                    if np.max(np.abs(rest - rest[0])) < 1e-9:
                        _add_sum(store, r, whole, p, q, sign, rest[0])


def _quarters(count: int) -> str:
    """Write a positive number of quarter turns."""
    return "pi" if count == 2 else f"{count}*pi/2" if count > 1 else "pi/2"


def _add_sum(store: Store, r: Value, whole: int, p: Value, q: Value, sign: int, rest: Any) -> None:
    """Make r = whole (p + sign q + constant) if the constant is a multiple of a quarter turn."""
    from cordicc.ir.fold import PI

    quarters = np.angle(rest) / (np.pi / 2)
    if abs(quarters - round(quarters)) > 1e-9:
        return
    store.begin(store.node(r).origin)
    names = [name_of(store, v) for v in (r, p, q)]
    middle = "+" if sign == 1 else "-"
    turned = f" {'+' if quarters > 0 else '-'} {_quarters(abs(round(quarters)))}" if round(quarters) else ""
    right = f"{names[1]} {middle} {names[2]}{turned}"
    whole_right = f"-({right})" if whole == -1 else right
    store.reason = (f"`{names[0]} = {whole_right}`: both sides have the same cosine and sine",)
    total = store.make("add" if sign == 1 else "sub", (p, q))[0]
    total = store.add(total, store.const(PI / 2 * round(quarters)))
    if whole == -1:
        total = store.make("neg", (total,))[0]
    store.rotors.rotor(total)
