"""What stands above every generated file: what it is, where it comes from, and under which terms."""

from __future__ import annotations

from hashlib import sha256

from cordicc import __version__
from cordicc.backends.rtl.names import comment
from cordicc.backends.rtl.reset_style import USUAL_RESET, ResetStyle
from cordicc.plan.file import dump
from cordicc.plan.model import Plan

LICENCE = "CC0-1.0"
"""Of all that is generated: it is its user's own, and no notice has to go with it."""

_DEFAULTS = {"units": "auto", "minimize": "processors", "ii": 1, "effort": None, "copies": 1}


def file_header(plan: Plan, about: str, reset: ResetStyle) -> list[str]:
    """Return the lines of a header, without the mark of a comment."""
    return [
        comment(f"{plan.name}: {about}"),
        comment(f"Made by cordicc {__version__}: {command_line(plan, reset)}"),
        f"SHA-256 of plan.json: {sha256(dump(plan).encode()).hexdigest()}",
        f"SPDX-License-Identifier: {LICENCE}",
    ]


def command_line(plan: Plan, reset: ResetStyle) -> str:
    """Return the command that makes the Verilog of a plan, without folders."""
    options = plan.options
    words = ["cordicc compile", options.file or f"{plan.name}.yaml", f"--target {plan.target.name}"]
    for name, usual in _DEFAULTS.items():
        value = getattr(options, name)
        if value != usual:
            words.append(f"--{name} {value}")
    if options.max_processors is not None:
        words.append(f"--max-processors {options.max_processors}")
    if options.max_latency is not None:
        words.append(f"--max-latency {options.max_latency}")
    if options.certify is not None:
        words.append("--certify" if options.certify else "--no-certify")
    words.append("--emit verilog")
    if reset != USUAL_RESET:
        words.append(f"--reset {reset.port}")
    return " ".join(words)
