"""The fuzzer for some seconds, and what it found before; `benchmarks/fuzz.py` runs it for longer."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings

from tests.support.fuzzing import TARGETS, compiled, loaded, plan_texts
from tests.support.selection import examples

CASES = {"problem text": 80, "compile": 8, "plan reader": 120}
"""Examples of a run of everything; about six seconds each."""


@pytest.mark.parametrize("name", TARGETS)
def test_ends_well(name: str) -> None:
    target = TARGETS[name]

    # A find is shown as it is: making a problem smaller takes minutes of compiling.
    @settings(
        max_examples=examples(CASES[name]),
        deadline=None,
        suppress_health_check=list(HealthCheck),
        database=None,
        phases=[Phase.generate],
    )
    @given(target.strategy)
    def one(text: str) -> None:
        assert target.run(text)

    one()


def unit(data: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = data["target_data"]["units"]["add"]
    return found


def observed(data: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = next(iter(data["accuracy"].values()))["observed"]
    return found


FINDS: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "a unit of the target that is no object": (lambda d: d["target_data"]["units"].update(add=True), "E602"),
    "stages that are no object": (lambda d: unit(d).update(stages="add"), "E602"),
    "a file name that is a number": (lambda d: d["options"].update(file=-1), "E602"),
    "an error beyond 2^1023": (lambda d: observed(d)["histogram"][-1].__setitem__(0, 1e308), "ok"),
    "a histogram without a largest error": (lambda d: observed(d).update(max=None), "E603"),
}


@pytest.mark.parametrize("find", FINDS)
def test_finds(find: str) -> None:
    change, end = FINDS[find]
    data = json.loads(plan_texts()[0])
    change(data)
    assert loaded(json.dumps(data)) == end


@pytest.mark.exhaustive(reason="compiles one find; quick ones compile problems of the same kind")
def test_a_pair_whose_error_bounds_are_nan() -> None:
    """NumPy warned of bounds that are nan on every sample."""
    text = (
        "inputs: {x: [0.5, 1], y: [0, 0], S: [0, 0]}\nequations:\n"
        "  - solve: [-x**1.5*cos(w0) + abs(x)*sin(w0) = (-S)**2, -y**2*cos(w0) - y*sin(w0) = S]\n"
        "    for: w0\n"
    )
    assert compiled(text) == "ok"


@pytest.mark.exhaustive(reason="compiles one find; rows of pictures have quick tests in tests/backends")
def test_a_row_of_the_picture_from_which_all_boxes_move_on() -> None:
    text = (
        "constants: {a: 0.3}\ninputs:\n  x: {range: [0.1, pi/2], unit: rad}\n  y: [-1, 1]\nequations:\n"
        "  - solve: -x*cos(w0) + (y + y)**1.5*sin(w0) = (y**-2 + deg)\n    for: w0\n    branch: '+'\n"
        "  - solve: [atanh(x)*cos(w1) + w0**2*sin(w1) = --y, cos(x)*cos(w1) + -2*sin(w1) = (x + deg)]\n"
        "    for: w1\n"
    )
    assert compiled(text) == "ok"
