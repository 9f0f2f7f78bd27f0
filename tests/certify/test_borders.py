"""What rounding alone puts beyond a border is on it: slacks, the end of reach, and what is said of it."""

import math
from pathlib import Path

import numpy as np
import pytest

from cordicc.arith.numbers.slack import EXACT
from cordicc.backends.text.summary import plan_sheet
from cordicc.base.text_tables import plain
from cordicc.certify.error_network import network
from cordicc.certify.own_bounds import own_bounds
from cordicc.emulate import functional
from cordicc.ir.meaning.reference import reference_outputs
from tests.support.plans import compiled, planned
from tests.support.selection import quick

TARGETS = ["fixed24", "kinematic", "krieger96", "imscor24"]
PAIRS = [(-0.528, -0.794), (0.254, 0.332)]
CLAMPS = "inputs: {k: [-2, 2]}\nequations:\n" + "".join(
    f"  - r{i} = hypot({a}, {b})\n"
    f"  - solve: {a}*cos(q{i}) + {b}*sin(q{i}) = min(max(k, -r{i}), r{i})\n    for: q{i}\n    branch: '-'\n"
    for i, (a, b) in enumerate(PAIRS)
)
ARC_COSINE = "inputs: {c: [-1.001, 1.001]}\nequations:\n  - ang = acos(min(1, max(-1, c)))\n"
TORQUE = """
constants: {lam: 0.0105, dl: 30e-6}
inputs: {iq: [-200, 200]}
equations:
  - i_d = (lam - sqrt(lam**2 + 8*dl**2*iq**2))/(4*dl)
  - iqn = sign(iq)*sqrt(iq**2 - i_d**2)
outputs: [iqn]
"""
CIRCLE = "inputs: {x: [-1, 1], y: [-1, 1]}\nequations:\n  - z = sqrt(1 - x**2 - y**2)\n"
ROOT = "inputs: {x: [-1, 1]}\nequations:\n  - z = sqrt(x)\n"


def written(folder, text):
    path = folder / "problem.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def run(plan, **samples):
    columns = {name: np.atleast_1d(np.asarray(column, dtype=float)) for name, column in samples.items()}
    return functional.run(plan, plan.arithmetic, columns)


def slacks(plan):
    return [o.slack for o in plan.operations if o.slack != EXACT]


@pytest.mark.parametrize("target", quick(TARGETS, "fixed24", "kinematic"))
def test_a_clamp_is_a_clamp(target: str, tmp_path: Path) -> None:
    plan = planned(written(tmp_path, CLAMPS), target=target, effort=0.1)
    found = run(plan, k=[2, -2, 1.5, -1.5])
    assert found["valid"].all()
    for i, (a, b) in enumerate(PAIRS):
        ends = np.array([math.atan2(b, a), math.atan2(b, a) - math.pi] * 2)
        off = np.angle(np.exp(1j * (found[f"q{i}"] - ends)))
        assert np.abs(off).max() < 1e-6


@pytest.mark.parametrize("target", quick(TARGETS, "fixed24", "kinematic"))
def test_the_ends_of_an_arc_cosine_are_the_rounded_angles(target: str, tmp_path: Path) -> None:
    plan = planned(written(tmp_path, ARC_COSINE), target=target, effort=0.1)
    assert not slacks(plan)  # rounding is monotone: c within 1 is no word beyond
    c = [1.0005, 1.0, -1.0, -1.0005, 1 - 2.0**-20]
    found = run(plan, c=c)
    (pi,) = plan.arithmetic.system.format(plan.formats.outputs.get("ang")).encode_angle(np.array([math.pi]))
    rounded = plan.arithmetic.system.format(plan.formats.outputs.get("ang")).decode(np.array([pi]))[0]
    assert found["ang"][:4].tolist() == [0.0, 0.0, rounded, rounded]
    assert found["ang"][4] == pytest.approx(math.acos(c[4]), rel=0.02)


@pytest.mark.parametrize("target", quick(TARGETS, "fixed24"))
def test_a_root_at_the_border_is_valid(target: str, tmp_path: Path) -> None:
    plan = planned(written(tmp_path, TORQUE), target=target, effort=0.1)
    assert slacks(plan)
    found = run(plan, iq=[0.0, 1e-6, -1e-6, 0.01])
    assert found["valid"].all()
    assert np.abs(found["iqn"][:3]).max() < 1e-4


