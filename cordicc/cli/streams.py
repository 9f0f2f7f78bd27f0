"""stdout and stderr as commands use them: in any encoding; full, closed or with nobody at the other end.

What people read is written in the encoding of the stream, and what that lacks is replaced.  What programs
read, files and JSON, is UTF-8 on every stream.  A stdout that takes nothing is an error as with any file; a
stderr that takes nothing is none, since it is where errors are told.
"""

from __future__ import annotations

import codecs
import errno
import os
import sys
from collections.abc import Callable
from io import TextIOWrapper
from typing import TextIO

import click

from cordicc.base.diagnostics import Diagnostic, InvalidInput

_LEGIBLE = "cordicc.legible"
_SPELT = {"\u00b5": "u", "\u2212": "-"}
"""What cordicc itself says with other characters than ASCII has."""


def _legible(error: UnicodeError) -> tuple[str, int]:
    """Spell a character that an encoding lacks in ASCII, or put a question mark in its place."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_SPELT.get(each, "?") for each in lacking), error.end


codecs.register_error(_LEGIBLE, _legible)


def prepare() -> None:
    """Let stdout and stderr of the process replace what their encodings lack."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=_LEGIBLE)


def is_tty(stream: TextIO | None) -> bool:
    """Tell whether a stream is a terminal; None is one that was closed before the process began."""
    return stream is not None and stream.isatty()


def say(text: str, *, err: bool = False, newline: bool = True, colour: bool | None = None) -> None:
    """Write what people read to stdout or stderr.  Raises as `written`."""
    written(lambda stream: click.echo(text, stream, newline, color=colour), err=err)


def deliver(text: str, *, err: bool = False) -> None:
    """Write what programs read, a file or JSON.  Raises as `written`."""
    written(lambda stream: click.echo(text.encode(), stream, nl=False), err=err)


def written(put: Callable[[TextIO], object], *, err: bool = False) -> None:
    """Have `put` write to stdout or stderr.

    Raises:
        InvalidInput: stdout takes nothing (E600).
        BrokenPipeError: nobody reads stdout any more.
    """
    stream = sys.stderr if err else sys.stdout
    try:
        if stream is None:
            raise OSError(errno.EBADF, "it is closed")
        put(stream)
    except OSError as error:
        if err or isinstance(error, BrokenPipeError):
            _abandon(stream)
            if err:
                return
            raise
        raise InvalidInput([cannot_write(error)]) from None


def cannot_write(error: OSError) -> Diagnostic:
    """Return what is to be said of a stdout that takes nothing; it is given nothing more."""
    _abandon(sys.stdout)
    return Diagnostic("E600", f"cannot write to stdout: {error.strerror or error}")


def _abandon(stream: TextIO | None) -> None:
    """Throw away what a stream still holds and will be given: at its end Python would fail to write it."""
    if stream is None:
        return
    try:
        descriptor = stream.fileno()
    except OSError:  # no file of the system
        return
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, descriptor)
    os.close(nothing)
