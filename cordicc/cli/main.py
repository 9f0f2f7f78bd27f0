"""The command line: thin commands over `cordicc.api` and `cordicc.pipeline`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from cordicc import __version__
from cordicc.base.diagnostics import CordiccError, Diagnostic, Severity
from cordicc.cli.arguments import COPIES, FILE, finite, hertz, plan_or_problem, write_or_print
from cordicc.cli.console import show, stages, tell
from cordicc.cli.explain import diff, explain, schema
from cordicc.cli.explore import Seconds, explore, schedule
from cordicc.cli.sequences import sequences, trace

_POSITIVE = click.IntRange(min=1)


class _Group(click.Group):
    """Turns the errors of cordicc into diagnostics on stderr and their exit status."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except CordiccError as error:
            tell(error.diagnostics)
            ctx.exit(error.exit_status)
        except BrokenPipeError:
            sys.stderr.close()
            ctx.exit(1)


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="cordicc")
def main() -> None:
    """Compile kinematic equations to CORDIC hardware plans.

    \b
    cordicc compile arm.yaml              write build/arm/: plan, report, pictures, simulation
    cordicc simulate build/arm/plan.json  run the plan, bit-true, and report its errors
    cordicc explain build/arm/plan.json   say in words what it does, and why none is cheaper
    cordicc check arm.yaml                only look for mistakes in the file
    """  # noqa: D301


