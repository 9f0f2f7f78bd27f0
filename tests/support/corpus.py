"""The public corpus: its problems, tables, and outputs that are angles."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from tests.support.paths import CORPUS

PROBLEMS = tuple(sorted(p.stem for p in CORPUS.glob("*.yaml") if not p.stem.startswith("rej_")))
REFUSED = tuple(sorted(p.stem for p in CORPUS.glob("rej_*.yaml")))

VARIED = ("planar_2r", "four_bar", "catenary", "lorentz_boost", "mecanum", "wrist_zyz")
"""Small problems that differ: implicit and standard units of each system, lightcones, sums of products."""

LITTLE = 0.1
"""An effort with which a plan is found soon; it may take more units than the usual one."""

LITTLE_CASES = [(name, LITTLE) for name in VARIED]
EFFORT_CASES = [*((name, 1.0) for name in PROBLEMS), *LITTLE_CASES]
"""Problems and efforts of tests that run plans of the whole corpus; those with little effort are quick."""


def problem_path(name: str) -> Path:
    """Return the file of a problem."""
    return CORPUS / f"{name}.yaml"


def inputs_of(name: str) -> dict[str, np.ndarray]:
    """Return the workspace of a problem: for each input an array of shape (samples,)."""
    return table(CORPUS / f"{name}.inputs.csv")


def expected_of(name: str) -> dict[str, np.ndarray]:
    """Return the outputs on the workspace, and for each output `tol_` with its tolerance."""
    return table(CORPUS / f"{name}.expected.csv")


def table(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of a CSV file of numbers."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def angles() -> dict[str, set[str]]:
    """Return by problem the outputs that are angles."""
    lines = (CORPUS / "angles.txt").read_text(encoding="utf-8").splitlines()
    return {line.split()[0]: set(line.split()[1:]) for line in lines if line}
