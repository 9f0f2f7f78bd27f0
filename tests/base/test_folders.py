"""Output folders change as a whole: whatever happens on the way, they are the old ones or the new ones."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from cordicc.base import folders
from cordicc.base.diagnostics import InvalidInput
from cordicc.base.folders import write_files
from cordicc.base.temporaries import new_name

OLD = {name: f"old {name}" for name in ("plan.json", "report.html", "simulate.py")}
NEW = {name: f"new {name}" * 1000 for name in OLD}


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir() if path.is_file()}


def test_a_new_folder_and_its_parents(tmp_path: Path) -> None:
    write_files(tmp_path / "build" / "arm", NEW)
    assert contents(tmp_path / "build" / "arm") == NEW
    assert [path.name for path in (tmp_path / "build").iterdir()] == ["arm"]
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "build" / "arm").stat().st_mode & 0o777 == 0o777 & ~umask
    assert (tmp_path / "build" / "arm" / "plan.json").stat().st_mode & 0o777 == 0o666 & ~umask


def test_what_else_is_in_a_folder_stays_and_so_does_the_folder(tmp_path: Path) -> None:
    write_files(tmp_path / "arm", OLD)
    (tmp_path / "arm" / "notes.txt").write_text("mine")
    (tmp_path / "arm" / "link").symlink_to("notes.txt")
    before = (tmp_path / "arm").stat()
    write_files(tmp_path / "arm", NEW)
    assert contents(tmp_path / "arm") == {**NEW, "notes.txt": "mine", "link": "mine"}
    assert (tmp_path / "arm" / "link").is_symlink()
    after = (tmp_path / "arm").stat()
    assert (after.st_ino, after.st_mode) == (before.st_ino, before.st_mode)
    assert [path.name for path in tmp_path.iterdir()] == ["arm"]


def test_a_folder_with_folders_in_it(tmp_path: Path) -> None:
    write_files(tmp_path / "arm", OLD)
    (tmp_path / "arm" / "sub").mkdir()
    write_files(tmp_path / "arm", NEW)
    assert contents(tmp_path / "arm") == NEW
    assert sorted(path.name for path in (tmp_path / "arm").iterdir()) == sorted([*NEW, "sub"])


def test_files_in_folders_of_the_folder(tmp_path: Path) -> None:
    old = {**OLD, "rtl/core.v": "old", "rtl/vectors/in.hex": "old"}
    new = {name: f"new {name}" for name in old}
    folder = tmp_path / "arm"
    for texts in (old, new):
        write_files(folder, texts)
        found = {str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file()}
        assert found == {**texts, **({"rtl/notes.txt": "mine"} if texts is new else {})}
        (folder / "rtl" / "notes.txt").write_text("mine")
    (folder / "rtl" / "build").mkdir()
    write_files(folder, old)
    assert (folder / "rtl" / "vectors" / "in.hex").read_text() == "old"
    assert (folder / "rtl" / "build").is_dir()
    write_files(folder, NEW)
    assert contents(folder) == NEW
    assert (folder / "rtl" / "core.v").read_text() == "old"


def test_a_file_where_a_folder_of_the_folder_belongs(tmp_path: Path) -> None:
    write_files(tmp_path / "arm", {"rtl": "mine"})
    with pytest.raises(InvalidInput, match="is a file, not a folder"):
        write_files(tmp_path / "arm", {"plan.json": "{}", "rtl/core.v": "new"})
    assert contents(tmp_path / "arm") == {"rtl": "mine"}


def test_the_folder_behind_a_link_is_written_to(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "here").symlink_to("there")
    write_files(tmp_path / "here", OLD)
    write_files(tmp_path / "here", NEW)
    assert (tmp_path / "here").is_symlink()
    assert contents(tmp_path / "there") == NEW


def test_leftovers_of_killed_runs_are_removed(tmp_path: Path) -> None:
    for left in (tmp_path / new_name(), tmp_path / "arm" / new_name()):
        left.mkdir(parents=True)
        (left / "plan.json").write_text("torn")
    (tmp_path / new_name()).write_text("torn")
    write_files(tmp_path / "arm", NEW)
    assert [path.name for path in tmp_path.iterdir()] == ["arm"]
    assert contents(tmp_path / "arm") == NEW
    assert not list((tmp_path / "arm").glob(".*"))


def test_what_only_looks_like_a_leftover_stays(tmp_path: Path) -> None:
    names = [
        ".arm.cordicc-backup",
        ".cordicc-notes",
        ".cordicc.x",
        f"{new_name()[:-1]}g",
        f".cordicc-{'0' * 24}",
    ]
    mine = [folder / name for folder in (tmp_path, tmp_path / "arm") for name in names]
    for path in mine:
        path.mkdir(parents=True)
        (path / "mine.txt").write_text("mine")
    write_files(tmp_path / "arm", OLD)
    write_files(tmp_path / "arm", NEW)
    assert all((path / "mine.txt").read_text() == "mine" for path in mine)
    assert len(list(tmp_path.iterdir())) == len(names) + 1
    assert contents(tmp_path / "arm") == NEW


@pytest.mark.parametrize("name", ["file", "loop", "file/below", "a\0b"])
def test_places_that_cannot_be_folders(name: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InvalidInput) as caught:
        write_files(tmp_path / name, NEW)
    assert [d.code for d in caught.value.diagnostics] == ["E600"]
    assert (tmp_path / "file").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "loop"]


def steps(monkeypatch: pytest.MonkeyPatch, act: Callable[[], None]) -> None:
    """Have `act` called before and after each change to the file system."""

    def watched(call: Callable[..., Any]) -> Callable[..., Any]:
        def step(*args: Any, **options: Any) -> Any:
            act()
            made = call(*args, **options)
            act()
            return made

        return step

    for place, name in [
        (folders, "write_new"), (folders, "exchange"), (os, "link"), (os, "replace"), (os, "rename"),
        (os, "unlink"), (os, "rmdir"), (os, "mkdir"), (os, "chmod"),
    ]:  # fmt: skip
        monkeypatch.setattr(place, name, watched(getattr(place, name)))


def killed_runs(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Iterator[int]:
    """Write into the folder with a process that dies at each step in turn; yield its status."""
    for last in range(1000):
        child = os.fork()
        if child == 0:
            count = 0

            def act(last: int = last) -> None:
                nonlocal count
                count += 1
                if count > last:
                    os._exit(9)

            steps(monkeypatch, act)
            write_files(folder, NEW)
            os._exit(0)
        yield os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_killed_at_any_step_over_an_old_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, mine = tmp_path / "arm", {"notes.txt": "mine"}
    write_files(folder, OLD | mine)
    seen = []
    for status in killed_runs(monkeypatch, folder):
        found = contents(folder)
        assert found in (OLD | mine, NEW | mine)
        if status == 0:
            assert found == NEW | mine
            break
        seen.append(found == NEW | mine)
        write_files(folder, OLD)
        assert [path.name for path in tmp_path.iterdir()] == ["arm"]
    assert len(seen) > 30
    assert set(seen) == {False, True}


def test_killed_at_any_step_of_a_new_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "arm"
    seen = []
    for status in killed_runs(monkeypatch, folder):
        found = contents(folder) if folder.exists() else {}
        assert found in ({}, NEW)
        if status == 0:
            assert found == NEW
            break
        seen.append(found == NEW)
        shutil.rmtree(folder, ignore_errors=True)
    assert set(seen) == {False, True}


@pytest.mark.parametrize("old", [True, False], ids=["over an old folder", "anew"])
def test_no_space_at_any_step(old: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "arm"
    write = folders.write_new
    for torn in range(2 * len(NEW)):
        if old:
            write_files(folder, OLD)
        left = torn

        def fail(path: Path, text: str) -> None:
            nonlocal left
            if left == 0:
                path.write_text(text[:100])
                raise OSError(28, "No space left on device")
            left -= 1
            write(path, text)

        with monkeypatch.context() as patched:
            patched.setattr(folders, "write_new", fail)
            if torn < len(NEW):
                with pytest.raises(InvalidInput, match="No space left"):
                    write_files(folder, NEW)
                assert (contents(folder) if folder.exists() else {}) == (OLD if old else {})
        assert {path.name for path in tmp_path.iterdir()} <= {"arm"}


def test_a_system_without_exchange(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Path) -> None:
        raise OSError(22, "Invalid argument")

    monkeypatch.setattr(folders, "exchange", missing)
    write_files(tmp_path / "arm", OLD)
    write_files(tmp_path / "arm", NEW)
    assert contents(tmp_path / "arm") == NEW
    assert [path.name for path in tmp_path.iterdir()] == ["arm"]
    assert len(list((tmp_path / "arm").iterdir())) == len(NEW)


def test_runs_at_one_time_leave_one_set(tmp_path: Path) -> None:
    folder = tmp_path / "arm"
    for _ in range(3):
        children = []
        for number in range(6):
            child = os.fork()
            if child == 0:
                for _ in range(20):
                    write_files(folder, dict.fromkeys(NEW, f"{number}"))
                os._exit(0)
            children.append(child)
        for child in children:
            assert os.waitpid(child, 0)[1] == 0
        assert len(set(contents(folder).values())) == 1
        assert [path.name for path in tmp_path.iterdir()] == ["arm"]
