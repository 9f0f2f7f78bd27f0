"""`cordicc explain`: a plan, or the code of a diagnostic, in words."""

from __future__ import annotations

import re
from pathlib import Path

import click

from cordicc.cli.arguments import plan_or_problem
from cordicc.cli.console import show
from cordicc.cli.streams import say

_CODE = re.compile(r"[EW][0-9]{3}")


@click.command("explain")
@click.argument("plan", metavar="PLAN|FILE|CODE")
def command(plan: str) -> None:
    """Say in words what a plan does and why no cheaper one exists.

    PLAN is a plan.json; a problem FILE is compiled first with the default options.  The CODE of a diagnostic,
    such as E302, is explained too.

    \b
    cordicc explain build/planar-2r/plan.json
    cordicc explain E302
    """  # noqa: D301
    if _CODE.fullmatch(plan):
        from cordicc.base.codes import entry

        said = entry(plan)
        if said is None:
            raise click.BadParameter(f"there is no code {plan}; see docs/diagnostics.md", param_hint="CODE")
        say(said, newline=False)
        return
    from cordicc.backends.text.explanation import explanation

    show(explanation(plan_or_problem(Path(plan))))
