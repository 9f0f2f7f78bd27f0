"""What several commands share: the kinds of arguments, plans from either kind of file, texts to files."""

from __future__ import annotations

import math
import re
from decimal import Decimal, InvalidOperation
from os.path import isdir
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cordicc.cli.console import tell

if TYPE_CHECKING:
    from cordicc.api import Plan

FILE = click.Path(path_type=Path)


_PREFIXES = {"": 1, "k": 1000, "M": 1_000_000, "G": 1_000_000_000}


def hertz(ctx: click.Context, param: click.Parameter, text: str | None) -> float | None:
    """Return the positive number of hertz of an option, perhaps with a unit; raise BadParameter."""
    if text is None:
        return None
    match = re.fullmatch(r"\s*([0-9.]+(?:[eE][-+]?[0-9]{1,3})?)\s*(?:([kMG]?)Hz)?\s*", text)
    try:
        rate = float(Decimal(match[1]) * _PREFIXES[match[2] or ""]) if match else 0.0
    except InvalidOperation:
        rate = 0.0
    if not 0 < rate < math.inf:
        raise click.BadParameter(
            f"{text!r} is not a positive number of hertz, such as 5e5 or 500kHz", ctx, param
        )
    return rate


def finite(ctx: click.Context, param: click.Parameter, number: float | None) -> float | None:
    """Return the number of an option; raise BadParameter for one that is not finite."""
    if number is not None and not math.isfinite(number):
        raise click.BadParameter(f"{number} is not a finite number", ctx, param)
    return number


COPIES = click.option(
    "--copies",
    type=click.IntRange(1, 64),
    default=1,
    show_default=True,
    help="Instances of the problem that share the units.",
)


def write_or_print(path: Path, text: str) -> None:
    """Write a file, or to stdout if the path is '-'."""
    from cordicc.base.files import write_file

    if str(path) == "-":
        click.echo(text, nl=False)
    else:
        write_file(path, text)


def plan_or_problem(path: Path) -> Plan:
    """Return the plan of a plan.json or its folder, or of a problem file, compiled as by default."""
    from cordicc.api import Plan, load_plan
    from cordicc.pipeline import Options, compile_file

    if path.suffix == ".json" or isdir(path):
        return load_plan(path)
    compiled = compile_file(path, Options())
    tell(compiled.warnings)
    return Plan.of(compiled.plan)
