"""Check a plan read back: operations that exist, sizes that can be run, a sound problem part."""

from __future__ import annotations

from collections.abc import Iterable

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.arith.numbers.formats import BinaryPoint, NumberSystem
from cordicc.arith.numbers.slack import EXACT
from cordicc.ir.graph import Graph, Value
from cordicc.ir.ops import BRANCHES, GUARD_CONDITIONS, OPS, Level, has_border
from cordicc.ir.well_formed import verify
from cordicc.plan.model import Operation, Plan

MAX_INTERVAL = 1_000_000
MAX_UNIT_LATENCY = 100_000
MAX_LATENCY = 1_000_000
MAX_DEPTH = 1_000_000
MAX_FIFO_WORDS = 50_000_000
"""Cycles and words; beyond, running a plan clock by clock would exhaust time or memory."""

_LARGEST_SHIFT = 4096

_ALLOWED = {
    "m": lambda p: type(p) is int and p in (1, 0, -1),
    "sign": lambda p: type(p) is int and p in (1, -1),
    "branch": lambda p: p in BRANCHES,
    "condition": lambda p: p in GUARD_CONDITIONS,
    "exponent": lambda p: type(p) is int and abs(p) <= _LARGEST_SHIFT,
    "factor": lambda p: isinstance(p, str),
}


def check_operations(plan: Plan) -> None:
    """Raise ValueError if an operation is unknown or is not of the form its definition asks for."""
    for operation in plan.operations:
        _check(operation)
        if operation.kind not in plan.target.units:
            raise ValueError(f"{operation.id}: the target has no unit of kind '{operation.kind}'")


def _check(operation: Operation) -> None:
    definition = OPS.get(operation.op)
    if definition is None or definition.level not in (Level.ARITHMETIC, Level.UNIT):
        raise ValueError(f"{operation.id}: no unit does '{operation.op}'")
    if operation.ports != definition.ports or len(operation.operands) != definition.arity:
        raise ValueError(f"{operation.id}: '{operation.op}' has the ports {', '.join(definition.ports)}")
    if len(operation.results) != len(definition.results):
        raise ValueError(f"{operation.id}: '{operation.op}' has {len(definition.results)} results")
    if set(operation.params) != set(definition.params):
        raise ValueError(f"{operation.id}: '{operation.op}' has other parameters")
    for name, param in operation.params.items():
        if not _ALLOWED[name](param):
            raise ValueError(f"{operation.id}: {name} = {param!r} is not allowed")
    slack = operation.slack
    allowed = slack == EXACT or has_border(operation.op, operation.params)
    if slack.within and operation.op != "implicit":
        allowed = False
    if slack.relative and operation.op not in ("implicit", "vector"):
        allowed = False
    if not allowed:
        raise ValueError(f"{operation.id}: '{operation.op}' has no such slack")


def check_programs(plan: Plan) -> None:
    """Raise if the graphs of the equations and of the operations are not sound or not those of the plan."""
    program = plan.problem.program
    verify(program)
    inputs = {node.name for node in program.nodes if node.op == "input"}
    if inputs != set(plan.problem.input_names):
        raise ValueError("the inputs of the program differ")
    if set(program.outputs) != set(plan.outputs):
        raise ValueError("the outputs of the program differ")
    facts = plan.problem.facts
    if len(facts.items) != len(plan.problem.assumptions) * plan.options.copies:
        raise ValueError("what the problem assumes is not what its facts are")
    if facts.items:
        verify(facts.graph)
        if not {node.name for node in facts.graph.nodes if node.op == "input"} <= inputs:
            raise ValueError("the facts are about other inputs")
    if plan.problem.checks:
        _verify_checks(plan)
    if plan.unit_program is not None:
        verify(plan.unit_program)
        _check_unit_program(plan, plan.unit_program)


def _verify_checks(plan: Plan) -> None:
    """Raise if the graph of the checks is not sound, or is not over the inputs and outputs of the plan."""
    graph = plan.problem.check_program
    verify(graph)
    taken = {node.name for node in graph.nodes if node.op == "input"}
    if not taken <= {*plan.problem.input_names, *plan.outputs}:
        raise ValueError("the check program takes more than inputs and outputs")
    if any(len(node.definition.results) > 1 for node in graph.nodes):
        raise ValueError("the check program has operations of units")


