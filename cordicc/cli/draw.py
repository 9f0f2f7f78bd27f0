"""`cordicc draw`: a picture of a plan."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from cordicc.artefacts import VIEWS
from cordicc.cli.arguments import NOT_NEGATIVE, is_stdout, output_option, plan_argument, require_unread
from cordicc.cli.streams import deliver, is_tty


@click.command("draw")
@plan_argument()
@click.option("--view", type=click.Choice(VIEWS), default=VIEWS[0], show_default=True, help="What to draw.")
@click.option(
    "--width",
    type=NOT_NEGATIVE,
    default=1240,
    show_default=True,
    metavar="PIXELS",
    help="Fold datapath and graph into rows about so wide; 0: one row.",
)
@output_option(
    "Write here instead of stdout ('-'); PNG and PDF take 'cordicc[pictures]'.", "FILE.svg|png|pdf"
)
def command(plan: Path, view: str, width: int, output: Path | None) -> None:
    """Draw a plan.json as SVG, PNG or PDF.

    \b
    cordicc draw build/arm/plan.json -o arm.svg
    cordicc draw build/arm/plan.json --view schedule -o arm.pdf
    """  # noqa: D301
    from cordicc.api import load_plan
    from cordicc.base.files import write_file

    if output is None and is_tty(sys.stdout):
        raise click.UsageError("a picture is no text to read: name a file with -o, or '-o -' for stdout")
    require_unread("-o", output, plan)
    picture = load_plan(plan).picture(view, width or None)
    if output is None or is_stdout(output):
        deliver(picture.svg)
    else:
        write_file(output, picture.converted(output.suffix))
