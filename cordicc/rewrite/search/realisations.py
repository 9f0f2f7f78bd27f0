"""Search for the cheapest operations: alternatives around the realisation of the passes, then a choice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from cordicc.ir.graph import Graph, Value
from cordicc.ir.problem import Problem
from cordicc.rewrite.exact.angle_rotors import MOST_TURNS
from cordicc.rewrite.exact.field import TooLarge
from cordicc.rewrite.exact.keys import Key, RotorKey
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.passes.base import Context
from cordicc.rewrite.rules.angles import (
    add_offsets,
    add_principal_values,
    add_sums_of_vectors,
    add_unit_vectors,
)
from cordicc.rewrite.rules.circles import circles, realise, squared_lengths
from cordicc.rewrite.rules.common_denominators import Lifting
from cordicc.rewrite.rules.derivation import circle_steps, name_of
from cordicc.rewrite.rules.frames import add_frames
from cordicc.rewrite.rules.perfect_squares import add_perfect_squares, add_roots_of_products
from cordicc.rewrite.rules.products import turned
from cordicc.rewrite.rules.rotation_chains import add_chains, add_halves
from cordicc.rewrite.rules.sharing import add_multiples, add_norm_chains, add_norms, add_orders, add_pairs
from cordicc.rewrite.rules.squares import add_squares
from cordicc.rewrite.rules.synthesis import Synthesis
from cordicc.rewrite.search.conditions import nonzero_factors, proven, requirements
from cordicc.rewrite.search.costs import Costs
from cordicc.rewrite.search.extraction import extract
from cordicc.rewrite.search.options import alternatives
from cordicc.rewrite.search.rebuilding import facts_of, rebuild
from cordicc.rewrite.search.start import SUMS, Filled, angles_of, fill, sample_points

_NODES = 400
_SUBSETS = 16
_WORSE = (16.0, 16.0, 16.0, 8.0, 4.0)
"""How many times the error bound of a value in the realisation of the passes an operation is allowed.

