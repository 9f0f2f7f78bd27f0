"""plan.json: writing a plan, and reading one back with everything checked."""

from __future__ import annotations

import json
import math
import re
from functools import cache
from importlib.resources import files
from typing import Any

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.plan.cordic_data import cordic_data, difference
from cordicc.plan.model import Plan
from cordicc.plan.plain_data import FORMAT, VERSION, as_dict
from cordicc.plan.plan_from_data import plan_of

MAX_BYTES = 64 << 20
MAX_DEPTH = 64
MAX_ROWS = 100_000
MAX_DIGITS = 18
"""Digits of an integer; whatever a plan counts is far below."""

BROKEN = (ArithmeticError, AssertionError, AttributeError, LookupError, TypeError, ValueError)
"""What parts of a plan that do not fit together raise where they meet."""

_INTEGERS = re.compile(r"\[\n\s*-?\d+(?:,\n\s*-?\d+)*\n\s*\]")

_PARTS = ("units", "operations", "fifos", "cordic")
"""What `--json` leaves out of the summary."""


def dump(plan: Plan) -> str:
    """Return the text of plan.json: sorted keys, two spaces, lists of integers on one line."""
    return _text(as_dict(plan))


def summary(plan: Plan) -> str:
    """Return plan.json without units, operations and fifos, as `--json` prints it."""
    data = {key: value for key, value in as_dict(plan).items() if key not in _PARTS}
    return _text(data)


def _text(data: dict[str, Any]) -> str:
    text = json.dumps(data, indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False)
    # No text of JSON has a line break in it, so this is about lists alone.
    return _INTEGERS.sub(lambda found: "[" + " ".join(found[0][1:-1].split()) + "]", text) + "\n"


@cache
def schema() -> dict[str, Any]:
    """Return the published JSON Schema of plan.json."""
    text = files("cordicc").joinpath("schema/plan.schema.json").read_text(encoding="utf-8")
    loaded: dict[str, Any] = json.loads(text)
    return loaded


def parse(text: str, name: str) -> Plan:
    """Return the plan of a text, checked against the schema.

    Args:
        text: the content of plan.json.
        name: how the user knows the file.

    Raises:
        InvalidInput: not JSON, not a plan, or not a version this program reads (E602); figures that
            contradict one another (E603).
    """
    source = Source(name, "")

    def refuse(message: str, hint: str | None = None) -> InvalidInput:
        return InvalidInput([Diagnostic("E602", message, None, hint, source=source)])

    if len(text) > MAX_BYTES:
        raise refuse(f"the plan is larger than {MAX_BYTES >> 20} MiB")
    try:
        data = json.loads(text, parse_constant=_no_constant, parse_int=_integer, parse_float=_finite)
        _check_texts(data)
    except (ValueError, RecursionError) as error:
        raise refuse(f"not a plan: {_first_line(error)}", _hint(text)) from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise refuse(
            "not a plan: the key 'format' is missing or different", "plans are written by 'cordicc compile'"
        )
    if data.get("version") != VERSION:
        version = repr(data.get("version"))[:40]
        raise refuse(f"plan version {version} is not supported", "compile the problem again")
    import jsonschema

    validator = jsonschema.Draft202012Validator(schema())
    # The first finding only: limits come before what they limit, so a huge plan ends the search early.
    finding = next(validator.iter_errors(_outline(data)), None)
    if finding is not None:
        place = "/".join(str(part) for part in finding.absolute_path)[:200] or "the top level"
        raise refuse(f"not a valid plan: at {place}: {finding.message[:200]}")
    try:
        plan = plan_of(data, name)
    except BROKEN as error:
        raise contradiction(_first_line(error), source) from None
    _check_derived(data, plan, source)
    _check_cordic(data, plan, source)
    return plan


def contradiction(reason: str, source: Source | None = None) -> InvalidInput:
    """Return the refusal of a plan whose parts do not fit together."""
    message = f"the plan contradicts itself: {reason}"
    return InvalidInput([Diagnostic("E603", message, None, "compile the problem again", source=source)])


def _hint(text: str) -> str | None:
    if re.search(r"^(equations|inputs|constants|name)\s*:", text, re.MULTILINE):
        return "this looks like a problem file: compile it first"
    return None


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is not a number of JSON")


def _integer(text: str) -> int:
    if len(text) > MAX_DIGITS:
        raise ValueError(f"the integer {text[:MAX_DIGITS]}... is too large")
    return int(text)


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"the number {text[:MAX_DIGITS]} is too large")
    return number


def _check_texts(data: Any) -> None:
    """Raise ValueError for text that UTF-8 cannot hold, and for deep nesting."""
    level: list[Any] = [data]
    for _ in range(MAX_DEPTH):
        below: list[Any] = []
        for item in level:
            if isinstance(item, str):
                item.encode()
            elif isinstance(item, dict):
                below.extend(item)
                below.extend(item.values())
            elif isinstance(item, list):
                below.extend(item)
        level = below
    if level:
        raise ValueError("it is nested too deeply")


def _outline(data: dict[str, Any]) -> dict[str, Any]:
    """Return the data with one number for each column of samples that is nothing but numbers.

    A schema is slow on long lists.
    """
    try:
        columns = data["problem"]["samples"]["columns"]
        short = {
            name: column[:1]
            if type(column) is list and len(column) <= MAX_ROWS and {*map(type, column)} <= {int, float}
            else column
            for name, column in columns.items()
        }
    except (KeyError, TypeError, AttributeError):
        return data
    samples = {**data["problem"]["samples"], "columns": short}
    return {**data, "problem": {**data["problem"], "samples": samples}}


def _check_derived(data: dict[str, Any], plan: Plan, source: Source) -> None:
    """Refuse figures of the file that the plan's own parts contradict."""
    again = {
        "name": plan.name,
        "description": plan.description,
        "target": plan.target.name,
        "clock_hz": plan.clock_hz,
        "processors": plan.processors(),
        "fifo_words": plan.fifo_words,
    }
    for key, value in again.items():
        found = data[key]
        if isinstance(value, dict):
            found = {each: found[each] for each in value}
        if found != value:
            raise contradiction(f"{key} is {_short(found)}, its parts say {_short(value)}", source)
    for check in plan.problem.checks:
        found = data.get("checks", {}).get(check.name, {"max": check.max, "unit": check.unit})
        if (found["max"], found["unit"]) != (check.max, check.unit):
            raise contradiction(
                f"the limit or unit of check '{check.name}' is not that of the problem", source
            )


def _check_cordic(data: dict[str, Any], plan: Plan, source: Source) -> None:
    """Refuse constants of units that are not those of the target; plans of before have none."""
    if "cordic" not in data:
        return
    try:
        own = cordic_data(plan)
    except BROKEN as error:
        raise contradiction(_first_line(error), source) from None
    found = difference(data["cordic"], own, "cordic")
    if found is not None:
        place, stated, wanted = found
        raise contradiction(f"{place} is {_short(stated)}, its target says {_short(wanted)}", source)


def _short(value: object) -> str:
    """Return a value in one short line."""
    return " ".join(str(value).split())[:80]


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:200]
