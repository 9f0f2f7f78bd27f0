"""Reading files with limits, writing them whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from cordicc.diagnostics import Diagnostic, InvalidInput, Source

MAX_BYTES = 64 << 20


def failure(path: Path, what: str, error: OSError | None = None, hint: str | None = None) -> InvalidInput:
    """Return the error for a file that cannot be used."""
    reason = f": {error.strerror or error}" if error is not None else ""
    return InvalidInput([Diagnostic("E600", f"{what}{reason}", None, hint, source=Source(str(path), ""))])


def read_text(path: Path, limit: int = MAX_BYTES) -> str:
    """Return the UTF-8 text of a file of at most `limit` bytes; raises InvalidInput."""
    try:
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except OSError as error:
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
    staged: list[tuple[str, Path]] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            handle, aside = tempfile.mkstemp(dir=folder, prefix=f".{name}.")
            staged.append((aside, folder / name))
            with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(aside, 0o666 & ~_umask())
        for aside, final in staged:
            os.replace(aside, final)
    except OSError as error:
        raise failure(folder, "cannot write the files", error) from None
    finally:
        for aside, _ in staged:
            Path(aside).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
