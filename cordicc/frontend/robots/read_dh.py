"""Reads Denavit-Hartenberg tables."""

from __future__ import annotations

from fractions import Fraction

from cordicc.base.diagnostics import Span
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import Expr, Number, parse_expression
from cordicc.frontend.document.yamltree import NodeKind, YamlNode
from cordicc.frontend.plain.context import EquationContext, failed, one_line
from cordicc.frontend.plain.expansion import Expansion
from cordicc.frontend.plain.plain_equation import ParsedEquation
from cordicc.frontend.plain.vectors import FRAME, Vectors
from cordicc.frontend.reading import NAME, check_keys, wanted
from cordicc.frontend.robots.dh import (
    CONVENTIONS,
    FIELDS,
    MAX_ALL_JOINTS,
    MAX_JOINTS,
    Joint,
    expand_table,
    frame_entries,
)
from cordicc.frontend.scope import Text
from cordicc.frontend.trees import relocated

_KEYS = ("frame", "convention", "joints")
_FORM = "write 'dh: {frame: T, convention: standard, joints: [...]}'"
_JOINT = "write a joint as '{theta: q1, d: d1, a: 0, alpha: pi/2}'; what is left out is 0"


def parse_table(node: YamlNode, key: Span, context: EquationContext) -> list[ParsedEquation]:
    """Return the entries of the frame that a table of joints defines; mistakes are reported."""
    report = context.report
    if node.kind is not NodeKind.MAPPING:
        report.error("E202", wanted("'dh'", "a mapping", node), node.span, _FORM)
        return []
    entries = check_keys(node, _KEYS, report)
    missing = [f"'{name}'" for name in _KEYS if name not in entries]
    if missing:
        report.error("E208", f"the table has no {' and no '.join(missing)}", key, _FORM)
    frame, convention, rows = (entries.get(name) for name in _KEYS)
    if frame is None:
        return []
    if frame.kind is not NodeKind.SCALAR or frame.is_null or not NAME.fullmatch(frame.value):
        report.error("E207", "'frame' must be a name such as T", frame.span)
        return []
    name = frame.value
    make = context.expansion(node, name)
    joints = None if rows is None else _joints(rows, make, context)
    known = convention is not None and convention.value in CONVENTIONS
    if convention is not None and not known:
        hint = "standard: Rz(theta) Tz(d) Tx(a) Rx(alpha); modified: Rx(alpha) Tx(a) Rz(theta) Tz(d)"
        report.error("E202", "the convention must be 'standard' or 'modified'", convention.span, hint)
    context.vectors[name] = FRAME
    written = f"{name} = dh {one_line(node, context.places)}"
    if joints is not None and convention is not None and known:
        at = context.places.offsets(frame, 0, len(name)) or (frame.start, frame.end)
        try:
            found = expand_table(joints, convention.value, make, at)
            named = zip(frame_entries(name), found, strict=True)
            equations = [make.equation(entry, expr, frame.span, written) for entry, expr in named]
            return [*make.hidden, *equations]
        except ExpressionError as error:
            make.text.report(report, error)
    return failed(name, frame_entries(name), frame.span, written)


def _joints(rows: YamlNode, make: Expansion, context: EquationContext) -> list[Joint] | None:
    """Return the joints; None after diagnostics."""
    report = context.report
    if rows.kind is NodeKind.SEQUENCE and not rows.items:
        report.error("E208", "there are no joints", rows.span, _JOINT)
        return None
    if rows.kind is not NodeKind.SEQUENCE:
        report.error("E202", wanted("'joints'", "a list of joints", rows), rows.span, _JOINT)
        return None
    if len(rows.items) > MAX_JOINTS:
        message = f"the table has more than {MAX_JOINTS} joints"
        report.error("E104", message, rows.items[MAX_JOINTS].span)
        return None
    context.joints += len(rows.items)
    if context.joints > MAX_ALL_JOINTS:
        report.error("E104", f"the tables have more than {MAX_ALL_JOINTS} joints", rows.span)
        return None
    joints = []
    for row in rows.items:
        if row.kind is not NodeKind.MAPPING:
            report.error("E202", wanted("a joint", "a mapping", row), row.span, _JOINT)
            continue
        values = check_keys(row, FIELDS, report)
        fields = [_field(values.get(name), name, row, make, context) for name in FIELDS]
        known = [expr for expr in fields if expr is not None]
        if len(known) == len(FIELDS):
            joints.append(Joint(*known))
    return joints if len(joints) == len(rows.items) else None


def _field(
    node: YamlNode | None, name: str, row: YamlNode, make: Expansion, context: EquationContext
) -> Expr | None:
    """Return the expression of a field, 0 if it is not written; None after a diagnostic."""
    if node is None:
        return Number(Fraction(0), (row.start, row.start + 1))
    if node.kind is not NodeKind.SCALAR or node.is_null:
        context.report.error("E202", wanted(f"'{name}'", "an expression", node), node.span)
        return None
    text = Text(node, context.places)
    try:
        expr = relocated(parse_expression(node.value), text)
    except ExpressionError as error:
        text.report(context.report, error)
        return None
    try:
        return make.plain(Vectors(context.vectors, make).scalar(expr))
    except ExpressionError as error:
        make.text.report(context.report, error)
        return None
