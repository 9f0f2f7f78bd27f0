"""`cordicc schema`: the JSON Schemas of the files."""

from __future__ import annotations

import click

from cordicc.cli.streams import deliver


@click.command("schema")
@click.argument("kind", type=click.Choice(["problem", "target", "plan"]))
def command(kind: str) -> None:
    """Print the JSON Schema of a kind of file.

    Editors complete and check problem and target files by it; plan.json is for other programs.

    \b
    cordicc schema problem > problem.schema.json
    """  # noqa: D301
    from importlib.resources import files

    text = files("cordicc").joinpath("schema", f"{kind}.schema.json").read_text(encoding="utf-8")
    deliver(text)
