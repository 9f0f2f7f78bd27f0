"""Samples of the true workspace, and the assumptions about the inputs that they must satisfy."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cordicc.diagnostics import Report, Span
from cordicc.frontend.lexer import ExpressionError
from cordicc.frontend.lower import lower
from cordicc.frontend.numeric import evaluate
from cordicc.frontend.reading import wanted
from cordicc.frontend.scope import MAX_ERRORS, Scope, Text
from cordicc.frontend.syntax import RELATIONS, parse_relation
from cordicc.frontend.yamltree import NodeKind, Places, YamlNode
from cordicc.ir.graph import Graph, Value
from cordicc.ir.problem import Assumption, InputSpec, SampleTable

MAX_SAMPLE_BYTES = 64 << 20
MAX_SAMPLE_ROWS = 100_000
_TOLERANCE = 1e-6


class _UnreadableError(Exception):
    """The sample file is not what it should be; the text says why."""


def read_samples(
    node: YamlNode, base: Path | None, inputs: Sequence[InputSpec], report: Report
) -> SampleTable | None:
    """Return the table of the file that `node` names, relative to `base`; None after a diagnostic."""
    if node.kind is not NodeKind.SCALAR or not node.value.strip():
        report.error("E202", wanted("'samples'", "the name of a CSV file", node), node.span)
        return None
    if base is None:
        report.error("E220", "samples can only be read beside a problem file", node.span)
        return None
    try:
        columns = _read_columns(base / node.value, [spec.name for spec in inputs])
    except (OSError, ValueError, csv.Error) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        report.error("E220", f"cannot read '{node.value}': {reason}", node.span)
        return None
    except _UnreadableError as error:
        report.error("E220", f"'{node.value}': {error}", node.span)
        return None
    _check_ranges(node, columns, inputs, report)
    return SampleTable(node.value, columns)


def _read_columns(path: Path, wanted_names: Sequence[str]) -> dict[str, tuple[float, ...]]:
    if not path.is_file():
        raise _UnreadableError("it is a directory" if path.is_dir() else "there is no such file")
    if path.stat().st_size > MAX_SAMPLE_BYTES:
        raise _UnreadableError(f"it is larger than {MAX_SAMPLE_BYTES >> 20} MiB")
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise _UnreadableError("it is not UTF-8 text") from None
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    header = [name.strip() for name in next(rows, [])]
    missing = [name for name in wanted_names if name not in header]
    if missing:
        raise _UnreadableError("the header lacks " + ", ".join(f"'{name}'" for name in missing))
    repeated = [name for name in wanted_names if header.count(name) > 1]
    if repeated:
        raise _UnreadableError(f"the header has '{repeated[0]}' twice")
    places = [header.index(name) for name in wanted_names]
    columns: list[list[float]] = [[] for _ in wanted_names]
    count = 0
    for row in rows:
        if not row:
            continue
        count += 1
        if count > MAX_SAMPLE_ROWS:
            raise _UnreadableError(f"it has more than {MAX_SAMPLE_ROWS} rows")
        if len(row) != len(header):
            raise _UnreadableError(f"line {rows.line_num} has {len(row)} fields, the header {len(header)}")
        for column, place in zip(columns, places, strict=True):
            column.append(_number(row[place], rows.line_num))
    if not count:
        raise _UnreadableError("it has no rows")
    return {name: tuple(column) for name, column in zip(wanted_names, columns, strict=True)}


def _number(text: str, line: int) -> float:
    try:
        number = float(text) if "_" not in text else math.nan
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise _UnreadableError(f"line {line} has '{text[:40]}' where a finite number is expected")
    return number


def _check_ranges(
    node: YamlNode, columns: Mapping[str, tuple[float, ...]], inputs: Sequence[InputSpec], report: Report
) -> None:
    for spec in inputs:
        lo, hi = float(spec.lo), float(spec.hi)
        outside = [row for row, x in enumerate(columns[spec.name], 1) if not lo <= x <= hi]
        if outside:
            first = columns[spec.name][outside[0] - 1]
            message = f"'{spec.name}' = {first!r} in row {outside[0]} is outside its range [{lo!r}, {hi!r}]"
            more = f"{len(outside)} rows are outside" if len(outside) > 1 else None
            report.error("E221", message, node.span, more)


@dataclass(frozen=True, slots=True)
class Assumptions:
    """The assumptions as values of a graph of their own."""

    items: tuple[Assumption, ...]
    graph: Graph


def read_assumptions(node: YamlNode, scope: Scope, places: Places) -> tuple[Assumptions, list[Span]]:
    """Return the assumptions of the list `node`; `scope` has the inputs and constants alone."""
    report = scope.report
    read: list[tuple[str, str, Value, Value, Span]] = []
    if node.kind is not NodeKind.SEQUENCE:
        hint = "each assumption is an item: '- x > 0'"
        report.error("E202", wanted("'assume'", "a list", node), node.span, hint)
    for item in node.items:
        if len(report.diagnostics) >= MAX_ERRORS:
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
    graph = scope.builder.build(sides)
    items = tuple(
        Assumption(text, relation, graph.outputs[f"left{i}"], graph.outputs[f"right{i}"], span.line)
        for i, (text, relation, _, _, span) in enumerate(read)
    )
    return Assumptions(items, graph), [r[4] for r in read]


def check_assumptions(
    assumptions: Assumptions, spans: Sequence[Span], samples: SampleTable, report: Report
) -> None:
    """Report each assumption that a sample contradicts, with the first such row.

    Equality is checked to 1e-6 of the largest number on the way.
    """
    graph = assumptions.graph
    for assumption, span in zip(assumptions.items, spans, strict=True):
        order = sorted(graph.live([assumption.left, assumption.right]))
        for row in range(samples.rows):
            point = {name: column[row] for name, column in samples.columns.items()}
            values = evaluate(graph.nodes, order, point)
            left, right = values[assumption.left.node], values[assumption.right.node]
            scale = max(abs(v) for v in values.values() if not math.isnan(v))
            if not _holds(assumption.relation, left, right, scale):
                message = (
                    f"the assumption does not hold in row {row + 1} of the samples: {left!r} and {right!r}"
                )
                report.error("E222", message, span)
                break


def _holds(relation: str, left: float, right: float, scale: float) -> bool:
    if relation == "=":
        return abs(left - right) <= _TOLERANCE * scale
    if relation in ("<", ">"):
        return left < right if relation == "<" else left > right
    slack = 1e-12 * scale
    return left <= right + slack if relation == "<=" else left >= right - slack
