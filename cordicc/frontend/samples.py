"""Samples of the true workspace."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from cordicc.base.diagnostics import Report
from cordicc.frontend.document.yamltree import NodeKind, YamlNode
from cordicc.frontend.reading import wanted
from cordicc.ir.problem import InputSpec, SampleTable

MAX_SAMPLE_BYTES = 64 << 20
MAX_SAMPLE_ROWS = 100_000


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
        number = float(text) if text.isascii() and "_" not in text else math.nan
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
