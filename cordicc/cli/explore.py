"""The commands around scheduling: `cordicc schedule` and `cordicc explore`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cordicc.cli.arguments import COPIES, FILE
from cordicc.cli.console import Progress, show, tell

if TYPE_CHECKING:
    from cordicc.studies.trade_off import Front


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


@click.command()
@click.argument("graph", type=FILE, metavar="GRAPH.json")
@click.option("-o", "--output", type=FILE, metavar="OUT.json", help="Write here instead of stdout.")
@click.option("--time-limit", type=Seconds(), metavar="SECONDS", help="Emergency stop of searches.")
def schedule(graph: Path, output: Path | None, time_limit: float | None) -> None:
    """Schedule a bare graph of operations.

    GRAPH.json has initiation_interval, minimize (latency, fifo or processors), kinds (latency and limit),
    operations (id and kind) and edges.  FIFO words are the longest waits of the values, in cycles.

    \b
    cordicc schedule graph.json -o schedule.json
    """  # noqa: D301
    import json

    from cordicc.base.files import read_text, write_file
    from cordicc.schedule.bare import parse_graph, schedule_graph
    from cordicc.schedule.solver.engine import Effort
    from cordicc.schedule.verify_bare import verify_bare

    text = read_text(graph)
    answer = schedule_graph(parse_graph(text, str(graph)), Effort(words=10.0, seconds=time_limit))
    verify_bare(json.loads(text), answer)
    written = json.dumps(answer, indent=1, sort_keys=True, ensure_ascii=False) + "\n"
    if output is None or str(output) == "-":
        click.echo(written, nl=False)
        return
    write_file(output, written)
    for name, bound in answer["bounds"].items():
        proven = "proven optimal" if answer["optimal"][name] else f"at least {bound}"
        figure = answer[name] if name in answer else len(set(answer["unit"].values()))
        click.echo(f"{name.replace('_', ' ')} {figure} ({proven})")


@click.command()
@click.argument("file", type=FILE)
@click.option(
    "--target", default="kinematic", show_default=True, metavar="NAME|FILE", help="See 'cordicc targets'."
)
@click.option(
    "--units", type=click.Choice(["auto", "standard", "implicit"]), default="auto", show_default=True
)
@COPIES
@click.option("--jobs", type=click.IntRange(1, 1024), help="Processes.  [default: one a core]")
@click.option("--cluster", metavar="ADDRESS", help="Address of a Dask scheduler to work on instead.")
@click.option(
    "-o", "--output", type=FILE, metavar="FILE.svg", help="Plot.  [default: build/<name>/explore.svg]"
)
@click.option("--json", "as_json", is_flag=True, help="Print the points as one JSON object.")
def explore(
    file: Path,
    target: str,
    units: str,
    copies: int,
    jobs: int | None,
    cluster: str | None,
    output: Path | None,
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
    from cordicc.base.folders import write_files
    from cordicc.studies import trade_off as study

    bar: Progress | None = None

    def progress(done: int, count: int) -> None:
        nonlocal bar
        bar = bar or Progress(count, "points")
        bar.reached(done)

    try:
        result = study.explore(file, target, units, copies, study.workers(jobs, cluster), progress)
    finally:
        if bar is not None:
            bar.done()
    plot = result.plot()
    picture = pareto_plot.render(plot.title, plot.marks)
    if output is None:
        folder = Path("build") / result.name
        write_files(folder, {"explore.svg": picture} | _report(folder, result))
    else:
        write_file(output, picture)
    if as_json:
        click.echo(study.as_json(result), nl=False)
    else:
        show(study.as_sheet(result))


def _report(folder: Path, front: Front) -> dict[str, str]:
    """Return the report of the plan in a folder with the trade-off in it; nothing without such a plan."""
    from cordicc.api import load_plan
    from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity
    from cordicc.pipeline import report_page

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
