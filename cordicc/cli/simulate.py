"""`cordicc simulate`: a plan run on samples, and compared with its equations or with expected outputs."""

from __future__ import annotations

import math
from pathlib import Path

import click

from cordicc.base.diagnostics import Diagnostic, Severity
from cordicc.cli.arguments import (
    FILE,
    NOT_NEGATIVE,
    PLAN_OR_PROBLEM,
    POSITIVE,
    json_option,
    plan_or_problem,
    require_unread,
    write_or_print,
)
from cordicc.cli.console import tell


def _finite(ctx: click.Context, param: click.Parameter, number: float | None) -> float | None:
    """Return the number of an option; raise BadParameter for one that is not finite."""
    if number is not None and not math.isfinite(number):
        raise click.BadParameter(f"{number} is not a finite number", ctx, param)
    return number


@click.command("simulate")
@PLAN_OR_PROBLEM
@click.option("--inputs", type=FILE, metavar="IN.csv|IN.npz", help="Samples, under the names of the inputs.")
@click.option("--random", "count", type=POSITIVE, help="Draw so many samples.  [default: 10000]")
@click.option("--seed", type=NOT_NEGATIVE, default=0, show_default=True, help="Seed of the drawing.")
@click.option(
    "--outputs",
    type=FILE,
    metavar="OUT.csv|OUT.npz",
    help="Write the outputs and 'valid'; '-': CSV to stdout.",
)
@click.option(
    "--compare",
    nargs=2,
    type=FILE,
    metavar="IN EXPECTED",
    help="Compare with expected outputs instead of the equations; exit status 1 if they differ.",
)
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0),
    callback=_finite,
    help="Largest difference that --compare allows.  [default: columns tol_<output>, else what is proven of "
    "the row; where nothing is, twice the largest error observed]",
)
@click.option(
    "--reference",
    type=NOT_NEGATIVE,
    metavar="N",
    help="Evaluate the equations in high precision for N samples.  [default: 10000]",
)
@click.option(
    "--own-bounds",
    is_flag=True,
    help="Add a column bound_<output> to --outputs: the proven bound of each sample's own error.",
)
@click.option("--no-reference", is_flag=True, help="Only run the plan; compare with nothing.")
@click.option("--report", is_flag=True, help="Show histograms and worst inputs, and search for worse ones.")
@click.option("--cycle-accurate", is_flag=True, help="Execute units, pipelines and FIFOs clock by clock.")
@click.option("--vcd", type=FILE, metavar="FILE", help="Write the waveform of the first samples.")
@click.option(
    "--vcd-samples", type=POSITIVE, default=100, show_default=True, metavar="N", help="Samples of --vcd."
)
@json_option("the errors")
@click.pass_context
def command(
    ctx: click.Context,
    plan: Path,
    inputs: Path | None,
    count: int | None,
    seed: int,
    outputs: Path | None,
    compare: tuple[Path, Path] | None,
    tolerance: float | None,
    reference: int | None,
    own_bounds: bool,
    no_reference: bool,
    report: bool,
    cycle_accurate: bool,
    vcd: Path | None,
    vcd_samples: int,
    as_json: bool,
) -> None:
    """Run a plan, bit-true, compare it with the equations and judge the bounds that it states.

    PLAN is a plan.json; a problem FILE is compiled first with the default options.

    \b
    cordicc simulate build/planar-2r/plan.json --random 1000
    cordicc simulate arm.yaml --inputs poses.csv --outputs angles.csv --cycle-accurate
    cordicc simulate arm.yaml --compare poses.csv expected.csv
    """  # noqa: D301
    from cordicc.cli.sample_run import Reference, SampleRun, run_samples

    if inputs is not None and count is not None:
        raise click.UsageError("--inputs and --random exclude each other")
    if compare and any(option is not None for option in (inputs, count, outputs, vcd)):
        raise click.UsageError("--compare excludes --inputs, --random, --outputs and --vcd")
    if no_reference and (reference is not None or report):
        raise click.UsageError("--no-reference excludes --reference and --report")
    if tolerance is not None and not compare:
        raise click.UsageError("--tolerance goes with --compare")
    if own_bounds and outputs is None:
        raise click.UsageError("--own-bounds goes with --outputs")
    require_unread("--outputs", outputs, plan, inputs)
    require_unread("--vcd", vcd, plan, inputs)
    run = SampleRun(plan_or_problem(plan), cycle_accurate, as_json, tell, own_bounds)
    if compare:
        from cordicc.cli.compare import check_expected

        ctx.exit(check_expected(run, *compare, tolerance))
    if vcd is not None:
        from cordicc.emulate import waveform
        from cordicc.ir.sampling import DEFAULT_SAMPLES

        drawn = count or DEFAULT_SAMPLES
        first, more = waveform.first_samples(run.plan.problem, inputs, drawn, seed, vcd_samples)
        write_or_print(vcd, waveform.render(run.plan, first))
        if more:
            message = f"the waveform holds the first {vcd_samples} samples"
            tell([Diagnostic("W616", message, hint="--vcd-samples N writes N", severity=Severity.WARNING)])
    ctx.exit(run_samples(run, inputs, count, seed, outputs, Reference.of(reference, no_reference, report)))
