"""Columns of numbers in NumPy's .npz, read a part at a time.

What the header of an array says is checked against what the archive says that it holds, before any of it
is read; the header is taken apart by a pattern, never evaluated.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple
from zipfile import ZipInfo

import numpy as np

from cordicc.base.arrays import Floats
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.base.files import failure
from cordicc.emulate.archive_members import DamagedArchiveError, Member, members
from cordicc.emulate.sample_columns import Columns, OpenedTable, choose

MAX_HEADER_BYTES = 10_000
"""Bytes of an array's header, as NumPy allows; that of a plain array takes 128."""

_MAGIC = b"\x93NUMPY"
_LENGTHS = {1: "<H", 2: "<I", 3: "<I"}
"""How the length of the header is written, by the version of the format."""

_ENTRY = re.compile(
    r"""\s*(?P<mark>['"])(?P<key>\w+)(?P=mark)\s*:\s*
    (?:'(?P<text>[^'\\]*)'|"(?P<text2>[^"\\]*)"|(?P<flag>True|False)|\((?P<numbers>[\d\sL,]*)\))\s*(?:,|(?=\}))""",
    re.VERBOSE | re.ASCII,
)
_MOST_DIGITS = 18
_REAL = re.compile(r"[<>=|]?(?:f(?:2|4|8|16)|[iu][1248]|b1)")
_OTHER = re.compile(r"[<>=|]?(?:[SUV]\d+|O|c(?:8|16|32)|[Mm]8(?:\[\w+\])?)", re.ASCII)


def read_npz(path: Path, columns: Columns, part: int) -> OpenedTable:
    """Open an archive of arrays; what follows their headers is read as the parts are taken.

    Raises:
        InvalidInput: now or while parts are taken, see `cordicc.emulate.sample_tables.read_table`.
    """
    source = Source(str(path), "")
    if path.exists() and not path.is_file():
        raise failure(path, "cannot read the file: an archive is read from a plain file")
    try:
        listed = members(path)
        file = path.open("rb")
    except (OSError, ValueError) as error:
        raise failure(path, "cannot read the file", error) from None
    except DamagedArchiveError as error:
        raise _unreadable(f"not an .npz archive: {error}", source) from None
    try:
        header = [info.filename.removesuffix(".npy") for info in listed]
        names, warnings = choose(header, columns, source)
        infos = dict(zip(header, listed, strict=True))
        arrays = [_Array.opened(name, file, infos[name], source) for name in names]
        counts = {array.name: array.rows for array in arrays}
        if len(set(counts.values())) > 1:
            told = ", ".join(f"{name}: {count}" for name, count in counts.items())
            raise InvalidInput([Diagnostic("E613", f"arrays of different lengths ({told})", source=source)])
    except InvalidInput:
        file.close()
        raise
    return OpenedTable(names, _parts(file, arrays, part, columns.nan), warnings)


def _parts(file: IO[bytes], arrays: list[_Array], part: int, nan: bool) -> Iterator[dict[str, Floats]]:
    """Yield the numbers of so many rows at a time, at least once."""
    total = min((array.rows for array in arrays), default=0)
    with file:
        for begin in range(0, max(1, total), part):
            end = min(total, begin + part)
            taken = {array.name: array.take(end - begin) for array in arrays}
            for array in arrays:
                if end == total:  # a damaged archive is told before what it does to numbers
                    array.finish()
                if not nan:
                    array.require_finite(taken[array.name], begin)
            yield taken


def _unreadable(message: str, source: Source) -> InvalidInput:
    return InvalidInput([Diagnostic("E611", message, source=source)])


