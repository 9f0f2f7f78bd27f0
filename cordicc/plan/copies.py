"""Several instances of a problem in one plan: a leg each, say, of a robot with six."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from cordicc.ir.facts import SIDES, InputFacts
from cordicc.ir.graph import Graph, Node, Value
from cordicc.plan.model import Operand, Plan
from cordicc.plan.origin import PlanProblem


def name_of(name: str, copy: int) -> str:
    """Return the name of an input or output in a copy, numbered from 1.

    Different names stay different: the number is what follows the last underscore.
    """
    return f"{name}_{copy}"


def replicated(plan: Plan, copies: int) -> Plan:
    """Return the plan of several instances of a problem, yet to be placed; of one, the plan itself.

    Every input and output is there once for each copy; constants, equations and assumptions are the same
    for all.  Operations are those of copy 1, then those of copy 2, and so on.
    """
    if copies == 1:
        return plan
    every = range(1, copies + 1)
    count = len(plan.operations)
    position = {operation.id: index for index, operation in enumerate(plan.operations, 1)}

    def id_of(id: str, copy: int) -> str:
        return f"o{position[id] + (copy - 1) * count}"

    def value_of(value: str, copy: int) -> str:
        id, dot, result = value.partition(".")
        return f"{id_of(id, copy)}.{result}" if dot else name_of(value, copy)

    def operand(item: Operand, copy: int) -> Operand:
        return item if item.value is None else Operand(value_of(item.value, copy))

    operations = tuple(
        replace(
            o,
            id=id_of(o.id, copy),
            operands=tuple(operand(item, copy) for item in o.operands),
            results=tuple(None if name is None else value_of(name, copy) for name in o.results),
        )
        for copy in every
        for o in plan.operations
    )
    formats = replace(
        plan.formats,
        values={value_of(name, c): spec for c in every for name, spec in plan.formats.values.items()},
        outputs={name_of(name, c): spec for c in every for name, spec in plan.formats.outputs.items()},
    )
    return replace(
        plan,
        operations=operations,
        outputs={name_of(name, c): operand(o, c) for c in every for name, o in plan.outputs.items()},
        problem=_problem(plan.problem, copies),
        options=replace(plan.options, copies=copies),
        formats=formats,
        unit_program=None if plan.unit_program is None else copied(plan.unit_program, copies),
    )


def _problem(problem: PlanProblem, copies: int) -> PlanProblem:
    """Return the record of a problem with the inputs, outputs, programs, samples and facts of all copies.

    Its equations stay as they are written, once.
    """
    every = range(1, copies + 1)
    return replace(
        problem,
        inputs=tuple(replace(i, name=name_of(i.name, copy)) for copy in every for i in problem.inputs),
        outputs=tuple(replace(o, name=name_of(o.name, copy)) for copy in every for o in problem.outputs),
        program=copied(problem.program, copies),
        samples=None if problem.samples is None else _columns(problem.samples, copies),
        facts=_facts(problem.facts, copies),
        checks=tuple(replace(c, name=name_of(c.name, copy)) for copy in every for c in problem.checks),
        check_program=copied(problem.check_program, copies),
    )


def _facts(facts: InputFacts, copies: int) -> InputFacts:
    """Return the facts of all copies, those of each with its number in their text."""
    if not facts.items:
        return facts
    graph, count = copied(facts.graph, copies), len(facts.items)
    sides = {
        f"{side}{(copy - 1) * count + index}": graph.outputs[name_of(f"{side}{index}", copy)]
        for copy in range(1, copies + 1)
        for index in range(count)
        for side in SIDES
    }
    stated = [
        (f"{fact.text} of copy {copy}", fact.relation)
        for copy in range(1, copies + 1)
        for fact in facts.items
    ]
    return InputFacts.of(stated, Graph(graph.nodes, sides))


def _columns(columns: Mapping[str, tuple[float, ...]], copies: int) -> dict[str, tuple[float, ...]]:
    """Return the samples of all copies: the rows of each begin at another one, so that copies differ."""
    found = {}
    for copy in range(1, copies + 1):
        for name, column in columns.items():
            first = (copy - 1) * len(column) // copies
            found[name_of(name, copy)] = column[first:] + column[:first]
    return found


def copied(graph: Graph, count: int) -> Graph:
    """Return a graph of `count` instances that share their constants and nothing else.

    Args:
        graph: what is copied.
        count: at least 1.
    """
    nodes: list[Node] = []
    outputs: dict[str, Value] = {}
    constants: dict[int, int] = {}
    for copy in range(1, count + 1):
        place: dict[int, int] = {}
        for index, node in enumerate(graph.nodes):
            if node.op == "const" and index in constants:
                place[index] = constants[index]
                continue
            place[index] = len(nodes)
            if node.op == "const":
                constants[index] = place[index]
            params = (name_of(node.name, copy),) if node.op == "input" else node.params
            operands = tuple(Value(place[v.node], v.result) for v in node.operands)
            nodes.append(Node(node.op, params, operands, node.origin))
        for output, value in graph.outputs.items():
            outputs[name_of(output, copy)] = Value(place[value.node], value.result)
    return Graph(tuple(nodes), outputs)
