"""Checks in plan.json: written, read back, of copies, missing in old plans, and contradicting one another."""

import json
from pathlib import Path
from typing import Any

import pytest

import cordicc
from cordicc.base.diagnostics import CordiccError, InvalidInput
from cordicc.plan.file import dump, parse
from cordicc.plan.model import Plan
from cordicc.readback import check_plan
from tests.support.plans import compiled

TEXT = """\
name: turned
inputs: {x: [0.1, 0.5], a: [-1, 1]}
equations:
  - solve: cos(q) = x
    for: q
    branch: "+"
  - s = x + a
outputs: [q, s]
checks: {e: {value: "s - x - sin(a)*q", unit: mm}}
"""


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> cordicc.Plan:
    path = tmp_path_factory.mktemp("checks") / "turned.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return compiled(path)


@pytest.fixture
def data(plan: cordicc.Plan) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads(plan.to_json())
    return loaded


def load(data: dict[str, Any]) -> Plan:
    return check_plan(parse(json.dumps(data), "plan.json"))


def test_they_read_back(plan: cordicc.Plan, data: dict[str, Any]) -> None:
    again = load(data)
    assert again.problem.checks == plan.problem.checks
    assert again.checks == plan.checks
    assert list(again.checks) == ["e", "solve.q"]
    assert dump(again) == plan.to_json()
    assert (data["checks"]["e"]["unit"], data["checks"]["e"]["max"]) == ("mm", None)
    assert [check["asked"] for check in data["problem"]["checks"]] == [True, False]


def test_an_old_plan_has_none(data: dict[str, Any]) -> None:
    del data["checks"], data["problem"]["checks"], data["problem"]["check_program"]
    del data["selection"]["turned_down"]
    old = load(data)
    assert old.checks == {}
    assert old.problem.checks == ()
    assert json.loads(dump(old))["problem"]["check_program"] == ""


def test_copies_have_their_own(plan: cordicc.Plan, tmp_path: Path) -> None:
    path = tmp_path / "turned.yaml"
    path.write_text(TEXT, encoding="utf-8")
    two = compiled(path, copies=2)
    assert list(two.checks) == ["e_1", "solve.q_1", "e_2", "solve.q_2"]
    assert two.checks["solve.q_1"].observed.max == plan.checks["solve.q"].observed.max
    assert set(two.checks["e_2"].worst_input or ()) == {"x_1", "a_1", "x_2", "a_2"}


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        ("checks/e/max", 1.0, "limit or unit"),
        ("checks/e/unit", "m", "limit or unit"),
        ("checks/e/worst_input", None, "lacks the largest value"),
        ("checks/e/worst_input", {"x": 0.2}, "has other inputs"),
        ("checks/e/observed/rms", None, "lacks the largest value"),
        ("checks/other", None, "not a valid plan"),
        ("problem/checks/1/name", "e", "limit or unit"),
        ("problem/checks/1/name", "f", "differ"),
        ("problem/check_program", "", "differ"),
        ("problem/check_program", "%0 = input[name=y]\noutput e = %0\noutput solve.q = %0\n", "more than"),
        ("problem/check_program", "%0 = input[name=x]\noutput e = %7\noutput solve.q = %0\n", "%7"),
        (
            "problem/check_program",
            "%0 = input[name=x]\n%1:2 = lightcone(%0, %0)\noutput e = %1#1\noutput solve.q = %0\n",
            "operations of units",
        ),
    ],
)
def test_what_does_not_fit_is_refused(data: dict[str, Any], path: str, value: Any, said: str) -> None:
    place: Any = data
    *before, last = (int(part) if part.isdigit() else part for part in path.split("/"))
    for part in before:
        place = place[part]
    place[last] = value
    with pytest.raises(InvalidInput, match=said):
        load(data)


def test_a_value_beyond_the_limit_is_refused(data: dict[str, Any]) -> None:
    data["checks"]["e"]["max"] = data["problem"]["checks"][0]["max"] = 1e-12
    with pytest.raises(CordiccError, match="'e' is beyond its limit"):
        load(data)
