"""Reading files with limits, writing a file whole or not at all."""

from __future__ import annotations

import errno
import os
import select
import stat
import time
from pathlib import Path

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.base.temporaries import replacing, umask

MAX_BYTES = 64 << 20

PATIENCE_SECONDS = 60.0
"""For which a pipe or a terminal may keep a reader waiting."""

_CHUNK = 1 << 20


def failure(path: Path, what: str, error: Exception | None = None, hint: str | None = None) -> InvalidInput:
    """Return the error for a file that cannot be used."""
    reason = f": {getattr(error, 'strerror', None) or error}" if error is not None else ""
    return InvalidInput([Diagnostic("E600", f"{what}{reason}", None, hint, source=Source(str(path), ""))])


def read_bytes(path: Path, limit: int) -> bytes:
    """Return what a file holds, one byte more than `limit` at the most, without waiting forever.

    Raises:
        OSError, ValueError: it cannot be read, or a pipe yields nothing.
    """
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
    with os.fdopen(handle, "rb", buffering=0) as file:
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        data = bytearray()
        deadline = time.monotonic() + PATIENCE_SECONDS
        while len(data) <= limit:
            part = file.read(min(_CHUNK, limit + 1 - len(data)))
            if part:
                data += part
            elif part is not None:
                break
            elif not select.select([file], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise TimeoutError(errno.ETIMEDOUT, f"nothing came for {PATIENCE_SECONDS:.0f} seconds")
    return bytes(data)


def read_text(path: Path, limit: int = MAX_BYTES) -> str:
    """Return the UTF-8 text of a file of at most `limit` bytes; raises InvalidInput."""
    try:
        data = read_bytes(path, limit)
    except (OSError, ValueError) as error:
        raise failure(path, "cannot read the file", error) from None
    if len(data) > limit:
        raise failure(path, f"the file is larger than {limit >> 20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise failure(path, f"the file is not UTF-8 (byte {error.start})") from None


def write_file(path: Path, content: str | bytes) -> None:
    """Write a file, whole or not at all, into a folder that exists; a device is written to."""
    try:
        if path.is_dir():
            raise failure(path, "is a folder, not a file")
        if not path.parent.is_dir():
            raise failure(path, f"no such folder: {path.parent}")
        if path.exists() and not path.is_file():
            path.write_bytes(_bytes(content))
        else:
            _replace(Path(os.path.realpath(path)), content)
    except (OSError, ValueError) as error:
        raise failure(path, "cannot write the file", error) from None


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def _replace(final: Path, content: str | bytes) -> None:
    with replacing(final) as file:
        file.write(_bytes(content))


def write_new(path: Path, content: str | bytes) -> None:
    """Write a file that nobody reads yet, down to the disk; raises OSError."""
    with path.open("wb") as file:
        file.write(_bytes(content))
        file.flush()
        os.fsync(file.fileno())
    path.chmod(0o666 & ~umask())
