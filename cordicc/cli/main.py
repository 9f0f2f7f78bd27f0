"""`cordicc`: gathers the commands, each in a module of its name, and turns errors into an exit status."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

import click

from cordicc import __version__
from cordicc.base.diagnostics import CordiccError
from cordicc.cli.console import tell
from cordicc.cli.streams import cannot_write, prepare, say, written

COMMANDS = (
    "check",
    "compile",
    "diff",
    "draw",
    "explain",
    "explore",
    "schedule",
    "schema",
    "sequences",
    "simulate",
    "synthesize",
    "targets",
    "trace",
)
"""Their names; `command` in the module `cordicc.cli.NAME` is each of them.

These modules import what a command takes when it runs, so that all of them are here at once.
"""


class _Group(click.Group):
    """Turns the errors of cordicc into diagnostics on stderr and their exit status."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except CordiccError as error:
            tell([*error.warnings, *error.diagnostics])
            ctx.exit(error.exit_status)
        except BrokenPipeError:
            ctx.exit(1)

    def main(self, *args: Any, **options: Any) -> Any:
        """Run the command line, and end the process with its status unless told otherwise."""
        prepare()
        if not options.get("standalone_mode", True):
            return super().main(*args, **options)
        try:
            status = super().main(*args, **options | {"standalone_mode": False})
        except click.ClickException as error:
            written(error.show, err=True)
            status = error.exit_code
        except click.Abort:
            say("Aborted!", err=True)
            status = 1
        except OSError as error:  # the help of a command
            if error.filename is not None:
                raise
            tell([cannot_write(error)])
            status = 2
        sys.exit(status or 0)


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


for _name in COMMANDS:
    main.add_command(import_module(f"cordicc.cli.{_name}").command)
