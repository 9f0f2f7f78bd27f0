"""Output folders whose files change together: a reader, and a killed run, leave the old ones or the new ones.

The new files are written into a folder beside.  Where the system can exchange the names of two folders in
one step, both are exchanged, the files of the old folder are replaced while the new one stands in its
place, and the names are exchanged back; so the folder stays the one that shells and programs have open.
Elsewhere the files are replaced one after the other.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path

from cordicc.base.files import failure, write_new
from cordicc.base.temporaries import folder_in, locked, new_name, remove_leftovers, umask

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2
"""Of Linux, <fcntl.h> and <linux/fs.h>."""


def write_files(folder: Path, files: Mapping[str, str], check: Callable[[], None] | None = None) -> None:
    """Write text files into a folder, all at once or none; what else is in the folder stays.

    A name may be that of a file in a folder of it, `rtl/core.v`.  `check` looks at what is there, and may
    raise, while no other run can write.  Raises InvalidInput (E600).
    """
    try:
        if folder.exists() and not folder.is_dir():
            raise failure(folder, "is a file, not a folder")
        final = Path(os.path.realpath(folder))
        for name in files:
            if (final / name).is_dir():
                raise failure(folder / name, "is a folder, not a file")
        for inner in _inner(files):
            if (final / inner).exists() and not (final / inner).is_dir():
                raise failure(folder / inner, "is a file, not a folder")
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
        _write_all(fresh, files)
        if not final.exists():
            fresh.chmod(0o777 & ~umask())
            fresh.rename(final)
            return True
        return _taken_over(final, fresh, files)


def _taken_over(final: Path, fresh: Path, files: Mapping[str, str]) -> bool:
    """Give a folder the files of a fresh one in one step; False, with nothing changed, if it cannot be."""
    if not os.access(final, os.W_OK):
        return False
    try:
        for inner in (Path(), *_inner(files)):
            if (final / inner).is_dir():
                _link_others(final, fresh, inner, files)
        exchange(final, fresh)
    except (OSError, AttributeError):
        return False
    old, new = fresh, final
    with suppress(OSError):  # if this fails, the fresh folder stays: it has everything
        for name in files:
            linked = old / new_name()
            os.link(new / name, linked)
            (old / name).parent.mkdir(parents=True, exist_ok=True)
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
        _write_all(fresh, files)
        for name in files:
            (final / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(fresh / name, final / name)


def _write_all(folder: Path, files: Mapping[str, str]) -> None:
    for inner in _inner(files):
        (folder / inner).mkdir()
    for name, text in files.items():
        write_new(folder / name, text)


def _inner(files: Iterable[str]) -> list[Path]:
    """Return the folders of files inside their folder, each after the one that it is in."""
    return sorted({inner for name in files for inner in Path(name).parents} - {Path()})


def _link_others(old: Path, new: Path, inner: Path, files: Mapping[str, str]) -> None:
    """Link what is in a folder besides files into a new one; raises OSError for other folders in it."""
    own = {*map(Path, files), *_inner(files)}
    with os.scandir(old / inner) as entries:
        for entry in entries:
            if inner / entry.name not in own:
                os.link(entry.path, new / inner / entry.name, follow_symlinks=False)  # not of a folder
            elif entry.is_symlink() and inner / entry.name not in map(Path, files):
                raise NotADirectoryError(entry.path)
    (new / inner).chmod((old / inner).stat().st_mode & 0o7777)
