"""Samples of the inputs: drawn, or read from and written to CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cordicc.diagnostics import Diagnostic, InvalidInput, Severity, Source, Span

Floats = NDArray[np.float64]

MAX_ROWS = 10_000_000


def draw(problem: Mapping[str, Any], count: int, seed: int) -> dict[str, Floats]:
    """Draw samples: rows of the problem's own samples if it has them, else uniform in the ranges.

    The generator is NumPy's PCG64 with the given seed, the inputs in order of declaration.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    samples = problem.get("samples")
    if samples:
        columns = {name: np.asarray(column, dtype=np.float64) for name, column in samples["columns"].items()}
        rows = generator.integers(0, len(next(iter(columns.values()))), count)
        return {item["name"]: columns[item["name"]][rows] for item in problem["inputs"]}
    drawn = {}
    for item in problem["inputs"]:
        lo, hi = float(item["lo"]), float(item["hi"])
        share = generator.random(count)
        wide = not math.isfinite(hi - lo)
        drawn[item["name"]] = np.clip(
            hi * share + lo * (1 - share) if wide else lo + (hi - lo) * share, lo, hi
        )
    return drawn


def read_csv(text: str, name: str, inputs: list[str]) -> tuple[dict[str, Floats], list[Diagnostic]]:
    """Read input samples.

    Args:
        text: CSV with a header of input names.
        name: how the user knows the file.
        inputs: the columns wanted; others are ignored with a warning.

    Returns:
        An array of shape (rows,) per input, and warnings.

    Raises:
        InvalidInput: a column is missing or twice, a row has another length, a field is no decimal number.
    """
    source = Source(name, text)
    if not text.strip():
        raise InvalidInput([Diagnostic("E612", "the file is empty", source=source)])
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        header = [field.strip() for field in next(reader, [])]
        rows = [(reader.line_num, row) for row in islice(reader, MAX_ROWS + 1) if row]
    except csv.Error as error:
        raise InvalidInput([Diagnostic("E611", f"not CSV: {error}", source=source)]) from None
    if len(rows) > MAX_ROWS:
        raise InvalidInput([Diagnostic("E611", f"the file has more than {MAX_ROWS} rows", source=source)])
    found = _columns(header, inputs, source)
    problems: list[Diagnostic] = []
    columns: dict[str, list[float]] = {column: [] for column in inputs}
    for line, row in rows:
        if len(row) != len(header):
            fields = "1 field" if len(row) == 1 else f"{len(row)} fields"
            message = f"{fields} in a row under a header of {len(header)}"
            problems.append(Diagnostic("E613", message, _line_span(source, line), source=source))
            continue
        for column in inputs:
            field = row[found[column]].strip()
            number = _decimal(field)
            if number is None or not math.isfinite(number):
                what = "decimal" if number is None else "finite"
                message = f"'{field[:80]}' is not a {what} number (column '{column}')"
                span = _field_span(source, line, found[column], field)
                problems.append(Diagnostic("E614", message, span, source=source))
            else:
                columns[column].append(number)
        if len(problems) >= 10:
            break
    if problems:
        raise InvalidInput(problems)
    extra = [field for field in header if field not in inputs]
    warnings = []
    if extra:
        message = "columns that are no input are ignored: " + ", ".join(extra)
        warnings.append(Diagnostic("W611", message, severity=Severity.WARNING, source=source))
    return {column: np.asarray(numbers, dtype=np.float64) for column, numbers in columns.items()}, warnings


def _columns(header: list[str], inputs: list[str], source: Source) -> dict[str, int]:
    problems = []
    whole = _line_span(source, 1)
    hint = None
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        hint = "fields are separated by commas"
    for name in inputs:
        if header.count(name) != 1:
            what = "twice in the header" if name in header else "missing from the header"
            problems.append(Diagnostic("E612", f"input '{name}' is {what}", whole, hint, source=source))
    if problems:
        raise InvalidInput(problems)
    return {name: header.index(name) for name in inputs}


def _line_span(source: Source, line: int) -> Span:
    return Span(line, 1, 1 + max(1, len(source.line(line))))


def _field_span(source: Source, line: int, index: int, field: str) -> Span:
    """Return where a field stands, the whole line if quotes are in the way."""
    text = source.line(line)
    fields = text.split(",")
    if '"' in text or index >= len(fields) or fields[index].strip() != field:
        return _line_span(source, line)
    before = sum(len(each) + 1 for each in fields[:index])
    column = 1 + before + (len(fields[index]) - len(fields[index].lstrip()))
    return Span(line, column, column + max(1, len(field)))


def _decimal(text: str) -> float | None:
    """Return a decimal number, perhaps not finite, or None; spellings that only Python knows are refused."""
    if not text.isascii() or "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def write_csv(outputs: Mapping[str, NDArray[Any]]) -> str:
    """Return outputs as CSV: the outputs, then `valid`, a row per sample, enough digits to round-trip."""
    names = [name for name in outputs if name != "valid"]
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*names, "valid"])
    columns = [[repr(x) for x in outputs[name].tolist()] for name in names]
    columns.append(["1" if ok else "0" for ok in outputs["valid"].tolist()])
    writer.writerows(zip(*columns, strict=True))
    return out.getvalue()
