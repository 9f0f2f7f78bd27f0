"""Reading files with limits, writing them whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from cordicc.diagnostics import Diagnostic, InvalidInput, Source

MAX_BYTES = 64 << 20


def failure(path: Path, what: str, error: Exception | None = None, hint: str | None = None) -> InvalidInput:
    """Return the error for a file that cannot be used."""
    reason = f": {getattr(error, 'strerror', None) or error}" if error is not None else ""
    return InvalidInput([Diagnostic("E600", f"{what}{reason}", None, hint, source=Source(str(path), ""))])


def read_text(path: Path, limit: int = MAX_BYTES) -> str:
    """Return the UTF-8 text of a file of at most `limit` bytes; raises InvalidInput."""
    try:
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as error:
        raise failure(path, "cannot read the file", error) from None
    if len(data) > limit:
        raise failure(path, f"the file is larger than {limit >> 20} MiB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise failure(path, f"the file is not UTF-8 (byte {error.start})") from None


def write_files(folder: Path, files: Mapping[str, str]) -> None:
    """Write text files into a folder, each appearing whole or not at all.

    All are written aside first, so that nothing of the folder changes if one cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise failure(folder, "is a file, not a folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise failure(folder, "cannot make the folder", error) from None
    _write(folder, files, folder)


def write_file(path: Path, content: str | bytes) -> None:
    """Write a file, whole or not at all, into a folder that exists; a device is written to."""
    if path.is_dir():
        raise failure(path, "is a folder, not a file")
    if not path.parent.is_dir():
        raise failure(path, f"no such folder: {path.parent}")
    if path.exists() and not path.is_file():
        try:
            path.write_bytes(_bytes(content))
        except OSError as error:
            raise failure(path, "cannot write the file", error) from None
        return
    final = path.resolve()
    _write(final.parent, {final.name: content}, path)


def _bytes(content: str | bytes) -> bytes:
    return content.encode() if isinstance(content, str) else content


def _write(folder: Path, files: Mapping[str, str | bytes], known_as: Path) -> None:
    staged: list[tuple[str, Path]] = []
    try:
        for name, content in files.items():
            handle, aside = tempfile.mkstemp(dir=folder, prefix=".cordicc.")
            staged.append((aside, folder / name))
            with os.fdopen(handle, "wb") as file:
                file.write(_bytes(content))
                file.flush()
                os.fsync(file.fileno())
            os.chmod(aside, 0o666 & ~_umask())
        for aside, final in staged:
            os.replace(aside, final)
    except (OSError, ValueError) as error:
        raise failure(known_as, "cannot write", error) from None
    finally:
        for aside, _ in staged:
            Path(aside).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
