"""Archives of arrays: the damaged and strange are E611 with a reason, in little memory; others are read."""

from __future__ import annotations

import io
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cordicc.base.diagnostics import InvalidInput
from cordicc.emulate import archive_members
from cordicc.emulate.sample_columns import Columns
from cordicc.emulate.sample_tables import read_table
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.plans import planned

HEADER = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }\n"
TWO = struct.pack("<dd", 0.25, -3.0)
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA)


def array(header: str = HEADER, data: bytes = TWO, version: bytes = b"\1\0") -> bytes:
    length = struct.pack("<H" if version == b"\1\0" else "<I", len(header))
    return b"\x93NUMPY" + version + length + header.encode("latin-1") + data


def archive(content: bytes, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as made:
        made.writestr("x.npy", content)
    return file.getvalue()


def patched(data: bytes, *changes: tuple[int, int, int]) -> bytes:
    """Change bytes of the member's own header and of the list: offset in either, and the new value."""
    made, listed = bytearray(data), data.find(b"PK\1\2")
    for own, in_list, value in changes:
        if own >= 0:
            made[own] = value
        made[listed + in_list] = value
    return bytes(made)


def read(data: bytes, folder: Path, part: int = 65536) -> np.ndarray:
    (folder / "in.npz").write_bytes(data)
    parts = read_table(folder / "in.npz", Columns(["x"]), part).parts
    return np.concatenate([each["x"] for each in parts])


def noise(count: int) -> bytes:
    return np.random.Generator(np.random.PCG64(1)).bytes(count)


def torn(method: int) -> bytes:
    """Return an archive whose compressed data has other bytes in the middle."""
    rows = array(HEADER.replace("(2,)", "(4000,)"), noise(32000))
    data = bytearray(archive(rows, method))
    data[10_000:10_100] = bytes(100)
    return bytes(data)


def headed(old: str, new: str, data: bytes = TWO) -> Callable[[], bytes]:
    return lambda: archive(array(HEADER.replace(old, new), data))


DAMAGED: dict[str, tuple[Callable[[], bytes], str]] = {
    "a negative shape": (headed("(2,)", "(-1,)"), "not that of an array of numbers"),
    "a shape of a truth value": (headed("(2,)", "(True,)"), "not that of an array of numbers"),
    "a shape beyond the member": (headed("(2,)", "(3,)"), "says 3 numbers of 8 bytes, the archive 16 bytes"),
    "a shape short of the member": (headed("(2,)", "(1,)"), "says 1 numbers of 8 bytes"),
    "a shape beyond all": (headed("2", "1" + "0" * 30), "its shape is (1000"),
    "a shape beyond memory": (headed("2", str(2**60 - 1)), "its shape is"),
    "no type": (headed("'<f8'", "None"), "not that of an array of numbers"),
    "a tuple for a type": (headed("'<f8'", "()"), "its type is ''"),
    "a type that does not exist": (headed("<f8", "f1000"), "its type is 'f1000'"),
    "a type of no bytes": (headed("<f8", "f0"), "its type is 'f0'"),
    "fields": (headed("'<f8'", "[('a', '<f8'), ('a', '<f8')]"), "not that of an array of numbers"),
    "half a surrogate pair": (headed("<f8", r"\ud800"), "not that of an array of numbers"),
    "a call": (headed("'<f8'", "__import__('os').system('true')"), "not that of an array of numbers"),
    "a key that is no name": (lambda: archive(array("{[]: 1}\n")), "not that of an array of numbers"),
    "an open bracket": (lambda: archive(array("{'descr': '<f8', 'shape': (2L,\n")), "not that of an array"),
    "an open quote": (lambda: archive(array("'''abc\n")), "not that of an array of numbers"),
    "9,000 signs": (lambda: archive(array("-" * 9000 + "1\n")), "not that of an array of numbers"),
    "9,000 brackets": (lambda: archive(array("(" * 9000)), "not that of an array of numbers"),
    "a header beyond all": (
        lambda: archive(b"\x93NUMPY\2\0" + struct.pack("<I", 3 << 30)), "its header of 3221225472 bytes",
    ),
    "another version": (lambda: archive(array(version=b"\t\t")), "version 9.9"),
    "no array": (lambda: archive(b"x\n0.5\n0.75\n"), "not an array of NumPy"),
    "nothing": (lambda: archive(b""), "cut short"),
    "a start alone": (lambda: archive(b"\x93NUMPY\1\0"), "cut short"),
    "half a header": (lambda: archive(array()[:40]), "cut short"),
    "an encrypted member": (lambda: patched(archive(array()), (6, 8, 1)), "encrypted"),
    "a strongly encrypted member": (lambda: patched(archive(array()), (6, 8, 0x41)), "encrypted"),
    "a patch": (lambda: patched(archive(array()), (6, 8, 0x20)), "a patch of other data"),
    "an unknown method": (lambda: patched(archive(array()), (8, 10, 99)), "method 99"),
    "another method": (lambda: patched(archive(array(data=noise(16))), (8, 10, 12)), "cannot be read"),
    "another checksum": (lambda: patched(archive(array()), (-1, 16, 1), (-1, 17, 2)), "its checksum"),
    "more than is listed": (
        lambda: patched(archive(array(data=TWO + bytes(8))), (-1, 24, len(array()))), "longer than the list",
    ),
    "less than is listed": (
        lambda: patched(archive(array(HEADER.replace("2", "3"))), (-1, 24, len(array()) + 8)), "cut short",
    ),
    "another place": (lambda: patched(archive(array()), (-1, 42, 9)), "not where the list of members says"),
    "a place beyond the end": (lambda: patched(archive(array()), (-1, 44, 99)), "not where the list"),
    "LZMA without its header": (lambda: patched(archive(array(data=b"")), (8, 10, 14)), "LZMA header"),
    "a torn list": (lambda: archive(array())[:-30] + bytes(30), "not an .npz archive"),
    "a list of another version": (lambda: patched(archive(array()), (-1, 6, 99)), "not an .npz archive"),
    "a text": (lambda: b"x\n0.5\n", "not an .npz archive"),
    **{f"torn data of method {m}": (lambda m=m: torn(m), "cannot be read") for m in METHODS},
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGED)
def test_damaged_archives(name: str, tmp_path: Path) -> None:
    make, reason = DAMAGED[name]
    with pytest.raises(InvalidInput) as caught:
        read(make(), tmp_path)
    (finding,) = caught.value.diagnostics
    assert finding.code == "E611"
    assert finding.source is not None
    assert finding.source.name.endswith("in.npz")
    assert reason in finding.message


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("part", [65536, 3000])
def test_every_method_in_parts(method: int, part: int, tmp_path: Path) -> None:
    numbers = np.frombuffer(noise(80_000), np.int64).astype(np.float64)
    file = io.BytesIO()
    np.save(file, numbers)
    assert np.array_equal(read(archive(file.getvalue(), method), tmp_path, part), numbers)


@pytest.mark.parametrize(
    "header",
    [
        HEADER,
        '{"shape":(2,),"fortran_order":True,"descr":"<f8"}',
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2L,)}" + " " * 9000,
    ],
)
@pytest.mark.parametrize("version", [b"\1\0", b"\2\0", b"\3\0"])
def test_headers_of_other_programs(header: str, version: bytes, tmp_path: Path) -> None:
    assert read(archive(array(header, version=version)), tmp_path).tolist() == [0.25, -3.0]