Each is tried anew only if something was banned since."""


@dataclass(frozen=True, slots=True)
class Found:
    """The chosen graph, whether it is proven best over the alternatives, steps by node, facts used.

    Only the first realisation is proven: later ones lack alternatives that may be accurate in another.
    `sources` are the values of the search that results are.
    """

    graph: Graph
    proven: bool
    steps: Mapping[int, tuple[str, ...]]
    facts: tuple[str, ...]
    sources: Mapping[Value, Value]


class Realisations:
    """The best realisations around those given, one after the other."""

    def __init__(
        self,
        problem: Problem,
        context: Context,
        graphs: Sequence[Graph],
        costs: Costs,
        *,
        lift: bool = True,
    ) -> None:
        """Find the alternatives.

        Args:
            problem: the problem, for its samples.
            context: the ranges of the inputs, the goal and the work to be done.
            graphs: realisations in unit operations, implicit ones included; the first one gives conditions.
            costs: what operations cost.
            lift: whether values may be scaled by common denominators.
        """
        self._problem, self._context, self._graph, self._costs = problem, context, graphs[0], costs
        self._outputs: dict[str, Value] = {}
        self._allowed = list(_WORSE)
        self._tried = 0.0
        self._banned: set[Value] = set()
        self._filled = None
        if problem.inputs and sum(len(g.nodes) for g in graphs) <= _NODES:
            points = sample_points(problem, graphs)
            self._filled = None if points is None else fill(problem, context.inputs, graphs, points)
        if self._filled is not None:
            self._outputs = _explore(self._filled, graphs, lift=lift)

    def may_be_banned(self, found: Found) -> set[Value]:
        """Return the results in a realisation that the first one given does not need."""
        assert self._filled is not None
        nodes = self._filled.store.algebra.nodes[: self._filled.certain]
        needed = {v for node in nodes for v in node.operands}.union(self._outputs.values(), self._subjects())
        return {value for value, source in found.sources.items() if source not in needed | self._banned}

    def ban(self, found: Found, value: Value) -> None:
        """Take a result of a realisation no more, nor one that is made the same way."""
        self._banned.add(found.sources[value])
        self._tried = 0.0

    def _subjects(self) -> list[Value]:
        """Return the values that guards may want."""
        assert self._filled is not None
        partial = [node for node in self._graph.nodes if node.definition.partial]
        return [self._filled.moved[0][v.node][v.result] for node in partial for v in node.operands]

    def best(self) -> Found | None:
        """Return the best realisation without what is banned, None if the work limits end or all was tried.

        Where nothing is banned after one, fewer roundings are allowed to every value in the next.
        """
        while self._allowed and self._allowed[0] == self._tried:
            self._allowed.pop(0)
        if self._filled is None or not self._allowed:
            return None
        first = len(self._allowed) == len(_WORSE)
        self._tried = self._allowed.pop(0)
        store, moved, certain = self._filled.store, self._filled.moved[0], self._filled.certain
        choice = alternatives(store, certain, self._outputs, self._subjects(), self._tried, self._banned)
        store.begin("")
        needs = requirements(store, self._graph, moved, choice)
        conditions = frozenset(store.field.touched)
        zeros = frozenset([choice.class_of(store.const(0))])
        extraction = extract(choice, needs, zeros, self._costs, self._context)
        if extraction is None:
            return None
        graph, steps, sources = rebuild(store, choice, needs, extraction, self._graph)
        facts = conditions | facts_of(store, choice, extraction, certain)
        told = tuple(fact.text for fact in self._problem.assumptions if fact.text in facts)
        return Found(graph, extraction.proven and first, steps, told, sources)


def _explore(filled: Filled, graphs: Sequence[Graph], *, lift: bool) -> dict[str, Value]:
    """Add all that the rules find to a store; return the outputs."""
    store, moved = filled.store, filled.moved
    outputs = {name: moved[0][v.node][v.result] for name, v in graphs[0].outputs.items()}
    for graph, values in zip(graphs[1:], moved[1:], strict=True):
        for name, value in graph.outputs.items():
            store.union(outputs[name], values[value.node][value.result])
    _join_areas(store)
    _add_forms(store)
    angles = angles_of(store)
    _add_circles(store, graphs[0], moved[0], angles)
    add_frames(store)
    add_principal_values(store)
    add_perfect_squares(store)
    add_unit_vectors(store)
    add_offsets(store)
    add_sums_of_vectors(store)
    if lift:
        _lift(store, outputs)
    add_roots_of_products(store)
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
    return outputs


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
    known: dict[RotorKey, Value] = {}
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
    sums = [v for results in moved for v in results if store.node(v).op in SUMS and _is_angle(store, v)]
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


def _nonzero_factors(store: Store, graph: Graph, moved: Sequence[tuple[Value, ...]]) -> frozenset[Key]:
    """Return the polynomials that the conditions of a graph keep away from 0."""
    found: frozenset[Key] = frozenset()
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
    return node.op in SUMS and any(_is_angle(store, v) for v in node.operands)


def _lift(store: Store, outputs: Mapping[str, Value]) -> None:
    """Add homogeneous versions of all values, for sets of angles whose rotations are replaced."""
    turned = sorted(
        {n.operands[2] for n in store.algebra.nodes if n.op == "rotate" and n.params[0] == 1},
    )
    lifted = [z for z in turned if _is_angle(store, z)]
    size = len(store.algebra.nodes)
    own: dict[RotorKey, Value] = {}
    for value in angles_of(store):
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
    angles = [v for v in angles_of(store) if store.rotors.rotor(v) is not None]
    angles += [n.operands[2] for n in store.algebra.nodes if n.op == "rotate" and n.params[0] == 1]
    distinct: dict[RotorKey, Value] = {}
    for value in angles:
        rotor = store.rotors.rotor(value)
        if rotor is not None:
            distinct.setdefault((rotor[0].key, rotor[1].key), value)
    values = list(distinct.values())[:24]
    if len(values) < 3:
        return
    turns = np.stack([np.exp(1j * store.numbers(v)) for v in values])
    for (i, p), (j, q) in combinations(enumerate(values), 2):
        for sign in (1, -1):
            both = turns[i] * (turns[j] if sign == 1 else np.conj(turns[j]))
            # One row for each angle and sign in front of the sum: how far they differ at the points.
            rests = np.stack((turns, np.conj(turns)), axis=1) * np.conj(both)
            constant = np.max(np.abs(rests - rests[..., :1]), axis=-1) < 1e-9
            for k, r in enumerate(values):
                for column, whole in enumerate((1, -1)):
                    if k not in (i, j) and constant[k, column]:
                        _add_sum(store, r, whole, p, q, sign, rests[k, column, 0])


def _quarters(count: int) -> str:
    """Write a positive number of quarter turns."""
    return "pi" if count == 2 else f"{count}*pi/2" if count > 1 else "pi/2"


def _add_sum(store: Store, r: Value, whole: int, p: Value, q: Value, sign: int, rest: Any) -> None:
    """Make r = whole (p + sign q + constant) if the constant is a multiple of a quarter turn."""
    from cordicc.ir.meaning.exact import PI

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
