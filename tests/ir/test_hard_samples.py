"""Samples near borders of the domain and near vectors of length 0."""

import numpy as np

from cordicc.base.diagnostics import Source
from cordicc.frontend.load import parse_problem
from cordicc.ir.hard_samples import hard_samples
from cordicc.ir.meaning.doubles import screen
from cordicc.ir.sampling import Workspace, draw


def problem(inputs: str, *equations: str):
    lines = "".join(f"  - {equation}\n" for equation in equations)
    return parse_problem(Source("p.yaml", f"inputs: {{{inputs}}}\nequations:\n{lines}")).problem


def found(made) -> dict[str, np.ndarray]:
    return hard_samples(made.graph, made.workspace, draw(made.workspace, 2000, 0))


def test_they_are_inside_and_close_to_the_border():
    disk = problem("x: [-1, 1], y: [0, 1]", "z = sqrt(1 - x**2 - y**2)")
    samples = found(disk)
    depth = 1 - np.hypot(samples["x"], samples["y"])
    assert screen(disk.graph, samples)[1].all()
    assert depth.size > 100
    assert depth.min() < 5e-6
    for distance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        assert ((depth > distance / 10) & (depth < 3 * distance)).any()


def test_a_vector_without_direction_is_approached():
    wrist = problem("a: [-1, 1], b: [-0.5, 2], c: [0, 1]", "q = atan2(sin(b)*c, sin(a) - b)")
    samples = found(wrist)
    length = np.hypot(np.sin(samples["b"]) * samples["c"], np.sin(samples["a"]) - samples["b"])
    assert screen(wrist.graph, samples)[1].all()
    assert 0 < length.min() < 1e-5


def test_there_are_none_without_a_border_or_where_inputs_depend_on_one_another():
    whole = problem("x: [1, 2]", "z = sqrt(x)")
    assert not found(whole)["x"].size
    disk = problem("x: [-1, 1]", "z = sqrt(1 - 4*x**2)")
    drawn = draw(disk.workspace, 500, 0)
    rows = Workspace(disk.workspace.ranges, {"x": tuple(drawn["x"])})
    assert not hard_samples(disk.graph, rows, drawn)["x"].size
    assert found(disk)["x"].size


def test_an_input_with_one_value_keeps_it():
    disk = problem("x: [-1, 1], y: [0.5, 0.5]", "z = sqrt(1 - x**2 - y**2)")
    samples = found(disk)
    assert samples["x"].size
    assert (samples["y"] == 0.5).all()
