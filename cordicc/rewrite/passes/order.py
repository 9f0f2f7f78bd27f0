"""The passes in their order, each with the reason for its place."""

from __future__ import annotations

from cordicc.ir.graph import Graph
from cordicc.rewrite.passes.base import Pass, PassContext
from cordicc.rewrite.passes.implicit_forms import ImplicitForms
from cordicc.rewrite.passes.quotients import Quotients
from cordicc.rewrite.passes.rotations import Rotations
from cordicc.rewrite.passes.selections import Selections
from cordicc.rewrite.passes.simplify import Simplify
from cordicc.rewrite.passes.standard_chains import StandardChains
from cordicc.rewrite.passes.vectorings import Vectorings
from cordicc.rewrite.passes.wraps import DropWraps


def default_passes(*, implicit: bool) -> tuple[Pass, ...]:
    """Return the passes from the equations as written to unit operations.

    `implicit` tells whether implicit CAUs may be used.
    """
    return (
        DropWraps(),  # needs the inverse functions still in sight
        Simplify(),  # one shape for constant factors, signs and powers, on which the patterns rest
        Selections(),  # before anything is made of what is never selected; sees squares as products
        ImplicitForms(),  # takes quotients inside acos and asin before they become CAUs
        Vectorings(),  # takes quotients inside atan and log; reads squares before they become mul
        Rotations(),  # after Vectorings, so that sums under a root are seen as lengths first
        *(() if implicit else (StandardChains(),)),  # the whole circle of implicit forms is known now
        Quotients(),  # last: no pattern wants the remaining quotients
    )


def through_passes(graph: Graph, context: PassContext, *, implicit: bool) -> Graph:
    """Return what the passes make of a graph, one after the other; `implicit` as in `default_passes`."""
    for step in default_passes(implicit=implicit):
        graph = step.apply(graph, context)
    return graph
