"""A store filled with realisations of a problem, on points of its workspace."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from cordicc.base.arrays import Bools, Floats
from cordicc.ir.graph import Graph, Value, factored
from cordicc.ir.meaning.doubles import all_results
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.roundings import SINGLE, Words
from cordicc.ir.ops import Level
from cordicc.ir.problem import Problem, input_intervals
from cordicc.ir.towards_zero import roots_of, towards_zero
from cordicc.rewrite.exact.angle_rotors import MOST_TURNS
from cordicc.rewrite.exact.field import Field
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.simplify import Simplify
from cordicc.rewrite.rules.angles import SUMS, angles_of

_POINTS = 24
_NEAREST = 3
_DRAWN = 6_000
_CRITICAL = {"vector": 0, "lightcone": 0, "implicit": 1}
"""The result of a unit that is 0 where the others are ill-conditioned."""

_GENERATORS = 120

OPAQUE = 16
"""Values that may become generators because what they are made of is too large."""


@dataclass(frozen=True, slots=True)
class Filled:
    """A store with realisations in it.

    `moved` are the values that the nodes of each became, `certain` tells how many nodes of the store are
    those of the first, and `outputs` are the values of its outputs, equal to those of the others.
    """

    store: Store
    moved: Sequence[Sequence[tuple[Value, ...]]]
    certain: int
    outputs: Mapping[str, Value]


def fill(
    problem: Problem,
    ranges: Mapping[str, Interval],
    graphs: Sequence[Graph],
    points: Mapping[str, Floats],
    words: Words = SINGLE,
    work: float = 1.0,
) -> Filled | None:
    """Return a store with realisations in it, None if they take more generators than there may be.

    `work` multiplies the usual limits of size.
    """
    field = _field(graphs, work)
    if field is None:
        return None
    store = Store(field, ranges, points, words)
    _name_constants(store, graphs)
    _assume(store, problem)
    store.opaque_left = OPAQUE
    moved = [_import(store, graphs[0])]
    certain = len(store.algebra.nodes)
    moved += [_import(store, graph) for graph in graphs[1:]]
    for angle in angles_of(store):
        store.rotors.rotor(angle)
    store.opaque_left = 0
    return Filled(store, moved, certain, _joined_outputs(store, graphs, moved))


def _joined_outputs(
    store: Store, graphs: Sequence[Graph], moved: Sequence[Sequence[tuple[Value, ...]]]
) -> dict[str, Value]:
    """Return the outputs of the first realisation, made equal to those of the others."""
    outputs = {name: moved[0][v.node][v.result] for name, v in graphs[0].outputs.items()}
    for graph, values in zip(graphs[1:], moved[1:], strict=True):
        for name, value in graph.outputs.items():
            store.union(outputs[name], values[value.node][value.result])
    return outputs


def sample_points(
    problem: Problem, graphs: Sequence[Graph], count: int = _POINTS, words: Words = SINGLE
) -> dict[str, Floats] | None:
    """Return points of the workspace at which graphs have values, None if there are too few.

    Besides `count` random ones there are those nearest to the singular points of the units, and on fixed
    point, where small values have few digits, those on the way to the zeros of the roots.  They keep what the
    problem assumes if enough of the points that are looked at do.
    """
    generator = np.random.Generator(np.random.PCG64(7))
    if problem.samples is not None:
        rows = generator.integers(0, problem.samples.rows, _DRAWN)
        drawn = {name: np.asarray(column)[rows] for name, column in problem.samples.columns.items()}
    else:
        drawn = {
            spec.name: generator.uniform(float(spec.lo), float(spec.hi), _DRAWN) for spec in problem.inputs
        }
    good, critical = _judged(graphs, drawn)
    if good.sum() < _POINTS // 2:
        return None
    kept = good & problem.facts.kept(drawn)
    assumed = kept.sum() >= _POINTS // 2
    good = kept if assumed else good
    first = np.flatnonzero(good)
    nearest = [first[np.argsort(size[first], kind="stable")[:_NEAREST]] for size in critical]
    rows = np.unique(np.concatenate([first[:count], *nearest]))
    points = {name: column[rows] for name, column in drawn.items()}
    if not words.fixed or problem.samples is not None:
        return points
    known = {name: column[first] for name, column in drawn.items()}
    small = towards_zero(graphs[0], roots_of(graphs[0]), input_intervals(problem), known)
    held, _ = _judged(graphs, small)
    held = held & problem.facts.kept(small) if assumed else held
    return {name: np.concatenate([column, small[name][held]]) for name, column in points.items()}


def _judged(graphs: Sequence[Graph], points: Mapping[str, Floats]) -> tuple[Bools, list[Floats]]:
    """Tell at which points all results of graphs are finite; return the sizes of the critical ones."""
    good = np.ones(len(next(iter(points.values()))), dtype=bool)
    critical = []
    for graph in graphs:
        live = graph.live()
        for index, results in enumerate(all_results(graph, points)):
            if index in live:
                for result in results:
                    good &= np.isfinite(result)
                if graph.nodes[index].op in _CRITICAL:
                    critical.append(np.abs(results[_CRITICAL[graph.nodes[index].op]]))
    return good, critical


def _field(graphs: Sequence[Graph], work: float) -> Field | None:
    operations = [n for g in graphs for n in g.nodes]
    count = {op: sum(1 for n in operations if n.op == op) for op in {n.op for n in operations}}
    inputs = count.get("input", 0) // len(graphs)
    turned = len({n.operands[2] for g in graphs for n in g.nodes if n.op == "rotate"})
    roots = (
        6
        + OPAQUE // 2
        + sum(
            1 for n in graphs[0].nodes if n.op == "lightcone" or (n.op in ("vector", "implicit") and n.m != 0)
        )
    )
    pairs = turned + 4 + (count.get("abs", 0) + count.get("flip", 0)) // len(graphs)
    opaque = sum(count.get(op, 0) for op in ("min", "max", "select", "sign"))
    free = inputs + 2 * pairs + opaque + OPAQUE
    fits = free + pairs + roots <= _GENERATORS * work
    return Field(free, pairs, roots, work) if fits else None


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
        if node.op == "rotate" and node.m != 0:
            factor, base = factored(graph.nodes, node.operands[2])
            if graph.node(base).op not in (*SUMS, "vector", "implicit", "lightcone", "const", "guard"):
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
            if node.op == "rotate" and node.m == 1:
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
    graph = Simplify().apply(problem.facts.graph, PassContext({}))
    if any(n.definition.level is Level.FUNCTION for n in graph.nodes):
        return
    moved = _import(store, graph)
    for index, fact in enumerate(problem.assumptions):
        sides = [graph.outputs[f"{side}{index}"] for side in ("left", "right")]
        left, right = (store.element(moved[v.node][v.result]) for v in sides)
        if left is not None and right is not None:
            store.assume(store.field.sub(left, right), fact.relation, fact.text)
