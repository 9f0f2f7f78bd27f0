"""Every command on plans that lack what the schema of plan.json does not require."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cordicc.api import load_plan
from cordicc.artefacts import ARTEFACTS, VIEWS
from cordicc.backends.text.plan_differences import as_json, as_sheet, differences
from cordicc.base.diagnostics import InvalidInput
from cordicc.plan.file import parse, schema
from cordicc.plan.model import Plan
from cordicc.readback import check_plan
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled

Way = tuple[str, ...]
"""From the top of a plan: names of properties, and `*` for every item."""


def optional(part: dict[str, Any]) -> Iterator[Way]:
    """Yield the way to each property below a part of the schema that is not required."""
    for name, below in part.get("properties", {}).items():
        if name not in part.get("required", ()):
            yield (name,)
        yield from ((name, *way) for way in optional(below))
    for every in ("items", "additionalProperties"):
        if isinstance(part.get(every), dict):
            yield from (("*", *way) for way in optional(part[every]))
    for each in (*part.get("oneOf", ()), *part.get("anyOf", ())):
        yield from (way for way in optional(each) if len(way) > 1)  # of one level, either is required


def without(data: Any, way: Way) -> bool:
    """Remove what is at the end of a way, everywhere; tell whether there was any."""
    first, *rest = way
    if first == "*" or rest:
        items = list(data.values() if isinstance(data, dict) else data if isinstance(data, list) else ())
        below = items if first == "*" else [data[first]] if isinstance(data, dict) and first in data else []
        return sum(without(each, tuple(rest)) for each in below) > 0
    return isinstance(data, dict) and data.pop(first, None) is not None


WAYS = tuple(dict.fromkeys(optional(schema())))


def test_the_schema_leaves_something_open() -> None:
    assert {("target_data", "units", "*", "area"), ("formats",), ("problem", "unit_program")} <= set(WAYS)


def lesser(whole: dict[str, Any], *ways: Way) -> dict[str, Any]:
    less = copy.deepcopy(whole)
    for way in ways:
        without(less, way)
    return less


def read(data: dict[str, Any]) -> Plan | None:
    """Return the plan of plain data, None if what it lacks makes it contradict itself."""
    try:
        return check_plan(parse(json.dumps(data), "plan.json"))
    except InvalidInput:
        return None


def test_commands_take_what_the_reader_takes(tmp_path: Path) -> None:
    whole = json.loads(compiled(EXAMPLES / "wheel_beta.yaml", target="imscor24").to_json())
    full = read(whole)
    assert full is not None
    open_ways = []
    for way in WAYS:
        if (less := lesser(whole, way)) != whole and (plan := read(less)) is not None:
            open_ways.append(way)
            for one, other in ((full, plan), (plan, full)):
                found = differences(one, other)
                assert as_json(found)
                assert as_sheet(one, other, found, ("one", "other"))
    assert len(open_ways) > 8
    names = ("least", "full")
    for name, data in zip(names, (lesser(whole, *open_ways), whole), strict=True):
        (tmp_path / f"{name}.json").write_text(json.dumps(data), encoding="utf-8")
    plan, other = (tmp_path / f"{name}.json" for name in names)
    for arguments in (
        *(("draw", plan, "--view", view, "-o", tmp_path / "d.svg") for view in VIEWS),
        ("explain", plan),
        ("simulate", plan, "--random", "5", "--json", "--vcd", tmp_path / "w.vcd"),
    ):
        done = run(*arguments)
        assert done.exit_code == 0, done.output
    assert run("diff", plan, other).exit_code == run("diff", other, plan).exit_code == 1
    for name, artefact in ARTEFACTS.items():
        assert artefact.samples or load_plan(plan).emit(name)


def test_artefacts_with_samples_take_what_the_reader_takes(tmp_path: Path) -> None:
    plan = compiled(EXAMPLES / "wheel_beta.yaml", target="fixed24", certify=False, effort=0.1)
    whole = json.loads(plan.to_json())
    ways = [way for way in WAYS if (less := lesser(whole, way)) != whole and read(less) is not None]
    assert len(ways) > 8
    (tmp_path / "plan.json").write_text(json.dumps(lesser(whole, *ways)), encoding="utf-8")
    for name, artefact in ARTEFACTS.items():
        assert not artefact.samples or load_plan(tmp_path / "plan.json").emit(name, 10)
