"""`cordicc check`: the mistakes in a problem file."""

from __future__ import annotations

from collections.abc import Sized
from pathlib import Path

import click

from cordicc.cli.arguments import PROBLEM
from cordicc.cli.console import tell
from cordicc.cli.streams import say


@click.command("check")
@PROBLEM
def command(file: Path) -> None:
    """Look for mistakes in a problem FILE.

    It is read and checked, not compiled; all its mistakes are listed together.

    \b
    cordicc check arm.yaml
    """  # noqa: D301
    from cordicc.api import check
    from cordicc.backends.text.summary import count

    problem, warnings = check(file)
    tell(warnings)
    asked = tuple(check for check in problem.checks if check.asked)
    parts: list[tuple[Sized, str]] = [
        (problem.inputs, "input"),
        (problem.equations, "equation"),
        (problem.outputs, "output"),
    ]
    parts += [(asked, "check")] if asked else []
    counts = ", ".join(count(len(items), noun) for items, noun in parts)
    say(f"{problem.name}: {counts}, no errors")
