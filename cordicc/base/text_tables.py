"""What the command line shows, as data: a title, lines, facts and tables; as plain text for pipes and files.

`cordicc.cli.console` shows the same on a terminal.  The plain form is what scripts and the documentation see.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from cordicc.base.diagnostics import printable


@dataclass(frozen=True, slots=True)
class Facts:
    """Rows of a name and what is to be said of it; `indent` in columns."""

    rows: tuple[tuple[str, str], ...]
    indent: int = 2


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells under a header; the columns in `right` are aligned there."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    indent: int = 2
    right: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Heading:
    """The title of a section."""

    text: str


Block = str | Facts | Table | Heading
"""A text stands for a line of its own; the empty one for an empty line."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A title, if any, and what follows it."""

    title: str
    blocks: tuple[Block, ...] = ()


def percent(share: float) -> str:
    """Return a share in hundredths of a percent, rounded down: not quite all is never called all."""
    return f"{math.floor(1e4 * share) / 100:g} %"


def harmless(sheet: Sheet) -> Sheet:
    """Return a sheet without characters that could drive a terminal; texts may come from a plan file."""
    return Sheet(printable(sheet.title), tuple(map(_harmless, sheet.blocks)))


def _harmless(block: Block) -> Block:
    match block:
        case str():
            return printable(block)
        case Heading(text):
            return Heading(printable(text))
        case Facts(rows):
            return replace(block, rows=tuple((printable(name), printable(text)) for name, text in rows))
        case Table(header, rows):
            cells = tuple(tuple(map(printable, row)) for row in rows)
            return replace(block, header=tuple(map(printable, header)), rows=cells)


def plain(sheet: Sheet) -> str:
    """Return the text of a sheet, ending in a newline."""
    lines = [sheet.title] if sheet.title else []
    for block in sheet.blocks:
        lines += _lines(block)
    return "\n".join(lines) + "\n"


def _lines(block: Block) -> list[str]:
    if isinstance(block, str):
        return [block]
    if isinstance(block, Heading):
        return ["", block.text]
    if isinstance(block, Facts):
        width = max((len(name) for name, _ in block.rows), default=0)
        return [" " * block.indent + f"{name:<{width}}  {text}".rstrip() for name, text in block.rows]
    rows = [block.header, *block.rows]
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    return [" " * block.indent + aligned(row, widths, block.right) for row in rows]


def aligned(row: Sequence[str], widths: Sequence[int], right: Sequence[int] = ()) -> str:
    """Return the cells of a row side by side, two columns apart."""
    cells = (
        f"{cell:>{width}}" if at in right else f"{cell:<{width}}"
        for at, (cell, width) in enumerate(zip(row, widths, strict=False))
    )
    return "  ".join(cells).rstrip()