@pytest.mark.parametrize("kind", ["<f2", ">f4", "=f8", "|i1", ">i2", "<u4", "<i8", "|b1"])
def test_real_numbers_of_every_type(kind: str, tmp_path: Path) -> None:
    data = np.array([0, 1], dtype=kind).tobytes()
    assert read(archive(array(HEADER.replace("<f8", kind), data)), tmp_path).tolist() == [0, 1]


@pytest.mark.parametrize("kind", ["|O", "<U3", "|S8", "|V8", "<c16", "<M8[ns]"])
def test_other_types_are_not_read(kind: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match=r"E614.*not a one-dimensional array of real numbers"):
        read(archive(array(HEADER.replace("<f8", kind))), tmp_path)


@pytest.mark.parametrize("method", METHODS[1:])
def test_memory_does_not_follow_what_an_archive_unpacks_to(method: int, tmp_path: Path) -> None:
    """A few compressed bytes stand for 32 MB, of which no more is held than is asked for."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method) as made:
        made.writestr("x.npy", array(HEADER.replace("2", str(1 << 22)), bytes(32 << 20)))
    (tmp_path / "in.npz").write_bytes(file.getvalue())
    tracemalloc.start()
    try:
        rows = sum(len(each["x"]) for each in read_table(tmp_path / "in.npz", Columns(["x"])).parts)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert rows == 1 << 22
    assert peak < 16 << 20


def test_an_lzma_dictionary_is_bounded(tmp_path: Path) -> None:
    data = bytearray(archive(array(), zipfile.ZIP_LZMA))
    place = 30 + len("x.npy") + 5
    data[place : place + 4] = struct.pack("<I", 3 << 30)
    with pytest.raises(InvalidInput, match="LZMA dictionary is larger than 64 MiB"):
        read(bytes(data), tmp_path)


def test_a_list_of_members_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as made:
        made.writestr("x.npy", array())
        for number in range(200):
            made.writestr(f"{number}.npy", b"")
    assert len(read(file.getvalue(), tmp_path)) == 2
    monkeypatch.setattr(archive_members, "MAX_LIST_BYTES", 4096)
    with pytest.raises(InvalidInput, match="its list of members is larger"):
        read(file.getvalue(), tmp_path)


def test_a_folder_is_no_archive(tmp_path: Path) -> None:
    (tmp_path / "in.npz").mkdir()
    with pytest.raises(InvalidInput, match=r"E600.*read from a plain file"):
        read_table(tmp_path / "in.npz", Columns(["x"]))


def test_every_byte_of_an_archive_may_be_wrong(tmp_path: Path) -> None:
    good = archive(array(HEADER.strip(), TWO))
    told = set()
    for place in range(len(good)):
        try:
            assert len(read(good[:place] + bytes([good[place] ^ 1]) + good[place + 1 :], tmp_path)) == 2
        except InvalidInput as error:
            told |= {each.code for each in error.diagnostics}
    assert told == {"E611", "E612"}


def test_simulate_compares_its_own_outputs(tmp_path: Path) -> None:
    """`valid` is an array of truth values there."""
    plan = tmp_path / "plan.json"
    plan.write_text(planned(EXAMPLES / "planar_2r.yaml").to_json(), encoding="utf-8")
    np.savez_compressed(tmp_path / "in.npz", x=[0.3, 0.4], y=[0.1, 9.0])
    out = tmp_path / "out.npz"
    assert run("simulate", plan, "--inputs", tmp_path / "in.npz", "--outputs", out).exit_code == 0
    done = run("simulate", plan, "--compare", tmp_path / "in.npz", out)
    assert (done.exit_code, "as expected" in done.stdout) == (0, True), done.output
