"""From the graph of unit operations to the plan: units, slots, FIFOs, counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

from cordicc.arith.formats import NumberSystem
from cordicc.diagnostics import Diagnostic, InvalidInput, Unattainable
from cordicc.ir.graph import Graph, Param, Value
from cordicc.ir.ops import Level
from cordicc.plan import Formats, Operand, Operation, Plan, Unit
from cordicc.schedule.delays import delays
from cordicc.schedule.fifo_lp import Goal, solve
from cordicc.schedule.problem import OUT, InfeasibleError, Schedule, SchedulingProblem, Sink, Task
from cordicc.schedule.problem import Value as Wire
from cordicc.targets.model import CAU_KINDS, SYSTEMS, Target, function_name


@dataclass(frozen=True, slots=True)
class Limits:
    """What the user asks of the plan besides the equations."""

    minimize: str = "processors"
    initiation_interval: int = 1
    max_processors: int | None = None
    max_latency: int | None = None


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
    limits: Limits,
    *,
    problem: Mapping[str, Any],
    options: Mapping[str, Any],
    formats: Mapping[Value | str, dict[str, int]],
) -> Plan:
    """Return the plan of a graph of unit operations at initiation interval 1.

    Args:
        graph: leaves, arithmetic and unit operations only.
        target: the units and their latencies.
        limits: goals and limits.
        problem: what the plan records of the problem.
        options: what it records of the command.
        formats: of values, and of outputs by name, as a plan states them; empty if the target implies them.

    Raises:
        InvalidInput: an initiation interval that is not supported.
        Unattainable: no plan within the limits.
    """
    if limits.initiation_interval != 1:
        raise InvalidInput(
            [
                Diagnostic(
                    "E401",
                    f"initiation interval {limits.initiation_interval} is not supported",
                    hint="this version plans one sample per cycle: --ii 1",
                )
            ]
        )
    words = target.machine().system
    names = _names(graph)
    used = graph.used_results()
    operations = [_operation(graph, index, names, target, used, words) for index in sorted(names)]
    caus = sum(o.kind in CAU_KINDS for o in operations)
    if limits.max_processors is not None and caus > limits.max_processors:
        message = f"the CAUs of the plan are {caus}, more than --max-processors {limits.max_processors}"
        hint = f"every operation has a CAU of its own; the least is --max-processors {caus}"
        raise _unattainable("E402", message, hint)
    outputs = {name: _operand(graph, names, v, name, words) for name, v in graph.outputs.items()}
    wires = _wires(graph, operations, outputs)
    schedulable = SchedulingProblem(tuple(Task(o.id, o.kind, o.finish - o.start) for o in operations), wires)
    schedulable.check()
    schedule = _solve(schedulable, limits)
    stated = _formats(graph, names, formats)
    widths = {wire.name: words.format(stated.values.get(wire.name)).width_bits for wire in wires}
    fifos = delays(schedulable, schedule, widths)
    units, placed = _place(operations, schedule)
    return Plan(
        name=problem["name"],
        description=problem["description"],
        target=target.embedded(),
        problem=dict(problem),
        options=dict(options),
        initiation_interval=1,
        latency_cycles=schedule.latency,
        cau_cycles=_cau_cycles(placed),
        units=units,
        operations=placed,
        fifos=fifos,
        outputs=outputs,
        optimal={"processors": True, **schedule.optimal},
        bounds={"processors": caus, **schedule.bounds},
        formats=stated,
    )


def _solve(problem: SchedulingProblem, limits: Limits) -> Schedule:
    # At interval 1 every operation has its own unit, so the units' area is fixed and FIFO words decide it.
    goal: Goal = "fifo" if limits.minimize in ("fifo", "area") else "latency"
    try:
        return solve(problem, goal, limits.max_latency)
    except InfeasibleError:
        least = problem.earliest().latency
        message = f"the critical path takes {least} cycles, more than --max-latency {limits.max_latency}"
        raise _unattainable("E403", message, f"the least that can be met is --max-latency {least}") from None


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
        return str(node.params[0])
    return f"{names[value.node]}.{node.definition.results[value.result]}"


def _formats(
    graph: Graph, names: Mapping[int, str], formats: Mapping[Value | str, dict[str, int]]
) -> Formats:
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
    kinds = target.kinds_for(function_name(node.op, params.get("m")))
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
        finish=target.units[kind].latency,
        ports=definition.ports,
        operands=tuple(_operand(graph, names, v, node.origin, words) for v in node.operands),
        results=tuple(
            _value_name(graph, names, Value(index, r)) if Value(index, r) in used else None
            for r in range(len(definition.results))
        ),
        equation=node.origin,
    )


def _wires(graph: Graph, operations: list[Operation], outputs: Mapping[str, Operand]) -> tuple[Wire, ...]:
    """Return every value that something takes, inputs first."""
    sinks: dict[str, list[Sink]] = {}
    for operation in operations:
        for port, operand in zip(operation.ports, operation.operands, strict=True):
            if operand.value is not None:
                sinks.setdefault(operand.value, []).append((operation.id, port))
    for name, operand in outputs.items():
        if operand.value is not None:
            sinks.setdefault(operand.value, []).append((OUT, name))
    inputs = [str(node.params[0]) for node in graph.nodes if node.op == "input"]
    made = [(r, o.id) for o in operations for r in o.results if r is not None]
    every: list[tuple[str, str | None]] = [(name, None) for name in inputs]
    every += made
    return tuple(Wire(name, producer, tuple(sinks[name])) for name, producer in every if name in sinks)


def _place(operations: list[Operation], schedule: Schedule) -> tuple[tuple[Unit, ...], tuple[Operation, ...]]:
    """Give every operation its slot and a unit of its own; CAUs are numbered together."""
    units: list[Unit] = []
    placed: list[Operation] = []
    count: dict[str, int] = {}
    for operation in operations:
        prefix = "cau" if operation.kind in CAU_KINDS else operation.kind
        count[prefix] = count.get(prefix, 0) + 1
        unit = Unit(f"{prefix}{count[prefix]}", operation.kind, operation.finish - operation.start)
        start = schedule.start[operation.id]
        units.append(unit)
        placed.append(operation.at(unit.id, start, start + unit.latency))
    return tuple(units), tuple(placed)


def _cau_cycles(operations: tuple[Operation, ...]) -> int:
    """Return the largest sum of CAU latencies on any path."""
    longest: dict[str, int] = {}
    best = 0
    for operation in operations:
        before = max((longest.get(o.value, 0) for o in operation.operands if o.value is not None), default=0)
        total = before + (operation.finish - operation.start if operation.kind in CAU_KINDS else 0)
        best = max(best, total)
        longest |= {result: total for result in operation.results if result is not None}
    return best
