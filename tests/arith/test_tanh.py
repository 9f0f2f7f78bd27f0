"""tanh, and sinh/cosh, of large arguments on fixed point: bounded numbers only."""

from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.certify.plans import StatedBounds
from tests.support.selection import slow

TEXT = "inputs: {{z: [{lo}, {hi}], a: [0.5, 2]}}\nequations: ['t = {formula}']\n"
PLACE = 2.0**-22
"""Of words for numbers up to 1."""


def compiled(folder: Path, formula: str, lo: float, hi: float, target: str = "fixed24") -> cordicc.Plan:
    path = folder / "p.yaml"
    path.write_text(TEXT.format(lo=lo, hi=hi, formula=formula), encoding="utf-8")
    return cordicc.compile(path, target=target)


@pytest.mark.parametrize(
    ("formula", "lo", "hi", "scale"),
    [
        ("tanh(z)", -30, 30, 1.0),
        slow(("a*tanh(z)", 3, 400, 2.0)),
        slow(("sinh(z)/cosh(z)", -12, 12, 1.0)),
        slow(("-3*sinh(z)/(2*cosh(z)) + a", -50, 9, 4.0)),
        slow(("tanh(a*z)", -8, 8, 1.0)),
    ],
)
def test_error_and_bound_are_those_of_the_words(
    tmp_path: Path, formula: str, lo: float, hi: float, scale: float
) -> None:
    plan = compiled(tmp_path, formula, lo, hi)
    word = 2.0 ** -plan.formats.values["z"].fraction  # the rounding of z moves tanh z by half of it
    limit = 4 * (scale * word + scale * PLACE)
    figures = plan.accuracy["t"]
    assert figures.observed.max <= limit
    assert figures.bound.value <= 2 * limit
    assert figures.bound.share_of_samples >= 0.99
    z = np.linspace(lo, hi, 2001)
    made = plan.simulate({"z": z, "a": np.full(2001, 1.25)})
    assert made["valid"].all()
    stated = StatedBounds.of(plan)
    assert stated is not None
    held = stated.inside({"z": z, "a": np.full(2001, 1.25)})["t"]
    exact = eval(formula, {"z": z, "a": 1.25, "tanh": np.tanh, "sinh": np.sinh, "cosh": np.cosh})
    finite = np.isfinite(exact)
    assert np.all(np.abs(made["t"] - exact)[held & finite] <= figures.bound.value)


@pytest.mark.parametrize(("target", "lo", "hi"), [("kinematic", -30, 30), ("fixed24", -3, 3)])
def test_small_arguments_and_floating_point_keep_the_quotient(
    tmp_path: Path, target: str, lo: float, hi: float
) -> None:
    plan = compiled(tmp_path, "tanh(z)", lo, hi, target)
    assert "flip" not in {operation.op for operation in plan.operations}


@pytest.mark.parametrize("formula", ["cosh(z)/sinh(z + 20)", slow("sinh(z)/cosh(z - 1)")])
def test_other_quotients_stay(tmp_path: Path, formula: str) -> None:
    plan = compiled(tmp_path, formula, 5, 6)
    assert "flip" not in {operation.op for operation in plan.operations}
