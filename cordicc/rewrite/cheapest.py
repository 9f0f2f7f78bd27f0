"""The realisation that is compiled: the search's, if it is cheaper and as accurate as that of the passes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.ir.border import border_samples
from cordicc.ir.graph import Graph
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

_POINTS = 1000
"""Samples on which realisations are compared, besides those near singular points and borders."""

_CLOSER = 8
"""Realisations that are looked at for one that keeps checks close, once there is one to compile."""

_DRAWN = 6_000
"""Samples among which the border of the domain is looked for."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A graph of unit operations, whether it is proven the cheapest alternative, each node's steps.

    `facts`: the texts of the assumptions that it rests on; `turned_down`: the checks for which cheaper
    realisations were turned down.
    """

    graph: Graph
    proven: bool = False
    searched: bool = False
    steps: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    facts: tuple[str, ...] = ()
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
        return Choice(graph)
    gate = AccuracyGate(problem, graph, _with_borders(problem, bases, points))
    search = _Search(problem, graph, gate, costs, context)
    # Fixed point has no digits to spare for products of denominators.
    for lift in (True, False) if costs.floating else (False,):
        realisations = Realisations(problem, context, bases, costs, lift=lift)
        if (choice := search.among(realisations)) is not None:
            return choice
    return Choice(graph, searched=True, turned_down=tuple(search.turned_down))


@dataclass(slots=True)
class _Search:
    """Takes the cheapest of realisations that is accurate enough."""

    problem: Problem
    graph: Graph
    gate: AccuracyGate
    costs: Costs
    context: PassContext
    turned_down: dict[str, None] = field(default_factory=dict)

    def among(self, realisations: Realisations) -> Choice | None:
        """Return the choice; None if some were not accurate and the next one is no cheaper than the passes'."""
        kept: Choice | None = None
        found, first, more = realisations.best(), True, 0
        if found is None:
            return Choice(self.graph)
        while found is not None and more <= _CLOSER:
            made = found.graph if self.costs.implicit else StandardChains().apply(found.graph, self.context)
            verify(made)
            if kept is None and self._cost(made) >= self._cost(self.graph):
                if not first:
                    return None
                kept = Choice(self.graph, proven=found.proven, searched=True)
                if self.gate.judged(self.graph)[1] is None:
                    return kept
            if kept is not None and self._cost(made)[0] > self._cost(kept.graph)[0]:
                break
            inaccurate, far = self.gate.judged(made)
            if inaccurate is None and (kept is None or far is None):
                steps = found.steps if self.costs.implicit else {}
                closer = kept is not None
                kept = Choice(made, found.proven, True, steps, found.facts, tuple(self.turned_down))
                if far is None:
                    return replace(kept, proven=False) if closer else kept
            moved = inaccurate or far
            assert moved is not None
            if moved[0] in self.problem.check_graph.outputs:
                self.turned_down[moved[0]] = None
            # In chains of standard units results are no longer those of the search.
            if self.costs.implicit:
                self._ban(realisations, found, moved, needed=kept is not None)
            found, first, more = realisations.best(), False, more + (kept is not None)
        return kept

    def _ban(self, realisations: Realisations, found: Found, moved: tuple[str, int], needed: bool) -> None:
        """Let what moves an output or check at a sample be in no further realisation."""
        among = realisations.may_be_banned(found, needed=needed)
        if moved[0] in self.problem.check_graph.outputs:
            # Errors of a unit move it where not all that should follows from the unit.
            for unit in self.gate.movers(found.graph, *moved, found.sources):
                apart = realisations.apart(found, unit)
                if [value for value in sorted(apart) if realisations.ban(found, value)]:
                    return
        blamed = self.gate.culprit(found.graph, *moved, among)
        while blamed is not None and not realisations.ban(found, blamed):
            among.remove(blamed)
            blamed = self.gate.culprit(found.graph, *moved, among)

    def _cost(self, graph: Graph) -> tuple[int, ...]:
        return of_graph(graph, self.costs, self.context.goal)


def _with_borders(
    problem: Problem, graphs: Sequence[Graph], points: Mapping[str, Floats]
) -> dict[str, Floats]:
    """Return points of the workspace and others where equations and graphs have values: corners, borders."""
    drawn = draw_with_corners(problem.workspace, _DRAWN)
    corners = {name: column[_DRAWN:] for name, column in drawn.items()}
    borders = border_samples(problem.graph, problem.workspace, drawn)
    more = {name: np.concatenate([corners[name], borders[name]]) for name in drawn}
    good = np.ones(len(next(iter(more.values()))), dtype=bool)
    for graph in (problem.graph, *graphs):
        good &= screen(graph, more)[1]
    return {name: np.concatenate([column, more[name][good]]) for name, column in points.items()}
