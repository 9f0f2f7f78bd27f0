"""What is written aside: it takes a result's place or vanishes, whatever ends the run."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from cordicc.base import temporaries
from cordicc.base.temporaries import folder_in, is_own, new_name, remove_leftovers, replacing

ENDING = [signal.SIGTERM, signal.SIGHUP]


def in_a_process(act: Callable[[], None]) -> int:
    """Run something in a process of its own; return its status, negative if a signal ended it."""
    child = os.fork()
    if child == 0:
        status = 99
        try:
            act()
            status = 0
        except SystemExit as ended:
            status = int(str(ended.code))
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def test_names_check_themselves() -> None:
    names = {new_name() for _ in range(100)}
    assert len(names) == 100
    assert all(is_own(name) for name in names)
    assert not any(is_own(name[:-1] + ("0" if name[-1] != "0" else "1")) for name in names)


def test_a_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    final = tmp_path / "out"
    final.write_text("old")

    def torn() -> None:
        with replacing(final) as file:
            file.write(b"half")
            raise ValueError("torn")

    with pytest.raises(ValueError, match="torn"):
        torn()
    assert final.read_text() == "old"
    with replacing(final) as file:
        file.write(b"new")
        assert final.read_text() == "old"
    assert final.read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("number", ENDING)
@pytest.mark.parametrize("make", [lambda path: replacing(path / "out"), folder_in], ids=["file", "folder"])
def test_a_signal_clears_up(number: signal.Signals, make: Callable, tmp_path: Path) -> None:
    def act() -> None:
        with make(tmp_path) as aside, make(tmp_path):
            if isinstance(aside, Path):
                (aside / "plan.json").write_text("half")
            assert len(list(tmp_path.iterdir())) == 2
            os.kill(os.getpid(), number)
            time.sleep(5)

    assert in_a_process(act) == 128 + number
    assert not list(tmp_path.iterdir())


def test_signals_at_any_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before and after each change to the file system, a second one during the clearing up included."""
    statuses = []
    for last in range(100):

        def act(last: int = last) -> None:
            count = 0

            def watched(call: Callable) -> Callable:
                def step(*arguments: object, **options: object) -> object:
                    nonlocal count
                    for moment in (lambda: None, lambda: call(*arguments, **options)):
                        made = moment()
                        count += 1
                        if count in (last + 1, last + 3):
                            os.kill(os.getpid(), signal.SIGTERM)
                    return made

                return step

            for name in ("open", "fsync", "chmod", "replace", "unlink", "mkdir", "rmdir"):
                monkeypatch.setattr(os, name, watched(getattr(os, name)))
            with folder_in(tmp_path) as aside, (aside / "x").open("w"):
                pass
            with replacing(tmp_path / "out") as file:
                file.write(b"new")

        statuses.append(in_a_process(act))
        names = [path.name for path in tmp_path.iterdir()]
        assert names in ([], ["out"])
        if statuses[-1] == 0:
            break
    assert len(statuses) > 10
    # The last steps come after everything is done, where the signal ends a process as it always did.
    assert set(statuses[:-4]) == {128 + signal.SIGTERM}


def test_handlers_of_the_program_stay(tmp_path: Path) -> None:
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    with replacing(tmp_path / "out"):
        assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        with replacing(tmp_path / "out"):
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_other_threads_write_too(tmp_path: Path) -> None:
    def write() -> None:
        with replacing(tmp_path / "out") as file:
            file.write(b"new")

    thread = threading.Thread(target=write)
    thread.start()
    thread.join()
    assert (tmp_path / "out").read_text() == "new"


def test_what_a_killed_run_left_is_removed_by_the_next(tmp_path: Path) -> None:
    def act() -> None:
        with replacing(tmp_path / "out") as file, folder_in(tmp_path):
            file.write(b"half")
            os.kill(os.getpid(), signal.SIGKILL)

    assert in_a_process(act) == -signal.SIGKILL
    left = sorted(path.name for path in tmp_path.iterdir())
    assert len(left) == 2
    assert all(map(is_own, left))
    with replacing(tmp_path / "other"):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["other"]


def test_what_another_run_has_aside_stays(tmp_path: Path) -> None:
    with replacing(tmp_path / "out") as file, folder_in(tmp_path) as aside:
        file.write(b"new")
        (aside / "x").write_text("new")

        def other() -> None:
            remove_leftovers(tmp_path)
            with replacing(tmp_path / "other") as second:
                second.write(b"other")

        assert in_a_process(other) == 0
        assert (aside / "x").read_text() == "new"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["other", "out"]


def test_without_locks_nothing_is_taken_for_a_leftover(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(temporaries, "fcntl", None)
    left = tmp_path / new_name()
    left.write_text("perhaps in use")
    with temporaries.locked(tmp_path), replacing(tmp_path / "out"):
        pass
    assert left.exists()


def test_links_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").write_text("mine")
    (tmp_path / new_name()).symlink_to("mine")
    remove_leftovers(tmp_path)
    assert (tmp_path / "mine" / "file").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2
