"""Output folders whose files change together: a reader, and a killed run, leave the old ones or the new ones.

The new files are written into a folder beside.  Where the system can exchange the names of two folders in
one step, both are exchanged, the files of the old folder are replaced while the new one stands in its
place, and the names are exchanged back; so the folder stays the one that shells and programs have open.
Elsewhere the files are replaced one after the other.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path

from cordicc.base.files import failure, write_new
from cordicc.base.temporaries import folder_in, locked, new_name, remove_leftovers, umask

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2
"""Of Linux, <fcntl.h> and <linux/fs.h>."""


def write_files(folder: Path, files: Mapping[str, str], check: Callable[[], None] | None = None) -> None:
    """Write text files into a folder, all at once or none; what else is in the folder stays.

    `check` looks at what is there, and may raise, while no other run can write.  Raises InvalidInput (E600).
    """
    try:
        if folder.exists() and not folder.is_dir():
            raise failure(folder, "is a file, not a folder")
        final = Path(os.path.realpath(folder))
        for name in files:
            if (final / name).is_dir():
                raise failure(folder / name, "is a folder, not a file")
        final.parent.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise failure(folder, "cannot make the folder", error) from None
    try:
        with locked(final.parent):
            if check is not None:
                check()
            remove_leftovers(final.parent)
            remove_leftovers(final)
            if not _written_beside(final, files):
                _write_inside(final, files)
    except (OSError, ValueError) as error:
        raise failure(folder, "cannot write", error) from None


def _written_beside(final: Path, files: Mapping[str, str]) -> bool:
    """Write a folder beside and give it the name; tell whether that can be done here."""
    with ExitStack() as stack:
        try:
            fresh = stack.enter_context(folder_in(final.parent))
        except OSError:
            return False
        for name, text in files.items():
            write_new(fresh / name, text)
        if not final.exists():
            fresh.chmod(0o777 & ~umask())
            fresh.rename(final)
            return True
        return _taken_over(final, fresh, files)


def _taken_over(final: Path, fresh: Path, files: Mapping[str, str]) -> bool:
    """Give a folder the files of a fresh one in one step; False, with nothing changed, if it cannot be."""
    if not os.access(final, os.W_OK):
        return False
    others = [entry for entry in os.scandir(final) if entry.name not in files]
    try:
        for entry in others:  # folders cannot be linked
            os.link(entry.path, fresh / entry.name, follow_symlinks=False)
        fresh.chmod(final.stat().st_mode & 0o7777)
        exchange(final, fresh)
    except (OSError, AttributeError):
        return False
    old, new = fresh, final
    with suppress(OSError):  # if this fails, the fresh folder stays: it has everything
        for name in files:
            linked = old / new_name()
            os.link(new / name, linked)
            os.replace(linked, old / name)
        exchange(final, fresh)
    return True


def exchange(one: Path, other: Path) -> None:
    """Exchange the names of two folders in one step; raises AttributeError where there is no such call."""
    rename = ctypes.CDLL(None, use_errno=True).renameat2
    if rename(_AT_FDCWD, os.fsencode(one), _AT_FDCWD, os.fsencode(other), _RENAME_EXCHANGE):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))


def _write_inside(final: Path, files: Mapping[str, str]) -> None:
    """Replace the files of a folder one after the other, after all are written."""
    final.mkdir(exist_ok=True)
    with folder_in(final) as fresh:
        for name, text in files.items():
            write_new(fresh / name, text)
        for name in files:
            os.replace(fresh / name, final / name)
