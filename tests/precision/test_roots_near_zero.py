"""Plans on fixed point keep the digits of small roots, and an allowed error is refused only without them."""

import math
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.base.diagnostics import Unattainable
from cordicc.pipeline import Options, plan_file

NORM = "v = sqrt(x**2 + y**2 + z**2)"
BOX = "x: [-1, 1], y: [-1, 1], z: [-1, 1]"
AWAY = "x: [0.1, 1], y: [0.1, 1], z: [0.1, 1]"


def problem(folder: Path, inputs: str, equation: str, options: str = "") -> Path:
    path = folder / "root.yaml"
    text = f"inputs: {{{inputs}}}\nequations:\n  - {equation}\noutputs: {{v: {{{options}}}}}\n"
    path.write_text(text, encoding="utf-8")
    return path


def ulp(plan: cordicc.Plan, output: str = "v") -> float:
    return math.ldexp(1.0, -plan.formats.outputs[output].fraction)


def small(inputs: int, count: int = 200) -> np.ndarray:
    """Return points at distances from 2^-22 to 1 from 0, in all directions."""
    generator = np.random.default_rng(8)
    return generator.uniform(-1, 1, (inputs, count)) * 2.0 ** -generator.uniform(0, 22, count)


def test_small_vectors_keep_their_length(tmp_path: Path) -> None:
    plan = cordicc.compile(problem(tmp_path, BOX, NORM), target="fixed24", effort=0.1)
    x, y, z = small(3)
    found = plan.simulate({"x": x, "y": y, "z": z})
    assert found["valid"].all()
    # Half an ulp of each input and of the output, and what the units make of it.
    assert np.max(np.abs(found["v"] - np.sqrt(x**2 + y**2 + z**2))) < 2.5 * ulp(plan)
    bound = plan.accuracy["v"].bound
    assert bound is not None
    assert bound.value is not None
    assert not bound.conditions, "for every valid sample"
    assert bound.value < 3 * ulp(plan)


def test_an_allowed_error_is_met_by_lengths(tmp_path: Path) -> None:
    plan = cordicc.compile(problem(tmp_path, BOX, NORM, "max_error: 1e-6"), target="fixed24", effort=0.1)
    bound = plan.accuracy["v"].bound
    assert bound is not None
    assert bound.value is not None
    assert bound.value <= 1e-6
    assert bound.share_of_samples == 1


@pytest.mark.exhaustive(
    reason="tries all widths of words twice; quick ones meet an error by lengths, and refuse one"
)
@pytest.mark.parametrize("inputs", [BOX, AWAY])
def test_an_error_is_refused_only_after_lengths(inputs: str, tmp_path: Path) -> None:
    """With squares the nearest that can be met where nothing is small is 5e-8."""
    with pytest.raises(Unattainable) as refused:
        plan_file(problem(tmp_path, inputs, NORM, "max_error: 5e-9"), Options("fixed24", effort=0.1))
    (diagnostic,) = refused.value.diagnostics
    assert diagnostic.code == "E413"
    assert diagnostic.hint is not None
    assert float(diagnostic.hint.split("met is ")[1].split(",")[0]) < 1e-8


def test_guard_bits_are_judged_where_roots_are_small(tmp_path: Path) -> None:
    """Random samples of four numbers do not come near 0, where no length keeps the digits of this root."""
    names = ", ".join(f"{name}: [-10, 10]" for name in "wxyz")
    equation = "v = sqrt(x**2 + y**2 + z**2 + w**2 + x*y*z/16 + w*x/2)"
    plan = plan_file(problem(tmp_path, names, equation), Options("fixed24")).plan
    assert plan.arithmetic.system.guard_bits > 4