def _check_unit_program(plan: Plan, graph: Graph) -> None:
    """Raise ValueError if a graph is not that of the plan's operations, constants apart."""
    made = [i for i, node in enumerate(graph.nodes) if node.definition.level is not Level.LEAF]
    names = {index: f"o{number}" for number, index in enumerate(made, 1)}

    def value(taken: Value) -> str | None:
        node = graph.node(taken)
        if node.op == "input":
            return node.name
        return None if node.op == "const" else f"{names[taken.node]}.{node.definition.results[taken.result]}"

    operations = {operation.id: operation for operation in plan.operations}
    if set(operations) != set(names.values()):
        raise ValueError("the unit program has other operations")
    for index, id in names.items():
        node, operation = graph.nodes[index], operations[id]
        same = node.op == operation.op
        same = same and [value(v) for v in node.operands] == [item.value for item in operation.operands]
        # A factor is exact in the graph, and a word in the plan.
        same = same and all(operation.params[k] == v for k, v in node.named.items() if k != "factor")
        if not same:
            raise ValueError(f"{id} is another operation in the unit program")
    taken = {name: value(v) for name, v in graph.outputs.items()}
    if taken != {name: item.value for name, item in plan.outputs.items()}:
        raise ValueError("the outputs of the unit program differ")


def check_formats(plan: Plan) -> None:
    """Raise ValueError if formats are not those of the number system, or a FIFO has another width."""
    system = plan.arithmetic.system
    for name, point in plan.formats.outputs.items():
        _require_outside(system, f"output '{name}'", point)
    for name, point in plan.formats.values.items():
        if name in plan.problem.input_names:
            _require_outside(system, f"input '{name}'", point)
    for fifo in plan.fifos:
        width = system.format(plan.formats.values.get(fifo.value)).width_bits
        if fifo.width != width:
            raise ValueError(f"{fifo.id} is {fifo.width} bits wide, its words are {width}")


def _require_outside(system: NumberSystem, what: str, point: BinaryPoint) -> None:
    if isinstance(system, FixedSystem) and point.width != system.width_bits:
        width = system.width_bits
        raise ValueError(f"the words of {what} have {point.width} bits, outside there are {width}")


def check_sizes(plan: Plan) -> None:
    """Raise ValueError if running the plan clock by clock would exhaust time or memory."""
    figures = [
        ("the initiation interval", plan.initiation_interval, MAX_INTERVAL),
        ("the latency", plan.latency_cycles, MAX_LATENCY),
        *((f"the latency of {unit.id}", unit.latency, MAX_UNIT_LATENCY) for unit in plan.units),
        *((f"the depth of {fifo.id}", fifo.depth, MAX_DEPTH) for fifo in plan.fifos),
        ("the sum of FIFO words", plan.fifo_words, MAX_FIFO_WORDS),
    ]
    for name, figure, limit in figures:
        if figure > limit:
            raise ValueError(f"{name} is {figure}, more than {limit}")


def check_problem(plan: Plan) -> None:
    """Raise ValueError if the inputs, samples, outputs or accuracy figures do not fit together."""
    problem = plan.problem
    inputs = problem.input_names
    _require_unique("input", inputs)
    for item in problem.inputs:
        if not item.lo <= item.hi:
            raise ValueError(f"the range of input '{item.name}' is empty")
    outputs = [item.name for item in problem.outputs]
    _require_unique("output", outputs)
    if set(outputs) != set(plan.outputs):
        raise ValueError("the outputs of the problem differ")
    if not set(plan.accuracy) <= set(outputs):
        raise ValueError("the accuracy is of another output")
    for name, figures in plan.accuracy.items():
        seen = figures.observed
        if (seen.max is None) != (seen.rms is None):
            raise ValueError(f"the errors of output '{name}' lack the largest or the rms error")
        if seen.histogram and seen.max is None:
            raise ValueError(f"the errors of output '{name}' have a histogram, but no largest or rms error")
    _check_checks(plan)
    columns = problem.samples
    if columns is not None:
        if set(columns) != set(inputs):
            raise ValueError("the columns of the samples are not the inputs")
        if len({len(column) for column in columns.values()}) != 1:
            raise ValueError("the columns of the samples are of unequal lengths")


def _check_checks(plan: Plan) -> None:
    """Raise ValueError if the checks, their graph and their figures do not fit together."""
    names = [check.name for check in plan.problem.checks]
    _require_unique("check", names)
    if set(names) != set(plan.problem.check_program.outputs):
        raise ValueError("the checks of the check program differ")
    if not set(plan.checks) <= set(names):
        raise ValueError("the figures are of another check")
    for name, figures in plan.checks.items():
        seen = figures.observed
        if not (seen.max is None) == (seen.rms is None) == (figures.worst_input is None):
            raise ValueError(f"check '{name}' lacks the largest value, its sample or the rms")
        if figures.worst_input is not None and set(figures.worst_input) != set(plan.problem.input_names):
            raise ValueError(f"the worst sample of check '{name}' has other inputs")
        limit = plan.problem.check(name).max
        if limit is not None and seen.max is not None and seen.max > limit:
            raise ValueError(f"check '{name}' is beyond its limit")


def _require_unique(what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ValueError(f"{what} '{name}' occurs twice")
        seen.add(name)
