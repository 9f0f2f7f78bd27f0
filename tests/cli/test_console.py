"""The terminal: plain text where nobody sees colour, else the same words in colour and in its width."""

import os
import pty
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from cordicc.base.text_tables import Facts, Heading, Sheet, Table, plain
from cordicc.cli import console
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.selection import slow

ESCAPE = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")


def on_terminal(*arguments: object, columns: int = 100, both: bool = False, **settings: str) -> str:
    """Return what a command prints on a terminal: its stdout, or stderr too if both are one."""
    ours, theirs = pty.openpty()
    environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "TERM", "FORCE_COLOR")}
    environment |= {"TERM": "xterm-256color", "COLUMNS": str(columns), **settings}
    command = [sys.executable, "-m", "cordicc", *map(str, arguments)]
    with subprocess.Popen(
        command, stdout=theirs, stderr=theirs if both else None, env=environment
    ) as process:
        os.close(theirs)
        parts = b"".join(_read(ours))
    os.close(ours)
    assert process.returncode in (0, 1, 2)
    return parts.decode("utf-8").replace("\r\n", "\n")


def _read(end: int) -> Iterator[bytes]:
    while True:
        try:
            part = os.read(end, 65536)
        except OSError:  # Linux says so when the other end is closed
            return
        if not part:
            return
        yield part


def piped(*arguments: object) -> str:
    return run(*arguments).stdout


def words(text: str) -> list[str]:
    """Return the words, without rules, colours and whatever came and went."""
    return re.sub(r"[─━╶╴]", " ", ESCAPE.sub("", text)).split()


def test_a_table_in_colour_says_what_the_plain_one_says() -> None:
    shown = on_terminal("targets")
    assert ESCAPE.search(shown)
    assert words(shown) == words(piped("targets"))


@pytest.mark.parametrize("settings", [{"NO_COLOR": "1"}, slow({"TERM": "dumb"})])
def test_plain_on_request(settings: dict[str, str]) -> None:
    assert on_terminal("targets", **settings) == piped("targets")


@pytest.mark.parametrize("columns", [40, slow(60), slow(200)])
def test_lines_fit_the_terminal(columns: int) -> None:
    lines = ESCAPE.sub("", on_terminal("targets", columns=columns)).splitlines()
    assert max(map(len, lines)) <= columns


@pytest.mark.exhaustive(reason="compiles four times in processes; tables and diagnostics have colours too")
def test_a_plan_in_colour(tmp_path: Path) -> None:
    arguments = ("compile", EXAMPLES / "wheel_beta.yaml", "-o", tmp_path)
    shown = on_terminal(*arguments, columns=300)
    assert ESCAPE.search(shown)
    assert words(shown) == words(piped(*arguments))
    json = on_terminal(*arguments, "--json")
    assert json == piped(*arguments, "--json")


def test_diagnostics_in_colour(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("inputs: {x: [0, 1]}\nequations: [y = z]\n", encoding="utf-8")
    shown = on_terminal("check", tmp_path / "p.yaml", both=True)
    assert "\x1b[31m\x1b[1merror[E203]\x1b[0m: unknown name 'z'" in shown
    assert "\x1b" not in on_terminal("check", tmp_path / "p.yaml", both=True, NO_COLOR="1")


SHEET = Sheet(
    "title",
    (
        Facts((("a", "1 (aside)"), ("long", "2"))),
        "",
        Heading("part"),
        Table(("x", "y"), (("1", "22"),), right=(1,)),
    ),
)


def test_plain_sheet() -> None:
    assert plain(SHEET) == "title\n  a     1 (aside)\n  long  2\n\n\npart\n  x   y\n  1  22\n"
    assert plain(Sheet("", (Table(("x",), ()),))) == "  x\n"


def test_markup_of_others_is_text(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a file is called must not drive the terminal."""
    monkeypatch.setattr(console, "is_terminal", lambda stream: True)
    console.show(
        Sheet("[bold]x[/bold] :smile:", (Facts((("[red]", "[link=x]y[/]"),)), Table(("[b]",), (("[i]",),))))
    )
    shown = capsys.readouterr().out
    for text in ("[bold]x[/bold] :smile:", "[red]", "[link=x]y[/]", "[b]", "[i]"):
        assert text in shown


def test_progress_away_from_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    now = iter(range(0, 1000, 8))
    progress = console.Progress(100, "samples", lambda: float(next(now)))
    for done in (10, 20, 30, 40):
        progress.reached(done)
    progress.done()
    assert capsys.readouterr().err == "20 of 100 samples\n40 of 100 samples\n"
    quick = console.Progress(None, "samples", lambda: 0.0)
    quick.reached(5)
    quick.done()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("total", [100, None])
def test_progress_on_a_terminal(
    total: int | None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(console, "is_terminal", lambda stream: True)
    now = iter(range(0, 1000, 8))
    progress = console.Progress(total, "samples", lambda: float(next(now)))
    for done in (10, 20, 30):
        progress.reached(done)
    progress.done()
    assert "samples" in capsys.readouterr().err


def test_watched_passes_on_everything() -> None:
    assert list(console.watched([1, 2, 3], 3, "parts")) == [1, 2, 3]


def test_stages(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with console.stages(quiet=False) as enter:
        enter("reading")
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(console, "is_terminal", lambda stream: True)
    with console.stages(quiet=True) as enter:
        enter("reading")
    assert capsys.readouterr().err == ""
    now = iter((0.0, 0.5, 2.0, 3.0))
    with console.stages(quiet=False, clock=lambda: next(now)) as enter:
        enter("quick")
        enter("reading")
        enter("scheduling")
    assert capsys.readouterr().err != ""


def test_rich_is_imported_for_a_terminal_alone(tmp_path: Path) -> None:
    code = (
        "import sys\nfrom cordicc.cli import main\n"
        f"main(['check', {str(EXAMPLES / 'wheel_beta.yaml')!r}], standalone_mode=False)\n"
        "sys.exit('rich' in sys.modules)"
    )
    assert (
        subprocess.run([sys.executable, "-c", code], stdout=subprocess.DEVNULL, check=False).returncode == 0
    )
