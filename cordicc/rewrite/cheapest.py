"""The realisation that is compiled: the search's, if it is cheaper and as accurate as that of the passes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from cordicc.ir.graph import Graph
from cordicc.ir.problem import Problem
from cordicc.ir.well_formed import verify
from cordicc.rewrite.accuracy_gate import AccuracyGate
from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.passes.order import default_passes
from cordicc.rewrite.passes.standard_chains import StandardChains
from cordicc.rewrite.search.costs import Costs, of_graph
from cordicc.rewrite.search.realisations import Realisations
from cordicc.rewrite.search.start import sample_points

STOPPED = "all alternatives: the choice among them found none within its work"

_POINTS = 1000
"""Samples on which realisations are compared, besides those near singular points."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A graph of unit operations, whether it is proven the cheapest alternative, each node's steps.

    `facts`: the texts of the assumptions that it rests on.  `left_out`: what was not among the alternatives,
    or turned down, in words.
    """

    graph: Graph
    proven: bool = False
    searched: bool = False
    steps: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    facts: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()


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
    least = of_graph(graph, costs, context.goal)
    gate = AccuracyGate(problem, graph, points)
    turned_down = 0
    left_out: list[str] = []
    # Fixed point has no digits to spare for products of denominators.
    for lift in (True, False) if costs.floating else (False,):
        realisations = Realisations(problem, context, bases, costs, lift=lift)
        left_out = realisations.left_out
        found, first = realisations.best(), True
        if found is None:
            return Choice(graph, left_out=_words(left_out or [STOPPED], turned_down))
        while found is not None:
            made = found.graph if costs.implicit else StandardChains().apply(found.graph, context)
            verify(made)
            cheaper = of_graph(made, costs, context.goal) < least
            if not cheaper and first:
                return Choice(graph, found.proven, searched=True, left_out=_words(left_out, turned_down))
            if not cheaper:
                break
            inaccurate = gate.less_accurate(made)
            if inaccurate is None:
                steps = found.steps if costs.implicit else {}
                said = _words(left_out, turned_down)
                return Choice(made, found.proven, True, steps, found.facts, said)
            turned_down += 1
            # In chains of standard units results are no longer those of the search.
            among = realisations.may_be_banned(found) if costs.implicit else ()
            blamed = gate.culprit(made, *inaccurate, among) if among else None
            if blamed is not None:
                realisations.ban(found, blamed)
            found, first = realisations.best(), False
    return Choice(graph, searched=True, left_out=_words(left_out, turned_down))


def _words(left_out: Sequence[str], turned_down: int) -> tuple[str, ...]:
    """Return what was left out, with how many cheaper realisations were turned down."""
    if not turned_down:
        return tuple(left_out)
    choices = "choice of operations" if turned_down == 1 else "choices of operations"
    return (*left_out, f"{turned_down} cheaper {choices}, with which rounding would move an output too far")
