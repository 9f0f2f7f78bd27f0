"""Reads the items `solve`: the equations, their unknowns, and the branch or its condition."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Call, Relation, parse_relation, postorder
from cordicc.frontend.document.yamltree import NodeKind, YamlNode
from cordicc.frontend.plain.alternatives import ALL
from cordicc.frontend.plain.context import EquationContext, one_line
from cordicc.frontend.plain.expansion import Expansion
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.plain.vectors import Vectors, uses_vectors
from cordicc.frontend.reading import NAME, check_keys, wanted
from cordicc.frontend.scope import Text
from cordicc.frontend.solving.branches import CONDITIONS
from cordicc.frontend.solving.solve import SolveRequest
from cordicc.frontend.trees import check_size, relocated

Relations = list[tuple[Relation, Text]]


def parse_solve(item: YamlNode, context: EquationContext) -> list[ParsedEquation]:
    """Return the equations of a solve, one for each unknown; mistakes are reported."""
    report = context.report
    entries = check_keys(item, ("solve", "for", "branch"), report)
    solve_node, for_node, branch_node = (entries.get(key) for key in ("solve", "for", "branch"))
    if solve_node is None:  # a key that is near 'solve' but nearer to another
        return []
    nodes = () if for_node is None else _unknowns(for_node, context)
    unknowns = tuple(node.value for node in nodes)
    make = context.expansion(item, unknowns[0] if unknowns else "", frozenset(unknowns))
    relations = _relations(solve_node, context, make, len(unknowns))
    if for_node is None:
        hint = "add 'for: NAME' with the unknown"
        report.error("E208", "'solve' without 'for'", solve_node.span, hint)
        return []
    branch, condition = None, None
    if branch_node is not None:
        branch = branch_node.value if branch_node.kind is NodeKind.SCALAR else "?"
    if branch_node is not None and branch is not None and re.search("[<>]", branch):
        condition = _condition(branch_node, context, make)
        relations = relations if condition is not None else None
    if context.all_branches and relations is not None:
        chosen = branch in ("+", "-") or condition is not None
        if chosen or (branch is None and _has_branches(relations, len(unknowns))):
            branch, condition = ALL, None
    shown = unknowns[0] if len(unknowns) == 1 else one_line(for_node, context.places)
    written = _written(solve_node, shown, branch)
    if relations is None:
        return [ParsedEquation(node.value, node.span, written) for node in nodes]
    branch_span = branch_node.span if branch_node is not None else solve_node.span
    together = unknowns if len(unknowns) > 1 else ()
    made: list[ParsedEquation] = [*make.hidden]
    for node in nodes:
        request = SolveRequest(
            relations, node.value, branch, solve_node.span, branch_span, together, condition
        )
        equation = ParsedEquation(node.value, node.span, written, request=request)
        made.append(replace(equation, depends=make.depends(equation.names)))
    return made


def _has_branches(relations: Relations, unknowns: int) -> bool:
    """Return whether there are two solutions for sure: cosh and sinh may have one, as has a pair."""
    calls = {
        part.function
        for relation, _ in relations
        for side in (relation.left, relation.right)
        for part in postorder(side)
        if isinstance(part, Call)
    }
    return len(relations) == unknowns and calls.isdisjoint(("cosh", "sinh"))


def _condition(node: YamlNode, context: EquationContext, make: Expansion) -> tuple[Relation, Text] | None:
    """Return the condition that a branch is chosen by; None after a diagnostic."""
    found = _relation(node, CONDITIONS, context, make)
    if found is not None and len(found) > 1:
        message = "a condition compares numbers, not vectors"
        context.report.error("E310", message, node.span)
        return None
    return None if found is None else found[0]


def _unknowns(node: YamlNode, context: EquationContext) -> Sequence[YamlNode]:
    """Return the names of the unknowns, one or two; none after a diagnostic."""
    report = context.report
    nodes = node.items if node.kind is NodeKind.SEQUENCE else (node,)
    if any(n.kind is not NodeKind.SCALAR or n.is_null or not NAME.fullmatch(n.value) for n in nodes):
        report.error("E207", "'for' must be the name of the unknown", node.span)
        return ()
    if node.kind is NodeKind.SEQUENCE and (len(nodes) != 2 or nodes[0].value == nodes[1].value):
        message = "'for' takes the name of the unknown, or two names for coupled equations"
        report.error("E207", message, node.span)
        return ()
    return nodes


def _relations(node: YamlNode, context: EquationContext, make: Expansion, unknowns: int) -> Relations | None:
    """Return the one or two equations of a solve; None after diagnostics."""
    report = context.report
    items: Sequence[YamlNode] = (node,)
    if node.kind is NodeKind.SEQUENCE:
        items = node.items
        if len(items) != 2:
            hint = "put quotes around an equation that contains commas" if len(items) > 2 else None
            message = f"'solve' takes one equation or a pair, not {len(items)}"
            report.error("E202", message, node.span, hint)
            return None
    relations: Relations = []
    failed = False
    for item in items:
        if item.kind is not NodeKind.SCALAR or item.is_null:
            report.error("E202", wanted("'solve'", "an equation 'A = B'", item), item.span)
            failed = True
            continue
        found = _relation(item, ("=",), context, make)
        relations += found or []
        failed = failed or found is None
    if failed:
        return None
    if unknowns == 2 and len(relations) != 2:
        hint = "write solve: [eq1, eq2], or one equation of vectors [x, y]"
        report.error("E202", "two unknowns need two equations", node.span, hint)
        return None
    if len(relations) > 2:
        message = f"these are {len(relations)} equations, one for each component of a vector"
        report.error("E202", message, node.span, "'solve' takes one equation or two")
        return None
    return relations


def _relation(
    node: YamlNode, kinds: tuple[str, ...], context: EquationContext, make: Expansion
) -> Relations | None:
    """Return a relation, one for each component if it is of vectors; None after a diagnostic."""
    text = Text(node, context.places)
    try:
        relation = parse_relation(node.value, kinds, vectors=True)
    except ExpressionError as error:
        text.report(context.report, error)
        return None
    if not any(uses_vectors(side, context.vectors) for side in (relation.left, relation.right)):
        return [(relation, text)]
    vectors = Vectors(context.vectors, make)
    try:
        left, right = (vectors.expand(relocated(side, text)) for side in (relation.left, relation.right))
        many = [side if isinstance(side, tuple) else (side,) for side in (left, right)]
        if isinstance(left, tuple) != isinstance(right, tuple) or len(many[0]) != len(many[1]):
            message = "the sides must be vectors of as many components, or numbers"
            text.report(context.report, ExpressionError("E310", message, *relation.at))
            return None
        for part in (*many[0], *many[1]):
            check_size(part)
    except ExpressionError as error:
        make.text.report(context.report, error)
        return None
    at = context.places.offsets(node, *relation.at) or (node.start, node.end)
    pairs = zip(many[0], many[1], strict=True)
    return [(replace(relation, left=a, right=b, at=at), make.text) for a, b in pairs]


def _written(node: YamlNode, unknown: str, branch: str | None) -> str:
    """Return the text of a solve in one line."""
    if node.kind is NodeKind.SEQUENCE:
        body = "[" + ", ".join(" ".join(item.value.split()) for item in node.items) + "]"
    else:
        body = " ".join(node.value.split())
    return f"solve {body} for {unknown}" + (f", branch {branch}" if branch is not None else "")
