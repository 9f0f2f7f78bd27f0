"""stdout and stderr in any encoding, full, closed, or with nobody at the other end."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from cordicc.base.diagnostics import InvalidInput
from cordicc.cli import main, streams
from tests.support.paths import EXAMPLES
from tests.support.plans import planned
from tests.support.selection import slow

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="no /dev/full")

COMMANDS: dict[str, tuple[str, ...]] = {
    "help": ("--help",),
    "help of a command": ("compile", "--help"),
    "version": ("--version",),
    "check": ("check", "p.yaml"),
    "compile": ("compile", "p.yaml", "-o", "out"),
    "compile --json": ("compile", "p.yaml", "-o", "out", "--json"),
    "diff": ("diff", "plan.json", "plan.json"),
    "diff --json": ("diff", "plan.json", "plan.json", "--json"),
    "draw": ("draw", "plan.json"),
    "explain": ("explain", "plan.json"),
    "explain a code": ("explain", "E302"),
    "schedule": ("schedule", "g.json"),
    "schedule to a file": ("schedule", "g.json", "-o", "s.json"),
    "schema": ("schema", "plan"),
    "sequences": ("sequences",),
    "sequences NAME": ("sequences", "krieger96"),
    "simulate": ("simulate", "plan.json", "--random", "5"),
    "simulate --outputs -": ("simulate", "plan.json", "--random", "5", "--outputs", "-"),
    "targets": ("targets",),
    "targets NAME": ("targets", "kinematic"),
    "trace": ("trace", "rotation", "--z", "1"),
}
PROBLEM = """
description: "Ärm, € and √2"
inputs: {x: [0.5, 1]}
equations: [w = 2*x]
"""
GRAPH = {"kinds": {"a": {"latency": 1}}, "operations": [{"id": "ö", "kind": "a"}], "edges": []}

Run = Callable[..., int]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return what runs a command in a folder of files, on streams of its own, and returns its status."""
    (tmp_path / "p.yaml").write_text(PROBLEM, encoding="utf-8")
    (tmp_path / "g.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    plan = planned(EXAMPLES / "planar_2r.yaml").to_json()
    (tmp_path / "plan.json").write_text(plan.replace("Two-link", "Zwei-€"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)

    def run(
        arguments: tuple[str, ...], out: str = "out.txt", err: str = "err.txt", encoding: str = "utf-8"
    ) -> int:
        with open(out, "w", encoding=encoding) as stdout, open(err, "w", encoding=encoding) as stderr:
            monkeypatch.setattr(sys, "stdout", stdout)
            monkeypatch.setattr(sys, "stderr", stderr)
            with pytest.raises(SystemExit) as ended:
                main(list(arguments), prog_name="cordicc")
            monkeypatch.undo()
            monkeypatch.chdir(tmp_path)
        return ended.value.code

    return run


@needs_full
@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_stdout_is_an_error(name: str, run: Run) -> None:
    assert run(COMMANDS[name], out=str(FULL)) == 2
    told = Path("err.txt").read_text(encoding="utf-8")
    assert told == "error[E600]: cannot write to stdout: No space left on device\n"
    assert run(COMMANDS[name], out=str(FULL), err=str(FULL)) == 2


@needs_full
@pytest.mark.parametrize(
    "arguments", [("check", "missing.yaml"), ("check",), ("nothing",), ("draw", "p.yaml")]
)
def test_a_full_stderr_changes_no_status(arguments: tuple[str, ...], run: Run) -> None:
    assert run(arguments, err=str(FULL)) == run(arguments) == 2
    assert Path("out.txt").read_text(encoding="utf-8") == ""


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
@pytest.mark.parametrize("name", COMMANDS)
def test_every_encoding_will_do(name: str, encoding: str, run: Run) -> None:
    assert run(COMMANDS[name], encoding=encoding) == 0
    assert "Traceback" not in Path("err.txt").read_text(encoding)


def test_what_an_encoding_lacks_is_replaced(run: Run) -> None:
    assert run(("compile", "p.yaml", "-o", "€"), encoding="ascii") == 0
    assert "wrote ?: plan.json" in Path("out.txt").read_text("ascii")
    assert "Ärm, € and √2" in Path("€/plan.json").read_text("utf-8")
    for arguments in (("check", "€.yaml"), ("check", "€.yaml", "€"), ("sequences", "€")):
        assert run(arguments, encoding="ascii") == 2
        assert "?" in Path("err.txt").read_text("ascii")


def test_what_cordicc_itself_says_is_spelt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for encoding, shown in (("ascii", "6.2 us, ?"), ("latin-1", "6.2 µs, ?"), ("cp1252", "6.2 µs, €")):
        with (tmp_path / encoding).open("w", encoding=encoding) as stream:
            monkeypatch.setattr(sys, "stdout", stream)
            streams.prepare()
            streams.say("6.2 µs, €", newline=False)
        assert (tmp_path / encoding).read_text(encoding) == shown


def test_files_and_json_are_utf_8_on_every_stream(run: Run) -> None:
    assert run(("draw", "plan.json"), encoding="latin-1") == 0
    drawn = Path("out.txt").read_bytes()
    assert run(("draw", "plan.json", "-o", "d.svg")) == 0
    assert drawn == Path("d.svg").read_bytes()
    assert run(("compile", "p.yaml", "-o", "out", "--json"), encoding="latin-1") == 0
    assert json.loads(Path("out.txt").read_bytes())["description"] == "Ärm, € and √2"


@pytest.mark.parametrize("name", ["compile", "draw", "check"])
def test_streams_that_were_closed_before(name: str, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    with pytest.raises(SystemExit) as ended:
        main(list(COMMANDS[name]), prog_name="cordicc")
    assert ended.value.code == 2


def test_a_stream_that_takes_nothing_is_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: object) -> None:
        raise BrokenPipeError

    with pytest.raises(BrokenPipeError):
        streams.written(broken)
    streams.written(broken, err=True)
    monkeypatch.setattr(sys, "stdout", None)
    with pytest.raises(InvalidInput, match=r"E600.*it is closed"):
        streams.say("words")


@needs_full
@pytest.mark.parametrize(
    ("arguments", "status", "redirected"),
    [
        slow((("targets",), 2, "> /dev/full")),
        (("--help",), 2, "> /dev/full"),
        (("check", "missing.yaml"), 2, "2> /dev/full"),
        (("schema", "plan"), 1, "| true; exit ${PIPESTATUS[0]}"),
    ],
)
def test_the_process_ends_with_the_status(arguments: tuple[str, ...], status: int, redirected: str) -> None:
    """Python itself writes what is left when it ends, and would change the status."""
    words = " ".join((sys.executable, "-m", "cordicc", *arguments))
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(
        ["bash", "-c", f"{words} {redirected}"], capture_output=True, text=True, env=environment, check=False
    )
    assert done.returncode == status
    assert "Exception" not in done.stderr
