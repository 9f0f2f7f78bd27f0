"""A plan as plain data, in the form of the published schema; `cordicc.plan.file` has its text."""

from __future__ import annotations

from dataclasses import asdict, fields
from typing import Any

from cordicc.arith.numbers.slack import EXACT
from cordicc.ir.text import print_graph
from cordicc.plan.area import Area, SynthesisResult
from cordicc.plan.cordic_data import cordic_data
from cordicc.plan.model import Fifo, Operand, Operation, Plan, Unit
from cordicc.plan.origin import (
    PlanCheck,
    PlanInput,
    PlanTarget,
    PlanUnitKind,
)
from cordicc.plan.stated_accuracy import (
    CheckFigures,
    OutputAccuracy,
    StatedBound,
)

FORMAT = "cordicc-plan"
VERSION = 1


def as_dict(plan: Plan) -> dict[str, Any]:
    """Return the plan as plain data, in the form of the published schema."""
    data = {
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
    cordic = cordic_data(plan)
    if cordic is not None:
        data["cordic"] = cordic
    if plan.area is not None:
        data["area"] = {**asdict(plan.area), "estimated": plan.synthesis is None}
    if plan.synthesis is not None:
        data["synthesis"] = synthesis_data(plan.synthesis, plan.estimate)
    return data


def synthesis_data(synthesis: SynthesisResult, estimate: Area | None) -> dict[str, Any]:
    """Return what building showed as plain data, in the form of the published schema, but for the area."""
    return {
        "device": synthesis.device,
        "programs": list(synthesis.programs),
        "seed": synthesis.seed,
        "clock_hz": synthesis.clock_hz,
        "slowest_path": None if synthesis.slowest is None else asdict(synthesis.slowest),
        "estimate": None if estimate is None else asdict(estimate),
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
    data: dict[str, Any] = {
        "name": target.name,
        "description": target.description,
        "clock_hz": target.clock_hz,
        "angle_unit": target.angle_unit,
        "arithmetic": target.arithmetic.spec,
        "fifo_area_per_bit": target.fifo_area_per_bit,
        "units": {kind: _unit_kind(unit) for kind, unit in target.units.items()},
    }
    return data if target.device is None else {**data, "device": target.device}


def _unit_kind(unit: PlanUnitKind) -> dict[str, Any]:
    data = {**asdict(unit), "stages": dict(unit.stages)}
    if unit.initiation_interval == 1:
        del data["initiation_interval"]
    return data


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
    if unit.initiation_interval > 1:
        data["initiation_interval"] = unit.initiation_interval
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