@pytest.mark.parametrize("target", quick(TARGETS, "fixed24"))
def test_what_is_truly_outside_stays_invalid(target: str, tmp_path: Path) -> None:
    plan = planned(written(tmp_path, CIRCLE), target=target, effort=0.1)
    (slack,) = slacks(plan)
    assert slack.beyond < 1e-6
    x, y = np.array([0.6, -0.28, 0.8, 1.0]), np.array([0.8, 0.96, 0.6, 0.0])
    assert run(plan, x=x, y=y)["valid"].all()
    assert not run(plan, x=x[:3] * (1 + 2e-6), y=y[:3] * (1 + 2e-6))["valid"].any()
    exact = planned(written(tmp_path, ROOT), target=target, effort=0.1)
    assert not slacks(exact)
    assert run(exact, x=[0.0, -1e-6, -3e-7])["valid"].tolist() == [True, False, False]


def test_own_bounds_hold_at_the_end_of_reach(tmp_path: Path) -> None:
    plan = planned(written(tmp_path, CLAMPS), target="fixed24", effort=0.1)
    rng = np.random.default_rng(3)
    sizes = np.array([math.hypot(*pair) for pair in PAIRS])
    near = rng.choice(sizes, 600) * (1 - rng.choice([0, 1, 1], 600) * 10.0 ** rng.uniform(-9, -2, 600))
    samples = {"k": np.clip(near * rng.choice([-1, 1], 600), -2, 2)}
    found, (exact, valid) = run(plan, **samples), reference_outputs(plan.problem.program, samples)
    assert valid.all()
    assert found["valid"].all()
    own = own_bounds(network(plan), list(exact), samples)
    for name, values in exact.items():
        error = np.abs(np.angle(np.exp(1j * (found[name] - values))))
        assert (error <= own[name]).all()
        assert own[name].max() < 5e-3


def test_the_summary_says_what_an_angle_is_off_near_the_end(tmp_path: Path) -> None:
    plan = compiled(written(tmp_path, ARC_COSINE), target="kinematic", effort=0.1)
    (error,) = [o.end_error for o in plan.operations if o.end_error is not None]
    said = plain(plan_sheet(plan))
    assert "near the end of reach, |C| = R, the angle of the equation of" in said
    assert f"ang  off by {error.residual:.3g}/sqrt(R^2 - C^2) rad, at most {error.angle_rad:.3g} rad" in said
    c = 1 - 10.0 ** np.linspace(-9, -3, 400)
    off = np.abs(run(plan, c=c)["ang"] - np.arccos(c))
    assert off.max() <= error.angle_rad
    far = 1 - c > 4 * error.residual
    assert (off <= 1.2 * error.residual / np.sqrt(1 - c * c) + 2.0**-23)[far].all()


COSINE_LAW = """
inputs: {x: [0.001, 1000], y: [0.001, 1000], z: [0.001, 1000]}
equations: ["q = acos((x**2 + y**2 - z**2)/(2*x*y))"]
outputs: [q]
"""


@pytest.mark.parametrize("target", quick(["kinematic", "imscor24", "krieger96"], "kinematic"))
def test_small_samples_of_wide_ranges_are_not_at_the_border(target: str, tmp_path: Path) -> None:
    plan = planned(written(tmp_path, COSINE_LAW), target=target)
    inside = {"x": [0.1, 0.3, 0.01, 80.0], "y": [0.1, 0.4, 0.01, 0.9], "z": [0.1, 0.5, 0.019, 80.1]}
    found = run(plan, **inside)
    x, y, z = (np.array(inside[name]) for name in "xyz")
    assert found["valid"].all()
    assert np.abs(found["q"] - np.arccos((x**2 + y**2 - z**2) / (2 * x * y))).max() < 1e-4
    outside = run(plan, x=[0.001, 0.1, 1], y=[0.001, 0.1, 1], z=[0.003, 0.205, 2.01])
    assert not outside["valid"].any()


JUMPS = """
inputs: {x: [0.1, 0.9], y: [-1, 1]}
equations:
  - solve: x*y*cos(q) + max(y, y)*sin(q) = x
    for: q
    branch: q < 0
"""


def test_a_choice_that_errors_change_is_no_distance(tmp_path: Path) -> None:
    plan = planned(written(tmp_path, JUMPS), target="kinematic")
    assert all(slack.beyond < 1e-5 for slack in slacks(plan))
    assert run(plan, x=[0.13, 0.13], y=[0.19, 0.99])["valid"].tolist() == [False, False]


