"""The items of `equations`: definitions, vectors, tables of joints and solves, as plain equations."""

from __future__ import annotations

from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import parse_definition
from cordicc.frontend.document.yamltree import NodeKind, YamlNode
from cordicc.frontend.plain.context import TARGET, EquationContext, failed
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.plain.vectors import Vectors, component_names, uses_vectors
from cordicc.frontend.read_solve import parse_solve
from cordicc.frontend.reading import NAME, check_keys, wanted
from cordicc.frontend.robots.read_dh import parse_table
from cordicc.frontend.scope import MAX_ERRORS, Text, nearest
from cordicc.frontend.trees import relocated

_KINDS = ("solve", "vector", "dh")


def parse_equations(node: YamlNode, context: EquationContext) -> list[ParsedEquation]:
    """Return the equations of the list `node`; malformed ones are reported."""
    report = context.report
    if node.kind is not NodeKind.SEQUENCE:
        hint = "each equation is an item: '- y = 2*x'"
        report.error("E202", wanted("'equations'", "a list", node), node.span, hint)
        return []
    if not node.items:
        report.error("E208", "there are no equations", node.span)
    parsed: list[ParsedEquation] = []
    for item in node.items:
        if report.errors >= MAX_ERRORS:
            break
        if item.kind is NodeKind.MAPPING:
            parsed += _parse_mapping(item, context)
        elif item.kind is NodeKind.SCALAR and not item.is_null:
            parsed += _parse_definition(Text(item, context.places), context)
        else:
            report.error("E202", wanted("an equation", "'name = expression'", item), item.span)
    return parsed


def _parse_definition(text: Text, context: EquationContext) -> list[ParsedEquation]:
    written = " ".join(text.node.value.split())
    try:
        target, expr = parse_definition(text.node.value, vectors=True)
    except ExpressionError as error:
        text.report(context.report, error)
        match = TARGET.match(text.node.value)
        return [ParsedEquation(match[1], text.node.span, written)] if match else []
    span = text.span(target.at)
    if not uses_vectors(expr, context.vectors):
        return [ParsedEquation(target.name, span, written, (expr, text))]
    make = context.expansion(text.node, target.name)
    try:
        plain = Vectors(context.vectors, make).scalar(relocated(expr, text))
        return [*make.hidden, make.equation(target.name, plain, span, written)]
    except ExpressionError as error:
        make.text.report(context.report, error)
        return [ParsedEquation(target.name, span, written)]


def _parse_mapping(item: YamlNode, context: EquationContext) -> list[ParsedEquation]:
    keys = [key.value for key, _ in item.pairs]
    kind = next((near for key in keys if (near := nearest(key, _KINDS))), None)
    if kind is None:
        hint = f"write '{keys[0]} = ...'" if len(keys) == 1 and NAME.fullmatch(keys[0]) else None
        message = "an equation is 'name = expression', or a mapping with 'solve' and 'for'"
        context.report.error("E202", message, item.span, hint)
        return []
    if kind == "solve":
        return parse_solve(item, context)
    node = check_keys(item, (kind,), context.report).get(kind)
    if node is None:
        return []
    if kind == "dh":
        return parse_table(node, item.pairs[0][0].span, context)
    return _parse_vector(node, context)


def _parse_vector(node: YamlNode, context: EquationContext) -> list[ParsedEquation]:
    if node.kind is not NodeKind.SCALAR or node.is_null:
        form = "write 'vector: p = [x, y, z]'"
        context.report.error("E202", wanted("'vector'", "'name = vector'", node), node.span, form)
        return []
    text = Text(node, context.places)
    written = " ".join(node.value.split())
    try:
        target, expr = parse_definition(node.value, vectors=True)
    except ExpressionError as error:
        text.report(context.report, error)
        match = TARGET.match(node.value)
        if not match:
            return []
        context.vectors[match[1]] = 3
        return failed(match[1], component_names(match[1], 3), node.span, written)
    make = context.expansion(node, target.name)
    span = text.span(target.at)
    try:
        components = Vectors(context.vectors, make).vector(relocated(expr, text))
        named = zip(component_names(target.name, len(components)), components, strict=True)
        equations = [make.equation(name, part, span, written) for name, part in named]
    except ExpressionError as error:
        make.text.report(context.report, error)
        context.vectors[target.name] = 3
        return failed(target.name, component_names(target.name, 3), span, written)
    context.vectors[target.name] = len(components)
    return [*make.hidden, *equations]
