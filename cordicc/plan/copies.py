"""Several instances of a problem in one plan: a leg each, say, of a robot with six."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from cordicc.ir.copies import copied
from cordicc.ir.text import parse_graph, print_graph
from cordicc.plan.model import Operand, Plan
from cordicc.plan.problem_record import UNIT_PROGRAM


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
        options={**plan.options, "copies": copies},
        formats=formats,
    )


def _problem(problem: Mapping[str, Any], copies: int) -> dict[str, Any]:
    """Return the record of a problem with the inputs, outputs, programs and samples of all copies."""

    def of_all(items: list[dict[str, Any]]) -> list[dict[str, Any]]:
        every = range(1, copies + 1)
        return [{**item, "name": name_of(item["name"], copy)} for copy in every for item in items]

    programs = {
        key: print_graph(copied(parse_graph(problem[key], key), copies, name_of))
        for key in ("program", UNIT_PROGRAM)
        if key in problem
    }
    samples = problem["samples"]
    if samples is not None:
        samples = {**samples, "columns": _columns(samples["columns"], copies)}
    made = {"inputs": of_all(problem["inputs"]), "outputs": of_all(problem["outputs"]), "samples": samples}
    return {**problem, **programs, **made}


def _columns(columns: Mapping[str, list[float]], copies: int) -> dict[str, list[float]]:
    """Return the samples of all copies: the rows of each begin at another one, so that copies differ."""
    found = {}
    for copy in range(1, copies + 1):
        for name, column in columns.items():
            first = (copy - 1) * len(column) // copies
            found[name_of(name, copy)] = [*column[first:], *column[:first]]
    return found
