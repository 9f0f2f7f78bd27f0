"""The integers of CORDIC units in plan.json: those that the units work with, checked where a plan is read."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cordicc.arith.unit.cau import implicit_table, standard_table
from cordicc.base.diagnostics import InvalidInput
from cordicc.plan.file import dump, parse
from cordicc.plan.model import Plan
from tests.support.plans import planned

PROBLEM = """
name: small
inputs: {x: [0.25, 0.5], a: [-1, 1], u: [0.1, 2]}
equations:
  - z = x*cos(a) + sqrt(u)
  - b = acos(x/u/5)
  - q = x/u
outputs: [z, b, q]
"""


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    path = tmp_path_factory.mktemp("small") / "small.yaml"
    path.write_text(PROBLEM, encoding="utf-8")
    return planned(path, target="fixed24")


@pytest.fixture
def data(plan: Plan) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(dump(plan))
    return found


def refusal(data: dict[str, Any]) -> str:
    with pytest.raises(InvalidInput) as caught:
        parse(json.dumps(data), "plan.json")
    return str(caught.value)


def test_integers_are_those_of_the_units(plan: Plan, data: dict[str, Any]) -> None:
    units = data["cordic"]["units"]
    standard = plan.arithmetic.caus["standard"]
    assert set(units) == {"standard", "implicit"}
    assert units["standard"]["fraction_bits"] == standard.fraction_bits
    assert set(units["standard"]["steps"]) == {"circular", "linear", "hyperbolic"}
    for name, m in (("circular", 1), ("linear", 0), ("hyperbolic", -1)):
        table = standard_table(standard, m)
        found = units["standard"]["steps"][name]
        assert (found["shifts"], found["angles"]) == (list(table.shifts), list(table.angles))
    (solved,) = (each for each in plan.operations if each.op == "implicit")
    reach = implicit_table(plan.arithmetic.caus["implicit"], 1, solved.slack).reach
    stated = data["cordic"]["operations"][solved.id]["reach"]
    assert stated.pop("first") == reach.rows.first
    assert "beyond" not in stated
    assert stated == {name: getattr(reach.columns, name).tolist() for name in stated}


def test_only_operations_of_units_are_named(plan: Plan, data: dict[str, Any]) -> None:
    made = {each.id for each in plan.operations if each.kind in ("standard", "implicit")}
    assert set(data["cordic"]["operations"]) == made


def test_lists_of_integers_take_one_line(plan: Plan) -> None:
    lines = dump(plan).splitlines()
    assert any(line.strip().startswith('"shifts": [0, 1, 2') for line in lines)
    assert not [line for line in lines if line.strip().rstrip(",").isdigit()]


def test_plans_on_floating_point_have_none(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text(PROBLEM, encoding="utf-8")
    single = planned(tmp_path / "small.yaml", target="kinematic")
    stated = json.loads(dump(single))
    assert "cordic" not in stated
    assert dump(parse(json.dumps(stated), "plan.json")) == dump(single)


def test_plans_of_before_are_read(plan: Plan, data: dict[str, Any]) -> None:
    del data["cordic"]
    assert dump(parse(json.dumps(data), "plan.json")) == dump(plan)


def numbers(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every number and text, of a list the first and the last."""
    if isinstance(data, dict):
        for key, item in data.items():
            yield from numbers(item, (*path, key))
    elif isinstance(data, list):
        for at in {0, len(data) - 1}:
            yield from numbers(data[at], (*path, at))
    else:
        yield path


def test_every_other_number_is_refused(data: dict[str, Any]) -> None:
    for *above, last in list(numbers(data["cordic"])):
        place = data["cordic"]
        for key in above:
            place = place[key]
        kept = place[last]
        place[last] = not kept if isinstance(kept, bool) else "1" if isinstance(kept, str) else kept + 1
        said = refusal(data)
        named = [str(key) for key in (*above, last) if isinstance(key, str)]
        # A number beyond what any unit has is no valid plan, any other one is not the target's.
        assert "E603" in said, said
        assert f"cordic.{'.'.join(named)} is" in said
        place[last] = kept


@pytest.mark.parametrize("missing", ["constants", "units", "operations"])
def test_parts_that_are_missing_are_refused(missing: str, data: dict[str, Any]) -> None:
    del data["cordic"][missing]
    assert "E602" in refusal(data)


def test_operations_that_are_missing_are_refused(data: dict[str, Any]) -> None:
    named = data["cordic"]["operations"]
    first = next(iter(named))
    del named[first]
    said = refusal(data)
    assert "E603" in said
    assert f"cordic.operations.{first} is missing" in said
