"""The PUMA 560 of the examples: its hand is where it should be, with a straight wrist too."""

from typing import Any

import numpy as np
import pytest

import cordicc
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled

D1, A2, A3, D3, D4 = 0.67183, 0.4318, 0.0203, 0.15005, 0.4318
LINKS = (  # twist, length, offset
    (np.pi / 2, 0, D1),
    (0, A2, 0),
    (-np.pi / 2, A3, D3),
    (np.pi / 2, 0, D4),
    (-np.pi / 2, 0, 0),
    (0, 0, 0),
)
STRETCHED, FOLDED = np.arctan2(-D4, A3), np.arctan2(D4, -A3)
LIMITS = ((-3, 3), (-1.5, 2.5), (STRETCHED + 1e-3, FOLDED - 1e-2), (-3, 3), (0, 3), (-3, 3))


def hand(angles: np.ndarray) -> np.ndarray:
    """Return the frames, of shape (n, 4, 4), that joint angles of shape (6, n) turn the hand into."""
    frame = np.broadcast_to(np.eye(4), (angles.shape[1], 4, 4))
    for angle, (twist, length, offset) in zip(angles, LINKS, strict=True):
        c, s, ct, st = np.cos(angle), np.sin(angle), np.cos(twist), np.sin(twist)
        zero, one = np.zeros_like(c), np.ones_like(c)
        rows = [
            [c, -s * ct, s * st, length * c],
            [s, c * ct, -c * st, length * s],
            [zero, st * one, ct * one, offset * one],
            [zero, zero, zero, one],
        ]
        frame = frame @ np.moveaxis(np.array(rows), -1, 0)
    return frame


def poses(q5: float | None, count: int = 1_000) -> dict[str, np.ndarray]:
    """Return poses that the arm reaches in front of it, all over its range; with one q5 if it is given."""
    source = np.random.default_rng(5)
    angles = np.array([source.uniform(low, high, count) for low, high in LIMITS])
    if q5 is not None:
        angles[4] = q5
    frames = hand(angles)
    names = [(f"r{i + 1}{j + 1}", frames[:, i, j]) for i in range(3) for j in range(3)]
    place = {name: frames[:, i, 3] for i, name in enumerate(["px", "py", "pz"])}
    return {name: np.clip(column, -1, 1) for name, column in names} | place


def plan_of(how: str) -> cordicc.Plan:
    # Without options as other tests ask for them, so that each is compiled once.
    options: dict[str, dict[str, Any]] = {
        "kinematic": {},
        "fixed24": {"target": "fixed24", "certify": False},
    }
    return compiled(EXAMPLES / "puma560.yaml", **options[how])


@pytest.mark.exhaustive(
    reason="the whole search takes half a minute; smaller arms reach their points quickly"
)
@pytest.mark.parametrize("how", ["kinematic", "fixed24"])
@pytest.mark.parametrize("q5", [0.0, 1e-7, 1e-5, 1e-3, None])
def test_the_hand_arrives(how: str, q5: float | None) -> None:
    plan, inputs = plan_of(how), poses(q5)
    outputs = plan.simulate(inputs)
    valid = outputs["valid"]
    frames = hand(np.array([outputs[f"q{joint}"] for joint in range(1, 7)]))[valid]
    place = np.stack([inputs[n] for n in ("px", "py", "pz")], axis=-1)[valid]
    turn = np.stack([np.stack([inputs[f"r{i}{j}"] for j in (1, 2, 3)], axis=-1) for i in (1, 2, 3)], axis=-2)
    inside = (np.abs(place) < [0.9, 0.9, 2]).all(axis=1)
    assert inside.sum() == valid.sum() > 600
    assert np.max(np.abs(frames[:, :3, 3] - place)) < 2e-6
    assert np.max(np.abs(frames[:, :3, :3] - turn[valid])) < 1e-5
    found = plan.check_values(inputs, outputs)
    assert found["pz"][valid] == pytest.approx(frames[:, 2, 3] - place[:, 2], abs=1e-14)
    assert found["r12"][valid] == pytest.approx(frames[:, 0, 1] - turn[valid][:, 0, 1], abs=1e-14)


@pytest.mark.exhaustive(reason="runs the same plan; tests/ir draws such samples of smaller problems quickly")
@pytest.mark.parametrize("how", ["kinematic", "fixed24"])
def test_its_samples_go_to_where_errors_are_amplified(how: str) -> None:
    plan = plan_of(how)
    columns = plan.problem.samples
    assert columns is not None
    q5, q3 = (plan.simulate(columns)[name] for name in ("q5", "q3"))
    assert (np.abs(q5) < 1e-6).sum() >= 8
    assert np.nanmin(np.abs(q3 - STRETCHED)) < 2e-3
    assert {name: check.max for name, check in plan_checks(plan).items()} == dict.fromkeys(
        ("px", "py", "pz"), 2e-6
    ) | {f"r{i}{j}": 1e-5 for i in (1, 2, 3) for j in (1, 2, 3)}


def plan_checks(plan: cordicc.Plan):
    return {check.name: check for check in plan.problem.checks if check.asked}


@pytest.mark.exhaustive(reason="the whole search takes half a minute; quick ones count units of smaller arms")
def test_it_takes_few_units() -> None:
    assert compiled(EXAMPLES / "puma560.yaml").processors()["total"] <= 7
