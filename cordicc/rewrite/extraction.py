"""The cheapest set of operations that yields the outputs, by constraint programming (CP-SAT)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cordicc.rewrite.conditions import Requirement
from cordicc.rewrite.costs import Costs, ordered
from cordicc.rewrite.options import Alternatives

_SEED = 1
_WORK = {"standard": 0.4, "processors": 0.8, "multipliers": 0.8, "latency": 0.3, "area": 0.3}
"""Deterministic time of the solver for each figure that is minimised."""

_STEP = 64
"""Time is counted in 1/64 cycles, so that operations without a cycle still have an order."""


@dataclass(frozen=True, slots=True)
class Extraction:
    """The chosen option for each class that is needed, guards, and whether the choice is proven best."""

    provider: Mapping[int, int]
    guards: tuple[int, ...]
    proven: bool


@dataclass(frozen=True, slots=True)
class _Task:
    """What is chosen from: options with the CAUs they take, conditions to be met, and the costs."""

    choice: Alternatives
    requirements: Sequence[Requirement]
    units: Sequence[int]
    costs: Costs

    def ticks(self, option: int) -> int:
        """Return the latency of an option in steps of `_STEP`."""
        return self.costs.cycles(self.choice.options[option].op, self.units[option]) * _STEP + 1


@dataclass(slots=True)
class _Model:
    """The variables of a model: options taken, classes needed, who provides, guards; when, if it is timed."""

    model: Any
    taken: list[Any]
    needed: dict[int, Any]
    provides: dict[tuple[int, int], Any]
    guards: list[Any]
    time: dict[int, Any]
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
    task = _Task(choice, requirements, units, costs)
    figures = ordered(goal, "processors", "multipliers", "latency", "area")
    figures = ("standard", *figures) if costs.preferred else figures
    timed = figures.index("latency")
    search = _Search(cp_model, task)
    if timed == 0 or figures[0] == "area":
        # Few CAUs and multipliers are a good start for every goal.
        search.start(("processors", "multipliers"))
    search.minimise(figures[:timed], timed=False)
    search.minimise(figures[timed:], timed=True)
    if search.answer is None:
        return None
    return Extraction(search.answer[0], search.answer[1], search.proven)


class _Search:
    """Minimises one figure after the other, each from the last solution and without giving back."""

    def __init__(self, cp_model: Any, task: _Task) -> None:
        self._cp_model, self._task = cp_model, task
        self._reached: dict[str, int] = {}
        self.proven = True
        self.answer: tuple[dict[int, int], tuple[int, ...]] | None = None

    def start(self, figures: Sequence[str]) -> None:
        """Find a solution with small figures, without holding on to them."""
        self.minimise(figures, timed=False)
        self._reached.clear()
        self.proven = True

    def minimise(self, figures: Sequence[str], *, timed: bool) -> None:
        """Minimise figures in their order; of a model with or without times."""
        if not figures:
            return
        built = _build(self._cp_model, self._task, timed=timed)
        for figure, reached in self._reached.items():
            built.model.add(_figure(self._task, built, figure) <= reached)
        for figure in figures:
            if not self._minimise(built, figure):
                self.proven = False
                return

    def _minimise(self, built: _Model, figure: str) -> bool:
        """Minimise a figure; tell whether there is a solution."""
        solver = self._cp_model.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.random_seed = _SEED
        solver.parameters.max_deterministic_time = _WORK[figure]
        if self.answer is not None:
            _hint(built, self._task, *self.answer)
        expression = _figure(self._task, built, figure)
        built.model.minimize(expression)
        status = solver.solve(built.model)
        if status not in (self._cp_model.OPTIMAL, self._cp_model.FEASIBLE):
            return False
        self.proven = self.proven and status == self._cp_model.OPTIMAL
        provider = {k: o for (k, o), used in built.provides.items() if solver.value(used)}
        guards = tuple(i for i, used in enumerate(built.guards) if solver.value(used))
        self.answer = provider, guards
        self._reached[figure] = round(solver.objective_value)
        built.model.add(expression <= self._reached[figure])
        return True


def _hint(built: _Model, task: _Task, provider: Mapping[int, int], guards: Sequence[int]) -> None:
    """Start the next search from a solution."""
    model, chosen, kept = built.model, set(provider.values()), set(guards)
    model.clear_hints()
    for option, variable in enumerate(built.taken):
        model.add_hint(variable, option in chosen)
    for k, variable in built.needed.items():
        model.add_hint(variable, k in provider)
    for (k, option), variable in built.provides.items():
        model.add_hint(variable, provider.get(k) == option)
    for index, variable in enumerate(built.guards):
        model.add_hint(variable, index in kept)
    if built.finish is not None:
        times = _times(task, provider)
        for k, variable in built.time.items():
            model.add_hint(variable, times.get(k, 0))
        model.add_hint(built.finish, max(times[k] for k in task.choice.wanted.values()))


def _times(task: _Task, provider: Mapping[int, int]) -> dict[int, int]:
    """Return when each class of a solution is there."""
    times: dict[int, int] = {}
    for wanted in task.choice.wanted.values():
        todo = [wanted]
        while todo:
            k = todo[-1]
            option = provider[k]
            operands = task.choice.options[option].operands
            pending = [operand for operand in operands if operand not in times]
            if k in times or not pending:
                times[k] = max((times[operand] for operand in operands), default=0) + task.ticks(option)
                todo.pop()
            else:
                todo += pending
    return times


def _build(cp_model: Any, task: _Task, *, timed: bool) -> _Model:
    choice, model = task.choice, cp_model.CpModel()
    taken = [model.new_bool_var(f"x{i}") for i in range(len(choice.options))]
    needed = {k: model.new_bool_var(f"n{k}") for k in choice.providers}
    provides = {}
    for k, makers in choice.providers.items():
        for o in makers:
            provides[k, o] = used = model.new_bool_var(f"p{k}_{o}")
            model.add_implication(used, taken[o])
        model.add(sum(provides[k, o] for o in makers) == needed[k])
    for o, option in enumerate(choice.options):
        for operand in set(option.operands):
            model.add_implication(taken[o], needed[operand])
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
    built = _Model(model, taken, needed, provides, guards, {}, None)
    if timed:
        _add_times(built, task)
    else:
        _add_orders(built, choice)
    return built


def _add_times(built: _Model, task: _Task) -> None:
    """Add the time at which each class is there, and that of the last output."""
    model, choice = built.model, task.choice
    horizon = min(sum(task.ticks(o) for o in range(len(choice.options))), 40_000 * _STEP)
    built.time = time = {k: model.new_int_var(0, horizon, f"t{k}") for k in choice.providers}
    for (k, o), used in built.provides.items():
        for operand in choice.options[o].operands:
            model.add(time[k] >= time[operand] + task.ticks(o)).only_enforce_if(used)
    built.finish = model.new_int_var(0, horizon, "finish")
    for k in choice.wanted.values():
        model.add(built.finish >= time[k])


def _add_orders(built: _Model, choice: Alternatives) -> None:
    """Keep operations from feeding each other in a circle: an order of the classes within each component."""
    for component in _components(choice):
        order = {k: built.model.new_int_var(0, len(component), f"o{k}") for k in component}
        for k in component:
            for o in choice.providers[k]:
                for operand in set(choice.options[o].operands) & order.keys():
                    before = order[k] >= order[operand] + 1
                    built.model.add(before).only_enforce_if(built.provides[k, o])


def _components(choice: Alternatives) -> list[list[int]]:
    """Return the strongly connected classes, where one may be made from another and the other from it."""
    import networkx

    graph = networkx.DiGraph()
    for k, makers in choice.providers.items():
        graph.add_edges_from((k, operand) for o in makers for operand in choice.options[o].operands)
    found = [sorted(component) for component in networkx.strongly_connected_components(graph)]
    loops = {k for k in graph if graph.has_edge(k, k)}
    return sorted(each for each in found if len(each) > 1 or each[0] in loops)


def _figure(task: _Task, built: _Model, figure: str) -> Any:
    """Return what is minimised as an expression of the model's variables."""
    pairs = list(zip(built.taken, task.choice.options, task.units, strict=True))
    match figure:
        case "standard":
            return sum(u * x for x, o, u in pairs if u and o.op != "implicit")
        case "processors":
            return sum(u * x for x, _, u in pairs if u)
        case "multipliers":
            return sum(x for x, o, _ in pairs if o.op == "mul")
        case "area":
            return sum(task.costs.size(o.op, u) * x for x, o, u in pairs) + sum(built.guards)
    return built.finish
