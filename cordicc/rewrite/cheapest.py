"""The realisation that is compiled: the search's, if it is cheaper and as accurate as that of the passes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.graph import Graph
from cordicc.ir.hard_samples import hard_samples
from cordicc.ir.meaning.doubles import screen
from cordicc.ir.problem import Problem
from cordicc.ir.sampling import draw_with_corners
from cordicc.ir.well_formed import verify
from cordicc.rewrite.accuracy_gate import AccuracyGate, RoundingEffect
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import through_passes
from cordicc.rewrite.passes.standard_chains import StandardChains
from cordicc.rewrite.search.costs import Costs, of_graph
from cordicc.rewrite.search.realisations import Found, Realisations
from cordicc.rewrite.search.start import sample_points

STOPPED = "all alternatives: the choice among them found none within its work"

_POINTS = 1000
"""Samples on which realisations are compared, besides those near singular points and borders."""

_CLOSER = 5
"""Realisations that are looked at for one that keeps checks close, once there is one to compile."""

_ABOUT = 4.0
"""How much less accurate a realisation may be anywhere than the best there, where none is accurate enough."""

_ROUNDS = 6
"""How often alternatives are found anew, by what is known of the checks by then."""

_DRAWN = 6_000
"""Samples among which the border of the domain is looked for."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A graph of unit operations, whether it is proven the cheapest alternative, each node's steps.

    `facts`: the texts of the assumptions that it rests on; `left_out`: what was not among the alternatives,
    or turned down, in words; `turned_down`: the checks for which cheaper realisations were turned down.
    """

    graph: Graph
    proven: bool = False
    searched: bool = False
    steps: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    facts: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    turned_down: tuple[str, ...] = ()


def cheapest(problem: Problem, graph: Graph, context: PassContext, costs: Costs) -> Choice:
    """Return the cheapest realisation found for the goal of the context.

    Args:
        problem: the problem, for its samples and outputs.
        graph: the realisation of the passes in unit operations, kept where nothing better is found.
        context: the ranges of the inputs and the goal.
        costs: what operations cost.
    """
    bases = [
        through_passes(problem.graph, replace(context, goal=goal), implicit=True)
        for goal in ("processors", "latency")
    ]
    points = sample_points(problem, bases, _POINTS, costs.words)
    if points is None:
        words = "all alternatives: too few samples of the inputs have a value"
        return Choice(graph, left_out=(words,) if problem.inputs else ())
    gate = AccuracyGate(problem, graph, points, _hard_points(problem, bases), costs.words, costs.coarsest)
    asked = any(check.asked for check in problem.checks)
    passes = _Tried(of_graph(graph, costs, context.goal), gate.judged(graph), graph)
    search = _Search(problem, passes, gate, costs, context, together=asked)
    # Fixed point has no digits to spare for products of denominators.
    lift = costs.floating
    for _ in range(_ROUNDS):
        around = Realisations(problem, context, bases, costs, lift, search.apart, search.together)
        search.again = False
        if search.among(around) or not (lift or search.again):
            break
        lift = lift and search.again
    return search.choice()


@dataclass(frozen=True, slots=True)
class _Tried:
    """A realisation with its cost and how accurate it is; `found` is what it came from, if not the passes."""

    cost: tuple[int, ...]
    effect: RoundingEffect
    graph: Graph
    proven: bool = False
    found: Found | None = None

    @property
    def accurate(self) -> bool:
        """Tell whether rounding moves no output and no check further than is allowed."""
        return self.effect.inaccurate is None

    @property
    def close(self) -> bool:
        """Tell whether checks stay close to 0 as well."""
        return self.effect.far is None

    @property
    def excess(self) -> float:
        """The largest of what rounding does, compared with what is allowed."""
        return max(float(np.max(ratios, initial=0.0)) for ratios in self.effect.ratios.values())


@dataclass(slots=True)
class _Search:
    """Takes the cheapest of realisations that is accurate enough, `passes` if there is no better one.

    `tried` are the others of the last round, and `rejected` the costs of those of the rounds before.
    `turned_down` has the least cost of what was turned down for a check.  What checks want of realisations is
    learnt of those that are not accurate: `apart` are the operations of the passes' realisation whose results
    must not be scaled, `together` tells whether equations must share roots; `again` that there is more of it.
    """

    problem: Problem
    passes: _Tried
    gate: AccuracyGate
    costs: Costs
    context: PassContext
    tried: list[_Tried] = field(default_factory=list)
    rejected: list[tuple[int, ...]] = field(default_factory=list)
    turned_down: dict[str, tuple[int, ...]] = field(default_factory=dict)
    apart: frozenset[int] = frozenset()
    together: bool = False
    again: bool = False
    searched: bool = True
    left_out: list[str] = field(default_factory=list)

    def among(self, realisations: Realisations) -> bool:
        """Try some realisations; tell whether others need no look.

        They do where none was accurate before the next one is no cheaper than that of the passes, and where
        checks want more.
        """
        self.left_out = realisations.left_out
        self.rejected += [each.cost for each in self.tried]
        self.tried = []
        found, kept, more = realisations.best(), None, 0
        if found is None:
            self.left_out, self.searched = self.left_out or [STOPPED], False
            return True
        while found is not None and more <= _CLOSER:
            made = found.graph if self.costs.implicit else StandardChains().apply(found.graph, self.context)
            verify(made)
            cost, first = self._cost(made), not self.tried
            if first and found.proven and cost >= self.passes.cost:
                self.passes = replace(self.passes, proven=True)
            if kept is None and self.passes.accurate and cost >= self.passes.cost:
                if not first:
                    return False
                kept = self.passes
                if kept.close:
                    return True
            if kept is not None and cost[0] > kept.cost[0] and not kept.effect.excessive:
                break
            each = _Tried(cost, self.gate.judged(made), made, found.proven and kept is None, found)
            self.tried.append(each)
            if kept is None and each.accurate:
                kept = each
            if each.accurate and each.close:
                return True
            moved = each.effect.inaccurate or each.effect.far
            assert moved is not None
            if moved[0] in self.problem.check_graph.outputs:
                self.turned_down[moved[0]] = min(cost, self.turned_down.get(moved[0], cost))
                if not self.together:
                    self.together = self.again = True
                    return False
            # In chains of standard units results are no longer those of the search.
            if self.costs.implicit and not self._ban(realisations, found, moved, close=kept is not None):
                return False
            found, more = realisations.best(), more + (kept is not None)
        return kept is not None

    def choice(self) -> Choice:
        """Return the cheapest that is about as accurate everywhere as the best there, with the passes' one.

        On fixed point no words may be as fine as is allowed, so that it need not be accurate enough.
        Where it moves a check far, one that does not and takes no more of what costs first is better; at any
        cost, where the problem allows the check no more.
        """
        every = sorted([self.passes, *self.tried], key=lambda each: each.cost)
        least = {
            name: np.min([each.effect.ratios[name] for each in every], axis=0)
            for name in self.passes.effect.ratios
        }
        fitting = [
            each
            for each in every
            if all(np.all(each.effect.ratios[n] <= np.maximum(1.0, _ABOUT * least[n])) for n in least)
        ]
        best = fitting[0] if fitting else min(every, key=lambda each: each.excess)
        close = [e for e in fitting if e.close and (best.effect.excessive or e.cost[0] <= best.cost[0])]
        best = close[0] if close else best
        found = best.found
        return Choice(
            best.graph,
            best.proven,
            self.searched,
            found.steps if found is not None and self.costs.implicit else {},
            found.facts if found is not None else (),
            self._words(best),
            tuple(name for name, cost in self.turned_down.items() if cost < best.cost),
        )

    def _words(self, chosen: _Tried) -> tuple[str, ...]:
        """Return what was left out, with how many cheaper realisations were turned down."""
        found = list(self.left_out)
        if chosen.effect.excessive:
            found.append("operations that keep checks within their largest everywhere: none was found")
        count = sum(cost < chosen.cost for cost in [*self.rejected, *(each.cost for each in self.tried)])
        if not count:
            return tuple(found)
        choices = "choice of operations" if count == 1 else "choices of operations"
        said = f"{count} cheaper {choices}, with which rounding would move an output or a check too far"
        return (*found, said)

    def _ban(self, realisations: Realisations, found: Found, moved: tuple[str, int], *, close: bool) -> bool:
        """Let what moves an output or check at a sample be in no further realisation.

        Return False if others do better than what is left.

        Args:
            realisations: where there are others.
            found: the one that is not accurate.
            moved: output or check, and sample.
            close: whether results that the passes' realisation needs may be banned too.
        """
        if moved[0] in self.problem.check_graph.outputs:
            # Errors of a unit move it where not all that should follows from the unit.
            units = self.gate.movers(found.graph, *moved, found.sources)
            for unit in units:
                apart = sorted(realisations.apart(found, unit))
                if [value for value in apart if realisations.ban(found, value)]:
                    return True
            scaled = [] if close or not realisations.lift else units
            for unit in scaled:
                if not (own := realisations.of_unit(found, unit)) <= self.apart:
                    self.apart, self.again = self.apart | own, True
                    return False
        among = realisations.may_be_banned(found, needed=close)
        blamed = self.gate.culprit(found.graph, *moved, among)
        while blamed is not None and not realisations.ban(found, blamed):
            among.remove(blamed)
            blamed = self.gate.culprit(found.graph, *moved, among)
        return True

    def _cost(self, graph: Graph) -> tuple[int, ...]:
        return of_graph(graph, self.costs, self.context.goal)


def _hard_points(problem: Problem, graphs: Sequence[Graph]) -> dict[str, Floats] | None:
    """Return corners and what is near borders and singular points; None without checks."""
    if not problem.checks:
        return None
    drawn = draw_with_corners(problem.workspace, _DRAWN)
    corners = {name: column[_DRAWN:] for name, column in drawn.items()}
    singular = hard_samples(problem.graph, problem.workspace, drawn)
    more = {name: np.concatenate([corners[name], singular[name]]) for name in drawn}
    good = np.ones(len(next(iter(more.values()))), dtype=bool)
    for graph in (problem.graph, *graphs):
        good &= screen(graph, more)[1]
    return {name: column[good] for name, column in more.items()}
