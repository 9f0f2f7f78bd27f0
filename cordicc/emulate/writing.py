"""Outputs written a part at a time, to CSV or NumPy's .npz; a file appears whole or not at all."""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from cordicc.base.files import failure
from cordicc.base.temporaries import replacing

Write = Callable[[Mapping[str, NDArray[Any]]], None]

_NO_TIME = (1980, 1, 1, 0, 0, 0)


def csv_header(names: Sequence[str]) -> str:
    """Return the first line: the outputs, then `valid`."""
    return ",".join([*names, "valid"]) + "\n"


def csv_rows(names: Sequence[str], outputs: Mapping[str, NDArray[Any]]) -> str:
    """Return a line per sample, with enough digits to round-trip."""
    columns = [[repr(x) for x in outputs[name].tolist()] for name in names]
    columns.append(["1" if ok else "0" for ok in outputs["valid"].tolist()])
    return "".join(",".join(row) + "\n" for row in zip(*columns, strict=True))


@contextmanager
def table_writer(path: Path, names: Sequence[str]) -> Iterator[Write]:
    """Open a file for the named outputs and `valid`; yields what takes a part after the other.

    A .npz file gets one array for each output, float64, and `valid`, bool, uncompressed.  Raises
    InvalidInput if the file cannot be written.
    """
    if path.is_dir():
        raise failure(path, "is a folder, not a file")
    if not path.parent.is_dir():
        raise failure(path, f"no such folder: {path.parent}")
    opened = _npz(path, names) if path.suffix == ".npz" else _csv(path, names)
    try:
        with opened as write:
            yield write
    except OSError as error:
        raise failure(path, "cannot write the file", error) from None


@contextmanager
def _csv(path: Path, names: Sequence[str]) -> Iterator[Write]:
    with ExitStack() as stack:
        if path.exists() and not path.is_file():  # a device, a pipe
            file: IO[bytes] = stack.enter_context(path.open("wb"))
        else:
            file = stack.enter_context(replacing(path.resolve()))
        file.write(csv_header(names).encode())
        yield lambda outputs: _ignore(file.write(csv_rows(names, outputs).encode()))


@contextmanager
def _npz(path: Path, names: Sequence[str]) -> Iterator[Write]:
    """Collect each array in a file of its own: a zip archive takes one member at a time."""
    with ExitStack() as stack:
        file = stack.enter_context(replacing(path.resolve()))
        folder = path.resolve().parent
        arrays = {name: stack.enter_context(tempfile.TemporaryFile(dir=folder)) for name in (*names, "valid")}

        def write(outputs: Mapping[str, NDArray[Any]]) -> None:
            for name, array in arrays.items():
                array.write(outputs[name].astype(_kind(name)).tobytes())

        yield write
        with zipfile.ZipFile(file, "w", allowZip64=True) as archive:
            for name, array in arrays.items():
                rows = array.tell() // _kind(name).itemsize
                array.seek(0)
                with archive.open(zipfile.ZipInfo(f"{name}.npy", _NO_TIME), "w", force_zip64=True) as member:
                    header = {"descr": _kind(name).str, "fortran_order": False, "shape": (rows,)}
                    np.lib.format.write_array_header_1_0(member, header)
                    shutil.copyfileobj(array, member, 1 << 20)


def _kind(name: str) -> np.dtype[Any]:
    return np.dtype("|b1" if name == "valid" else "<f8")


def _ignore(_: object) -> None:
    """Take a result that nobody wants."""
