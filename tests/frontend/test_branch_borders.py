"""Conditions that choose a branch, at angles on their very border: decided on the angle, for integers."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.frontend.load import load_problem
from cordicc.ir.meaning.reference import reference_outputs
from tests.support.selection import slow

CONDITIONS = {
    "q < 0": lambda t: t <= 0,
    "-q > 0": lambda t: t <= 0,
    "0 >= q": lambda t: t <= 0,
    "q > 0": lambda t: t >= 0,
    "sin(q) > 0": lambda t: t in (0, math.pi) or math.sin(t) > 0,
    "2*sin(q) < 0": lambda t: t in (0, math.pi) or math.sin(t) < 0,
    "cos(q) > 0": lambda t: math.cos(t) >= -1e-12,
    "-3*cos(q) > 0": lambda t: math.cos(t) <= 1e-12,
}
"""Whether an angle in (-pi, pi] meets a condition; equal counts as meeting it."""

FILE = """
inputs: {{a: [-4, 4], b: [-4, 4], c: [-5, 5]}}
equations:
  - solve: b*cos(q) + a*sin(q) = c
    for: q
    branch: {condition}
"""


def solutions(a: int, b: int, c: int) -> list[float]:
    """Return both solutions, + first, in (-pi, pi], multiples of pi exactly."""
    half = math.acos(c / math.hypot(a, b))
    found = []
    for sign in (1, -1):
        t = math.remainder(math.atan2(a, b) + sign * half, 2 * math.pi)
        near = [exact for exact in (0.0, math.pi) if abs(math.remainder(t - exact, 2 * math.pi)) < 1e-12]
        found.append(near[0] if near else t)
    return found


@pytest.mark.parametrize("condition", CONDITIONS)
def test_every_border_among_small_integers(tmp_path: Path, condition: str) -> None:
    path = tmp_path / "border.yaml"
    path.write_text(FILE.format(condition=condition), encoding="utf-8")
    numbers = [(a, b, c) for a in range(-3, 4) for b in range(-3, 4) for c in range(-5, 6)]
    numbers = [(a, b, c) for a, b, c in (*numbers, (3, 4, 2), (-4, 3, 3)) if c * c < a * a + b * b]
    columns = {
        n: np.array(column, dtype=float) for n, column in zip("abc", zip(*numbers, strict=True), strict=True)
    }
    values, valid = reference_outputs(load_problem(path).problem.graph, columns)
    for index, each in enumerate(numbers):
        wanted = [t for t in solutions(*each) if CONDITIONS[condition](t)]
        assert valid[index] == bool(wanted), each
        if wanted:
            error = math.remainder(values["q"][index] - wanted[0], 2 * math.pi)
            assert abs(error) < 1e-9, (each, values["q"][index], wanted)


@pytest.mark.parametrize("target", [slow("kinematic"), "fixed24"])
def test_a_solution_that_is_always_pi_is_not_negative(tmp_path: Path, target: str) -> None:
    path = tmp_path / "pi.yaml"
    path.write_text(
        "inputs: {x: [0.5, 1]}\nequations:\n"
        "  - solve: 2*cos(q) + x*sin(q) = -2\n    for: q\n    branch: q < 0\n"
    )
    out = cordicc.compile(path, target=target, effort=0.1, certify=False).simulate({"x": [0.5, 0.75, 1.0]})
    assert out["valid"].all()
    np.testing.assert_allclose(out["q"], 2 * np.arctan2([0.5, 0.75, 1.0], 2) - math.pi, atol=2e-6)


def test_a_solution_at_the_pole_of_its_condition_is_outside_the_domain(tmp_path: Path) -> None:
    path = tmp_path / "pole.yaml"
    path.write_text(
        "inputs: {x: [-1, 0]}\nequations:\n"
        "  - solve: x = 2*cos(w) + x*sin(w)\n    for: w\n    branch: tan(w) > 0\n"
    )
    problem, _ = cordicc.check(path)
    _, valid = reference_outputs(problem.graph, {"x": np.array([-0.5, -0.25, -1.0])})
    assert not valid.any()
    assert not cordicc.compile(path, effort=0.1).simulate({"x": [-0.5, -0.25, -1.0]})["valid"].any()
