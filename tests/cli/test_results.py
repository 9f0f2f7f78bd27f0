"""Folders of results: cordicc replaces what it made, and nobody else's files unless it is told to."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import cordicc
from cordicc.artefacts import artefacts
from cordicc.base.diagnostics import InvalidInput
from cordicc.base.temporaries import is_own
from cordicc.cli.results import require_own, write_results
from cordicc.studies import trade_off
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.plans import planned
from tests.support.selection import slow

PROBLEM = "name: p\ninputs: {x: [0.5, 1]}\nequations: [w = 2*x]\n"
FILES = [
    "plan.json",
    "report.html",
    "datapath.svg",
    "schedule.svg",
    "simulate.py",
    "planar_2r.c",
    "planar_2r.h",
]


@pytest.fixture(scope="module")
def plan() -> cordicc.Plan:
    return planned(EXAMPLES / "planar_2r.yaml")


@pytest.fixture(scope="module")
def results(plan: cordicc.Plan) -> dict[str, str]:
    made = artefacts(plan, ["c"])
    assert list(made) == FILES
    return made


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def refused(folder: Path, files: dict[str, str]) -> list[str]:
    """Return the files for which a folder is not written, in which nothing changes."""
    before = contents(folder)
    with pytest.raises(InvalidInput) as caught:
        write_results(folder, files)
    assert contents(folder) == before
    assert {each.code for each in caught.value.diagnostics} == {"E604"}
    assert all("--force" in str(each.hint) for each in caught.value.diagnostics)
    return [Path(each.source.name).name for each in caught.value.diagnostics if each.source]


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_the_users_stays(name: str, results: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    (tmp_path / name).write_text("made by me, with cordicc\n", encoding="utf-8")
    assert refused(tmp_path, results) == [name]
    write_results(tmp_path, results, force=True)
    assert contents(tmp_path) == results | {"notes.txt": "mine"}


def test_all_of_them_are_told_at_once(results: dict[str, str], tmp_path: Path) -> None:
    for name in FILES[2:5]:
        (tmp_path / name).touch()
    assert refused(tmp_path, results) == FILES[2:5]


def test_what_cordicc_made_is_replaced(results: dict[str, str], tmp_path: Path) -> None:
    for _ in range(2):
        write_results(tmp_path, results)
        assert contents(tmp_path) == results


@pytest.mark.parametrize("name", FILES[1:])
def test_what_was_changed_since_stays(name: str, results: dict[str, str], tmp_path: Path) -> None:
    write_results(tmp_path, results)
    (tmp_path / name).write_text(results[name].replace("planar", "my own", 1), encoding="utf-8")
    assert refused(tmp_path, results) == [name]


def test_links_are_the_users(results: dict[str, str], tmp_path: Path) -> None:
    write_results(tmp_path / "there", results)
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "report.html").symlink_to("../there/report.html")
    (tmp_path / "here" / "simulate.py").symlink_to("nowhere")
    with pytest.raises(InvalidInput) as caught:
        require_own(tmp_path / "here", results)
    assert len(caught.value.diagnostics) == 2


def test_results_from_before_the_marks_are_known_beside_their_plan(
    results: dict[str, str], tmp_path: Path
) -> None:
    """C models and scripts that people change are not, as nothing tells whether they did."""
    for name, text in results.items():
        lines = text.splitlines(keepends=True)
        (tmp_path / name).write_text("".join(lines if name == "plan.json" else lines[:-1]), encoding="utf-8")
    assert refused(tmp_path, results) == FILES[5:]
    require_own(tmp_path, FILES[:5])
    with (tmp_path / "simulate.py").open("a", encoding="utf-8") as script:
        script.write("# mine\n")
    assert refused(tmp_path, results) == FILES[4:]
    data = json.loads((tmp_path / "plan.json").read_text("utf-8"))
    for other in ({"format": "mine"}, {"name": "another"}):
        (tmp_path / "plan.json").write_text(json.dumps(data | other), encoding="utf-8")
        assert set(FILES[1:]) <= set(refused(tmp_path, results))


def test_compile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.yaml").write_text(PROBLEM, encoding="utf-8")
    for mine, more in (("simulate.py", ()), ("p.h", ("--emit", "c"))):
        (tmp_path / mine).write_text("mine", encoding="utf-8")
        done = run("compile", "p.yaml", "-o", ".", "-q", *more)
        assert (done.exit_code, done.stderr.startswith(f"{mine}: error[E604]")) == (2, True)
        assert sorted(contents(tmp_path)) == sorted([mine, "p.yaml"])
        (tmp_path / mine).unlink()
    (tmp_path / "report.html").write_text("mine", encoding="utf-8")
    assert run("compile", "p.yaml", "-o", ".", "-q", "--force").exit_code == 0
    assert run("compile", "p.yaml", "-o", ".", "-q").exit_code == 0


def test_explore_and_draw(results: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.yaml").write_text(PROBLEM, encoding="utf-8")
    folder = tmp_path / "build" / "p"
    folder.mkdir(parents=True)
    (folder / "explore.svg").write_text("mine", encoding="utf-8")
    front = trade_off.explore(
        Path("p.yaml"), "kinematic", "auto", 1, trade_off.workers(1, None), lambda done, count: None
    )
    monkeypatch.setattr(trade_off, "explore", lambda *_: front)
    asked = ("explore", "p.yaml", "--json")
    done = run(*asked)
    assert (done.exit_code, "explore.svg: error[E604]" in done.stderr) == (2, True)
    assert run(*asked, "--force").exit_code == 0
    assert run(*asked).exit_code == 0
    # A file that is named is the one that is meant; what is drawn is cordicc's as well.
    write_results(folder, results)
    (tmp_path / "mine.svg").write_text("mine", encoding="utf-8")
    for path in (tmp_path / "mine.svg", folder / "datapath.svg"):
        assert run("draw", folder, "--width", "0", "-o", path).exit_code == 0
    write_results(folder, results)


@pytest.fixture
def running(plan: cordicc.Plan, tmp_path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A long simulation that has begun to write, too short for compiled units, which take long to load."""
    (tmp_path / "plan.json").write_text(plan.to_json(), encoding="utf-8")
    command = ["simulate", "plan.json", "--random", "9000000", "--no-reference", "--outputs", "out.csv"]
    with subprocess.Popen([sys.executable, "-m", "cordicc", *command], cwd=tmp_path) as process:
        while process.poll() is None and not any(is_own(path.name) for path in tmp_path.iterdir()):
            time.sleep(0.01)
        yield process
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGTERM, slow(signal.SIGHUP)])
def test_a_simulation_that_is_ended_leaves_nothing(
    number: signal.Signals, running: subprocess.Popen[bytes], tmp_path: Path
) -> None:
    running.send_signal(number)
    assert running.wait() == 128 + number
    assert os.listdir(tmp_path) == ["plan.json"]


