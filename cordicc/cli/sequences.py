"""The commands that study iterations: `cordicc trace` and `cordicc sequences`."""

from __future__ import annotations

import os

import click

from cordicc.cli.console import show, tell, watched

_MODES = ("rotation", "vectoring", "implicit")
_TRACED = ("standard", "krieger96", "root-free", "single-rotation")


@click.command()
@click.argument("mode", type=click.Choice(_MODES))
@click.option("--x", default="1", show_default=True, metavar="NUMBER", help="x of the start; A if implicit.")
@click.option("--y", default="0", show_default=True, metavar="NUMBER", help="y of the start; B if implicit.")
@click.option("--z", default="0", show_default=True, metavar="NUMBER", help="z of the start.")
@click.option("--target", metavar="NUMBER", help="C of the implicit equation.")
@click.option(
    "--sequence",
    type=click.Choice(_TRACED),
    help="Shifts and rule.  [default: standard, or single-rotation if implicit]",
)
@click.option("--iterations", type=click.IntRange(1, 60), help="How many.  [default: to shift 17]")
@click.option(
    "--m",
    type=click.Choice(["1", "0", "-1"]),
    default="1",
    show_default=True,
    help="Circular, linear or hyperbolic.",
)
@click.option("--branch", type=click.Choice(["+", "-"]), help="Which solution.  [default: -]")
@click.option("--bits", type=click.IntRange(1, 40), help="Also run it in fixed point, to so many bits.")
def trace(
    mode: str,
    x: str,
    y: str,
    z: str,
    target: str | None,
    sequence: str | None,
    iterations: int | None,
    m: str,
    branch: str | None,
    bits: int | None,
) -> None:
    """Print the iterations of one operation, to ten decimals.

    Rotation drives z to 0, vectoring y to 0, implicit y to the C of B cos t + A sin t = C.  Numbers may be
    constant expressions such as 3*pi/8.  With krieger96, z counts half of what the vector turns.  With --bits
    a second table has the same iterations in integers, rounded as the units round.

    \b
    cordicc trace rotation --x 1 --y 1 --z 1.1780972451 --sequence krieger96
    cordicc trace implicit --x 1 --y 2 --target 0.5 --branch +
    """  # noqa: D301
    from cordicc.frontend.reading import option_number
    from cordicc.studies.iteration_table import Request, trace_text

    at = [option_number(text, name) for name, text in (("--x", x), ("--y", y), ("--z", z))]
    goal = None if target is None else option_number(target, "--target")
    rule = sequence or ("single-rotation" if mode == "implicit" else "standard")
    request = Request(mode, rule, int(m), at[0], at[1], at[2], goal, iterations, branch, bits)
    text, warnings = trace_text(request)
    tell(warnings)
    click.echo(text, nl=False)


@click.command()
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
@click.option("--jobs", type=click.IntRange(1, 1024), help="Processes.  [default: one a core]")
@click.option("--cluster", metavar="ADDRESS", help="Search on the Dask cluster of this scheduler instead.")
@click.option(
    "--limit",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    help="Sets to print of each length.",
)
@click.pass_context
def sequences(
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
            click.echo(sequence_listing.detail_text(name), nl=False)
        return
    from cordicc.frontend.reading import option_number
    from cordicc.studies.cluster import outcomes as on_cluster
    from cordicc.studies.sequence_search import Outcome, ZeroShift, merge, outcomes, tasks

    angle, error = option_number(domain, "--domain"), option_number(scaling_error, "--scaling-error")
    cases = sequence_listing.conditions(final_shift, angle, error, max_iterations, allow_zero)
    click.echo(sequence_listing.search_head(cases[0]), nl=False)
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
        click.echo("\n" + sequence_listing.search_text(case, whole), nl=False)
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
