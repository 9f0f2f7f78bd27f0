"""Assumptions about the inputs, and their check on samples or on the ranges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from cordicc.base.diagnostics import Report, Span
from cordicc.expressions.lexer import ExpressionError
from cordicc.expressions.syntax import RELATIONS, parse_relation
from cordicc.frontend.document.yamltree import NodeKind, Places, YamlNode
from cordicc.frontend.lower import lower
from cordicc.frontend.reading import wanted
from cordicc.frontend.scope import MAX_ERRORS, Scope, Text
from cordicc.ir.facts import InputFacts
from cordicc.ir.graph import Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.problem import InputSpec, SampleTable
from cordicc.ir.ranges.forward import value_ranges


def read_assumptions(node: YamlNode, scope: Scope, places: Places) -> tuple[InputFacts, list[Span]]:
    """Return the assumptions of the list `node`; `scope` has the inputs and constants alone."""
    report = scope.report
    read: list[tuple[str, str, Value, Value, Span]] = []
    if node.kind is not NodeKind.SEQUENCE:
        hint = "each assumption is an item: '- x > 0'"
        report.error("E202", wanted("'assume'", "a list", node), node.span, hint)
    for item in node.items:
        if report.errors >= MAX_ERRORS:
            break
        if item.kind is not NodeKind.SCALAR or item.is_null:
            report.error("E202", wanted("an assumption", "a relation such as 'x > 0'", item), item.span)
            continue
        text = Text(item, places)
        try:
            relation = parse_relation(item.value, RELATIONS)
        except ExpressionError as error:
            text.report(report, error)
            continue
        left, right = lower(relation.left, scope, text), lower(relation.right, scope, text)
        if left is not None and right is not None:
            read.append((" ".join(item.value.split()), relation.relation, left, right, item.span))
    sides = {f"left{i}": entry[2] for i, entry in enumerate(read)}
    sides |= {f"right{i}": entry[3] for i, entry in enumerate(read)}
    stated = [(text, relation) for text, relation, _, _, _ in read]
    return InputFacts.of(stated, scope.builder.build(sides)), [r[4] for r in read]


def check_on_samples(facts: InputFacts, spans: Sequence[Span], samples: SampleTable, report: Report) -> None:
    """Report each assumption that a sample contradicts, with the first such row."""
    columns = {name: np.asarray(column, dtype=np.float64) for name, column in samples.columns.items()}
    for fact, span in zip(facts.items, spans, strict=True):
        broken = np.flatnonzero(~facts.kept_one(fact, columns))
        if broken.size:
            row = int(broken[0])
            left, right, _ = facts.sides(fact, columns)
            sides = f"{float(left[row])!r} and {float(right[row])!r}"
            message = f"the assumption does not hold in row {row + 1} of the samples: {sides}"
            report.error("E222", message, span)


def check_on_box(
    facts: InputFacts, spans: Sequence[Span], inputs: Sequence[InputSpec], report: Report
) -> None:
    """Report each assumption that the ranges of the inputs contradict; warn if some are left open."""
    box = {spec.name: Interval(_below(spec.lo), -_below(-spec.hi)) for spec in inputs}
    ranges = value_ranges(facts.graph, box)
    unchecked: list[Span] = []
    for assumption, span in zip(facts.items, spans, strict=True):
        left, right = (ranges[v.node][v.result] for v in (assumption.left, assumption.right))
        if left is None or right is None:
            message = "the assumption has no value anywhere in the ranges of the inputs"
            report.error("E222", message, span, "correct the ranges or the assumption")
            continue
        verdict = _verdict(assumption.relation, left, right)
        if verdict is False:
            message = "the assumption holds nowhere in the ranges of the inputs"
            hint = f"the left side is in {_shown(left)}, the right side in {_shown(right)}"
            report.error("E222", message, span, f"{hint}: correct the ranges or the assumption")
        elif verdict is None:
            unchecked.append(span)
    if unchecked and not report.failed:
        message = "assumption not checked: there are no samples"
        more = f"{len(unchecked)} assumptions are not checked; " if len(unchecked) > 1 else ""
        hint = f"{more}add rows of the true workspace with 'samples: FILE.csv'"
        report.warning("W108", message, unchecked[0], hint)


def _below(number: Fraction) -> float:
    """Return the largest float that is not above a number."""
    near = float(number)
    return near if near <= number else math.nextafter(near, -math.inf)


def _verdict(relation: str, left: Interval, right: Interval) -> bool | None:
    """Return whether a relation holds everywhere or nowhere, None if neither is proven."""
    match relation:
        case "<" | ">":
            low, high = (left, right) if relation == "<" else (right, left)
            return True if low.hi < high.lo else False if low.lo >= high.hi else None
        case "<=" | ">=":
            low, high = (left, right) if relation == "<=" else (right, left)
            return True if low.hi <= high.lo else False if low.lo > high.hi else None
        case _:
            return False if left.intersect(right) is None else None


def _shown(interval: Interval) -> str:
    return f"[{interval.lo:.6g}, {interval.hi:.6g}]"
