"""Syntax trees taken apart and put together again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import (
    Call,
    Expr,
    Name,
    Neg,
    Number,
    Place,
    Power,
    Product,
    Sum,
    Vector,
    children,
    postorder,
)
from cordicc.frontend.scope import FileText, Text

MAX_TREE = 20_000
"""Nodes of the longest expression that expansion may make."""


def rebuilt(expr: Expr, parts: Sequence[Expr], at: Place | None = None) -> Expr:
    """Return the expression with other direct subexpressions, and another place if one is given."""
    at = expr.at if at is None else at
    match expr:
        case Number() | Name():
            return replace(expr, at=at)
        case Neg():
            return Neg(parts[0], at)
        case Sum(_, signs):
            return Sum(tuple(parts), signs, at)
        case Product(_, signs):
            return Product(tuple(parts), signs, at)
        case Power():
            return Power(parts[0], parts[1], at)
        case Call(function, _):
            return Call(function, tuple(parts), at)
        case Vector():
            return Vector(tuple(parts), at)


def relocated(expr: Expr, text: Text) -> Expr:
    """Return the expression of a scalar with offsets into the file as its places."""
    if isinstance(text, FileText):
        return expr
    made: dict[int, Expr] = {}
    for part in postorder(expr):
        at = text.places.offsets(text.node, *part.at) or (text.node.start, text.node.end)
        made[id(part)] = rebuilt(part, [made[id(child)] for child in children(part)], at)
    return made[id(expr)]


def renamed(expr: Expr, meaning: Callable[[str], str]) -> Expr:
    """Return the expression with other names."""
    made: dict[int, Expr] = {}
    for part in postorder(expr):
        if isinstance(part, Name):
            made[id(part)] = Name(meaning(part.name), part.at)
        else:
            made[id(part)] = rebuilt(part, [made[id(child)] for child in children(part)])
    return made[id(expr)]


def check_size(expr: Expr) -> None:
    """Raise ExpressionError if a tree, shared parts counted each time, is too large."""
    todo, count = [expr], 0
    while todo:
        count += 1
        if count > MAX_TREE:
            hint = "define its parts as vectors of their own, each with a name"
            raise ExpressionError("E104", f"it expands to more than {MAX_TREE} operations", *expr.at, hint)
        todo.extend(children(todo.pop()))
