"""`cordicc sequences`: shift sequences listed, checked and searched."""

from __future__ import annotations

import os

import click

from cordicc.cli.arguments import JOBS, cluster_option
from cordicc.cli.console import show, watched
from cordicc.cli.streams import say


@click.command("sequences")
@click.argument("name", required=False)
@click.option("--search", is_flag=True, help="Search root-free circular sequences exhaustively.")
@click.option(
    "--final-shift", type=click.IntRange(1, 40), default=17, show_default=True, help="The last shift."
)
@click.option("--domain", default="pi", show_default=True, metavar="RAD", help="Least convergence domain.")
@click.option(
    "--scaling-error",
    default="2**-22",
    show_default=True,
    metavar="NUMBER",
    help="Largest absolute difference of the scaling from 1/gain.",
)
@click.option(
    "--max-iterations", type=click.IntRange(1, 64), default=22, show_default=True, help="Longest sequence."
)
@click.option(
    "--allow-zero/--no-zero", default=None, help="Only with, or only without S = 0.  [default: both]"
)
@JOBS
@cluster_option("Search on the Dask cluster of this scheduler instead.")
@click.option(
    "--limit",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    help="Sets to print of each length.",
)
@click.pass_context
def command(
    ctx: click.Context,
    name: str | None,
    search: bool,
    final_shift: int,
    domain: str,
    scaling_error: str,
    max_iterations: int,
    allow_zero: bool | None,
    jobs: int | None,
    cluster: str | None,
    limit: int,
) -> None:
    """List, check or search shift sequences.

    Without NAME all are listed, with NAME one is checked, --search finds new ones.

    \b
    cordicc sequences krieger96
    cordicc sequences --search --final-shift 17 --scaling-error 2**-22
    cordicc sequences --search --cluster tcp://localhost:8786
    """  # noqa: D301
    from cordicc.studies import sequence_listing

    if search and name is not None:
        raise click.UsageError("NAME and --search exclude each other")
    if jobs is not None and cluster is not None:
        raise click.UsageError("--jobs and --cluster exclude each other")
    if not search:
        _refuse_search_options(ctx)
        if name is None:
            show(sequence_listing.list_sheet())
        else:
            say(sequence_listing.detail_text(name), newline=False)
        return
    from cordicc.frontend.reading import option_number
    from cordicc.studies.cluster import outcomes as on_cluster
    from cordicc.studies.sequence_search import Outcome, ZeroShift, merge, outcomes, tasks

    angle, error = option_number(domain, "--domain"), option_number(scaling_error, "--scaling-error")
    cases = sequence_listing.conditions(final_shift, angle, error, max_iterations, allow_zero)
    say(sequence_listing.search_head(cases[0]), newline=False)
    found = False
    without: Outcome = {}
    for case in cases:
        parts = tasks(case, limit)
        found_by_part = outcomes(parts, jobs or _cores()) if cluster is None else on_cluster(parts, cluster)
        whole = merge([without, *watched(found_by_part, len(parts), "parts of the search")], limit)
        if case.zero is ZeroShift.NONE:
            without = whole
            if allow_zero:
                continue
        found |= sequence_listing.shortest(whole) is not None
        say("\n" + sequence_listing.search_text(case, whole), newline=False)
    if not found:
        ctx.exit(1)


def _refuse_search_options(ctx: click.Context) -> None:
    for parameter in ctx.command.params:
        given = ctx.get_parameter_source(parameter.name or "") is click.core.ParameterSource.COMMANDLINE
        if given and parameter.name not in ("name", "search"):
            raise click.UsageError(f"{parameter.opts[0]} goes with --search")


def _cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
