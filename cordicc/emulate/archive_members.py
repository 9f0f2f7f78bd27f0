"""Members of a ZIP archive, read in pieces: memory follows what is asked for, not what comes of it.

`zipfile` reads the list of members.  Their data is decompressed here, since `zipfile` may make gigabytes of
a few compressed bytes before it hands out the first of them.
"""

from __future__ import annotations

import bz2
import io
import lzma
import struct
import zipfile
import zlib
from pathlib import Path
from typing import IO

MAX_LIST_BYTES = 8 << 20
"""Bytes of an archive's list of members, of about 150,000."""

MAX_DICTIONARY_BYTES = 64 << 20
"""Bytes of the dictionary that data compressed by LZMA may ask for."""

_PIECE = 1 << 16
_HEADER_BYTES = 30
_ENCRYPTED = 0x0041
"""Flags of encryption, plain and strong."""
_PATCHED = 0x0020

# What zipfile and the decompressors raise for lists and data that are not what they should be.
_BROKEN = (
    ArithmeticError, EOFError, LookupError, MemoryError, OSError, RuntimeError, TypeError, ValueError,
    lzma.LZMAError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


class DamagedArchiveError(Exception):
    """The archive is not what it should be; the text says why."""


class _ListReader(io.BufferedReader):
    """A file of which no piece larger than a list of members is read."""

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > MAX_LIST_BYTES:
            raise ValueError(f"its list of members is larger than {MAX_LIST_BYTES >> 20} MiB")
        return super().read(size)


def members(path: Path) -> list[zipfile.ZipInfo]:
    """Return the list of members of an archive.

    Raises:
        OSError: the file cannot be opened.
        DamagedArchiveError: it is no archive.
    """
    with _ListReader(io.FileIO(path)) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                return archive.infolist()
        except _BROKEN as error:
            raise DamagedArchiveError(reason_of(error)) from None


def reason_of(error: BaseException) -> str:
    """Return what an exception says in one short line, its kind if it says nothing."""
    return " ".join(str(error).split())[:200] or type(error).__name__


class Member:
    """The data of a member, read once from its start to its end; several may share a file."""

    def __init__(self, file: IO[bytes], info: zipfile.ZipInfo) -> None:
        """Find the data.

        Raises:
            DamagedArchiveError: there is none, or it is encrypted or of an unknown method.
        """
        if info.flag_bits & _ENCRYPTED:
            raise DamagedArchiveError("it is encrypted")
        if info.flag_bits & _PATCHED:
            raise DamagedArchiveError("it is a patch of other data")
        self._file, self._place, self._left = file, info.header_offset, _HEADER_BYTES
        head = self._raw(_HEADER_BYTES)
        if len(head) < _HEADER_BYTES or not head.startswith(b"PK\3\4"):
            raise DamagedArchiveError("it is not where the list of members says")
        self._place += sum(struct.unpack_from("<HH", head, 26))
        self._left = info.compress_size
        self._unpacker = self._unpacker_of(info.compress_type)
        self._crc, self._wanted_crc, self._read = 0, info.CRC, 0
        self.size = info.file_size
        """Bytes, as the list of members says; `finish` tells whether that is so."""

    def read(self, count: int) -> bytes:
        """Return the next bytes.

        Raises:
            DamagedArchiveError: there are not so many, or they cannot be decompressed.
        """
        data = bytearray()
        while len(data) < count:
            piece = self._next(count - len(data))
            if not piece:
                raise DamagedArchiveError("it is cut short")
            data += piece
        self._crc, self._read = zlib.crc32(data, self._crc), self._read + count
        return bytes(data)

    def finish(self) -> None:
        """Raise DamagedArchiveError unless all is read that there is, and its checksum is right."""
        if self._read != self.size or self._next(1):
            raise DamagedArchiveError("it is longer than the list of members says")
        if self._crc != self._wanted_crc:
            raise DamagedArchiveError("its checksum is wrong, the archive is damaged")

    def _raw(self, most: int) -> bytes:
        """Return the next bytes of the file, none at the end."""
        try:
            self._file.seek(self._place)
            data = self._file.read(min(most, self._left))
        except (OSError, ValueError, OverflowError) as error:
            raise DamagedArchiveError(reason_of(error)) from None
        self._place, self._left = self._place + len(data), self._left - len(data)
        return data

    def _unpacker_of(self, method: int) -> _Unpacker | None:
        if method == zipfile.ZIP_STORED:
            return None
        if method == zipfile.ZIP_DEFLATED:
            return _Inflater()
        if method == zipfile.ZIP_BZIP2:
            return bz2.BZ2Decompressor()
        if method == zipfile.ZIP_LZMA:
            return _lzma_decompressor(self._raw(9))
        raise DamagedArchiveError(f"it is compressed by method {method}, which is not known")

    def _next(self, most: int) -> bytes:
        """Return some of the next bytes, none at the end."""
        if self._unpacker is None:
            return self._raw(min(most, _PIECE))
        while not self._unpacker.eof:
            packed = self._raw(_PIECE) if self._unpacker.needs_input else b""
            try:
                made = self._unpacker.decompress(packed, most)
            except _BROKEN as error:
                raise DamagedArchiveError(reason_of(error)) from None
            if made:
                return made
            if not packed:
                break
        return b""


class _Inflater:
    """Raw deflate, with the interface of the other decompressors."""

    def __init__(self) -> None:
        self._inner = zlib.decompressobj(-zlib.MAX_WBITS)

    @property
    def eof(self) -> bool:
        return self._inner.eof

    @property
    def needs_input(self) -> bool:
        return not self._inner.unconsumed_tail

    def decompress(self, data: bytes, max_length: int) -> bytes:
        return self._inner.decompress(self._inner.unconsumed_tail + data, max_length)


_Unpacker = _Inflater | bz2.BZ2Decompressor | lzma.LZMADecompressor


def _lzma_decompressor(head: bytes) -> lzma.LZMADecompressor:
    """Return what decompresses data that starts with version, length of the properties, and these."""
    if len(head) < 9 or head[2:4] != b"\5\0":
        raise DamagedArchiveError("its LZMA header is broken")
    literal, dictionary = head[4], int.from_bytes(head[5:9], "little")
    if dictionary > MAX_DICTIONARY_BYTES:
        raise DamagedArchiveError(f"its LZMA dictionary is larger than {MAX_DICTIONARY_BYTES >> 20} MiB")
    settings = {"lc": literal % 9, "lp": literal // 9 % 5, "pb": literal // 45, "dict_size": dictionary}
    try:
        filters = [{"id": lzma.FILTER_LZMA1, **settings}]
        return lzma.LZMADecompressor(lzma.FORMAT_RAW, filters=filters)
    except _BROKEN as error:
        raise DamagedArchiveError(reason_of(error)) from None
