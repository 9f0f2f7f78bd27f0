"""The equations of a file: parsed all at once, then taken in order."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from cordicc.diagnostics import Report, Span
from cordicc.frontend.lexer import ExpressionError
from cordicc.frontend.lower import ANGLE, LinearForm, linear_form, lower_all
from cordicc.frontend.reading import NAME, check_keys, wanted
from cordicc.frontend.scope import MAX_ERRORS, Scope, Text, nearest
from cordicc.frontend.solve import SolveRequest, solve
from cordicc.frontend.syntax import Expr, Relation, names, parse_definition, parse_relation
from cordicc.frontend.yamltree import NodeKind, Places, YamlNode
from cordicc.frontend.zero import ZeroTest
from cordicc.ir.graph import Value
from cordicc.ir.problem import Equation


@dataclass(frozen=True, slots=True)
class ParsedEquation:
    """An equation or solve before its names are looked up; `target` alone is set if it is malformed."""

    target: str
    span: Span
    written: str
    definition: tuple[Expr, Text] | None = None
    request: SolveRequest | None = None

    @property
    def uses(self) -> frozenset[str]:
        """Return the names on which the definition depends."""
        sides: list[Expr] = []
        if self.definition is not None:
            return frozenset(n.name for n in names(self.definition[0]))
        if self.request is not None:
            for relation, _ in self.request.equations:
                sides += [relation.left, relation.right]
        return frozenset(n.name for side in sides for n in names(side)) - {self.target}


@dataclass(slots=True)
class Defined:
    """What the equations define, in order."""

    equations: list[Equation] = field(default_factory=list)
    uses: dict[str, frozenset[str]] = field(default_factory=dict)
    forms: dict[str, LinearForm] = field(default_factory=dict)
    spans: dict[str, Span] = field(default_factory=dict)
    targets: list[str] = field(default_factory=list)
    order: dict[str, int] = field(default_factory=dict)


def parse_equations(node: YamlNode, places: Places, report: Report) -> list[ParsedEquation]:
    """Return the equations of the list `node`; malformed ones are reported."""
    if node.kind is not NodeKind.SEQUENCE:
        hint = "each equation is an item: '- y = 2*x'"
        report.error("E202", wanted("'equations'", "a list", node), node.span, hint)
        return []
    if not node.items:
        report.error("E208", "there are no equations", node.span)
    parsed = []
    for item in node.items:
        if report.errors >= MAX_ERRORS:
            break
        if item.kind is NodeKind.MAPPING:
            equation = _parse_solve(item, places, report)
        elif item.kind is NodeKind.SCALAR and not item.is_null:
            equation = _parse_definition(Text(item, places), report)
        else:
            report.error("E202", wanted("an equation", "'name = expression'", item), item.span)
            continue
        if equation is not None:
            parsed.append(equation)
    return parsed


def _parse_definition(text: Text, report: Report) -> ParsedEquation | None:
    written = " ".join(text.node.value.split())
    try:
        target, expr = parse_definition(text.node.value)
    except ExpressionError as error:
        text.report(report, error)
        target_text = re.match(r"\s*([A-Za-z_][A-Za-z0-9_]*)\s*=(?!=)", text.node.value)
        return ParsedEquation(target_text[1], text.node.span, written) if target_text else None
    return ParsedEquation(target.name, text.span(target.at), written, (expr, text))


def _parse_solve(item: YamlNode, places: Places, report: Report) -> ParsedEquation | None:
    keys = [key.value for key, _ in item.pairs]
    if not any(nearest(key, ["solve"]) for key in keys):
        hint = f"write '{keys[0]} = ...'" if len(keys) == 1 and NAME.fullmatch(keys[0]) else None
        message = "an equation is 'name = expression', or a mapping with 'solve' and 'for'"
        report.error("E202", message, item.span, hint)
        return None
    entries = check_keys(item, ("solve", "for", "branch"), report)
    solve_node, for_node, branch_node = (entries.get(key) for key in ("solve", "for", "branch"))
    if solve_node is None:  # a key that is near 'solve' but nearer to another
        return None
    relations = _parse_relations(solve_node, places, report)
    if for_node is None:
        hint = "add 'for: NAME' with the unknown"
        report.error("E208", "'solve' without 'for'", solve_node.span, hint)
        return None
    if for_node.kind is not NodeKind.SCALAR or not NAME.fullmatch(for_node.value):
        report.error("E207", "'for' must be the name of the unknown", for_node.span)
        return None
    unknown, branch = for_node.value, None
    if branch_node is not None:
        branch = branch_node.value if branch_node.kind is NodeKind.SCALAR else "?"
    written = _written(solve_node, unknown, branch)
    if relations is None:
        return ParsedEquation(unknown, for_node.span, written)
    branch_span = branch_node.span if branch_node is not None else solve_node.span
    request = SolveRequest(relations, unknown, branch, solve_node.span, branch_span)
    return ParsedEquation(unknown, for_node.span, written, request=request)


def _parse_relations(node: YamlNode, places: Places, report: Report) -> list[tuple[Relation, Text]] | None:
    items: Sequence[YamlNode] = (node,)
    if node.kind is NodeKind.SEQUENCE:
        items = node.items
        if len(items) != 2:
            hint = "put quotes around an equation that contains commas" if len(items) > 2 else None
            message = f"'solve' takes one equation or a pair, not {len(items)}"
            report.error("E202", message, node.span, hint)
            return None
    relations = []
    for item in items:
        if item.kind is not NodeKind.SCALAR or item.is_null:
            report.error("E202", wanted("'solve'", "an equation 'A = B'", item), item.span)
            continue
        text = Text(item, places)
        try:
            relations.append((parse_relation(item.value), text))
        except ExpressionError as error:
            text.report(report, error)
    return relations if len(relations) == len(items) else None


def _written(node: YamlNode, unknown: str, branch: str | None) -> str:
    if node.kind is NodeKind.SEQUENCE:
        body = "[" + ", ".join(" ".join(item.value.split()) for item in node.items) + "]"
    else:
        body = " ".join(node.value.split())
    return f"solve {body} for {unknown}" + (f", branch {branch}" if branch is not None else "")


def define_equations(parsed: Sequence[ParsedEquation], scope: Scope, zeros: ZeroTest) -> Defined:
    """Add the names the equations define to the scope, and return what is known of them."""
    defined = Defined()
    first = {e.target: e for e in reversed(parsed) if e.target not in scope.lines}
    scope.later = {name: (e.span.line, e.uses) for name, e in first.items()}
    for equation in parsed:
        if scope.report.errors >= MAX_ERRORS:
            break
        target, line = equation.target, equation.span.line
        if not scope.check_new(target, equation.span, line):
            continue
        scope.builder.origin = target
        value, form = _value(equation, scope, zeros)
        scope.later.pop(target, None)
        scope.define(target, value, line)
        defined.equations.append(Equation(target, equation.written, line))
        defined.order[target] = len(defined.targets)
        defined.targets.append(target)
        defined.uses[target] = equation.uses
        defined.spans[target] = equation.span
        defined.forms[target] = form or LinearForm()
    scope.builder.origin = ""
    return defined


def _value(equation: ParsedEquation, scope: Scope, zeros: ZeroTest) -> tuple[Value | None, LinearForm | None]:
    if equation.request is not None:
        solved = solve(equation.request, scope, zeros)
        if solved is None:
            return None, None
        return solved[0], ANGLE if solved[1] == 1 else None
    if equation.definition is None:
        return None, None
    expr, text = equation.definition
    values = lower_all(expr, scope, text, equation.target)
    if values[id(expr)] is None:
        return None, None
    return values[id(expr)], linear_form(expr, values, scope.builder)
