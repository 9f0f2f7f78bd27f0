"""The terminal: sheets with colour and in its width, diagnostics with colour, progress.

Everything is plain text where stdout or stderr is no terminal, where TERM is `dumb`, or where NO_COLOR is
set to anything (https://no-color.org).  Rich is imported only where there is a terminal to show it on.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any, TextIO, TypeVar

import click

from cordicc.base.diagnostics import Diagnostic
from cordicc.base.text_tables import Facts, Heading, Sheet, harmless, plain
from cordicc.cli.streams import is_tty, say, written

T = TypeVar("T")

_QUIET_SECONDS = 2.0
_PLAIN_SECONDS = 15.0
_STAGE_SECONDS = 1.0
_HEAD = re.compile(r"\b(error|warning)(\[[EW][0-9]{3}\])")
_ASIDE = re.compile(r"\([^()]*\)")


def is_terminal(stream: TextIO | None) -> bool:
    """Tell whether a stream is a terminal that is to be more than plain text."""
    return is_tty(stream) and not os.environ.get("NO_COLOR") and os.environ.get("TERM", "dumb") != "dumb"


def tell(diagnostics: Iterable[Diagnostic]) -> None:
    """Print diagnostics to stderr."""
    coloured = is_terminal(sys.stderr)
    for diagnostic in diagnostics:
        text = diagnostic.render()
        say(_coloured(text) if coloured else text, err=True, colour=coloured)


def _coloured(text: str) -> str:
    head, *rest = text.split("\n")
    head = _HEAD.sub(lambda m: click.style(m[0], fg="red" if m[1] == "error" else "yellow", bold=True), head)
    return "\n".join(
        [head, *(click.style(line, fg="cyan") if line.strip(" ^") == "" else line for line in rest)]
    )


def show(sheet: Sheet, *, err: bool = False) -> None:
    """Print a sheet to stdout or stderr."""
    sheet = harmless(sheet)
    stream = sys.stderr if err else sys.stdout
    if not is_terminal(stream):
        say(plain(sheet), newline=False, err=err)
        return
    written(lambda stream: _draw(sheet, stream), err=err)


def _draw(sheet: Sheet, stream: TextIO) -> None:
    console = _console(stream)
    for part in _renderables(sheet):
        console.print(part)


def _console(stream: TextIO) -> Any:
    from rich.console import Console

    return Console(file=stream, force_terminal=True, highlight=False, markup=False, emoji=False)


def _renderables(sheet: Sheet) -> Iterator[Any]:
    """Yield what Rich prints."""
    from rich import box
    from rich.padding import Padding
    from rich.table import Table as Grid
    from rich.text import Text

    if sheet.title:
        yield Text(sheet.title, style="bold")
    for block in sheet.blocks:
        if isinstance(block, str):
            yield Text(block)
        elif isinstance(block, Heading):
            yield Text("\n" + block.text, style="bold")
        elif isinstance(block, Facts):
            grid = Grid.grid(padding=(0, 2, 0, 0))
            grid.add_column(no_wrap=True, style="cyan")
            grid.add_column()
            for name, text in block.rows:
                said = Text(text)
                said.highlight_regex(_ASIDE, "dim")
                grid.add_row(Text(name), said)
            yield Padding(grid, (0, 0, 0, block.indent))
        else:
            table = Grid(box=box.SIMPLE_HEAD, header_style="bold", pad_edge=False, show_edge=False)
            for at, name in enumerate(block.header):
                table.add_column(
                    Text(name), justify="right" if at in block.right else "left", overflow="fold"
                )
            for row in block.rows:
                table.add_row(*map(Text, row))
            yield Padding(table, (0, 0, 0, block.indent))


class Progress:
    """How far a long run has come, on stderr: a bar on a terminal, a line now and then else.

    It says nothing in a run of less than two seconds.  `total` may be unknown; `noun` is what is counted.
    """

    def __init__(self, total: int | None, noun: str, clock: Callable[[], float] = monotonic) -> None:
        self._total, self._noun, self._clock = total, noun, clock
        self._terminal = is_terminal(sys.stderr)
        self._next = clock() + (_QUIET_SECONDS if self._terminal else _PLAIN_SECONDS)
        self._bar: Any = None
        self._task: Any = None

    def reached(self, done: int) -> None:
        """Tell how much is done."""
        if self._bar is not None:
            self._bar.update(self._task, completed=done)
        elif self._clock() >= self._next:
            if self._terminal:
                self._start(done)
            else:
                self._next = self._clock() + _PLAIN_SECONDS
                of = "" if self._total is None else f" of {self._total:,}"
                say(f"{done:,}{of} {self._noun}", err=True)

    def _start(self, done: int) -> None:
        from rich import progress

        of = "{task.completed:,}" + ("" if self._total is None else " of {task.total:,}")
        columns = (progress.BarColumn(), progress.TextColumn(f"{of} {self._noun}"))
        left = () if self._total is None else (progress.TimeRemainingColumn(),)
        self._bar = progress.Progress(*columns, *left, console=_console(sys.stderr), transient=True)
        self._task = self._bar.add_task("", total=self._total, completed=done)
        self._bar.start()

    def done(self) -> None:
        """Wipe the bar from a terminal."""
        if self._bar is not None:
            self._bar.stop()


def watched(parts: Iterable[T], total: int, noun: str) -> Iterator[T]:
    """Pass on the parts and tell how many have come."""
    progress = Progress(total, noun)
    try:
        for done, part in enumerate(parts, 1):
            yield part
            progress.reached(done)
    finally:
        progress.done()


@contextmanager
def stages(quiet: bool, clock: Callable[[], float] = monotonic) -> Iterator[Callable[[str], None]]:
    """Give what is called with the name of each stage of a run; those after a second show on a terminal."""
    if quiet or not is_terminal(sys.stderr):
        yield lambda name: None
        return
    start, status = clock(), None

    def enter(name: str) -> None:
        nonlocal status
        if status is not None:
            status.update(f"{name} ...")
        elif clock() - start > _STAGE_SECONDS:
            status = _console(sys.stderr).status(f"{name} ...")
            status.start()

    try:
        yield enter
    finally:
        if status is not None:
            status.stop()
