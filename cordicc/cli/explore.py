"""`cordicc explore`: the trade-off of a problem, and into the report of its plan."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cordicc.cli.arguments import (
    COPIES,
    JOBS,
    PROBLEM,
    TARGET,
    cluster_option,
    force_option,
    json_option,
    output_option,
    require_unread,
    units_option,
)
from cordicc.cli.console import Progress, show, tell
from cordicc.cli.streams import deliver

if TYPE_CHECKING:
    from cordicc.studies.trade_off import Front


@click.command("explore")
@PROBLEM
@TARGET
@units_option()
@COPIES
@JOBS
@cluster_option("Address of a Dask scheduler to work on instead.")
@output_option("Plot.  [default: build/<name>/explore.svg]", "FILE.svg")
@force_option()
@json_option("the points")
def command(
    file: Path,
    target: str,
    units: str,
    copies: int,
    jobs: int | None,
    cluster: str | None,
    output: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Find the trade-off of units, latency and FIFO words.

    For a problem FILE: every combination of processors, latency, interval and FIFO words that no other beats.

    The plot goes to build/<name>/ and, if a plan of the problem is there, into its report.

    \b
    cordicc explore arm.yaml
    cordicc explore leg.yaml --copies 6 --json
    """  # noqa: D301
    from cordicc.backends.pictures import pareto_plot
    from cordicc.base.files import write_file
    from cordicc.base.seals import sealed
    from cordicc.cli.results import write_results
    from cordicc.studies import trade_off

    require_unread("-o", output, file)
    bar: Progress | None = None

    def progress(done: int, count: int) -> None:
        nonlocal bar
        bar = bar or Progress(count, "points")
        bar.reached(done)

    try:
        result = trade_off.explore(file, target, units, copies, trade_off.workers(jobs, cluster), progress)
    finally:
        if bar is not None:
            bar.done()
    plot = result.plot()
    picture = sealed("explore.svg", pareto_plot.render(plot.title, plot.marks))
    if output is None:
        folder = Path("build") / result.name
        write_results(folder, {"explore.svg": picture} | report_with(result, folder), force=force)
    else:
        write_file(output, picture)
    if as_json:
        deliver(trade_off.as_json(result))
    else:
        show(trade_off.as_sheet(result))


def report_with(front: Front, folder: Path) -> dict[str, str]:
    """Return the report of the plan in a folder with the trade-off in it; nothing without such a plan."""
    from cordicc.api import load_plan
    from cordicc.artefacts import report_page
    from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity

    if not (folder / "plan.json").is_file():
        return {}
    reason = "it is of another problem, target or number of copies"
    try:
        plan = load_plan(folder / "plan.json")
        if front.is_of(plan):
            return {"report.html": report_page(plan, front.plot())}
    except InvalidInput as error:
        reason = error.diagnostics[0].message
    message = f"the report of {folder / 'plan.json'} was left as it is: {reason}"
    tell([Diagnostic("W722", message, severity=Severity.WARNING)])
    return {}
