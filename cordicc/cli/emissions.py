"""What `--emit` takes: the name of an artefact, and of those with samples how many."""

from __future__ import annotations

from typing import Any

import click

from cordicc.artefacts import ON_REQUEST

_MOST = 10_000_000


class _Emission(click.Choice[str]):
    """A name, or NAME=N."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the name and the count, None if there is none; raise BadParameter."""
        if isinstance(value, tuple):
            return value
        text, equals, count = str(value).partition("=")
        name = super().convert(text, param, ctx)
        if not equals:
            return name, None
        if not ON_REQUEST[name].samples:
            self.fail(f"'{name}' takes no count", param, ctx)
        if not (count.isascii() and count.isdigit() and int(count[:9]) > 0 and int(count[:9]) <= _MOST):
            self.fail(f"{count!r} is not a count of samples from 1 to {_MOST}", param, ctx)
        return name, int(count)


EMISSION = _Emission(list(ON_REQUEST))


class EmittingCommand(click.Command):
    """A command whose `--emit NAME N` means `--emit NAME=N`, for what has samples.

    A problem file whose name is a number is written with a folder, `./5000`, behind such a name.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse arguments with counts joined to their names."""
        return super().parse_args(ctx, _joined(args))


def _joined(args: list[str]) -> list[str]:
    with_samples = {name for name, each in ON_REQUEST.items() if each.samples}
    found: list[str] = []
    for arg in args:
        *_, before, last = ["", "", *found]
        named = last if before == "--emit" else last.partition("--emit=")[2]
        if named in with_samples and arg.isascii() and arg.isdigit():
            found[-1] += f"={arg}"
        else:
            found.append(arg)
    return found
