"""Search for the cheapest operations: alternatives around the realisation of the passes, then a choice."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from cordicc.ir.graph import Graph, Value
from cordicc.ir.problem import Problem
from cordicc.rewrite.exact.values import Store
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.rules.catalogue import RULES
from cordicc.rewrite.rules.rule import Given
from cordicc.rewrite.search.conditions import requirements
from cordicc.rewrite.search.costs import Costs
from cordicc.rewrite.search.extraction import extract
from cordicc.rewrite.search.options import Classes, Worse, alternatives
from cordicc.rewrite.search.rebuilding import facts_of, rebuild
from cordicc.rewrite.search.start import Filled, fill, sample_points

MOST_NODES = 400
_WORSE = tuple(Worse(times) for times in (16.0, 16.0, 16.0, 8.0, 4.0))
"""What is allowed to an operation; each is tried anew only if something was banned since."""

_WORSE_FIXED = (
    *(Worse(times) for times in (256.0, 16.0, 16.0, 16.0)),
    *(Worse(times, than_any=True) for times in (64.0, 16.0, 4.0)),
)
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


def at_effort(work: float) -> str:
    """Return the option by which sizes are limited, with its value."""
    return f"--effort {work:g}"


class Realisations:
    """The best realisations around those given, one after the other."""

    def __init__(
        self,
        problem: Problem,
        context: PassContext,
        graphs: Sequence[Graph],
        costs: Costs,
        lift: bool = True,
        apart: frozenset[int] = frozenset(),
        together: bool = False,
    ) -> None:
        """Find the alternatives.

        Args:
            problem: the problem, for its samples.
            context: the ranges of the inputs, the goal and the work to be done.
            graphs: realisations in unit operations, implicit ones included; the first one gives conditions.
            costs: what operations cost.
            lift: whether values may be scaled by common denominators.
            apart: nodes of the first realisation of whose roots no cosine and sine is made then.
            together: whether equations share roots, so that errors of their angles cancel.
        """
        self._problem, self._context, self._graph, self._costs = problem, context, graphs[0], costs
        self.lift = lift
        self._allowed = list(_WORSE if costs.floating else _WORSE_FIXED)
        self._first = True
        self._tried: Worse | None = None
        self._banned: set[Value] = set()
        self._filled = None
        work, nodes = max(1.0, context.effort), sum(len(g.nodes) for g in graphs)
        self.left_out: list[str] = []
        """What the alternatives lack, in words."""
        points = None
        if nodes > MOST_NODES * work:
            self.left_out.append(f"all alternatives: {nodes} operations, too many for {at_effort(work)}")
        elif problem.inputs:
            points = sample_points(problem, graphs, words=costs.words)
        if points is not None:
            self._filled = fill(problem, context.inputs, graphs, points, costs.words, work)
            if self._filled is None:
                self.left_out.append(f"all alternatives: too many variables for {at_effort(work)}")
        if self._filled is not None:
            store, moved, outputs = self._filled.store, self._filled.moved, self._filled.outputs
            kept = frozenset(value for index in apart for value in moved[0][index])
            given = Given(store, graphs, moved, outputs, lift, kept, together)
            for rule in RULES:
                rule.run(given)
            if not lift:
                self.left_out.append("scaling by common denominators, which costs digits on fixed point")
            if store.field.given_up:
                steps = "step" if store.field.given_up == 1 else "steps"
                self.left_out.append(
                    f"{store.field.given_up} {steps} of algebra, too large for {at_effort(work)}"
                )

    @property
    def _store(self) -> Store:
        assert self._filled is not None
        return self._filled.store

    @property
    def _moved(self) -> Sequence[tuple[Value, ...]]:
        """The values that the nodes of the first realisation became."""
        assert self._filled is not None
        return self._filled.moved[0]

    def may_be_banned(self, found: Found, *, needed: bool = False) -> set[Value]:
        """Return the results in a realisation that the first one given does not need, or those as well.

        Without one that it needs there may be no realisation.
        """
        assert self._filled is not None
        if needed:
            return {value for value, source in found.sources.items() if source not in self._banned}
        nodes = self._filled.store.algebra.nodes[: self._filled.certain]
        kept = {v for node in nodes for v in node.operands}.union(
            self._filled.outputs.values(), self._subjects()
        )
        return {value for value, source in found.sources.items() if source not in kept | self._banned}

    def apart(self, found: Found, unit: Value) -> set[Value]:
        """Return the values of a realisation that go without a result of a unit, and equal ones do not.

        Equal ones are those of the first realisation given: there an error of the unit is in all that follows
        from it, and cancels.  Of the values here those are returned that follow from no other one.
        """
        classes, graph = Classes(self._store), self._graph
        made = [{classes.turn(value) for value in values} for values in self._moved]
        starts, live = self.of_unit(found, unit), graph.live()
        after = live & set(starts).union(*(graph.downstream(index) for index in starts))
        before = set().union(*(made[index] for index in {*live - after, *starts}))
        follow = set().union(*(made[index] for index in after)) - before
        with_unit = {unit.node, *found.graph.downstream(unit.node)}
        without = {
            value: source
            for value, source in found.sources.items()
            if value.node not in with_unit and classes.turn(source) in follow
        }
        first = [v for v in without if without.keys().isdisjoint(found.graph.nodes[v.node].operands)]
        return {v for v in first if without[v] not in self._banned} & found.graph.used_results()

    def of_unit(self, found: Found, unit: Value) -> frozenset[int]:
        """Return the nodes of the first realisation given that yield a result of a unit in another one."""
        classes, source = Classes(self._store), found.sources[unit]
        results = range(len(self._store.algebra.nodes[source.node].definition.results))
        own = {classes.turn(Value(source.node, result)) for result in results}
        return frozenset(
            index
            for index, values in enumerate(self._moved)
            if any(classes.turn(value) in own for value in values)
        )

    def ban(self, found: Found, value: Value) -> bool:
        """Take a result of a realisation no more, nor one that is made the same way.

        Return False, and ban nothing, if nothing else makes what the outputs need.
        """
        banned = {*self._banned, found.sources[value]}
        if value not in self.may_be_banned(found) and not self._possible(banned):
            return False
        self._banned, self._tried = banned, None
        return True

    def _possible(self, banned: Collection[Value]) -> bool:
        """Tell whether without some results all that the outputs need, and what guards may want, is made."""
        if self._filled is None or not self._allowed:
            return False
        wanted, subjects = self._filled.outputs, self._subjects()
        choice = alternatives(
            self._filled.store, self._filled.certain, wanted, subjects, self._allowed[0], banned
        )
        needed = {*choice.wanted.values(), *map(choice.class_of, subjects)}
        return needed <= choice.providers.keys()

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
