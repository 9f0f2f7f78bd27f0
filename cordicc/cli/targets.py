"""`cordicc targets`: the shipped targets."""

from __future__ import annotations

import click

from cordicc.cli.console import show
from cordicc.cli.streams import deliver


@click.command("targets")
@click.argument("name", required=False)
def command(name: str | None) -> None:
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
        deliver(target_text(name).text)
        return
    shipped = [load_target(each) for each in shipped_targets()]
    rows = tuple((target.name, " ".join(target.description.split())) for target in shipped)
    show(Sheet("", (Facts(rows, indent=0),)))
