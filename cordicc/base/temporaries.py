"""What is written aside until it is whole: files and folders that take the place of a result, or vanish.

A name holds a check of itself, so that nothing of the user's is taken for one of these.  Who writes keeps a
lock; what a killed run has left can be locked, and is removed by the next one that writes into the folder.
SIGTERM and SIGHUP end a run after it has removed what it has aside, with 128 and their number as status.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, Any

try:
    import fcntl
except ImportError:  # no such locks on this system
    fcntl = None  # type: ignore[assignment]

_PREFIX = ".cordicc-"
_NAME = re.compile(rf"{re.escape(_PREFIX)}([0-9a-f]{{12}})([0-9a-f]{{12}})")

_PATIENCE_SECONDS = 30.0
"""For which a run waits until another one has written."""

_SIGNALS = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))


def new_name() -> str:
    """Return a name for something aside that nothing else has."""
    token = os.urandom(6).hex()
    return f"{_PREFIX}{token}{_check(token)}"


def is_own(name: str) -> bool:
    """Tell whether a name is one that `new_name` gave, now or in an earlier run."""
    match = _NAME.fullmatch(name)
    return match is not None and match[2] == _check(match[1])


def _check(token: str) -> str:
    return hashlib.sha256(f"cordicc keeps this aside: {token}".encode()).hexdigest()[:12]


@contextmanager
def replacing(final: Path) -> Iterator[IO[bytes]]:
    """Open a file aside that takes the place of another once all is well; raises OSError."""
    with _named_in(final.parent) as aside, ExitStack() as stack:
        with locked(final.parent):
            remove_leftovers(final.parent)
            aside.touch(0o600, exist_ok=False)
            stack.enter_context(_in_use(aside))
        with aside.open("wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.chmod(aside, 0o666 & ~umask())
        os.replace(aside, final)


@contextmanager
def folder_in(parent: Path) -> Iterator[Path]:
    """Make a folder aside, which is removed in the end if it still has that name; raises OSError.

    The caller has locked the folder in which it is, or the one above.
    """
    with _named_in(parent) as aside:
        aside.mkdir(0o700)
        with _in_use(aside):
            yield aside


def umask() -> int:
    """Return the file mode creation mask of the process."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _try_lock(descriptor: int) -> bool | None:
    """Lock a file or folder; tell whether that could be done, None where there are no locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


@contextmanager
def _in_use(aside: Path) -> Iterator[None]:
    """Keep other runs from taking something aside for a leftover."""
    if fcntl is None:
        yield
        return
    descriptor = os.open(aside, os.O_RDONLY)
    try:
        _try_lock(descriptor)
        yield
    finally:
        os.close(descriptor)


def remove_leftovers(folder: Path) -> None:
    """Remove what runs that were killed have left in a folder, which the caller has locked."""
    with suppress(OSError):
        for entry in list(os.scandir(folder)):
            if is_own(entry.name) and not entry.is_symlink():
                _remove_unless_in_use(Path(entry.path))


def _remove_unless_in_use(path: Path) -> None:
    with suppress(OSError):
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        try:
            if _try_lock(descriptor):
                _remove(path)
        finally:
            os.close(descriptor)


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other runs from writing into a folder; raises TimeoutError.

    Where a folder cannot be locked it is not: it may be one that may be passed through but not opened, or on
    a file system without locks.
    """
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except PermissionError:
        yield
        return
    try:
        deadline = time.monotonic() + _PATIENCE_SECONDS
        while _try_lock(descriptor) is False:
            if time.monotonic() > deadline:
                raise TimeoutError(errno.ETIMEDOUT, "another run is writing there")
            time.sleep(0.01)
        yield
    finally:
        os.close(descriptor)


_aside: dict[Path, None] = {}
"""What this process has aside, in the order in which it came."""

_handlers: dict[int, Any] = {}
"""What was done about each signal before."""


@contextmanager
def _named_in(parent: Path) -> Iterator[Path]:
    """Give a name for something aside; what has it in the end, or when a signal comes, is removed.

    The name is known before anything has it, and removed by the signal itself: no moment is left out.
    """
    aside = parent / new_name()
    in_main_thread = threading.current_thread() is threading.main_thread()
    if not _aside and in_main_thread:
        for number in _SIGNALS:
            if signal.getsignal(number) is signal.SIG_DFL:
                _handlers[number] = signal.signal(number, _end)
    _aside[aside] = None
    try:
        yield aside
    finally:
        _remove(aside)
        del _aside[aside]
        if not _aside and in_main_thread:
            while _handlers:
                signal.signal(*_handlers.popitem())


def _end(number: int, frame: object) -> None:
    """End the run after a signal; further ones change nothing."""
    for each in _handlers:
        signal.signal(each, signal.SIG_IGN)
    for path in list(_aside):
        _remove(path)
    raise SystemExit(128 + number)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()
