"""Arguments and options that several commands take, and what they stand for: plans, and files written."""

from __future__ import annotations

import math
from collections.abc import Callable
from os.path import isdir
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from cordicc.cli.console import tell
from cordicc.cli.streams import deliver

if TYPE_CHECKING:
    from cordicc.api import RunnablePlan

F = TypeVar("F", bound=Callable[..., Any])

FILE = click.Path(path_type=Path)
POSITIVE = click.IntRange(min=1)
NOT_NEGATIVE = click.IntRange(min=0)


class Seconds(click.FloatRange):
    """A positive, finite time."""

    name = "seconds"

    def __init__(self) -> None:
        super().__init__(min=0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number; usage error for one that is not finite."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number", param, ctx)
        return number


PROBLEM = click.argument("file", type=FILE)
PLAN_OR_PROBLEM = click.argument("plan", type=FILE, metavar="PLAN|FILE")
TARGET = click.option(
    "--target", default="kinematic", show_default=True, metavar="NAME|FILE", help="See 'cordicc targets'."
)
COPIES = click.option(
    "--copies",
    type=click.IntRange(1, 64),
    default=1,
    show_default=True,
    help="Instances of the problem that share the units.",
)
JOBS = click.option("--jobs", type=click.IntRange(1, 1024), help="Processes.  [default: one a core]")


def plan_argument(name: str = "plan") -> Callable[[F], F]:
    """Return the argument of a plan.json or its folder."""
    return click.argument(name, type=FILE, metavar="PLAN")


def units_option(about: str | None = None) -> Callable[[F], F]:
    """Return the option `--units`: which kinds of CAUs may be used."""
    kinds = click.Choice(["auto", "standard", "implicit"])
    return click.option("--units", type=kinds, default="auto", show_default=True, help=about)


def cluster_option(about: str) -> Callable[[F], F]:
    """Return the option `--cluster`: the address of a Dask scheduler."""
    return click.option("--cluster", metavar="ADDRESS", help=about)


def time_limit_option(about: str) -> Callable[[F], F]:
    """Return the option `--time-limit`: seconds after which searches stop."""
    return click.option("--time-limit", type=Seconds(), metavar="SECONDS", help=about)


def output_option(about: str, metavar: str | None = None) -> Callable[[F], F]:
    """Return the option `-o` or `--output`: where results go."""
    return click.option("-o", "--output", type=FILE, metavar=metavar, help=about)


def force_option() -> Callable[[F], F]:
    """Return the flag `--force`: files that cordicc did not make may be replaced."""
    return click.option("--force", is_flag=True, help="Replace files that cordicc did not make, too.")


def json_option(what: str) -> Callable[[F], F]:
    """Return the flag `--json`: results for programs."""
    return click.option("--json", "as_json", is_flag=True, help=f"Print {what} as one JSON object.")


def is_stdout(path: Path | None) -> bool:
    """Tell whether an output goes to stdout: if no file is named, or the file '-'."""
    return path is None or str(path) == "-"


def require_unread(option: str, written: Path | None, *read: Path | None) -> None:
    """Raise UsageError if what an option names to be written is one of the files that are read."""
    if written is None or not written.exists():
        return
    if any(path is not None and path.exists() and written.samefile(path) for path in read):
        raise click.UsageError(f"{option} would replace '{written}', which this command reads")


def write_or_print(path: Path | None, text: str) -> None:
    """Write a file, or to stdout if none is named or the file '-'."""
    from cordicc.base.files import write_file

    if path is None or is_stdout(path):
        deliver(text)
    else:
        write_file(path, text)


def plan_or_problem(path: Path) -> RunnablePlan:
    """Return the plan of a plan.json or its folder, or of a problem file, compiled as by default."""
    from cordicc.api import RunnablePlan, load_plan
    from cordicc.pipeline import Options, compile_file

    if path.suffix == ".json" or isdir(path):
        return load_plan(path)
    compiled = compile_file(path, Options())
    tell(compiled.warnings)
    return RunnablePlan.of(compiled.plan)
