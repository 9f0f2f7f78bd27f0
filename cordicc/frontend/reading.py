"""Small helpers to read typed things from YAML nodes, with diagnostics."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction

from cordicc.base.diagnostics import InvalidInput, Report, Source, Span
from cordicc.expressions.lexer import MAX_NAME, ExpressionError
from cordicc.expressions.syntax import parse_expression
from cordicc.frontend.document.yamltree import NodeKind, Places, YamlNode
from cordicc.frontend.lower import lower
from cordicc.frontend.scope import MAX_ERRORS, Scope, Text, nearest
from cordicc.ir.graph import Builder

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_BOOLEANS = {"true": True, "false": False}


def wanted(what: str, form: str, node: YamlNode) -> str:
    """Return the message that something has the wrong type."""
    return f"{what} must be {form}, not {node.described}"


def check_keys(node: YamlNode, known: Sequence[str], report: Report) -> dict[str, YamlNode]:
    """Return the values of a mapping by key; report the keys that are not known.

    A misspelt key stands for the one that is meant, unless that is there too.
    """
    entries = {key.value: value for key, value in node.pairs if key.value in known}
    for key, value in node.pairs:
        if key.value not in known:
            meant = nearest(key.value, known)
            if meant is not None:
                entries.setdefault(meant, value)
            if report.errors < MAX_ERRORS:
                hint = f"did you mean '{meant}'?" if meant else "the keys are " + ", ".join(known)
                report.error("E201", f"unknown key '{key.value}'", key.span, hint)
    return entries


def read_mapping(node: YamlNode, what: str, form: str, report: Report) -> list[tuple[YamlNode, YamlNode]]:
    """Return the pairs of a mapping; empty after a diagnostic, or for nothing at all."""
    if node.is_null:
        return []
    if node.kind is not NodeKind.MAPPING:
        report.error("E202", wanted(what, "a mapping", node), node.span, form)
        return []
    return list(node.pairs)


def read_text(node: YamlNode, what: str, report: Report, most: int) -> str | None:
    """Return a text of at most so many characters; None after a diagnostic."""
    if node.kind is not NodeKind.SCALAR:
        report.error("E202", wanted(what, "a text", node), node.span)
        return None
    if len(node.value) > most:
        report.error("E104", f"{what} has more than {most} characters", node.span)
        return None
    return node.value


def read_boolean(node: YamlNode, what: str, report: Report) -> bool | None:
    """Return true or false; None after a diagnostic."""
    value = _BOOLEANS.get(node.value.lower()) if node.kind is NodeKind.SCALAR and node.plain else None
    if value is None:
        report.error("E202", f"{what} must be true or false", node.span)
    return value


def check_name(key: YamlNode, scope: Scope) -> bool:
    """Report whether a key can be defined as a name."""
    if not NAME.fullmatch(key.value) or len(key.value) > MAX_NAME:
        hint = "a name is made of the letters A-Z a-z, digits and '_', and starts with no digit"
        if len(key.value) > MAX_NAME:
            hint = f"a name has at most {MAX_NAME} characters"
        scope.report.error("E207", f"'{key.value[:60]}' is not a name", key.span, hint)
        return False
    return scope.check_new(key.value, key.span, key.span.line)


def read_constant(
    node: YamlNode,
    what: str,
    scope: Scope,
    places: Places,
    target: str | None = None,
) -> Fraction | None:
    """Return the number of a constant expression, that of `target` if given; None after a diagnostic.

    A number that stands alone may have a unit of length or angle.
    """
    if node.kind is not NodeKind.SCALAR or node.is_null:
        scope.report.error("E202", wanted(what, "a number or constant expression", node), node.span)
        return None
    text = Text(node, places)
    try:
        expr = parse_expression(node.value)
    except ExpressionError as error:
        text.report(scope.report, error)
        return None
    value = lower(expr, scope, text, target)
    if value is None:
        return None
    number = scope.builder.constant(value)
    if number is None:
        scope.report.error("E212", f"{what} must be constant", text.span(expr.at))
    return number


def option_number(text: str, option: str) -> Fraction:
    """Return the number of an option such as `0.5`, `2**-22` or `3*pi/4`.

    Raises:
        InvalidInput: the text is no constant expression.
    """
    source = Source(option, text)
    report = Report(source)
    node = YamlNode(NodeKind.SCALAR, Span(1, 1, len(text) + 1), 0, len(text), text)
    number = read_constant(node, option, Scope(Builder(), report), Places(source))
    report.raise_if_failed()
    if number is None:
        raise InvalidInput(report.ordered())
    return number
