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
from cordicc.rewrite.accuracy_gate import AccuracyGate
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import default_passes
from cordicc.rewrite.passes.standard_chains import StandardChains
from cordicc.rewrite.search.costs import Costs, of_graph
from cordicc.rewrite.search.realisations import Found, Realisations
from cordicc.rewrite.search.start import sample_points

STOPPED = "all alternatives: the choice among them found none within its work"

_POINTS = 1000
"""Samples on which realisations are compared, besides those near singular points and borders."""

_CLOSER = 5
"""Realisations that are looked at for one that keeps checks close, once there is one to compile."""

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
    bases = []
    for goal in ("processors", "latency"):
        base = problem.graph
        for step in default_passes(implicit=True):
            base = step.apply(base, replace(context, goal=goal))
        bases.append(base)
    points = sample_points(problem, bases, _POINTS)
    if points is None:
        words = "all alternatives: too few samples of the inputs have a value"
        return Choice(graph, left_out=(words,) if problem.inputs else ())
    hard = _hard_points(problem, bases)
    gate = AccuracyGate(problem, graph, points, hard, None if costs.floating else costs.guard_bits)
    asked = any(check.asked for check in problem.checks)
    search = _Search(problem, graph, gate, costs, context, together=asked)
    # Fixed point has no digits to spare for products of denominators.
    lift = costs.floating
    for _ in range(_ROUNDS):
        around = Realisations(problem, context, bases, costs, lift, search.apart, search.together)
        search.again = False
        if (choice := search.among(around)) is not None:
            return choice
        if not (lift or search.again):
            break
        lift = lift and search.again
    return search.choice(graph, proven=False)


@dataclass(slots=True)
class _Search:
    """Takes the cheapest of realisations that is accurate enough.

    `turned_down` are the checks for which cheaper ones were turned down.  What checks want of realisations is
    learnt of those that are not accurate: `apart` are the operations of the passes' realisation whose results
    must not be scaled, `together` tells whether equations must share roots; `again` that there is more of it.
    """

    problem: Problem
    graph: Graph
    gate: AccuracyGate
    costs: Costs
    context: PassContext
    turned_down: dict[str, None] = field(default_factory=dict)
    apart: frozenset[int] = frozenset()
    together: bool = False
    again: bool = False
    left_out: list[str] = field(default_factory=list)
    rejected: int = 0

    def among(self, realisations: Realisations) -> Choice | None:
        """Return the choice; None if others are to be looked at.

        Some were not accurate, and the next one is no cheaper than that of the passes, or checks want more.
        """
        self.left_out = realisations.left_out
        kept: Choice | None = None
        found, first, more = realisations.best(), True, 0
        if found is None:
            self.left_out = self.left_out or [STOPPED]
            return replace(self.choice(self.graph, proven=False), searched=False)
        while found is not None and more <= _CLOSER:
            made = found.graph if self.costs.implicit else StandardChains().apply(found.graph, self.context)
            verify(made)
            if kept is None and self._cost(made) >= self._cost(self.graph):
                if not first:
                    return None
                kept = self.choice(self.graph, found.proven)
                if self.gate.judged(self.graph)[1] is None:
                    return kept
            if kept is not None and self._cost(made)[0] > self._cost(kept.graph)[0]:
                break
            inaccurate, far = self.gate.judged(made)
            if inaccurate is None and (kept is None or far is None):
                kept = self.choice(made, found.proven and kept is None, found)
                if far is None:
                    return kept
            self.rejected += kept is None
            moved = inaccurate or far
            assert moved is not None
            if moved[0] in self.problem.check_graph.outputs:
                self.turned_down[moved[0]] = None
            # In chains of standard units results are no longer those of the search.
            if self.costs.implicit and not self._ban(realisations, found, moved, close=kept is not None):
                return None
            found, first, more = realisations.best(), False, more + (kept is not None)
        return kept

    def choice(self, graph: Graph, proven: bool, found: Found | None = None) -> Choice:
        """Return a graph as the choice; `found` is what it came from if it is not that of the passes."""
        left_out, turned_down = self._words(), tuple(self.turned_down)
        if found is None:
            return Choice(graph, proven, searched=True, left_out=left_out, turned_down=turned_down)
        steps = found.steps if self.costs.implicit else {}
        return Choice(graph, proven, True, steps, found.facts, left_out, turned_down)

    def _words(self) -> tuple[str, ...]:
        """Return what was left out, with how many cheaper realisations were turned down."""
        if not self.rejected:
            return tuple(self.left_out)
        choices = "choice of operations" if self.rejected == 1 else "choices of operations"
        said = (
            f"{self.rejected} cheaper {choices}, with which rounding would move an output or a check too far"
        )
        return (*self.left_out, said)

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
            if not self.together:
                self.together = self.again = True
                return False
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
