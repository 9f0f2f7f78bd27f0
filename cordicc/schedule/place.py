"""From the operations of a plan to a finished one: starts, FIFOs, units, counts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from cordicc.plan.model import Operand, Operation, Plan, Unit
from cordicc.plan.netlist import Netlist
from cordicc.schedule.binding import Binding, bind, wiring
from cordicc.schedule.control import controlled
from cordicc.schedule.delays import delays
from cordicc.schedule.request import Limits, goals, scheduled
from cordicc.schedule.solver.scheduling_problem import OUT, SchedulingProblem, Sink, Task, TaskValue
from cordicc.targets.target import CAU_KINDS

_FIGURES = ("processors", "latency", "fifo_words")


def place(plan: Plan, limits: Limits) -> Plan:
    """Return the plan scheduled anew, with the same operations in the same order.

    Starts, units and FIFOs that the plan has do not matter; latencies are taken from its operations.
    Raises Unattainable if no plan is within the limits.
    """
    interval = limits.initiation_interval
    problem = scheduling_problem(plan, interval)
    busy = {task.id: task.busy for task in problem.operations}
    system = plan.arithmetic.system
    widths = {v.name: system.format(plan.formats.values.get(v.name)).width_bits for v in problem.values}
    order = goals(limits.minimize, plan.target, tuple(problem.counts()), widths)
    schedule = scheduled(problem, order, limits)
    started = tuple(
        o.at("", schedule.start[o.id], schedule.start[o.id] + _cycles(o)) for o in plan.operations
    )
    timed = replace(
        plan,
        initiation_interval=interval,
        latency_cycles=schedule.latency,
        units=(),
        operations=started,
        fifos=delays(problem, schedule, widths),
    )
    kinds = {task.id: task.kind for task in problem.operations}
    binding = bind(wiring(Netlist.of(timed), started, kinds, busy), limits.effort.binding)
    units, operations = _bound(started, kinds, busy, binding)
    bound = replace(timed, units=units, operations=operations)
    return replace(
        bound,
        options=replace(plan.options, time_limit_struck=plan.options.time_limit_struck or schedule.struck),
        cau_cycles=_cau_cycles(operations),
        units=controlled(Netlist.of(bound)),
        optimal={name: schedule.optimal[name] for name in _FIGURES},
        bounds={name: schedule.bounds[name] for name in _FIGURES},
    )


def figures(plan: Plan, minimize: str) -> tuple[float, ...]:
    """Return a plan's figures in the order of a goal, to compare plans by."""
    units = plan.units_by_kind()
    caus, products = sum(units.get(kind, 0) for kind in CAU_KINDS), units.get("mul", 0)
    words = plan.fifo_words
    rest = (caus, products, plan.latency_cycles, words)
    if minimize == "area":
        area = sum(plan.target.units[unit.kind].area for unit in plan.units)
        bits = sum(fifo.depth * fifo.width for fifo in plan.fifos)
        return (area + bits * plan.target.fifo_area_per_bit, *rest)
    return {"latency": (plan.latency_cycles, *rest), "fifo": (words, *rest)}.get(minimize, rest)


def scheduling_problem(plan: Plan, interval: int) -> SchedulingProblem:
    """Return the problem of a plan's operations."""
    units = plan.target.units
    tasks = tuple(
        Task(o.id, _shared_kind(o), _cycles(o), units[o.kind].initiation_interval) for o in plan.operations
    )
    return SchedulingProblem(tasks, _values(plan), interval)


def _cycles(operation: Operation) -> int:
    return operation.finish - operation.start


def _shared_kind(operation: Operation) -> str:
    """Return the name under which operations may share a unit: its kind, and what it is built for.

    A product with a constant is built for that constant.  Logic without a register is not shared: its
    multiplexers would cost more than it, and could close combinational loops.
    """
    if _cycles(operation) == 0:
        return f"{operation.kind} {operation.id}"
    constant = operation.params.get("factor", operation.params.get("exponent"))
    return operation.kind if constant is None else f"{operation.kind} {constant}"


def _values(plan: Plan) -> tuple[TaskValue, ...]:
    """Return every value that something takes, inputs first."""
    sinks: dict[str, list[Sink]] = {}

    def take(operand: Operand, sink: Sink) -> None:
        if operand.value is not None:
            sinks.setdefault(operand.value, []).append(sink)

    for operation in plan.operations:
        for port, operand in zip(operation.ports, operation.operands, strict=True):
            take(operand, (operation.id, port))
    for name, operand in plan.outputs.items():
        take(operand, (OUT, name))
    every: list[tuple[str, str | None]] = [(name, None) for name in plan.problem.input_names]
    every += [(r, o.id) for o in plan.operations for r in o.results if r is not None]
    return tuple(TaskValue(name, producer, tuple(sinks[name])) for name, producer in every if name in sinks)


def _bound(
    operations: Sequence[Operation], kinds: Mapping[str, str], busy: Mapping[str, int], binding: Binding
) -> tuple[tuple[Unit, ...], tuple[Operation, ...]]:
    """Give every operation its unit; units are numbered by first use, CAUs together."""
    names: dict[tuple[str, int], str] = {}
    units: list[Unit] = []
    bound: list[Operation] = []
    count: dict[str, int] = {}
    for operation in operations:
        key = kinds[operation.id], binding[operation.id]
        if key not in names:
            prefix = "cau" if operation.kind in CAU_KINDS else operation.kind
            count[prefix] = count.get(prefix, 0) + 1
            names[key] = f"{prefix}{count[prefix]}"
            interval = busy[operation.id]
            units.append(Unit(names[key], operation.kind, _cycles(operation), initiation_interval=interval))
        bound.append(operation.at(names[key], operation.start, operation.finish))
    return tuple(units), tuple(bound)


def _cau_cycles(operations: tuple[Operation, ...]) -> int:
    """Return the largest sum of CAU latencies on any path."""
    longest: dict[str, int] = {}
    best = 0
    for operation in operations:
        before = max((longest.get(o.value, 0) for o in operation.operands if o.value is not None), default=0)
        total = before + (_cycles(operation) if operation.kind in CAU_KINDS else 0)
        best = max(best, total)
        longest |= {result: total for result in operation.results if result is not None}
    return best
