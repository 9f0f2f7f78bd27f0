"""A plan from the plain data of its file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.ir.facts import InputFacts
from cordicc.ir.text import parse_graph
from cordicc.plan.area import Area, PathEnd, SlowestPath, SynthesisResult
from cordicc.plan.model import ControlWord, EndError, Fifo, Formats, Operand, Operation, Plan, Selection, Unit
from cordicc.plan.origin import (
    PlanCheck,
    PlanEquation,
    PlanInput,
    PlanOptions,
    PlanOutput,
    PlanProblem,
    PlanTarget,
    PlanUnitKind,
)
from cordicc.plan.stated_accuracy import (
    AccuracyEnd,
    CheckFigures,
    OutputAccuracy,
    Predicate,
    SeenErrors,
    StatedBound,
)


def plan_of(data: dict[str, Any], name: str) -> Plan:
    """Return the plan of plain data that meets the schema.

    Args:
        data: the plain data.
        name: how the user knows the file.

    Raises:
        InvalidInput: a graph cannot be read (E601).
        ValueError: there is no such arithmetic.
    """
    problem = _read_problem(data["problem"], name)

    # JSON keys are sorted; the problem knows the order in which outputs are delivered.
    def delivered(items: dict[str, Any]) -> dict[str, Any]:
        return _ordered([output.name for output in problem.outputs], items)

    formats = data.get("formats", {"values": {}, "outputs": {}})
    selection = data.get("selection", {"searched": False, "proven": False})
    program = data["problem"].get("unit_program")
    return Plan(
        problem=problem,
        target=_read_target(data["target_data"]),
        options=_read_options(data["options"]),
        initiation_interval=int(data["initiation_interval"]),
        latency_cycles=int(data["latency"]["cycles"]),
        cau_cycles=int(data["latency"]["cau_cycles"]),
        units=tuple(_read_unit(item) for item in data["units"]),
        operations=tuple(_read_operation(item) for item in data["operations"]),
        fifos=tuple(
            Fifo(f["id"], f["value"], f["from"], tuple(f["to"]), int(f["depth"]), int(f["width"]))
            for f in data["fifos"]
        ),
        outputs={name: _read_operand(item) for name, item in delivered(data["outputs"]).items()},
        optimal=data["optimal"],
        bounds={name: int(data["bounds"][name]) for name in ("processors", "latency", "fifo_words")},
        formats=Formats(
            {name: _read_point(item) for name, item in formats["values"].items()},
            {name: _read_point(item) for name, item in delivered(formats["outputs"]).items()},
        ),
        accuracy={name: _read_accuracy(item) for name, item in delivered(data["accuracy"]).items()},
        selection=Selection(
            selection["searched"],
            selection["proven"],
            tuple(selection.get("facts", ())),
            tuple(selection.get("left_out", ())),
            tuple(selection.get("turned_down", ())),
        ),
        unit_program=None if program is None else parse_graph(program, name),
        checks={
            name: _read_check(item)
            for name, item in _ordered([c.name for c in problem.checks], data.get("checks", {})).items()
        },
        estimate=_read_estimate(data),
        synthesis=_read_synthesis(data),
    )


def _read_estimate(data: dict[str, Any]) -> Area | None:
    area = data["synthesis"]["estimate"] if "synthesis" in data else data.get("area")
    return None if area is None else _read_area(area)


def _read_area(data: dict[str, Any]) -> Area:
    return Area(**{field.name: int(data[field.name]) for field in fields(Area)})


def _read_synthesis(data: dict[str, Any]) -> SynthesisResult | None:
    if "synthesis" not in data:
        return None
    found = data["synthesis"]
    return SynthesisResult(
        device=found["device"],
        programs=tuple(found["programs"]),
        seed=None if found["seed"] is None else int(found["seed"]),
        area=_read_area(data["area"]),
        clock_hz=None if found["clock_hz"] is None else float(found["clock_hz"]),
        slowest=None if found["slowest_path"] is None else _read_path(found["slowest_path"]),
    )


def _read_path(data: dict[str, Any]) -> SlowestPath:
    begin, end = (
        PathEnd(**{**{f.name: end[f.name] for f in fields(PathEnd)}, "operations": tuple(end["operations"])})
        for end in (data["begin"], data["end"])
    )
    return SlowestPath(begin, end, float(data["logic_seconds"]), float(data["wire_seconds"]))


def _ordered(names: Sequence[str], items: dict[str, Any]) -> dict[str, Any]:
    """Return items by name, those with one of `names` first and in their order."""
    return {name: items[name] for name in dict.fromkeys([*names, *items]) if name in items}


def _read_problem(data: dict[str, Any], name: str) -> PlanProblem:
    samples = data["samples"]
    return PlanProblem(
        name=data["name"],
        program=parse_graph(data["program"], name),
        description=data["description"],
        inputs=tuple(
            PlanInput(item["name"], float(item["lo"]), float(item["hi"]), item["unit"], item.get("scale"))
            for item in data["inputs"]
        ),
        constants=data["constants"],
        equations=tuple(PlanEquation(item["target"], item["text"]) for item in data["equations"]),
        outputs=tuple(
            PlanOutput(item["name"], item["angle"], item["wrap"], item["max_error"])
            for item in data["outputs"]
        ),
        assumptions=tuple(data.get("assumptions", ())),
        samples=None if samples is None else {n: tuple(column) for n, column in samples["columns"].items()},
        warnings=tuple(data["warnings"]),
        facts=_read_facts(data, name),
        checks=tuple(
            PlanCheck(item["name"], item["text"], item["unit"], item["max"], item["asked"])
            for item in data.get("checks", ())
        ),
        check_program=parse_graph(data.get("check_program", ""), name),
    )


def _read_facts(data: dict[str, Any], name: str) -> InputFacts:
    if "facts" not in data:
        return InputFacts()
    stated = [(fact["text"], fact["relation"]) for fact in data["facts"]]
    return InputFacts.of(stated, parse_graph(data["fact_program"], name))


def _read_target(data: dict[str, Any]) -> PlanTarget:
    units = {
        kind: PlanUnitKind(
            int(unit.get("latency", 0)),
            int(unit.get("adders", 0)),
            float(unit.get("area", 0.0)),
            unit.get("stages", {}),
            int(unit.get("initiation_interval", 1)),
        )
        for kind, unit in data.get("units", {}).items()
    }
    return PlanTarget(
        name=data["name"],
        clock_hz=float(data["clock_hz"]),
        arithmetic=Arithmetic.from_spec(data["arithmetic"]),
        description=data.get("description", ""),
        angle_unit=data.get("angle_unit", "rad"),
        fifo_area_per_bit=float(data.get("fifo_area_per_bit", 0.0)),
        units=units,
        device=data.get("device"),
    )


def _read_options(data: dict[str, Any]) -> PlanOptions:
    known = {field.name for field in fields(PlanOptions)}
    # The schema takes 2.0 for an integer; the work of searches is the one number that need not be whole.
    whole = {
        name: int(value)
        for name, value in data.items()
        if type(value) is float and name not in ("effort", "clock")
    }
    return PlanOptions(**{name: value for name, value in (data | whole).items() if name in known})


def _read_point(data: dict[str, int]) -> BinaryPoint:
    return BinaryPoint(int(data["width"]), int(data["fraction"]))


def _read_accuracy(data: dict[str, Any]) -> OutputAccuracy:
    seen, bound = data["observed"], data["bound"]
    rows = tuple((row[0], row[1]) for row in seen.get("histogram", ()))
    return OutputAccuracy(
        SeenErrors(seen["max"], seen["rms"], rows),
        None if bound is None else _read_bound(bound),
        data.get("bound_reason", ""),
        tuple(map(_read_end, data.get("ends", ()))),
    )


def _read_end(data: dict[str, Any]) -> AccuracyEnd:
    return AccuracyEnd(**{field.name: data[field.name] for field in fields(AccuracyEnd)})


def _read_check(data: dict[str, Any]) -> CheckFigures:
    seen = data["observed"]
    return CheckFigures(SeenErrors(seen["max"], seen["rms"]), int(data["undefined"]), data["worst_input"])


def _read_bound(data: dict[str, Any]) -> StatedBound:
    conditions = data.get("conditions")
    return StatedBound(
        float(data["value"]),
        data["where"],
        data["share_of_samples"],
        None if conditions is None else tuple(map(_read_condition, conditions)),
        data.get("own_bounds"),
    )


def _read_condition(data: dict[str, Any]) -> Predicate:
    return Predicate(data["kind"], data["threshold"], data["text"], data["operation"])


def _read_unit(data: dict[str, Any]) -> Unit:
    words = tuple(
        ControlWord(int(word["slot"]), word["operation"], tuple(int(s) for s in word["select"]))
        for word in data.get("control", ())
    )
    inputs = tuple(tuple(sources) for sources in data.get("inputs", ()))
    interval = int(data.get("initiation_interval", 1))
    return Unit(data["id"], data["kind"], int(data["latency"]), inputs, words, interval)


def _read_operand(data: dict[str, str]) -> Operand:
    return Operand(data.get("value"), data.get("constant"))


def _read_operation(data: dict[str, Any]) -> Operation:
    end = data.get("end_error")
    return Operation(
        id=data["id"],
        op=data["op"],
        params=data["params"],
        kind=data["kind"],
        mode=data["mode"],
        unit=data["unit"],
        start=int(data["start"]),
        finish=int(data["finish"]),
        ports=tuple(data["ports"]),
        operands=tuple(_read_operand(item) for item in data["operands"]),
        results=tuple(data["results"]),
        equation=data["equation"],
        derivation=tuple(data.get("derivation", ())),
        slack=_read_slack(data.get("slack")),
        end_error=None if end is None else EndError(end["residual"], end["angle_rad"]),
    )


def _read_slack(data: dict[str, Any] | None) -> Slack:
    if data is None:
        return EXACT
    return Slack(float(data["beyond"]), float(data["within"]), bool(data["relative"]))