class _Array(NamedTuple):
    """An array of an archive, open for reading after its header."""

    name: str
    member: Member
    kind: np.dtype[np.generic]
    rows: int
    source: Source

    @classmethod
    def opened(cls, name: str, file: IO[bytes], info: ZipInfo, source: Source) -> _Array:
        """Read the header of an array.

        Raises:
            InvalidInput: there is none, it is of another kind of array (E614), or the member is of another
                size than it says.
        """
        try:
            member = Member(file, info)
            text, length = _header(member)
            kind, shape = _described(text)
            if kind is None or len(shape) != 1:
                message = f"array '{name}' is not a one-dimensional array of real numbers"
                raise InvalidInput([Diagnostic("E614", message, source=source)])
            if length + shape[0] * kind.itemsize != member.size:
                held = member.size - length
                raise DamagedArchiveError(
                    f"its header says {shape[0]} numbers of {kind.itemsize} bytes, the archive {held} bytes"
                )
        except DamagedArchiveError as error:
            raise _unreadable(f"array '{name}' cannot be read: {error}", source) from None
        return cls(name, member, kind, shape[0], source)

    def take(self, count: int) -> Floats:
        """Return the next numbers.  Raises InvalidInput for damaged data."""
        try:
            data = self.member.read(count * self.kind.itemsize)
        except DamagedArchiveError as error:
            raise _unreadable(f"array '{self.name}' cannot be read: {error}", self.source) from None
        with np.errstate(over="ignore", invalid="ignore"):  # wider numbers than double ones
            return np.frombuffer(data, dtype=self.kind).astype(np.float64)

    def require_finite(self, numbers: Floats, begin: int) -> None:
        """Raise InvalidInput for a number that is not finite; `begin` counts those before the first."""
        finite = np.isfinite(numbers)
        if not finite.all():
            row = begin + int(np.argmin(finite)) + 1
            message = f"row {row} of array '{self.name}' is not a finite number"
            raise InvalidInput([Diagnostic("E614", message, source=self.source)])

    def finish(self) -> None:
        """Raise InvalidInput unless the array ends here, with the right checksum."""
        try:
            self.member.finish()
        except DamagedArchiveError as error:
            raise _unreadable(f"array '{self.name}' cannot be read: {error}", self.source) from None


def _header(member: Member) -> tuple[str, int]:
    """Return the header of an array, and the bytes before its numbers.  Raises DamagedArchiveError."""
    lead = member.read(8)
    if not lead.startswith(_MAGIC):
        raise DamagedArchiveError("it is not an array of NumPy")
    version = lead[6]
    if version not in _LENGTHS or lead[7] != 0:
        raise DamagedArchiveError(f"its format has version {version}.{lead[7]}, not 1.0, 2.0 or 3.0")
    written = struct.calcsize(_LENGTHS[version])
    (length,) = struct.unpack(_LENGTHS[version], member.read(written))
    if length > MAX_HEADER_BYTES:
        raise DamagedArchiveError(f"its header of {length} bytes is longer than {MAX_HEADER_BYTES}")
    # Names of fields alone are not ASCII, and arrays with fields are refused.
    return member.read(length).decode("ascii", "replace"), len(lead) + written + length


def _described(header: str) -> tuple[np.dtype[np.generic] | None, tuple[int, ...]]:
    """Return kind and shape of an array, None for one of no real numbers; raises DamagedArchiveError."""
    shown = header.strip()
    entries = {}
    place = 1
    while shown.startswith("{") and (entry := _ENTRY.match(shown, place)) is not None:
        entries[entry["key"]] = entry
        place = entry.end()
    whole = shown[place:].strip() == "}" and entries.keys() == {"descr", "fortran_order", "shape"}
    if not whole or entries["shape"]["numbers"] is None or entries["fortran_order"]["flag"] is None:
        raise DamagedArchiveError(f"its header is not that of an array of numbers: {shown[:80]!r}")
    sides = [side.strip().removesuffix("L") for side in entries["shape"]["numbers"].split(",")]
    sides = sides[:-1] if sides[-1] == "" else sides
    if not all(side.isdecimal() and len(side) <= _MOST_DIGITS for side in sides):
        raise DamagedArchiveError(f"its shape is ({entries['shape']['numbers'][:80]})")
    descr = entries["descr"]["text"] or entries["descr"]["text2"] or ""
    return _real(descr), tuple(map(int, sides))


def _real(descr: str) -> np.dtype[np.generic] | None:
    """Return the type of numbers, or of truth values, that a header names; None for texts, times and so on.

    Raises DamagedArchiveError for no type, and for numbers of 16 bytes where the machine has none.
    """
    try:
        if _REAL.fullmatch(descr):
            return np.dtype(descr)
    except TypeError:
        pass
    if _OTHER.fullmatch(descr):
        return None
    raise DamagedArchiveError(f"its header says that its type is {descr[:80]!r}")
