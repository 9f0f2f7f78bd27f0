"""The slack of an operation in plan.json: read back as it was, and refused where the operation has none."""

import json
from dataclasses import replace

import pytest

from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.base.diagnostics import InvalidInput
from cordicc.plan.consistency import check_operations
from cordicc.plan.file import dump, parse
from cordicc.plan.model import EndError, Plan
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled


@pytest.fixture
def plan() -> Plan:
    return compiled(EXAMPLES / "planar_2r.yaml")


def with_slack(plan: Plan, op: str, slack: Slack, end: EndError | None = None) -> Plan:
    operations = (replace(o, slack=slack, end_error=end) if o.op == op else o for o in plan.operations)
    return replace(plan, operations=tuple(operations))


def test_read_back(plan: Plan) -> None:
    slack, end = Slack(1.5e-7, 2e-8, relative=True), EndError(1e-7, None)
    changed = with_slack(plan, "implicit", slack, end)
    text = dump(changed)
    again = parse(text, "plan.json")
    assert [o.slack for o in again.operations] == [o.slack for o in changed.operations]
    assert [o.end_error for o in again.operations if o.op == "implicit"] == [end, end]
    assert dump(again) == text
    kept = [("slack" in o, "end_error" in o) for o in json.loads(text)["operations"]]
    assert kept == [(o.op == "implicit",) * 2 for o in changed.operations]


def test_a_plan_without_slack_is_read(plan: Plan) -> None:
    data = json.loads(dump(with_slack(plan, "implicit", EXACT)))
    assert not any("slack" in operation for operation in data["operations"])
    assert all(o.slack == EXACT for o in parse(json.dumps(data), "plan.json").operations)


@pytest.mark.parametrize(("op", "slack"), [("add", Slack(0.1)), ("mul", Slack(0.1, 0.1))])
def test_operations_without_a_border_have_none(plan: Plan, op: str, slack: Slack) -> None:
    with pytest.raises(ValueError, match=f"'{op}' has no such slack"):
        check_operations(with_slack(plan, op, slack))


@pytest.mark.parametrize(
    "slack",
    [
        {"beyond": 1e-7},
        {"beyond": 1e-7, "within": 2e-7, "relative": False},
        {"beyond": -1e-7, "within": 0, "relative": False},
        {"beyond": 1e-290, "within": 0, "relative": False},
        {"beyond": "1e-7", "within": 0, "relative": False},
    ],
)
def test_what_is_no_slack_is_refused(plan: Plan, slack: dict[str, object]) -> None:
    data = json.loads(dump(plan))
    next(o for o in data["operations"] if o["op"] == "implicit")["slack"] = slack
    with pytest.raises(InvalidInput):
        parse(json.dumps(data), "plan.json")