@main.command("compile")
@click.argument("file", type=FILE)
@click.option("-o", "--output", type=FILE, help="Folder for the results.  [default: build/<name>]")
@click.option(
    "--target", default="kinematic", show_default=True, metavar="NAME|FILE", help="See 'cordicc targets'."
)
@click.option(
    "--units",
    type=click.Choice(["auto", "standard", "implicit"]),
    default="auto",
    show_default=True,
    help="Which CAUs may be used: 'standard' forbids implicit ones, 'implicit' wants a target with them.",
)
@click.option("--ii", type=_POSITIVE, help="Cycles between samples (initiation interval).  [default: 1]")
@click.option(
    "--rate",
    callback=hertz,
    metavar="HZ",
    help="Samples a second, instead of --ii: the longest interval that keeps up; 5e5, 500kHz.",
)
@COPIES
@click.option("--max-processors", type=click.IntRange(min=0), help="Most CAUs.")
@click.option("--max-latency", type=click.IntRange(min=0), metavar="CYCLES", help="Most cycles.")
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
@click.option(
    "--time-limit",
    type=Seconds(),
    metavar="SECONDS",
    help="Emergency stop of searches, which otherwise end on deterministic work limits.",
)
@click.option(
    "--emit",
    type=click.Choice(["c"]),
    multiple=True,
    help="Write more: 'c', a bit-accurate C99 model with its header.",
)
@click.option("--print-after", metavar="PASS", help="Print the operation graph after a pass, or after 'all'.")
@click.option(
    "--certify/--no-certify",
    default=None,
    help="Prove error bounds of the outputs.  [default: on fixed-point targets, and for a max_error]",
)
@click.option("--explain", is_flag=True, help="Print how each operation came about.")
@click.option("--json", "as_json", is_flag=True, help="Print the plan's figures as one JSON object.")
@click.option("-q", "--quiet", is_flag=True, help="Print no summary.")
def compile_command(
    file: Path,
    output: Path | None,
    target: str,
    units: str,
    ii: int | None,
    rate: float | None,
    copies: int,
    max_processors: int | None,
    max_latency: int | None,
    minimize: str,
    effort: float,
    time_limit: float | None,
    emit: tuple[str, ...],
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
    from cordicc.backends.text.summary import explanation_text, plan_sheet
    from cordicc.base.folders import write_files
    from cordicc.ir.text import print_graph
    from cordicc.plan.file import summary
    from cordicc.schedule.request import Limits, interval_for
    from cordicc.schedule.solver.engine import Effort
    from cordicc.targets.target_file import load_target

    names = pipeline.pass_names()
    if print_after is not None and print_after not in (*names, "all"):
        raise click.BadParameter(f"choose from all, {', '.join(names)}", param_hint="--print-after")

    def watch(name: str, graph: Any) -> None:
        if print_after in (name, "all"):
            click.echo(f"; after {name}\n{print_graph(graph)}", err=as_json)

    if rate is not None and ii is not None:
        raise click.UsageError("--ii and --rate exclude each other")
    interval = ii or 1 if rate is None else interval_for(load_target(target), rate)
    limits = Limits(minimize, interval, max_processors, max_latency, Effort(seconds=time_limit))
    options = pipeline.Options(target, units, limits, certify, copies, effort)
    with stages(quiet or print_after is not None) as enter:
        compiled = pipeline.compile_file(file, options, watch, enter)
    tell(compiled.warnings)
    plan = compiled.plan
    folder = output if output is not None else Path("build") / plan.name
    files = pipeline.artefacts(plan)
    if "c" in emit:
        from cordicc.backends.c import c_model

        files |= c_model.files(plan)
    write_files(folder, files)
    if explain:
        click.echo(explanation_text(plan), err=as_json)
    if as_json:
        click.echo(summary(plan), nl=False)
    elif not quiet:
        show(plan_sheet(plan, f"wrote {folder}: {', '.join(files)}"))


@main.command()
@click.argument("plan", type=FILE, metavar="PLAN|FILE")
@click.option("--inputs", type=FILE, metavar="IN.csv|IN.npz", help="Samples, under the names of the inputs.")
@click.option("--random", "count", type=_POSITIVE, help="Draw so many samples.  [default: 10000]")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the drawing.")
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
    callback=finite,
    help="Largest difference that --compare allows.  [default: columns tol_<output>, else what is proven of "
    "the row; where nothing is, twice the largest error observed]",
)
@click.option(
    "--reference",
    type=click.IntRange(min=0),
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
    "--vcd-samples", type=_POSITIVE, default=100, show_default=True, metavar="N", help="Samples of --vcd."
)
@click.option("--json", "as_json", is_flag=True, help="Print the errors as one JSON object.")
@click.pass_context
def simulate(
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
    from cordicc.cli.simulate import Reference, Run, run_samples

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
    run = Run(plan_or_problem(plan), cycle_accurate, as_json, tell, own_bounds)
    if compare:
        from cordicc.cli.compare import check_expected

        ctx.exit(check_expected(run, *compare, tolerance))
    if vcd is not None:
        from cordicc.emulate import waveform
        from cordicc.emulate.observation import DEFAULT_SAMPLES

        drawn = count or DEFAULT_SAMPLES
        first, more = waveform.first_samples(run.plan.problem, inputs, drawn, seed, vcd_samples)
        write_or_print(vcd, waveform.render(run.plan, first))
        if more:
            message = f"the waveform holds the first {vcd_samples} samples"
            tell([Diagnostic("W616", message, hint="--vcd-samples N writes N", severity=Severity.WARNING)])
    ctx.exit(run_samples(run, inputs, count, seed, outputs, Reference.of(reference, no_reference, report)))


@main.command()
@click.argument("plan", type=FILE)
@click.option(
    "--view",
    type=click.Choice(["datapath", "schedule", "graph"]),
    default="datapath",
    show_default=True,
    help="What to draw.",
)
@click.option(
    "--width",
    type=click.IntRange(min=0),
    default=1240,
    show_default=True,
    metavar="PIXELS",
    help="Fold datapath and graph into rows about so wide; 0: one row.",
)
@click.option(
    "-o",
    "--output",
    type=FILE,
    metavar="FILE.svg|png|pdf",
    help="Write here instead of stdout ('-'); PNG and PDF take 'cordicc[pictures]'.",
)
def draw(plan: Path, view: str, width: int, output: Path | None) -> None:
    """Draw a plan.json as SVG, PNG or PDF.

    \b
    cordicc draw build/arm/plan.json -o arm.svg
    cordicc draw build/arm/plan.json --view schedule -o arm.pdf
    """  # noqa: D301
    from cordicc.api import load_plan
    from cordicc.base.files import write_file

    if output is None and sys.stdout.isatty():
        raise click.UsageError("a picture is no text to read: name a file with -o, or '-o -' for stdout")
    picture = load_plan(plan).picture(view, width or None)
    if output is None or str(output) == "-":
        click.echo(picture.svg, nl=False)
    else:
        write_file(output, picture.converted(output.suffix))


@main.command()
@click.argument("file", type=FILE)
def check(file: Path) -> None:
    """Look for mistakes in a problem FILE.

    It is read and checked, not compiled; all its mistakes are listed together.

    \b
    cordicc check arm.yaml
    """  # noqa: D301
    from cordicc.api import check as check_file
    from cordicc.backends.text.summary import count

    problem, warnings = check_file(file)
    tell(warnings)
    parts = ((problem.inputs, "input"), (problem.equations, "equation"), (problem.outputs, "output"))
    counts = ", ".join(count(len(items), noun) for items, noun in parts)
    click.echo(f"{problem.name}: {counts}, no errors")


@main.command()
@click.argument("name", required=False)
def targets(name: str | None) -> None:
    """List the shipped targets, or print the one called NAME.

    NAME may be a file too, which is then checked.

    \b
    cordicc targets
    cordicc targets kinematic > mine.yaml
    """  # noqa: D301
    from cordicc.base.text_tables import Facts, Sheet
    from cordicc.targets.target_file import load_target, shipped_targets, target_text

    if name is not None:
        load_target(name)
        click.echo(target_text(name).text, nl=False)
        return
    shipped = [load_target(each) for each in shipped_targets()]
    rows = tuple((target.name, " ".join(target.description.split())) for target in shipped)
    show(Sheet("", (Facts(rows, indent=0),)))


main.add_command(trace)
main.add_command(sequences)
main.add_command(schedule)
main.add_command(explore)
main.add_command(explain)
main.add_command(diff)
main.add_command(schema)
