"""`cordicc diff`: what two plans have not in common."""

from __future__ import annotations

from pathlib import Path

import click

from cordicc.cli.arguments import json_option, plan_argument
from cordicc.cli.console import show
from cordicc.cli.streams import deliver


@click.command("diff")
@plan_argument("first")
@plan_argument("second")
@json_option("the differences")
@click.pass_context
def command(ctx: click.Context, first: Path, second: Path, as_json: bool) -> None:
    """Compare two plans.

    Problem, options, figures, accuracy and operations are compared.  As with diff(1), exit status 0 says that
    they are the same, 1 that they differ, 2 trouble.

    \b
    cordicc diff build/old/plan.json build/new/plan.json
    """  # noqa: D301
    from cordicc.api import load_plan
    from cordicc.backends.text import plan_differences

    plans = load_plan(first), load_plan(second)
    found = plan_differences.differences(*plans)
    if as_json:
        deliver(plan_differences.as_json(found))
    else:
        show(plan_differences.as_sheet(*plans, found, _told_apart(first, second)))
    ctx.exit(1 if found else 0)


def _told_apart(first: Path, second: Path) -> tuple[str, str]:
    """Return short names of two plans, of their folders or files if these differ."""
    names = [
        path.resolve().parent.name if path.name == "plan.json" else path.stem for path in (first, second)
    ]
    return (names[0], names[1]) if names[0] != names[1] and all(names) else ("first", "second")