UNKNOWN = {
    "half a turn": (
        "krieger96",
        "inputs: {y: [-0.5, 0.5], z: [-4, -1]}\nequations:\n"
        "  - w0 = atan2(sin(z), y + z) + acos(sin(z)/hypot(sin(z), y + z))\n  - w = asin(w0)**1.5\n",
        {"y": [0.11538511, 0.39816268], "z": [-3.74795397, -1.36704725]},
        [None, 0.00110791],
    ),
    "an angle at the cut": (
        "kinematic",
        "inputs: {x: [-2, 3], y: [-4, -1]}\nequations:\n"
        "  - solve: x*cos(v) + atan(x)*sin(v) = asinh(x)\n    for: v\n    branch: '-'\n"
        "  - solve: y*cos(a) + v**2*sin(a) = x**1.5\n    for: a\n    branch: sin(a) < 0\n"
        "  - solve: 1.25*cos(w) + a*sin(w) = 0.5\n    for: w\n    branch: '+'\noutputs: [w]\n",
        {"x": [0.09179374, 1.23594756], "y": [-1.3825, -2.13043847]},
        [2.7780933, 2.7184731],
    ),
    "an angle without a solution": (
        "krieger96",
        "inputs: {x: [0, 2], y: [-1, 1]}\nequations:\n"
        "  - solve: y*cos(v) + x*sin(v) = 0\n    for: v\n    branch: '+'\n"
        "  - solve: tanh(x)*cos(w) + y*sin(w) = v\n    for: w\n    branch: '+'\noutputs: [w]\n",
        {"x": [1.27392337, 1.8], "y": [0.23077022, -0.5]},
        [None, None],
    ),
    "a residue of small numbers": (
        "fixed24",
        "inputs: {x: [-2, 3]}\nequations:\n"
        "  - solve: x*cos(w) + atan2(x, x)*sin(w) = 0.7\n    for: w\n    branch: '+'\n",
        {"x": [0.09179374, 1.18480844]},
        [1.9382310, 1.6412861],
    ),
    "a direction of small numbers": (
        "fixed24",
        "inputs: {x: [-0.5, 0.5], y: [-0.5, 0.5]}\nequations:\n  - a = atan2(x**2*y, 0)\n"
        "  - solve: (y - x)*cos(w) + a**2*sin(w) = x\n    for: w\n    branch: '+'\n",
        {"x": [0.13696169, -0.45902648], "y": [0.11538511, 0.49720994]},
        [3.0948022, 2.9462139],
    ),
    "a root of a tangent": (
        "fixed24",
        "inputs: {x: [-1, 1]}\nequations:\n"
        "  - solve: (min(abs(x), 0.5) - x)*cos(q) + x*sin(q) = x\n    for: q\n    branch: sin(q) < 0\n"
        "  - w = sqrt(tanh(q))\noutputs: [q, w]\n",
        {"x": [-0.46042657, -0.99]},
        [None, None],
    ),
    "a difference of squares": (
        "kinematic",
        "inputs: {x: [-0.5, 0.5]}\nequations:\n"
        "  - solve: x*cos(q) + x*sin(q) = atanh(x)\n    for: q\n    branch: '-'\n"
        "  - w = sqrt(q**2 - x**2)\noutputs: [w]\n",
        {"x": [0.13696169, 0.31327024, -0.23021329]},
        [None, None, 4.7252050],
    ),
}
"""Equations near whose borders rounding may turn some angle by anything, and values; None: without one."""


@pytest.mark.parametrize("name", quick(UNKNOWN, "half a turn", "a difference of squares"))
def test_errors_as_large_as_anything_say_nothing_of_a_border(name: str, tmp_path: Path) -> None:
    target, text, samples, values = UNKNOWN[name]
    plan = planned(written(tmp_path, text), target=target, effort=0.1)
    found = run(plan, **samples)
    assert found["valid"].tolist() == [value is not None for value in values]
    for value, made in zip(values, found["w"], strict=True):
        assert value is None or abs(made - value) < 1e-5


def test_the_error_of_a_positive_factor_widens_no_border(tmp_path: Path) -> None:
    text = "inputs: {x: [-2, 3]}\nequations: ['w = sqrt(cosh(log(x**2))*x)']\n"
    plan = planned(written(tmp_path, text), target="fixed24", effort=0.1)
    assert all(slack.beyond < 1e-5 for slack in slacks(plan))
