"""plan.json: writing a plan, and reading one back with everything checked."""

from __future__ import annotations

import json
import math
import re
from functools import cache
from importlib.resources import files
from typing import Any

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.plan.model import (
    FORMAT,
    VERSION,
    ControlWord,
    Fifo,
    Formats,
    Operand,
    Operation,
    Plan,
    Selection,
    Unit,
)

MAX_BYTES = 64 << 20
MAX_DEPTH = 64
MAX_ROWS = 100_000
MAX_DIGITS = 18
"""Digits of an integer; whatever a plan counts is far below."""

_PARTS = ("units", "operations", "fifos")
"""What `--json` leaves out of the summary."""


def as_dict(plan: Plan) -> dict[str, Any]:
    """Return the plan as plain data, in the form of the published schema."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": plan.name,
        "description": plan.description,
        "target": plan.target["name"],
        "target_data": plan.target,
        "clock_hz": plan.target["clock_hz"],
        "options": plan.options,
        "problem": plan.problem,
        "initiation_interval": plan.initiation_interval,
        "latency": {
            "cycles": plan.latency_cycles,
            "seconds": plan.latency_seconds,
            "cau_cycles": plan.cau_cycles,
        },
        "processors": plan.processors(),
        "units": [_unit(u) for u in plan.units],
        "operations": [_operation(o) for o in plan.operations],
        "fifos": [
            {
                "id": f.id,
                "value": f.value,
                "from": f.source,
                "to": list(f.sinks),
                "depth": f.depth,
                "width": f.width,
            }
            for f in plan.fifos
        ],
        "fifo_words": plan.fifo_words,
        "outputs": {name: _operand(operand) for name, operand in plan.outputs.items()},
        "optimal": plan.optimal,
        "bounds": plan.bounds,
        "selection": {
            "searched": plan.selection.searched,
            "proven": plan.selection.proven,
            "facts": list(plan.selection.facts),
        },
        "formats": {"values": plan.formats.values, "outputs": plan.formats.outputs},
        "accuracy": plan.accuracy,
    }


def _unit(unit: Unit) -> dict[str, Any]:
    data: dict[str, Any] = {"id": unit.id, "kind": unit.kind, "latency": unit.latency}
    if unit.control:
        data["inputs"] = [list(sources) for sources in unit.inputs]
        data["control"] = [
            {"slot": word.slot, "operation": word.operation, "select": list(word.select)}
            for word in unit.control
        ]
    return data


def _operand(operand: Operand) -> dict[str, str]:
    if operand.constant is not None:
        return {"constant": operand.constant}
    assert operand.value is not None
    return {"value": operand.value}


def _operation(operation: Operation) -> dict[str, Any]:
    return {
        "id": operation.id,
        "op": operation.op,
        "params": operation.params,
        "kind": operation.kind,
        "mode": operation.mode,
        "unit": operation.unit,
        "start": operation.start,
        "finish": operation.finish,
        "ports": list(operation.ports),
        "operands": [_operand(o) for o in operation.operands],
        "results": list(operation.results),
        "equation": operation.equation,
        "derivation": list(operation.derivation),
    }


def dump(plan: Plan) -> str:
    """Return the text of plan.json: sorted keys, two spaces, a final newline."""
    return json.dumps(as_dict(plan), indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False) + "\n"


def summary(plan: Plan) -> str:
    """Return plan.json without units, operations and fifos, as `--json` prints it."""
    data = {key: value for key, value in as_dict(plan).items() if key not in _PARTS}
    return json.dumps(data, indent=2, sort_keys=True, allow_nan=False, ensure_ascii=False) + "\n"


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
    plan = _plan(data)
    _check_derived(data, plan, source)
    return plan


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
        "target": plan.target["name"],
        "clock_hz": plan.target["clock_hz"],
        "processors": plan.processors(),
        "fifo_words": plan.fifo_words,
    }
    for key, value in again.items():
        found = data[key]
        if isinstance(value, dict):
            found = {each: found[each] for each in value}
        if found != value:
            message = f"the plan contradicts itself: {key} is {found}, its parts say {value}"
            raise InvalidInput(
                [Diagnostic("E603", message, None, "compile the problem again", source=source)]
            )


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:200]


def _plan(data: dict[str, Any]) -> Plan:
    def operand(item: dict[str, str]) -> Operand:
        return Operand(item.get("value"), item.get("constant"))

    def unit(item: dict[str, Any]) -> Unit:
        words = (
            ControlWord(int(w["slot"]), w["operation"], tuple(int(s) for s in w["select"]))
            for w in item.get("control", ())
        )
        inputs = tuple(tuple(sources) for sources in item.get("inputs", ()))
        return Unit(item["id"], item["kind"], int(item["latency"]), inputs, tuple(words))

    # JSON keys are sorted; the problem knows the order in which outputs are delivered.
    order = [output["name"] for output in data["problem"]["outputs"]]

    def delivered(items: dict[str, Any]) -> dict[str, Any]:
        return {name: items[name] for name in dict.fromkeys([*order, *items]) if name in items}

    formats = data.get("formats", {"values": {}, "outputs": {}})
    selection = data.get("selection", {"searched": False, "proven": False})
    return Plan(
        name=data["name"],
        description=data["description"],
        target=data["target_data"],
        problem=data["problem"],
        options=data["options"],
        initiation_interval=int(data["initiation_interval"]),
        latency_cycles=int(data["latency"]["cycles"]),
        cau_cycles=int(data["latency"]["cau_cycles"]),
        units=tuple(unit(u) for u in data["units"]),
        operations=tuple(
            Operation(
                id=o["id"],
                op=o["op"],
                params=o["params"],
                kind=o["kind"],
                mode=o["mode"],
                unit=o["unit"],
                start=int(o["start"]),
                finish=int(o["finish"]),
                ports=tuple(o["ports"]),
                operands=tuple(operand(item) for item in o["operands"]),
                results=tuple(o["results"]),
                equation=o["equation"],
                derivation=tuple(o.get("derivation", ())),
            )
            for o in data["operations"]
        ),
        fifos=tuple(
            Fifo(f["id"], f["value"], f["from"], tuple(f["to"]), int(f["depth"]), int(f["width"]))
            for f in data["fifos"]
        ),
        outputs={name: operand(item) for name, item in delivered(data["outputs"]).items()},
        optimal=data["optimal"],
        bounds={name: int(data["bounds"][name]) for name in ("processors", "latency", "fifo_words")},
        formats=Formats(formats["values"], delivered(formats["outputs"])),
        accuracy=delivered(data["accuracy"]),
        selection=Selection(selection["searched"], selection["proven"], tuple(selection.get("facts", ()))),
    )
