"""Search for the cheapest operations: alternatives around the realisation of the passes, then a choice."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cordicc.ir.graph import Graph, Value
from cordicc.ir.problem import Problem
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.rules.catalogue import RULES
from cordicc.rewrite.rules.rule import Given
from cordicc.rewrite.search.conditions import requirements
from cordicc.rewrite.search.costs import Costs
from cordicc.rewrite.search.extraction import extract
from cordicc.rewrite.search.options import Worse, alternatives
from cordicc.rewrite.search.rebuilding import facts_of, rebuild
from cordicc.rewrite.search.start import Filled, fill, sample_points

_NODES = 400
_WORSE = tuple(Worse(times) for times in (16.0, 16.0, 16.0, 8.0, 4.0))
"""What is allowed to an operation; each is tried anew only if something was banned since."""

_WORSE_FIXED = (Worse(256.0), Worse(16.0), *(Worse(times, than_any=True) for times in (64.0, 16.0, 4.0)))
"""The same on fixed point: words of one step everywhere blur how much of an error an output sees, and what
the passes make need not be accurate."""


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
        context: PassContext,
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
        self._allowed = list(_WORSE if costs.floating else _WORSE_FIXED)
        self._first = True
        self._tried: Worse | None = None
        self._banned: set[Value] = set()
        self._filled = None
        if problem.inputs and sum(len(g.nodes) for g in graphs) <= _NODES:
            points = sample_points(problem, graphs, words=costs.words)
            if points is not None:
                self._filled = fill(problem, context.inputs, graphs, points, costs.words)
        if self._filled is not None:
            store, moved, outputs = self._filled.store, self._filled.moved, self._filled.outputs
            given = Given(store, graphs, moved, outputs, lifting=lift)
            for rule in RULES:
                rule.run(given)

    def may_be_banned(self, found: Found) -> set[Value]:
        """Return the results in a realisation that the first one given does not need."""
        assert self._filled is not None
        nodes = self._filled.store.algebra.nodes[: self._filled.certain]
        needed = {v for node in nodes for v in node.operands}.union(
            self._filled.outputs.values(), self._subjects()
        )
        return {value for value, source in found.sources.items() if source not in needed | self._banned}

    def ban(self, found: Found, value: Value) -> None:
        """Take a result of a realisation no more, nor one that is made the same way."""
        self._banned.add(found.sources[value])
        self._tried = None

    def _subjects(self) -> list[Value]:
        """Return the values that guards may want."""
        assert self._filled is not None
        partial = [node for node in self._graph.nodes if node.definition.partial]
        operands = [self._filled.moved[0][v.node][v.result] for node in partial for v in node.operands]
        return [*operands, *self._filled.store.sizes.values()]

    def best(self) -> Found | None:
        """Return the best realisation without what is banned, None if the work limits end or all was tried.

        Where nothing is banned after one, fewer roundings are allowed to every value in the next.
        """
        while self._filled is not None and self._allowed:
            worse = self._allowed.pop(0)
            if worse == self._tried:
                continue
            self._tried = worse
            found = self._found(self._filled, worse)
            # Where even the passes' operations may be left out, what is left need not do.
            if found is not None or not worse.than_any:
                return found
        return None

    def _found(self, filled: Filled, worse: Worse) -> Found | None:
        """Return the best realisation of operations with some accuracy, if there is one."""
        first, self._first = self._first, False
        store, moved, certain = filled.store, filled.moved[0], filled.certain
        choice = alternatives(store, certain, filled.outputs, self._subjects(), worse, self._banned)
        if not all(k in choice.providers for k in choice.wanted.values()):
            return None
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
