"""The cheapest set of operations that yields the outputs, by constraint programming (CP-SAT).

Goals that count operations are met on a model without times, whose linear relaxation is strong; only where
classes may be made from one another do they have an order in it.  Latency, and what comes after it, is met
on a model with the time of each class.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from typing import Any

from cordicc.rewrite.passes.base import PassContext
from cordicc.rewrite.search.conditions import Requirement
from cordicc.rewrite.search.costs import Costs, ordered
from cordicc.rewrite.search.dominance import Lean, lean
from cordicc.rewrite.search.options import Alternatives

_SEED = 23
_WORK = (0.8, 0.25, 0.05, 0.1)
"""Deterministic times of the searches for each goal, the most important first."""

_PREFERENCE = 0.4
"""The same for the number of standard CAUs, where implicit ones are preferred."""

_START = 0.5
"""The same for the start, where latency comes first."""

_MULTIPLIERS = 1000
"""Multipliers that a CAU counts for in the start."""

_STEP = 64
"""Time is counted in 1/64 cycles, so that operations without a cycle still have an order."""

_LATEST = 40_000
"""Cycles."""


@dataclass(frozen=True, slots=True)
class Extraction:
    """The chosen option for each class that is needed, guards, and whether the choice is proven best."""

    provider: Mapping[int, int]
    guards: tuple[int, ...]
    proven: bool


@dataclass(frozen=True, slots=True)
class _Task:
    """What is to be extracted: CAUs and steps of time by option, besides the arguments of `extract`."""

    choice: Alternatives
    left: Lean
    requirements: Sequence[Requirement]
    costs: Costs
    units: Sequence[int]
    steps: Sequence[int]
    effort: float


@dataclass(slots=True)
class _ChoiceModel:
    """The variables of a model: options taken, classes needed, who provides, when, guards.

    Without times `time` holds the order of the classes that may depend on themselves.
    """

    model: Any
    taken: dict[int, Any]
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
    context: PassContext,
) -> Extraction | None:
    """Return the best choice found for the goal, None if none was found within the work limit.

    Goals are lexicographic: CAUs, multipliers of two variables, latency, other operators for
    `processors` and `fifo`; latency first for `latency`; area first for `area`.  Standard CAUs come
    before all of them where implicit ones are preferred.
    """
    units = [costs.caus(o.op, not zeros.isdisjoint(o.operands[:2])) for o in choice.options]
    steps = [costs.cycles(o.op, u) * _STEP + 1 for o, u in zip(choice.options, units, strict=True)]
    task = _Task(
        choice, lean(choice, requirements, costs, units), requirements, costs, units, steps, context.effort
    )
    goals = list(
        zip(ordered(context.goal, "processors", "multipliers", "latency", "area"), _WORK, strict=True)
    )
    if costs.preferred:
        goals.insert(0, ("standard", _PREFERENCE))
    before = [name for name, _ in goals].index("latency")
    counted = goals[:before] or [("start", _START)]
    answer, reached, proven = _solved(task, _build(task, timed=False), counted, None)
    if answer is None:
        return None
    timed = _build(task, timed=True)
    for (name, _), value in zip(goals[:before], reached, strict=False):
        timed.model.add(_expression(task, timed, name) <= value)
    if before and len(reached) < before:
        return Extraction(*answer, proven=False)
    better, _, best = _solved(task, timed, goals[before:], answer)
    return Extraction(*(better or answer), proven=best and (proven or not before))


_Answer = tuple[dict[int, int], tuple[int, ...]]


def _solved(
    task: _Task, built: _ChoiceModel, goals: Sequence[tuple[str, float]], start: _Answer | None
) -> tuple[_Answer | None, list[int], bool]:
    """Return the last answer found, the value of each goal that was met, and whether all are proven."""
    from ortools.sat.python import cp_model

    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.random_seed = _SEED
    # Linear relaxations of a model with times are weak, and probing finds little there.
    solver.parameters.linearization_level = 2 if built.finish is None else 0
    if built.finish is not None:
        solver.parameters.cp_model_probing_level = 0
    if start is not None:
        _start(task, built, start)
    answer, reached, proven = None, [], True
    for name, work in goals:
        expression = _expression(task, built, name)
        built.model.minimize(expression)
        solver.parameters.max_deterministic_time = work * task.effort
        status = solver.solve(built.model)
        optimal = status == cp_model.OPTIMAL
        proven = proven and optimal
        if not optimal and status != cp_model.FEASIBLE:
            break
        provider = {k: o for (k, o), used in built.provides.items() if solver.value(used)}
        answer = provider, tuple(i for i, used in enumerate(built.guards) if solver.value(used))
        reached.append(round(solver.objective_value))
        if len(reached) < len(goals):
            built.model.add(expression <= reached[-1])
            _hint(built, {v.index: solver.value(v) for v in _variables(built)})
    return answer, reached, proven


def _variables(built: _ChoiceModel) -> list[Any]:
    times = built.time.values() if built.finish is None else (*built.time.values(), built.finish)
    each = (*built.taken.values(), *built.needed.values(), *built.provides.values(), *built.guards, *times)
    return list({variable.index: variable for variable in each}.values())


def _hint(built: _ChoiceModel, values: Mapping[int, int]) -> None:
    """Start the next search from values of the variables by their numbers."""
    built.model.clear_hints()
    for variable in _variables(built):
        built.model.add_hint(variable, values[variable.index])


def _start(task: _Task, built: _ChoiceModel, answer: _Answer) -> None:
    """Start from what another model has found."""
    provider, guards = answer
    taken = set(provider.values())
    times: dict[int, int] = {}
    todo = list(provider)
    while todo:
        option = provider[todo[-1]]
        operands = task.choice.options[option].operands
        pending = [k for k in operands if k not in times]
        if not pending:
            k = todo.pop()
            times[k] = max((times[each] + task.steps[option] for each in operands), default=0)
        todo += pending
    values = {x.index: int(o in taken) for o, x in built.taken.items()}
    values |= {x.index: int(provider.get(k) == o) for (k, o), x in built.provides.items()}
    values |= {x.index: int(k in provider) for k, x in built.needed.items()}
    values |= {x.index: int(i in guards) for i, x in enumerate(built.guards)}
    values |= {x.index: times.get(k, 0) for k, x in built.time.items()}
    values[built.finish.index] = max(times[k] for k in task.choice.wanted.values())
    _hint(built, values)


def _build(task: _Task, *, timed: bool) -> _ChoiceModel:
    """Return the model, with the time of each class or only with what order it needs."""
    from ortools.sat.python import cp_model

    model, choice, providers = cp_model.CpModel(), task.choice, task.left.providers
    taken = {o: model.new_bool_var(f"x{o}") for o in task.left.options}
    needed = {k: model.new_bool_var(f"n{k}") for k in providers}
    circular = set(providers) if timed else _circular(choice, providers)
    horizon = min(sum(task.steps[o] for o in taken), _LATEST * _STEP) if timed else len(circular)
    earliest = _earliest(task) if timed else dict.fromkeys(circular, 0)
    time = {
        k: model.new_int_var(earliest.get(k, horizon), horizon, f"t{k}") for k in providers if k in circular
    }
    provides = {}
    for k, makers in providers.items():
        for o in makers:
            used = needed[k] if len(makers) == 1 else model.new_bool_var(f"p{k}_{o}")
            provides[k, o] = used
            model.add_implication(used, taken[o])
            for operand in dict.fromkeys(choice.options[o].operands):
                if k in time and operand in time:
                    later = time[operand] + (task.steps[o] if timed else 1)
                    model.add(time[k] >= later).only_enforce_if(used)
        if len(makers) != 1:
            model.add(sum(provides[k, o] for o in makers) == needed[k])
    for o, used in taken.items():
        for operand in dict.fromkeys(choice.options[o].operands):
            model.add_implication(used, needed[operand])
    for k in choice.wanted.values():
        model.add(needed[k] == 1)
    guards = []
    for requirement in task.requirements:
        guard = model.new_bool_var("guard")
        guards.append(guard)
        if requirement.subject is None:
            model.add(guard == 0)
        else:
            model.add_implication(guard, needed[requirement.subject])
        model.add_bool_or([guard, *(provides[pair] for pair in requirement.met_by if pair in provides)])
    finish = model.new_int_var(0, horizon, "finish") if timed else None
    for k in choice.wanted.values() if timed else ():
        model.add(finish >= time[k])
    return _ChoiceModel(model, taken, needed, provides, time, guards, finish)


def _earliest(task: _Task) -> dict[int, int]:
    """Return the time before which no choice has a class, for those that some choice has."""
    users: dict[int, list[int]] = {}
    missing: dict[int, int] = {}
    ready: list[tuple[int, int]] = []
    for o in task.left.options:
        operands = set(task.choice.options[o].operands)
        missing[o] = len(operands)
        for k in operands:
            users.setdefault(k, []).append(o)
        if not operands:
            ready.append((0, o))
    found: dict[int, int] = {}
    # Options in the order of the times at which they have their results, as Dijkstra does it.
    while ready:
        at, o = heappop(ready)
        for k in (k for result in task.choice.options[o].results for k in result if k not in found):
            found[k] = at
            for user in users.get(k, ()):
                missing[user] -= 1
                if not missing[user]:
                    heappush(ready, (at + task.steps[user], user))
    return found


def _circular(choice: Alternatives, providers: Mapping[int, Sequence[int]]) -> set[int]:
    """Return the classes that may depend on themselves, and those between them."""
    takes = {k: {x for o in makers for x in choice.options[o].operands} for k, makers in providers.items()}
    left = set(takes)
    while True:
        used = {x for k in left for x in takes[k]}
        inner = {k for k in left & used if not takes[k].isdisjoint(left)}
        if inner == left:
            return left
        left = inner


def _expression(task: _Task, built: _ChoiceModel, name: str) -> Any:
    """Return what a goal minimises."""
    options, units, costs = task.choice.options, task.units, task.costs
    taken = built.taken.items()
    processors = sum(units[o] * x for o, x in taken if units[o])
    multipliers = sum(x for o, x in taken if options[o].op == "mul")
    match name:
        case "processors":
            return processors
        case "multipliers":
            return multipliers
        case "standard":
            return sum(units[o] * x for o, x in taken if units[o] and options[o].op != "implicit")
        case "start":
            # Few CAUs and multipliers are a good start for every goal.
            return _MULTIPLIERS * processors + multipliers
        case "area":
            return sum(costs.size(options[o].op, units[o]) * x for o, x in taken) + sum(built.guards)
    return built.finish
