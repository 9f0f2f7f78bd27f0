"""Every command in the pages of `docs` runs, and prints what is shown under it.

In a page, a fenced block after `<!-- file: NAME -->` is a file.  In a `console` block, lines with `$ ` are
commands and the others what they print, `...` standing for any lines; `sh` and `python` blocks run as they
are.  All blocks of a page run in order in one folder, which has the examples in it.
"""

import os
import re
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.paths import ROOT
from tests.support.selection import quick

PAGES = sorted(page for page in (ROOT / "docs").glob("*.md") if "```" in page.read_text(encoding="utf-8"))
SHORT = [page for page in PAGES if page.stem not in ("accuracy", "targets", "tutorial")]
BLOCK = re.compile(r"(?:<!-- file: (?P<file>\S+) -->\n)?```(?P<kind>\w*)\n(?P<text>.*?)```", re.DOTALL)
ANY = "..."


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with the examples, and beside it the programs that the pages call."""
    (tmp_path / "bin").mkdir()
    for name, call in (("cordicc", "-m cordicc"), ("python", "")):
        program = tmp_path / "bin" / name
        program.write_text(f'#!/bin/sh\nexec "{sys.executable}" {call} "$@"\n', encoding="utf-8")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
    here = tmp_path / "here"
    here.mkdir()
    (here / "examples").symlink_to(ROOT / "examples")
    return here


def run(folder: Path, *command: str) -> str:
    """Return what a command prints, stderr included."""
    path = f"{folder.parent / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        timeout=300,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}"
    return done.stdout


def printed(block: str, folder: Path) -> str:
    """Return a console block with what its commands print; where what is shown fits, with that."""
    fresh = ""
    for part in re.split(r"^(?=\$ )", block, flags=re.MULTILINE)[1:]:
        line, _, shown = part.partition("\n")
        real = run(folder, "bash", "-c", line.removeprefix("$ "))
        fresh += f"{line}\n{shown if fits(shown, real) else real}"
    return fresh


def fits(shown: str, real: str) -> bool:
    pattern = "".join(
        r"(?:.*\n)*?" if line == ANY else re.escape(line) + r"\n" for line in shown.rstrip().splitlines()
    )
    return re.fullmatch(pattern, real.rstrip() + "\n" if real.strip() else "") is not None


@pytest.mark.skipif(sys.platform == "win32", reason="the pages show commands of a POSIX shell")
@pytest.mark.parametrize("page", quick(PAGES, *SHORT), ids=lambda page: page.stem)
def test_pages(page: Path, folder: Path, request: pytest.FixtureRequest) -> None:
    text = page.read_text(encoding="utf-8")

    def checked(block: re.Match[str]) -> str:
        inside = block["text"]
        if block["file"]:
            (folder / block["file"]).write_text(inside, encoding="utf-8")
        elif block["kind"] == "console":
            return block[0].replace(inside, printed(inside, folder))
        elif block["kind"] == "sh":
            run(folder, "bash", "-e", "-c", inside)
        elif block["kind"] == "python":
            run(folder, sys.executable, "-c", inside)
        return block[0]

    fresh = BLOCK.sub(checked, text)
    if request.config.getoption("--update-golden"):
        page.write_text(fresh, encoding="utf-8")
    assert fresh == page.read_text(encoding="utf-8")


def test_what_fits() -> None:
    assert fits("a\n...\nb\n", "a\nx\ny\nb\n")
    assert fits("...\nb\n...\n", "a\nb\nc\n")
    assert fits("", "")
    assert not fits("a\n", "a\nb\n")
    assert not fits("", "a\n")
    assert not fits("a\n...\nc\n", "a\nb\n")
