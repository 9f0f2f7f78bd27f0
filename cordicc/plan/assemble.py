"""From the graph of unit operations to the operations of a plan, yet to be placed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

from cordicc.arith.numbers.formats import BinaryPoint, NumberSystem
from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.ir.graph import Graph, Param, Value
from cordicc.ir.ops import Level
from cordicc.plan.model import Formats, Operand, Operation, Plan, Selection
from cordicc.plan.origin import PlanOptions, PlanProblem, PlanTarget
from cordicc.targets.target import SYSTEMS, Target, function_name


def mode(op: str, params: Mapping[str, Any]) -> str:
    """Return in words what a unit does."""
    if op == "rotate":
        return f"{SYSTEMS[params['m']]} rotation"
    if op == "vector":
        return f"{SYSTEMS[params['m']]} vectoring"
    if op == "lightcone":
        return "hyperbolic vectoring of (u+v, u-v)/2"
    if op == "implicit":
        branch = "" if params["branch"] == "none" else f", branch {params['branch']}"
        return f"implicit {SYSTEMS[params['m']]}{branch}"
    return op


def assemble(
    graph: Graph,
    target: Target,
    *,
    problem: PlanProblem,
    options: PlanOptions,
    formats: Mapping[Value | str, BinaryPoint],
    steps: Mapping[int, tuple[str, ...]],
    selection: Selection,
) -> Plan:
    """Return the plan of a graph of unit operations, without units and with every start at 0.

    It can be run, but not clock by clock; `cordicc.schedule.place` gives it its schedule.

    Args:
        graph: leaves, arithmetic and unit operations only.
        target: the units and their latencies.
        problem: what the plan records of the problem.
        options: what it records of the command.
        formats: of values, and of outputs by name, as a plan states them; empty if the target implies them.
        steps: of rewriting, by node.
        selection: how the graph was chosen.

    Raises:
        Unattainable: the target has no unit for an operation, or no word for a constant.
    """
    made_for = PlanTarget.of(target)
    words = made_for.arithmetic.system
    names = _names(graph)
    used = graph.used_results()
    operations = [
        replace(_operation(graph, i, names, target, used, words), derivation=steps.get(i, ()))
        for i in sorted(names)
    ]
    outputs = {name: _operand(graph, names, v, name, words) for name, v in graph.outputs.items()}
    return Plan(
        problem=problem,
        target=made_for,
        options=options,
        initiation_interval=1,
        latency_cycles=0,
        cau_cycles=0,
        units=(),
        operations=tuple(operations),
        fifos=(),
        outputs=outputs,
        optimal={},
        bounds={},
        formats=_formats(graph, names, formats),
        selection=selection,
        unit_program=graph,
    )


def _names(graph: Graph) -> dict[int, str]:
    """Return the operation id of each node that is an operation."""
    found: dict[int, str] = {}
    for index, node in enumerate(graph.nodes):
        if node.definition.level is not Level.LEAF:
            found[index] = f"o{len(found) + 1}"
    return found


def _value_name(graph: Graph, names: Mapping[int, str], value: Value) -> str:
    node = graph.node(value)
    if node.op == "input":
        return node.name
    return f"{names[value.node]}.{node.definition.results[value.result]}"


def _formats(graph: Graph, names: Mapping[int, str], formats: Mapping[Value | str, BinaryPoint]) -> Formats:
    """Return the formats by the names of the plan."""
    return Formats(
        {_value_name(graph, names, v): spec for v, spec in formats.items() if isinstance(v, Value)},
        {name: spec for name, spec in formats.items() if isinstance(name, str)},
    )


def _unattainable(code: str, message: str, hint: str) -> Unattainable:
    return Unattainable([Diagnostic(code, message, hint=hint)])


def _constant(number: Fraction, equation: str, words: NumberSystem) -> str:
    """Return a constant as text of the number format; Unattainable if the format cannot hold it."""
    try:
        return words.constant_text(number)
    except OverflowError as error:
        shown = Decimal(number.numerator) / Decimal(number.denominator)
        message = f"the constant {shown:.6g} in the equation of '{equation}' cannot be held: {error}"
        hint = "choose other units for the inputs, so that constants are nearer to 1"
        raise _unattainable("E411", message, hint) from None


def _operand(graph: Graph, names: Mapping[int, str], value: Value, user: str, words: NumberSystem) -> Operand:
    number = graph.constant(value)
    if number is not None:
        return Operand(constant=_constant(number, graph.node(value).origin or user, words))
    return Operand(value=_value_name(graph, names, value))


def _operation(
    graph: Graph, index: int, names: Mapping[int, str], target: Target, used: set[Value], words: NumberSystem
) -> Operation:
    """Return the operation with start 0, to be placed later."""
    node = graph.nodes[index]
    definition = node.definition

    def plain(name: str, param: Param) -> Any:
        if name == "factor":
            return _constant(Fraction(param), node.origin, words)
        return int(param) if isinstance(param, Fraction) else param

    params = {name: plain(name, param) for name, param in zip(definition.params, node.params, strict=True)}
    function = function_name(node.op, params.get("m"))
    kinds = target.kinds_for(function)
    if not kinds:
        message = f"no unit of target '{target.name}' does {mode(node.op, params)}"
        raise _unattainable("E405", message, f"the equation of '{node.origin}' needs it")
    kind = kinds[0]
    return Operation(
        id=names[index],
        op=node.op,
        params=params,
        kind=kind,
        mode=mode(node.op, params),
        unit="",
        start=0,
        finish=target.units[kind].cycles_of(function),
        ports=definition.ports,
        operands=tuple(_operand(graph, names, v, node.origin, words) for v in node.operands),
        results=tuple(
            _value_name(graph, names, Value(index, r)) if Value(index, r) in used else None
            for r in range(len(definition.results))
        ),
        equation=node.origin,
    )
