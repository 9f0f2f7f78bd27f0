"""The cheapest set of operations that yields the outputs, by constraint programming (CP-SAT)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cordicc.rewrite.conditions import Requirement
from cordicc.rewrite.costs import Costs, ordered
from cordicc.rewrite.options import Alternatives

_SEED = 1
_WORK = (0.8, 0.4, 0.2, 0.2)
"""Deterministic time of the solver for each goal, the most important first."""

_PREFERENCE = 0.4
"""The same for the number of standard CAUs, where implicit ones are preferred."""

_STEP = 64
"""Time is counted in 1/64 cycles, so that operations without a cycle still have an order."""


_START = 0.5
_MULTIPLIERS = 1000
"""Multipliers that a CAU counts for in the start."""


@dataclass(frozen=True, slots=True)
class Extraction:
    """The chosen option for each class that is needed, guards, and whether the choice is proven best."""

    provider: Mapping[int, int]
    guards: tuple[int, ...]
    proven: bool


@dataclass(slots=True)
class _Model:
    """The variables of the model: options taken, classes needed, who provides, when, guards."""

    model: Any
    taken: list[Any]
    needed: dict[int, Any]
    provides: dict[tuple[int, int], Any]
    time: dict[int, Any]
    guards: list[Any]
    finish: Any


def extract(
    choice: Alternatives,
    requirements: Sequence[Requirement],
    zeros: frozenset[int],
    costs: Costs,
    goal: str,
) -> Extraction | None:
    """Return the best choice found, None if none was found within the work limit.

    Goals are lexicographic: CAUs, multipliers of two variables, latency, other operators for
    `processors` and `fifo`; latency first for `latency`; area first for `area`.  Standard CAUs come
    before all of them where implicit ones are preferred.
    """
    from ortools.sat.python import cp_model

    units = [costs.caus(o.op, not zeros.isdisjoint(o.operands[:2])) for o in choice.options]
    built = _build(cp_model, choice, requirements, costs, units)
    goals = _goals(choice, built, costs, units, goal)
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = _SEED
    proven, answer = True, None
    first = int(costs.preferred)
    works = (_PREFERENCE, *_WORK)[1 - first :]
    if goal in ("latency", "area"):
        # Few CAUs and multipliers are a good start for every goal.
        solver.parameters.max_deterministic_time = _START
        built.model.minimize(_MULTIPLIERS * goals[first + 1] + goals[first + 2])
        if solver.solve(built.model) in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            _hint(built, solver)
    for expression, work in zip(goals, works, strict=True):
        solver.parameters.max_deterministic_time = work
        built.model.minimize(expression)
        status = solver.solve(built.model)
        if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
            break
        proven = proven and status == cp_model.OPTIMAL
        provider = {k: o for (k, o), used in built.provides.items() if solver.value(used)}
        guards = tuple(i for i, used in enumerate(built.guards) if solver.value(used))
        answer = provider, guards
        built.model.add(expression <= round(solver.objective_value))
        _hint(built, solver)
    return None if answer is None else Extraction(answer[0], answer[1], proven)


def _hint(built: _Model, solver: Any) -> None:
    """Start the next search from the last solution."""
    built.model.clear_hints()
    for variable in (*built.taken, *built.needed.values(), *built.provides.values(), *built.time.values()):
        built.model.add_hint(variable, solver.value(variable))


def _build(
    cp_model: Any,
    choice: Alternatives,
    requirements: Sequence[Requirement],
    costs: Costs,
    units: Sequence[int],
) -> _Model:
    model = cp_model.CpModel()
    latencies = [costs.cycles(o.op, u) * _STEP + 1 for o, u in zip(choice.options, units, strict=True)]
    horizon = min(sum(latencies), 40_000 * _STEP)
    taken = [model.new_bool_var(f"x{i}") for i in range(len(choice.options))]
    needed = {k: model.new_bool_var(f"n{k}") for k in choice.providers}
    time = {k: model.new_int_var(0, horizon, f"t{k}") for k in choice.providers}
    provides = {}
    for k, makers in choice.providers.items():
        for o in makers:
            provides[k, o] = used = model.new_bool_var(f"p{k}_{o}")
            model.add_implication(used, taken[o])
            for operand in choice.options[o].operands:
                model.add(time[k] >= time[operand] + latencies[o]).only_enforce_if(used)
        model.add(sum(provides[k, o] for o in makers) == needed[k])
    for o, option in enumerate(choice.options):
        for operand in set(option.operands):
            model.add_implication(taken[o], needed[operand])
    for k in choice.wanted.values():
        model.add(needed[k] == 1)
    guards = []
    for requirement in requirements:
        guard = model.new_bool_var("guard")
        guards.append(guard)
        if requirement.subject is None:
            model.add(guard == 0)
        else:
            model.add_implication(guard, needed[requirement.subject])
        model.add_bool_or([guard, *(provides[pair] for pair in requirement.met_by if pair in provides)])
    finish = model.new_int_var(0, horizon, "finish")
    for k in choice.wanted.values():
        model.add(finish >= time[k])
    return _Model(model, taken, needed, provides, time, guards, finish)


def _goals(
    choice: Alternatives, built: _Model, costs: Costs, units: Sequence[int], goal: str
) -> tuple[Any, ...]:
    pairs = list(zip(built.taken, choice.options, units, strict=True))
    processors = sum(u * x for x, _, u in pairs if u)
    multipliers = sum(x for x, o, _ in pairs if o.op == "mul")
    area = sum(costs.size(o.op, u) * x for x, o, u in pairs) + sum(built.guards)
    goals = ordered(goal, processors, multipliers, built.finish, area)
    if not costs.preferred:
        return goals
    return (sum(u * x for x, o, u in pairs if u and o.op != "implicit"), *goals)
