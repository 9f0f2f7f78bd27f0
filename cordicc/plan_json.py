"""plan.json: writing a plan, and reading one back with everything checked."""

from __future__ import annotations

import json
import math
from functools import cache
from importlib.resources import files
from typing import Any

from cordicc.diagnostics import Diagnostic, InvalidInput, Source
from cordicc.plan import FORMAT, VERSION, Fifo, Operand, Operation, Plan, Unit

MAX_BYTES = 64 << 20

_PARTS = ("units", "operations", "fifos")
"""What `--json` leaves out of the summary."""

_BULK = ("problem", "target_data", "outputs")


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
        "units": [{"id": u.id, "kind": u.kind, "latency": u.latency} for u in plan.units],
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
        "accuracy": plan.accuracy,
    }


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
        InvalidInput: not JSON, not a plan, or not a version this program reads.
    """
    source = Source(name, "")

    def refuse(message: str, hint: str | None = None) -> InvalidInput:
        return InvalidInput([Diagnostic("E602", message, None, hint, source=source)])

    if len(text) > MAX_BYTES:
        raise refuse(f"the plan is larger than {MAX_BYTES >> 20} MiB")
    try:
        data = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise refuse(f"not a plan: {_first_line(error)}") from None
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise refuse(
            "not a plan: the key 'format' is missing or different", "plans are written by 'cordicc compile'"
        )
    if data.get("version") != VERSION:
        raise refuse(f"plan version {data.get('version')!r} is not supported", "compile the problem again")
    import jsonschema

    validator = jsonschema.Draft202012Validator(schema())
    errors = sorted(validator.iter_errors(data), key=lambda e: [str(part) for part in e.absolute_path])
    if errors:
        place = "/".join(str(part) for part in errors[0].absolute_path) or "the top level"
        raise refuse(f"not a valid plan: at {place}: {errors[0].message[:200]}")
    return _plan(data)


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is not a number of JSON")


def _first_line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0][:200]


def _plan(data: dict[str, Any]) -> Plan:
    def operand(item: dict[str, str]) -> Operand:
        return Operand(item.get("value"), item.get("constant"))

    assert math.isfinite(data["clock_hz"])
    return Plan(
        name=data["name"],
        description=data["description"],
        target=data["target_data"],
        problem=data["problem"],
        options=data["options"],
        initiation_interval=data["initiation_interval"],
        latency_cycles=data["latency"]["cycles"],
        cau_cycles=data["latency"]["cau_cycles"],
        units=tuple(Unit(u["id"], u["kind"], u["latency"]) for u in data["units"]),
        operations=tuple(
            Operation(
                id=o["id"],
                op=o["op"],
                params=o["params"],
                kind=o["kind"],
                mode=o["mode"],
                unit=o["unit"],
                start=o["start"],
                finish=o["finish"],
                ports=tuple(o["ports"]),
                operands=tuple(operand(item) for item in o["operands"]),
                results=tuple(o["results"]),
                equation=o["equation"],
            )
            for o in data["operations"]
        ),
        fifos=tuple(
            Fifo(f["id"], f["value"], f["from"], tuple(f["to"]), f["depth"], f["width"])
            for f in data["fifos"]
        ),
        outputs={name: operand(item) for name, item in data["outputs"].items()},
        optimal=data["optimal"],
        bounds=data["bounds"],
        accuracy=data["accuracy"],
    )
