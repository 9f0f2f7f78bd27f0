"""The commands that read plans and the schemas: `cordicc explain`, `cordicc diff`, `cordicc schema`."""

from __future__ import annotations

import re
from pathlib import Path

import click

from cordicc.cli.arguments import FILE, plan_or_problem
from cordicc.cli.console import show

_CODE = re.compile(r"[EW][0-9]{3}")


@click.command()
@click.argument("plan", metavar="PLAN|FILE|CODE")
def explain(plan: str) -> None:
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
        click.echo(said, nl=False)
        return
    from cordicc.backends.text.explanation import explanation

    show(explanation(plan_or_problem(Path(plan))))


@click.command()
@click.argument("first", type=FILE, metavar="PLAN")
@click.argument("second", type=FILE, metavar="PLAN")
@click.option("--json", "as_json", is_flag=True, help="Print the differences as one JSON object.")
@click.pass_context
def diff(ctx: click.Context, first: Path, second: Path, as_json: bool) -> None:
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
        click.echo(plan_differences.as_json(found), nl=False)
    else:
        show(plan_differences.as_sheet(*plans, found, _told_apart(first, second)))
    ctx.exit(1 if found else 0)


def _told_apart(first: Path, second: Path) -> tuple[str, str]:
    """Return short names of two plans, of their folders or files if these differ."""
    names = [
        path.resolve().parent.name if path.name == "plan.json" else path.stem for path in (first, second)
    ]
    return (names[0], names[1]) if names[0] != names[1] and all(names) else ("first", "second")


@click.command()
@click.argument("kind", type=click.Choice(["problem", "target", "plan"]))
def schema(kind: str) -> None:
    """Print the JSON Schema of a kind of file.

    Editors complete and check problem and target files by it; plan.json is for other programs.

    \b
    cordicc schema problem > problem.schema.json
    """  # noqa: D301
    from importlib.resources import files

    text = files("cordicc").joinpath("schema", f"{kind}.schema.json").read_text(encoding="utf-8")
    click.echo(text, nl=False)
