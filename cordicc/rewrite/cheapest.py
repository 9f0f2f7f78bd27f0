"""The realisation that is compiled: the search's, if it is cheaper and as accurate as that of the passes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from cordicc.ir.graph import Graph
from cordicc.ir.problem import Problem
from cordicc.ir.well_formed import verify
from cordicc.rewrite.accuracy_gate import AccuracyGate, worst_of
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import default_passes
from cordicc.rewrite.passes.standard_chains import StandardChains
from cordicc.rewrite.search.costs import Costs, of_graph
from cordicc.rewrite.search.realisations import Found, Realisations
from cordicc.rewrite.search.start import sample_points

_POINTS = 1000
"""Samples on which realisations are compared, besides those near singular points."""

_TRIED = 6
"""Realisations of the search that are compared on fixed point, where none of them is accurate enough."""

_ABOUT = 4.0
"""How much less accurate one of them may be anywhere than the most accurate of them there."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A graph of unit operations, whether it is proven the cheapest alternative, each node's steps.

    `facts`: the texts of the assumptions that it rests on.
    """

    graph: Graph
    proven: bool = False
    searched: bool = False
    steps: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    facts: tuple[str, ...] = ()


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
    points = sample_points(problem, bases, _POINTS, costs.words)
    if points is None:
        return Choice(graph)
    gate = AccuracyGate(problem, graph, points, costs.words)
    if not costs.floating:
        # Fixed point has no digits to spare for products of denominators.
        realisations = Realisations(problem, context, bases, costs, lift=False)
        return _most_fitting(realisations, graph, gate, context, costs)
    least = of_graph(graph, costs, context.goal)
    for lift in (True, False):
        realisations = Realisations(problem, context, bases, costs, lift=lift)
        found, first = realisations.best(), True
        if found is None:
            return Choice(graph)
        while found is not None:
            made = _on_units(found, context, costs)
            if of_graph(made, costs, context.goal) >= least:
                if first:
                    return Choice(graph, proven=found.proven, searched=True)
                break
            inaccurate = gate.less_accurate(made)
            if inaccurate is None:
                return _chosen(found, made, costs)
            _ban_culprit(realisations, found, made, gate, inaccurate, costs)
            found, first = realisations.best(), False
    return Choice(graph, searched=True)


def _on_units(found: Found, context: PassContext, costs: Costs) -> Graph:
    """Return a realisation in the units that may be used."""
    made = found.graph if costs.implicit else StandardChains().apply(found.graph, context)
    verify(made)
    return made


def _chosen(found: Found, made: Graph, costs: Costs) -> Choice:
    steps = found.steps if costs.implicit else {}
    return Choice(made, found.proven, True, steps, found.facts)


def _ban_culprit(
    realisations: Realisations,
    found: Found,
    made: Graph,
    gate: AccuracyGate,
    inaccurate: tuple[str, int],
    costs: Costs,
) -> None:
    """Take no more what costs a realisation its accuracy at an output's sample, if it is a choice."""
    # In chains of standard units results are no longer those of the search.
    among = realisations.may_be_banned(found) if costs.implicit else ()
    blamed = gate.culprit(made, *inaccurate, among) if among else None
    if blamed is not None:
        realisations.ban(found, blamed)


def _most_fitting(
    realisations: Realisations, graph: Graph, gate: AccuracyGate, context: PassContext, costs: Costs
) -> Choice:
    """Return the cheapest realisation that is as accurate as fixed-point words can be.

    Where none is, the cheapest of those tried that is about as accurate everywhere as the best of them.

    Args:
        realisations: what the search finds.
        graph: the realisation of the passes.
        gate: judges them.
        context: the goal.
        costs: what operations cost.
    """
    tried = [(of_graph(graph, costs, context.goal), gate.ratios(graph), Choice(graph, searched=True))]
    found = realisations.best()
    if found is None:
        return Choice(graph)
    while found is not None and len(tried) <= _TRIED:
        made = _on_units(found, context, costs)
        cost, ratios = of_graph(made, costs, context.goal), gate.ratios(made)
        if len(tried) == 1 and found.proven and cost >= tried[0][0]:
            tried[0] = *tried[0][:2], replace(tried[0][2], proven=True)
        tried.append((cost, ratios, _chosen(found, made, costs)))
        inaccurate = worst_of(ratios)
        if inaccurate is None or (cost >= tried[0][0] and worst_of(tried[0][1]) is None):
            break
        _ban_culprit(realisations, found, made, gate, inaccurate, costs)
        found = realisations.best()
    tried.sort(key=lambda each: each[0])  # of equal costs the passes' comes first
    least = {name: np.min([ratios[name] for _, ratios, _ in tried], axis=0) for name in graph.outputs}
    for _, ratios, choice in tried:
        if all(np.all(ratios[name] <= np.maximum(1.0, _ABOUT * least[name])) for name in least):
            return choice
    return min(tried, key=lambda each: max(float(np.max(own)) for own in each[1].values()))[2]
