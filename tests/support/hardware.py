"""Verilog as tests use it: a package in a folder, and the tools that may not be there."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

import cordicc

REACH = """
name: reach
inputs: {x: [0.2, 0.5], y: [-0.2, 0.3], spare: [0.25, 0.5]}
equations:
  - solve: x*cos(a) + y*sin(a) = (x**2 + y**2 + 0.05)/0.7
    for: a
    branch: "-"
  - r = hypot(x, y)*cos(a) + 2*x
outputs: [a, r]
"""
"""Implicit and standard units, a product, an input that nothing takes."""

SUMS = """
name: small
inputs: {x: [0.2, 0.5], y: [-0.2, 0.3], x_ok: [-1, 1], never: [1, 2]}
equations:
  - valid_ = x*y + 0.3*x*x_ok
  - f1 = sqrt(x)*y + valid_
outputs: [valid_, f1]
"""
"""Deep FIFOs beside a root; names that are words of Verilog, or inside a core; an input that nothing
takes, whose range its words do not hold."""


def needs(*programs: str) -> pytest.MarkDecorator:
    """Skip a test where a program is missing, with what to install."""
    missing = [program for program in programs if shutil.which(program) is None]
    reason = f"install {', '.join(missing)}: apt-get install {' '.join(missing)}"
    return pytest.mark.skipif(bool(missing), reason=reason)


def written(plan: cordicc.Plan, folder: Path, samples: int | None = None, reset: str = "rst") -> Path:
    """Write the Verilog of a plan below a folder; return `rtl/`."""
    for name, text in plan.emit("verilog", samples, reset).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder / "rtl"


def made(folder: Path, goal: str) -> subprocess.CompletedProcess[str]:
    """Run a goal of the Makefile in a folder."""
    return subprocess.run(
        ["make", "-s", goal], cwd=folder, capture_output=True, text=True, timeout=900, check=False
    )


def changed(folder: Path, name: str, old: str, new: str) -> None:
    """Change a file of a package, once."""
    text = (folder / name).read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{old!r} is {text.count(old)} times in {name}"
    (folder / name).write_text(text.replace(old, new), encoding="utf-8")