@pytest.mark.exhaustive(reason="a process more; leftovers of files have a test of their own")
def test_a_simulation_that_was_killed_is_cleared_up_by_the_next(
    running: subprocess.Popen[bytes], tmp_path: Path
) -> None:
    running.kill()
    running.wait()
    assert len(os.listdir(tmp_path)) == 2
    next_one = ("simulate", tmp_path / "plan.json", "--random", "5", "--outputs", tmp_path / "o.csv")
    assert run(*next_one).exit_code == 0
    assert sorted(os.listdir(tmp_path)) == ["o.csv", "plan.json"]


@pytest.mark.parametrize("option", ["--outputs", "--vcd"])
def test_what_a_command_reads_it_does_not_replace(option: str, tmp_path: Path) -> None:
    problem, rows = tmp_path / "p.yaml", tmp_path / "rows.csv"
    problem.write_text(PROBLEM, encoding="utf-8")
    rows.write_text("x\n0.75\n", encoding="utf-8")
    for target in (problem, rows):
        before = target.read_bytes()
        end = run("simulate", problem, "--inputs", rows, option, target)
        assert end.exit_code == 2
        assert "which this command reads" in end.output
        assert target.read_bytes() == before


@pytest.mark.parametrize("command", ["draw", "schedule", "explore"])
def test_an_output_is_not_the_file_that_is_read(command: str, tmp_path: Path) -> None:
    read = tmp_path / "graph.svg"
    read.write_text("{}", encoding="utf-8")
    end = run(command, read, "-o", tmp_path / "." / "graph.svg")
    assert end.exit_code == 2
    assert "-o would replace" in end.output
    assert read.read_text("utf-8") == "{}"
