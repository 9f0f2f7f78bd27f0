"""`cordicc trace`: the iterations of one operation."""

from __future__ import annotations

import click

from cordicc.cli.console import tell
from cordicc.cli.streams import say

_MODES = ("rotation", "vectoring", "implicit")
_TRACED = ("standard", "krieger96", "root-free", "single-rotation")


@click.command("trace")
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
def command(
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
    say(text, newline=False)
