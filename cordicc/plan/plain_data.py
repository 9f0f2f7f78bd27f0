"""A plan as plain data, in the form of the published schema, and back; `cordicc.plan.file` has its text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.ir.facts import InputFacts
from cordicc.ir.text import parse_graph, print_graph
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

FORMAT = "cordicc-plan"
VERSION = 1


def as_dict(plan: Plan) -> dict[str, Any]:
    """Return the plan as plain data, in the form of the published schema."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": plan.name,
        "description": plan.description,
        "target": plan.target.name,
        "target_data": _target(plan.target),
        "clock_hz": plan.clock_hz,
        "options": plan.options.recorded,
        "problem": _problem(plan),
        "initiation_interval": plan.initiation_interval,
        "latency": {
            "cycles": plan.latency_cycles,
            "seconds": plan.latency_seconds,
            "cau_cycles": plan.cau_cycles,
        },
        "processors": plan.processors(),
        "units": [_unit(u) for u in plan.units],
        "operations": [_operation(o) for o in plan.operations],
        "fifos": [_fifo(f) for f in plan.fifos],
        "fifo_words": plan.fifo_words,
        "outputs": {name: _operand(operand) for name, operand in plan.outputs.items()},
        "optimal": dict(plan.optimal),
        "bounds": dict(plan.bounds),
        "selection": {
            name: list(x) if isinstance(x, tuple) else x for name, x in asdict(plan.selection).items()
        },
        "formats": {
            "values": {name: point._asdict() for name, point in plan.formats.values.items()},
            "outputs": {name: point._asdict() for name, point in plan.formats.outputs.items()},
        },
        "accuracy": {name: _accuracy(figures) for name, figures in plan.accuracy.items()},
        "checks": {name: check_data(plan.problem.check(name), found) for name, found in plan.checks.items()},
    }


def _problem(plan: Plan) -> dict[str, Any]:
    problem = plan.problem
    data: dict[str, Any] = {
        "name": problem.name,
        "description": problem.description,
        "inputs": [_input(item) for item in problem.inputs],
        "constants": dict(problem.constants),
        "equations": [asdict(item) for item in problem.equations],
        "outputs": [
            {"name": o.name, "angle": o.is_angle, "wrap": o.wrap, "max_error": o.max_error}
            for o in problem.outputs
        ],
        "assumptions": list(problem.assumptions),
        "checks": [asdict(item) for item in problem.checks],
        "check_program": print_graph(problem.check_program) if problem.checks else "",
        "program": print_graph(problem.program),
        "samples": None,
        "warnings": list(problem.warnings),
    }
    if problem.samples is not None:
        data["samples"] = {"columns": {name: list(column) for name, column in problem.samples.items()}}
    if problem.facts.items:
        data["facts"] = [{"text": fact.text, "relation": fact.relation} for fact in problem.facts.items]
        data["fact_program"] = print_graph(problem.facts.graph)
    if plan.unit_program is not None:
        data["unit_program"] = print_graph(plan.unit_program)
    return data


def _input(item: PlanInput) -> dict[str, Any]:
    data = asdict(item)
    if item.scale is None:
        del data["scale"]
    return data


def _target(target: PlanTarget) -> dict[str, Any]:
    return {
        "name": target.name,
        "description": target.description,
        "clock_hz": target.clock_hz,
        "angle_unit": target.angle_unit,
        "arithmetic": target.arithmetic.spec,
        "fifo_area_per_bit": target.fifo_area_per_bit,
        "units": {kind: {**asdict(unit), "stages": dict(unit.stages)} for kind, unit in target.units.items()},
    }


def _accuracy(figures: OutputAccuracy) -> dict[str, Any]:
    seen, bound = figures.observed, figures.bound
    data: dict[str, Any] = {
        "bound": None,
        "observed": {"max": seen.max, "rms": seen.rms, "histogram": [list(row) for row in seen.histogram]},
    }
    if bound is not None:
        data["bound"] = bound_data(bound)
    elif figures.bound_reason:
        data["bound_reason"] = figures.bound_reason
    if figures.ends:
        data["ends"] = [{**asdict(end), "at": dict(end.at)} for end in figures.ends]
    return data


def check_data(check: PlanCheck, figures: CheckFigures) -> dict[str, Any]:
    """Return what a check showed as plain data, in the form of the published schema."""
    worst = figures.worst_input
    return {
        "observed": {"max": figures.observed.max, "rms": figures.observed.rms},
        "max": check.max,
        "unit": check.unit,
        "undefined": figures.undefined,
        "worst_input": None if worst is None else dict(worst),
    }


def bound_data(bound: StatedBound) -> dict[str, Any]:
    """Return a bound as plain data, in the form of the published schema."""
    data: dict[str, Any] = {
        "value": bound.value,
        "where": bound.where,
        "share_of_samples": bound.share_of_samples,
    }
    if bound.conditions is not None:
        data["conditions"] = [asdict(condition) for condition in bound.conditions]
    if bound.own_bounds is not None:
        data["own_bounds"] = dict(bound.own_bounds)
    return data


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
    data = {
        **{field.name: getattr(operation, field.name) for field in fields(operation)},
        "params": dict(operation.params),
        "ports": list(operation.ports),
        "operands": [_operand(o) for o in operation.operands],
        "results": list(operation.results),
        "derivation": list(operation.derivation),
        "slack": asdict(operation.slack),
        "end_error": None if operation.end_error is None else asdict(operation.end_error),
    }
    without = {"slack": operation.slack == EXACT, "end_error": operation.end_error is None}
    return {name: item for name, item in data.items() if not without.get(name)}


def _fifo(fifo: Fifo) -> dict[str, Any]:
    return {
        "id": fifo.id,
        "value": fifo.value,
        "from": fifo.source,
        "to": list(fifo.sinks),
        "depth": fifo.depth,
        "width": fifo.width,
    }


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
    )


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
    )


def _read_options(data: dict[str, Any]) -> PlanOptions:
    known = {field.name for field in fields(PlanOptions)}
    # The schema takes 2.0 for an integer; the work of searches is the one number that need not be whole.
    whole = {name: int(value) for name, value in data.items() if type(value) is float and name != "effort"}
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
    return Unit(data["id"], data["kind"], int(data["latency"]), inputs, words)


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
