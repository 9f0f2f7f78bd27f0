"""Columns of numbers in files, read and written a part at a time: CSV, and NumPy's .npz.

A .npz file has one one-dimensional array of real numbers for each column, all of one length.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source, Span
from cordicc.base.files import failure
from cordicc.emulate.npz_tables import read_npz
from cordicc.emulate.sample_columns import Columns, OpenedTable, choose, decimal

PART_ROWS = 1 << 16
"""Rows of a part: enough to hide what a part costs, few enough to need little memory."""

_LONGEST_LINE = 1 << 20
_MOST_PROBLEMS = 10


def read_table(path: Path, columns: Columns, part: int = PART_ROWS) -> OpenedTable:
    """Open a file of columns; what follows the header is read as the parts are taken.

    Raises:
        InvalidInput: now or while parts are taken: no such file, a column is missing or twice, columns
            or rows of different lengths, a field is no decimal number.
    """
    if path.suffix == ".npz":
        return read_npz(path, columns, part)
    try:
        file = path.open("r", encoding="utf-8-sig", newline="")
    except (OSError, ValueError) as error:
        raise failure(path, "cannot read the file", error) from None
    return _read_csv(file, path, columns, part)


class _Lines:
    """The lines of a file; remembers the last one."""

    def __init__(self, file: IO[str], path: Path) -> None:
        self.file, self.path, self.last, self.number = file, path, "", 0

    def __iter__(self) -> Iterator[str]:
        try:
            while line := self.file.readline(_LONGEST_LINE):
                self.number += 1
                if len(line) == _LONGEST_LINE:
                    raise failure(self.path, f"line {self.number} is too long")
                self.last = line.rstrip("\r\n")
                yield line
        except UnicodeDecodeError as error:
            raise failure(self.path, f"the file is not UTF-8 (byte {error.start} of a block)") from None
        except OSError as error:
            raise failure(self.path, "cannot read the file", error) from None
        finally:
            self.file.close()


class _Row(NamedTuple):
    """The fields of a row, and where its last line stands."""

    fields: list[str]
    number: int
    line: str


def _read_csv(file: IO[str], path: Path, columns: Columns, part: int) -> OpenedTable:
    lines = _Lines(file, path)
    rows = _rows(lines, csv.reader(iter(lines), strict=True))
    first = next(rows, None)
    if first is None:
        raise InvalidInput([Diagnostic("E612", "the file is empty", source=Source(str(path), ""))])
    header = [field.strip() for field in first.fields]
    names, warnings = choose(header, columns, Source(str(path), first.line))
    where = {name: header.index(name) for name in names}

    def parts() -> Iterator[dict[str, Floats]]:
        taken = list(islice(rows, part))
        yield _numbers(taken, where, len(header), path, columns.nan)
        while taken := list(islice(rows, part)):
            yield _numbers(taken, where, len(header), path, columns.nan)

    return OpenedTable(names, parts(), warnings)


def _rows(lines: _Lines, reader: Iterator[list[str]]) -> Iterator[_Row]:
    """Return the rows that are not blank."""
    try:
        for fields in reader:
            if fields:
                yield _Row(fields, lines.number, lines.last)
    except csv.Error as error:
        source = Source(str(lines.path), "")
        raise InvalidInput([Diagnostic("E611", f"not CSV: {error}", source=source)]) from None


def _numbers(rows: list[_Row], where: dict[str, int], width: int, path: Path, nan: bool) -> dict[str, Floats]:
    """Return the numbers of rows by column."""
    plain = all(len(row.fields) == width and row.line.isascii() and "_" not in row.line for row in rows)
    if plain:
        try:
            made = {
                name: np.array([float(row.fields[at]) for row in rows], dtype=np.float64)
                for name, at in where.items()
            }
        except ValueError:
            plain = False
        else:
            plain = nan or all(bool(np.isfinite(column).all()) for column in made.values())
    if plain:
        return made
    return _numbers_or_problems(rows, where, width, path, nan)


def _numbers_or_problems(
    rows: list[_Row], where: dict[str, int], width: int, path: Path, nan: bool
) -> dict[str, Floats]:
    """Return the numbers of rows by column, each field looked at by itself.  Raises InvalidInput."""
    problems: list[Diagnostic] = []
    columns: dict[str, list[float]] = {name: [] for name in where}
    for row in rows:
        source = Source(str(path), "\n" * (row.number - 1) + row.line)
        if len(row.fields) != width:
            fields = "1 field" if len(row.fields) == 1 else f"{len(row.fields)} fields"
            message = f"{fields} in a row under a header of {width}"
            span = Span(row.number, 1, 1 + max(1, len(row.line)))
            problems.append(Diagnostic("E613", message, span, source=source))
            continue
        for name, at in where.items():
            field = row.fields[at].strip()
            number = decimal(field)
            if number is None or not (nan or math.isfinite(number)):
                what = "decimal" if number is None else "finite"
                message = f"'{field[:80]}' is not a {what} number (column '{name}')"
                problems.append(Diagnostic("E614", message, _field_span(row, at, field), source=source))
            else:
                columns[name].append(number)
        if len(problems) >= _MOST_PROBLEMS:
            break
    if problems:
        raise InvalidInput(problems)
    return {name: np.asarray(numbers, dtype=np.float64) for name, numbers in columns.items()}


def _field_span(row: _Row, at: int, field: str) -> Span:
    """Return where a field stands, the whole line if quotes are in the way."""
    fields = row.line.split(",")
    if '"' in row.line or at >= len(fields) or fields[at].strip() != field:
        return Span(row.number, 1, 1 + max(1, len(row.line)))
    before = sum(len(each) + 1 for each in fields[:at])
    column = 1 + before + (len(fields[at]) - len(fields[at].lstrip()))
    return Span(row.number, column, column + max(1, len(field)))
