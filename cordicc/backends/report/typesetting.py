"""Texts of the user and sentences about them, typeset: from syntax trees to MathML."""

from __future__ import annotations

import re

from cordicc.backends.text import mathml
from cordicc.backends.text.mathml import Formula
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.quantities import FACTORS
from cordicc.expressions.syntax import (
    Call,
    Expr,
    Name,
    Neg,
    Number,
    Power,
    Product,
    Relation,
    Sum,
    Vector,
    children,
    parse_relation,
    postorder,
)

LONGEST = 4_000
"""Characters of a text that is typeset; longer ones are shown as they are written."""

_DOTS = "and_so_on"
_RELATIONS = ("=", ">", "<", ">=", "<=")
_SOLVE = re.compile(r"solve (?P<relations>.+) for (?P<unknowns>\S+|\[[^\]]*\])(?P<branch>, branch .+)?")


def typeset(text: str) -> str | None:
    """Return a formula, an equation or a `solve` as HTML, None for what is none of them or too long."""
    text = " ".join(text.split())
    if len(text) > LONGEST:
        return None
    try:
        solve = _SOLVE.fullmatch(text)
        if solve is None:
            return _formula(text).html()
        parts = [_formula(each).html() for each in _listed(solve["relations"])]
        unknowns = [mathml.name(each.strip()).html() for each in solve["unknowns"].strip("[]").split(",")]
    except ExpressionError:
        return None
    branch = "" if solve["branch"] is None else _branch(solve["branch"].removeprefix(", branch "))
    return f'{" and ".join(parts)} <span class="for">solved for {" and ".join(unknowns)}{branch}</span>'


def _branch(text: str) -> str:
    """Return a branch: a sign, or the condition that picks it."""
    if text in ("+", "-"):
        return f", branch {'−' if text == '-' else '+'}"
    return f", branch {_formula(text).html()}"


def _listed(text: str) -> list[str]:
    """Return the equations of a solve: one, or several in brackets."""
    inside = text[1:-1] if text.startswith("[") and text.endswith("]") else ""
    if "=" not in inside:
        return [text]
    # Only commas outside all brackets part one equation from the next.
    parts, depth = [""], 0
    for sign in inside:
        depth += (sign in "([") - (sign in ")]")
        if sign == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += sign
    return [part.strip() for part in parts]


def _formula(text: str) -> Formula:
    """Return an expression or a relation, in which `...` may stand for terms; raises ExpressionError."""
    text = text.replace("...", _DOTS)
    if not any(sign in text for sign in "=<>"):
        return _tree(parse_relation(f"{text} = 0", vectors=True).left)
    relation: Relation = parse_relation(text, _RELATIONS, vectors=True)
    return mathml.relation(_tree(relation.left), relation.relation, _tree(relation.right))


def _tree(expr: Expr) -> Formula:
    """Return a syntax tree as a formula."""
    made: dict[int, Formula] = {}
    for part in postorder(expr):
        made[id(part)] = _node(part, [made[id(child)] for child in children(part)])
    return made[id(expr)]


def _node(expr: Expr, parts: list[Formula]) -> Formula:
    match expr:
        case Number(value, unit=unit):
            return mathml.quantity(value / FACTORS[unit], unit) if unit else mathml.number(value)
        case Name(name):
            signs = {"deg": "°", _DOTS: "⋯"}
            return mathml.words(signs[name]) if name in signs else mathml.name(name)
        case Neg():
            return mathml.negative(parts[0])
        case Sum(_, signs):
            return mathml.total(parts, signs)
        case Product(_, signs):
            return mathml.product(parts, signs)
        case Power():
            return mathml.power(parts[0], parts[1])
        case Call(function, _):
            return mathml.call(function, parts)
        case Vector():
            return mathml.vector(parts)
