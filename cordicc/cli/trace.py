"""`cordicc trace`: the iterations of one operation, or every stage of an operation of a plan."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from cordicc.cli.arguments import FILE, NOT_NEGATIVE, POSITIVE, json_option, output_option
from cordicc.cli.console import tell
from cordicc.cli.streams import say

_MODES = ("rotation", "vectoring", "implicit")
_TRACED = ("standard", "krieger96", "root-free", "single-rotation")
_OF_PLAN = ("operation", "inputs", "count", "seed", "sample", "as_json", "as_csv", "output")
"""Parameters that go with a plan; the others go with a mode."""


def _mode_or_plan(ctx: click.Context, param: click.Parameter, value: str) -> str | Path:
    """Return a mode as it is, else the path of a plan; raise BadParameter for what cannot be one."""
    if value in _MODES:
        return value
    if value.endswith(".json") or os.path.lexists(value):
        return Path(value)
    modes = ", ".join(f"'{mode}'" for mode in _MODES)
    raise click.BadParameter(f"{value!r} is not one of {modes}, and there is no such plan", ctx, param)


def _completed(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the modes that fit, else files."""
    modes = [CompletionItem(mode) for mode in _MODES if mode.startswith(incomplete)]
    return modes or [CompletionItem(incomplete, type="file")]


class _TwoSections(click.Command):
    """Lists the options of a mode and those of a plan apart."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options under their titles."""
        sections: dict[str, list[tuple[str, str]]] = {
            "Options of a MODE": [],
            "Options of a PLAN": [],
            "Options": [],
        }
        for each in (own for own in self.get_params(ctx) if isinstance(own, click.Option)):
            record = each.get_help_record(ctx)
            if record is not None:
                kind = "" if "--help" in each.opts else " of a PLAN" if _of_plan(each) else " of a MODE"
                sections[f"Options{kind}"].append(record)
        for title, records in sections.items():
            with formatter.section(title):
                formatter.write_dl(records)


def _of_plan(parameter: click.Parameter) -> bool:
    return parameter.name in _OF_PLAN


@click.command("trace", cls=_TwoSections)
@click.argument("what", metavar="MODE|PLAN", callback=_mode_or_plan, shell_complete=_completed)
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
@click.option("--operation", metavar="ID", help="The operation, such as o5.")
@click.option("--inputs", type=FILE, metavar="IN.csv|IN.npz", help="Samples, under the names of the inputs.")
@click.option(
    "--random",
    "count",
    type=POSITIVE,
    is_flag=False,
    flag_value=10_000,
    metavar="[N]",
    help="Draw so many samples, as 'simulate' does.  [default: 10000]",
    show_default=False,
)
@click.option("--seed", type=NOT_NEGATIVE, default=0, show_default=True, help="Seed of the drawing.")
@click.option(
    "--sample", type=NOT_NEGATIVE, default=0, show_default=True, metavar="K", help="Which, counted from 0."
)
@json_option("operands, results and signals")
@click.option("--csv", "as_csv", is_flag=True, help="Print the signals as CSV.")
@output_option("Write here instead of stdout; .json and .csv say in which form.", "FILE")
@click.pass_context
def command(
    ctx: click.Context,
    /,
    what: str | Path,
    x: str,
    y: str,
    z: str,
    target: str | None,
    sequence: str | None,
    iterations: int | None,
    m: str,
    branch: str | None,
    bits: int | None,
    **of_plan: Any,
) -> None:
    """Print the iterations of one operation, or every stage of an operation of a PLAN.

    MODE is rotation, vectoring or implicit: its iterations, to ten decimals.  Rotation drives z to 0,
    vectoring y to 0, implicit y to the C of B cos t + A sin t = C.  Numbers may be constant expressions such
    as 3*pi/8.  With krieger96, z counts half of what the vector turns.  With --bits a second table has the
    same iterations in integers, rounded as the units round.

    PLAN is a plan.json of a fixed-point target, or its folder: operands and results of an operation for one
    sample, and every signal of its unit, as it is called in the Verilog module, with the cycle in which it
    has its word.  Cycles of the operation count from its operands on, those of the plan from the sample's
    inputs on.

    \b
    cordicc trace rotation --x 1 --y 1 --z 1.1780972451 --sequence krieger96
    cordicc trace implicit --x 1 --y 2 --target 0.5 --branch +
    cordicc trace build/arm --operation o5 --inputs poses.csv --sample 17
    cordicc trace build/arm/plan.json --operation o5 --random --seed 3 -o o5.csv
    """  # noqa: D301
    if isinstance(what, Path):
        from cordicc.cli.stages import print_stages

        _refuse(ctx, [each for each in ctx.command.params if not _of_plan(each)], "a MODE, not a PLAN")
        print_stages(what, **of_plan)
        return
    _refuse(ctx, [each for each in ctx.command.params if _of_plan(each)], "a PLAN, not a MODE")
    from cordicc.frontend.reading import option_number
    from cordicc.studies.iteration_table import Request, trace_text

    at = [option_number(text, name) for name, text in (("--x", x), ("--y", y), ("--z", z))]
    goal = None if target is None else option_number(target, "--target")
    rule = sequence or ("single-rotation" if what == "implicit" else "standard")
    request = Request(what, rule, int(m), at[0], at[1], at[2], goal, iterations, branch, bits)
    text, warnings = trace_text(request)
    tell(warnings)
    say(text, newline=False)


def _refuse(ctx: click.Context, parameters: Sequence[click.Parameter], reason: str) -> None:
    """Raise UsageError if one of some options was given."""
    for each in parameters:
        source = ctx.get_parameter_source(each.name or "")
        if isinstance(each, click.Option) and source is click.core.ParameterSource.COMMANDLINE:
            raise click.UsageError(f"{each.opts[0]} goes with {reason}")
