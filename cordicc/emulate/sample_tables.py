"""Columns of numbers in files, read and written a part at a time: CSV, and NumPy's .npz.

A .npz file has one one-dimensional array of real numbers for each column, all of one length.
"""

from __future__ import annotations

import csv
import math
import zipfile
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity, Source, Span
from cordicc.base.files import failure

PART_ROWS = 1 << 16
"""Rows of a part: enough to hide what a part costs, few enough to need little memory."""

_LONGEST_LINE = 1 << 20
_MOST_PROBLEMS = 10


class Columns(NamedTuple):
    """Which columns to read, what they are called in messages, and whether they may hold nan.

    `optional` ones need not be there.  If `some` of the wanted ones suffice, one does, but not beside names
    that nobody knows.
    """

    wanted: Sequence[str]
    noun: str = "input"
    optional: Sequence[str] = ()
    nan: bool = False
    some: bool = False


class OpenedTable(NamedTuple):
    """The columns found, their parts in order (at least one, perhaps without rows), and warnings."""

    names: tuple[str, ...]
    parts: Iterator[dict[str, Floats]]
    warnings: list[Diagnostic]


def read_table(path: Path, columns: Columns, part: int = PART_ROWS) -> OpenedTable:
    """Open a file of columns; what follows the header is read as the parts are taken.

    Raises:
        InvalidInput: now or while parts are taken: no such file, a column is missing or twice, columns
            or rows of different lengths, a field is no decimal number.
    """
    if path.suffix == ".npz":
        return _read_npz(path, columns, part)
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
    names, warnings = _choose(header, columns, Source(str(path), first.line))
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


def _choose(
    header: Sequence[str], columns: Columns, source: Source
) -> tuple[tuple[str, ...], list[Diagnostic]]:
    """Return the columns to read, and a warning of those that are not."""
    problems = []
    whole = Span(1, 1, 1 + max(1, len(source.text))) if source.text else None
    hint = None
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        hint = "fields are separated by commas"
    known = {*columns.wanted, *columns.optional}
    if source.text and not known.intersection(header) and all(_decimal(name) is not None for name in header):
        message, hint = "there is no header", "the first line names the columns: " + ",".join(columns.wanted)
        raise InvalidInput([Diagnostic("E612", message, whole, hint, source=source)])
    strange = [name for name in header if name not in known]
    needed = columns.wanted
    if columns.some and set(header) & set(columns.wanted) and not strange:
        needed = []
    for name in (*columns.wanted, *columns.optional):
        if header.count(name) > 1 or (name in needed and name not in header):
            what = "twice in the header" if name in header else "missing from the header"
            problems.append(
                Diagnostic("E612", f"{columns.noun} '{name}' is {what}", whole, hint, source=source)
            )
    if problems:
        raise InvalidInput(problems)
    names = tuple(name for name in (*columns.wanted, *columns.optional) if name in header)
    warnings = []
    if strange:
        message = f"columns that are no {columns.noun} are ignored: " + ", ".join(strange)
        warnings.append(Diagnostic("W611", message, severity=Severity.WARNING, source=source))
    return names, warnings


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
            number = _decimal(field)
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


def _decimal(text: str) -> float | None:
    """Return a decimal number, perhaps not finite, or None; spellings that only Python knows are refused."""
    if not text.isascii() or "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _read_npz(path: Path, columns: Columns, part: int) -> OpenedTable:
    try:
        archive = zipfile.ZipFile(path)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise failure(path, "cannot read the file", error) from None
    source = Source(str(path), "")
    header = [name.removesuffix(".npy") for name in archive.namelist()]
    names, warnings = _choose(header, columns, source)
    arrays = {name: _open_array(archive, name, source) for name in names}
    counts = {name: array.rows for name, array in arrays.items()}
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"{name}: {count}" for name, count in counts.items())
        raise InvalidInput([Diagnostic("E613", f"arrays of different lengths ({listed})", source=source)])
    total = next(iter(counts.values()), 0)

    def parts() -> Iterator[dict[str, Floats]]:
        with archive:
            for begin in range(0, max(1, total), part):
                size = min(part, total - begin)
                yield {name: array.take(size, begin, columns.nan) for name, array in arrays.items()}

    return OpenedTable(names, parts(), warnings)


class _Array(NamedTuple):
    """An array of an archive, open for reading."""

    name: str
    file: IO[bytes]
    kind: np.dtype[np.generic]
    rows: int
    source: Source

    def take(self, count: int, begin: int, nan: bool) -> Floats:
        """Return the next numbers.  Raises InvalidInput for one that is not finite, and at a torn end."""
        try:
            data = self.file.read(count * self.kind.itemsize)
            numbers = np.frombuffer(data, dtype=self.kind).astype(np.float64)
        except (OSError, ValueError, zipfile.BadZipFile) as error:
            message = f"cannot read array '{self.name}': {error}"
            raise InvalidInput([Diagnostic("E611", message, source=self.source)]) from None
        if numbers.size != count:
            raise InvalidInput([Diagnostic("E611", f"array '{self.name}' is cut short", source=self.source)])
        if not nan and not np.isfinite(numbers).all():
            row = begin + int(np.argmin(np.isfinite(numbers))) + 1
            message = f"row {row} of array '{self.name}' is not a finite number"
            raise InvalidInput([Diagnostic("E614", message, source=self.source)])
        return numbers


def _open_array(archive: zipfile.ZipFile, name: str, source: Source) -> _Array:
    try:
        file = archive.open(f"{name}.npy")
        version = np.lib.format.read_magic(file)
        read = (
            np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        )
        shape, _, kind = read(file)
    except (KeyError, OSError, ValueError, zipfile.BadZipFile) as error:
        message = f"array '{name}' cannot be read: {error}"
        raise InvalidInput([Diagnostic("E611", message, source=source)]) from None
    if len(shape) != 1 or kind.kind not in "fiu":
        message = f"array '{name}' is not a one-dimensional array of real numbers"
        raise InvalidInput([Diagnostic("E614", message, source=source)])
    return _Array(name, file, kind, shape[0], source)
