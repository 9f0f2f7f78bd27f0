"""Solves with `branch: all`: every equation that depends on one is there once for each combination."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product

from cordicc.base.diagnostics import Report, Span
from cordicc.expressions.syntax import Relation, postorder
from cordicc.frontend.plain.plain_equation import CHECK, ParsedEquation
from cordicc.frontend.solving.solve import SolveRequest
from cordicc.frontend.trees import renamed

ALL = "all"
MAX_CHOICES = 4
MAX_NODES = 200_000
"""Names, numbers and operations in all the equations that are made."""

_LETTERS = {"p": "+", "m": "-"}
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")

Choice = Span
"""A solve with both branches, by its place."""

Meaning = Callable[[str], str]
"""Gives the name that a name has for a choice of branches."""


def with_alternatives(
    parsed: Sequence[ParsedEquation], report: Report
) -> tuple[list[ParsedEquation], dict[str, list[str]]]:
    """Return the equations with one branch each, and the names that each name has become.

    A name ends in a letter for each solve it depends on, in the order of the solves: p for the branch
    +, m for the branch -.
    """
    choices: dict[str, tuple[Choice, ...]] = {}
    made: list[ParsedEquation] = []
    variants: dict[str, list[str]] = {}
    nodes = 0
    for equation in parsed:
        own = _choices(equation, choices)
        if not own:
            made.append(equation)
            continue
        nodes += _size(equation) << min(len(own), MAX_CHOICES)
        if len(own) > MAX_CHOICES or nodes > MAX_NODES:
            shown = equation.target.removeprefix(CHECK)
            message = f"'{shown}' depends on more than {MAX_CHOICES} solves with all branches"
            if len(own) <= MAX_CHOICES:
                message = f"all branches make equations of more than {MAX_NODES} operations"
            report.error("E104", message, equation.span, "choose a branch for some of them")
            return made, variants
        choices[equation.target] = own
        if equation.label:
            choices.setdefault(equation.label, own)
        for letters in product("pm", repeat=len(own)):
            clone = _clone(equation, dict(zip(own, letters, strict=True)), choices)
            made.append(clone)
            if not equation.hidden:
                variants.setdefault(equation.target, []).append(clone.target)
    return made, variants


def _choices(equation: ParsedEquation, choices: Mapping[str, tuple[Choice, ...]]) -> tuple[Choice, ...]:
    """Return the solves with both branches on which an equation depends, in order."""
    found = {choice for name in equation.names for choice in choices.get(name, ())}
    if equation.request is not None and equation.request.branch == ALL:
        found.add(equation.request.span)
    return tuple(sorted(found))


def _size(equation: ParsedEquation) -> int:
    """Return how many parts the expressions of an equation have."""
    sides = [] if equation.definition is None else [equation.definition[0]]
    if equation.request is not None:
        sides = [side for r, _ in equation.request.all_relations for side in (r.left, r.right)]
    return sum(len(postorder(side)) for side in sides)


def _clone(
    equation: ParsedEquation,
    letters: Mapping[Choice, str],
    choices: Mapping[str, tuple[Choice, ...]],
) -> ParsedEquation:
    """Return the equation for one choice of each branch."""

    def meaning(name: str) -> str:
        own = choices.get(name, ())
        return f"{name}_{''.join(letters[choice] for choice in own)}" if own else name

    written = _NAME.sub(lambda match: meaning(match[0]), equation.written)
    definition, request = equation.definition, equation.request
    if definition is not None:
        definition = (renamed(definition[0], meaning), definition[1])
    if request is not None:
        request, written = _request(request, written, letters, meaning)
    depends = None if equation.depends is None else frozenset(map(meaning, equation.depends))
    return replace(
        equation, target=meaning(equation.target), written=written, definition=definition,
        request=request, label=meaning(equation.label), depends=depends,
    )  # fmt: skip


def _request(
    request: SolveRequest, written: str, letters: Mapping[Choice, str], meaning: Meaning
) -> tuple[SolveRequest, str]:
    """Return the request of a clone, and its text."""

    def side(relation: Relation) -> Relation:
        return replace(relation, left=renamed(relation.left, meaning), right=renamed(relation.right, meaning))

    equations = [(side(relation), text) for relation, text in request.equations]
    condition = request.condition and (side(request.condition[0]), request.condition[1])
    branch = request.branch
    if branch == ALL:
        branch = _LETTERS[letters[request.span]]
        written = f"{written.removesuffix(ALL)}{branch}"
    together = tuple(map(meaning, request.together))
    changed = replace(
        request, equations=equations, unknown=meaning(request.unknown), branch=branch,
        together=together, condition=condition,
    )  # fmt: skip
    return changed, written
