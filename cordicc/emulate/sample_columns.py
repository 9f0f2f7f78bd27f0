"""Which columns of a file of samples are read, whatever the kind of file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from cordicc.base.arrays import Floats
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity, Source, Span


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


def choose(
    header: Sequence[str], columns: Columns, source: Source
) -> tuple[tuple[str, ...], list[Diagnostic]]:
    """Return the columns to read, and a warning of those that are not.

    Raises InvalidInput (E612): a column is missing or twice, or there is no header.
    """
    problems = []
    whole = Span(1, 1, 1 + max(1, len(source.text))) if source.text else None
    hint = None
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        hint = "fields are separated by commas"
    known = {*columns.wanted, *columns.optional}
    if source.text and not known.intersection(header) and all(decimal(name) is not None for name in header):
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


def decimal(text: str) -> float | None:
    """Return a decimal number, perhaps not finite, or None; spellings that only Python knows are refused."""
    if not text.isascii() or "_" in text:
        return None
    try:
        return float(text)
    except ValueError:
        return None
