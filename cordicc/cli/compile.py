"""`cordicc compile`: a problem file to a folder with its plan."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cordicc.artefacts import ALWAYS_WRITTEN, ON_REQUEST
from cordicc.backends.rtl.reset_style import RESETS, USUAL_RESET
from cordicc.cli.arguments import (
    COPIES,
    NOT_NEGATIVE,
    POSITIVE,
    PROBLEM,
    TARGET,
    force_option,
    json_option,
    output_option,
    time_limit_option,
    units_option,
)
from cordicc.cli.console import show, stages, tell
from cordicc.cli.emissions import EMISSION, EmittingCommand
from cordicc.cli.streams import deliver, say

if TYPE_CHECKING:
    from cordicc.ir.graph import Graph

_PREFIXES = {"": 1, "k": 1000, "M": 1_000_000, "G": 1_000_000_000}
_MORE = ", ".join(f"'{name}', {each.about}" for name, each in ON_REQUEST.items())


def _hertz(ctx: click.Context, param: click.Parameter, text: str | None) -> float | None:
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


def _shown(names: Iterable[str]) -> list[str]:
    """Return the names of files, of a folder's files its name alone."""
    return list(dict.fromkeys(name.partition("/")[0] + "/" * ("/" in name) for name in names))


@click.command("compile", cls=EmittingCommand)
@PROBLEM
@output_option("Folder for the results.  [default: build/<name>]")
@force_option()
@TARGET
@click.option(
    "--width", type=POSITIVE, metavar="BITS", help="Bits of fixed-point words instead of the target's."
)
@click.option("--clock", callback=_hertz, metavar="HZ", help="Clock instead of the target's; 5e7, 50MHz.")
@units_option(
    "Which CAUs may be used: 'standard' forbids implicit ones, 'implicit' wants a target with them."
)
@click.option("--ii", type=POSITIVE, help="Cycles between samples (initiation interval).  [default: 1]")
@click.option(
    "--rate",
    callback=_hertz,
    metavar="HZ",
    help="Samples a second, instead of --ii: the longest interval that keeps up; 5e5, 500kHz.",
)
@COPIES
@click.option("--max-processors", type=NOT_NEGATIVE, help="Most CAUs.")
@click.option("--max-latency", type=NOT_NEGATIVE, metavar="CYCLES", help="Most cycles.")
@click.option(
    "--minimize",
    type=click.Choice(["processors", "latency", "fifo", "area"]),
    default="processors",
    show_default=True,
    help="The first goal; the others follow in this order.",
)
@click.option(
    "--effort",
    type=click.FloatRange(0.01, 1000),
    default=1.0,
    show_default=True,
    metavar="FACTOR",
    help="Work of the searches, times the usual: more proves more, and may find less hardware.",
)
@time_limit_option("Emergency stop of searches, which otherwise end on deterministic work limits.")
@click.option(
    "--emit",
    type=EMISSION,
    multiple=True,
    help=f"Write more: {_MORE}.  Those with samples take a count, as 'verilog-vectors 5000' or "
    "'verilog=5000'.",
)
@click.option(
    "--reset",
    type=click.Choice(list(RESETS)),
    help="The port by which '--emit verilog' is reset: 'a' asynchronous, '_n' active low.  [default: rst]",
)
@click.option("--print-after", metavar="PASS", help="Print the operation graph after a pass, or after 'all'.")
@click.option(
    "--certify/--no-certify",
    default=None,
    help="Prove error bounds of the outputs.  [default: on fixed-point targets, and for a max_error]",
)
@click.option("--explain", is_flag=True, help="Print how each operation came about.")
@json_option("the plan's figures")
@click.option("-q", "--quiet", is_flag=True, help="Print no summary.")
def command(
    file: Path,
    output: Path | None,
    force: bool,
    target: str,
    width: int | None,
    clock: float | None,
    units: str,
    ii: int | None,
    rate: float | None,
    copies: int,
    max_processors: int | None,
    max_latency: int | None,
    minimize: str,
    effort: float,
    time_limit: float | None,
    emit: tuple[tuple[str, int | None], ...],
    reset: str | None,
    print_after: str | None,
    certify: bool | None,
    explain: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Compile a problem FILE to a hardware plan.

    The folder of the results gets plan.json, report.html, datapath.svg, schedule.svg and simulate.py.

    \b
    cordicc compile examples/planar_2r.yaml
    cordicc compile arm.yaml --target krieger96 --minimize latency -o out
    """  # noqa: D301
    from cordicc import pipeline
    from cordicc.artefacts import artefacts
    from cordicc.backends.text.summary import explanation_text, plan_sheet
    from cordicc.cli.results import require_own, write_results
    from cordicc.ir.text import print_graph
    from cordicc.plan.file import summary
    from cordicc.schedule.request import Limits, interval_for
    from cordicc.schedule.solver.engine import Effort
    from cordicc.targets.target_file import Asked, load_target

    names = pipeline.pass_names()
    if print_after is not None and print_after not in (*names, "all"):
        raise click.BadParameter(f"choose from all, {', '.join(names)}", param_hint="--print-after")

    def watch(name: str, graph: Graph) -> None:
        if print_after in (name, "all"):
            say(f"; after {name}\n{print_graph(graph)}", err=as_json)

    if rate is not None and ii is not None:
        raise click.UsageError("--ii and --rate exclude each other")
    if reset is not None and not any(ON_REQUEST[name].reset for name, _ in emit):
        raise click.UsageError("--reset goes with --emit verilog")
    asked = Asked(width, clock)
    interval = ii or 1 if rate is None else interval_for(load_target(target, asked=asked), rate)
    limits = Limits(minimize, interval, max_processors, max_latency, Effort(seconds=time_limit))
    if output is not None and not force:
        require_own(
            output, ALWAYS_WRITTEN
        )  # told before the work; the names of others follow from the plan's
    options = pipeline.Options(target, units, limits, certify, copies, effort, asked)
    with stages(quiet or print_after is not None) as enter:
        compiled = pipeline.compile_file(file, options, watch, enter)
    tell(compiled.warnings)
    plan = compiled.plan
    folder = output if output is not None else Path("build") / plan.name
    counts = {name: count for name, count in emit if count is not None}
    files = artefacts(plan, (name for name, _ in emit), counts, RESETS[reset or USUAL_RESET.port])
    write_results(folder, files, force=force)
    if explain:
        say(explanation_text(plan), err=as_json)
    if as_json:
        deliver(summary(plan))
    elif not quiet:
        show(plan_sheet(plan, f"wrote {folder}: {', '.join(_shown(files))}"))
