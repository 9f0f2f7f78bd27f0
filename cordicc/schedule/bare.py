"""Scheduling a bare graph: operations of kinds with latencies and limits, edges, nothing else.

The text of the graph is checked in full before any work, and its size is bounded.
"""

from __future__ import annotations

import itertools
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from cordicc.base.diagnostics import Diagnostic, Report, Source, Unattainable
from cordicc.schedule.binding import Binding, Delayed, Wiring, bind
from cordicc.schedule.solver.engine import Effort, solve
from cordicc.schedule.solver.goals import FIFO_WORDS, LATENCY, Goal
from cordicc.schedule.solver.scheduling_problem import (
    CyclicError,
    Schedule,
    SchedulingProblem,
    Task,
    TaskValue,
)

MAX_OPERATIONS = 200_000
MAX_EDGES = 1_000_000
MAX_KINDS = 1000
MAX_INTERVAL = 1_000_000
MAX_LATENCY = 100_000
MAX_ID = 256
_MAX_DIGITS = 18
_MOST_ERRORS = 20

_PREFIX = "op "
"""Before the ids in the problem, so that none of them is the one that stands for the outputs."""

_KEYS = {"initiation_interval", "minimize", "kinds", "operations", "edges"}
_MINIMIZE = ("latency", "fifo", "processors")


@dataclass(frozen=True, slots=True)
class BareGraph:
    """A graph and what is to be minimised first."""

    problem: SchedulingProblem
    minimize: str


def parse_graph(text: str, name: str) -> BareGraph:
    """Return the graph of a JSON text; `name` is how the user knows the file.

    Raises InvalidInput: not JSON or not of this form (E801), or a graph that makes no sense (E802).
    """
    report = Report(Source(name, ""))
    try:
        data = json.loads(
            text, parse_constant=_refused, parse_int=_integer, object_pairs_hook=_without_repeats
        )
    except (ValueError, RecursionError) as error:
        reason = (str(error) or type(error).__name__).splitlines()[0][:200]
        report.error("E801", f"not a graph: {reason}")
        data = None
    report.raise_if_failed()
    reader = _Reader(report)
    graph = reader.graph(data)
    report.raise_if_failed()
    assert graph is not None
    try:
        graph.problem.order()
    except CyclicError as error:
        shown = " -> ".join(id.removeprefix(_PREFIX) for id in error.ring)[:500]
        report.error("E802", f"operations depend on one another: {shown}")
    report.raise_if_failed()
    return graph


def schedule_graph(graph: BareGraph, effort: Effort) -> dict[str, Any]:
    """Return the answer as plain data: starts, units, latency, FIFO words, bounds.

    Raises Unattainable (E803) if a kind has fewer units than its operations need.
    """
    problem = graph.problem
    _check_limits(problem)
    schedule = solve(problem, _goals(graph), effort=effort)
    answer: dict[str, Any] = {
        "start": {id.removeprefix(_PREFIX): cycle for id, cycle in schedule.start.items()},
        "unit": _units(problem, schedule, effort.binding),
        "latency": schedule.latency,
        "fifo_words": schedule.fifo_words,
        "optimal": {name: schedule.optimal[name] for name in schedule.figures},
        "bounds": {name: schedule.bounds[name] for name in schedule.figures},
    }
    if schedule.struck:
        answer["time_limit_struck"] = True
    return answer


def _goals(graph: BareGraph) -> tuple[Goal, ...]:
    if graph.minimize == "fifo":
        return (FIFO_WORDS, LATENCY)
    if graph.minimize == "latency":
        return (LATENCY, FIFO_WORDS)
    return (Goal("processors", dict.fromkeys(graph.problem.counts(), 1)), LATENCY, FIFO_WORDS)


def _check_limits(problem: SchedulingProblem) -> None:
    findings = []
    busy = {task.kind: task.busy for task in problem.operations}
    for kind, count in problem.counts().items():
        if busy[kind] > problem.interval:
            message = (
                f"a unit of kind '{kind}' takes an operation every {busy[kind]} cycles, "
                f"which is beyond the interval {problem.interval}"
            )
            hint = f"the least that can be met is an initiation interval of {max(busy.values())}"
            findings.append(Diagnostic("E803", message, hint=hint))
            continue
        limit, least = problem.limits.get(kind, count), problem.fewest(kind)
        if limit < least:
            message = (
                f"{count} operations of kind '{kind}' need {least} units "
                f"at interval {problem.interval}, more than the limit {limit}"
            )
            hint = f"the least that can be met is a limit of {least}"
            if limit:
                hint += f", or an initiation interval of {-(-count // limit) * busy[kind]}"
            findings.append(Diagnostic("E803", message, hint=hint))
    if findings:
        raise Unattainable(findings[:_MOST_ERRORS])


def _units(problem: SchedulingProblem, schedule: Schedule, work: float) -> dict[str, str]:
    """Return the name of the unit of each operation, bound within some deterministic time."""
    finish = {task.id: schedule.start[task.id] + task.latency for task in problem.operations}
    drivers: dict[str, list[Delayed]] = {task.id: [] for task in problem.operations}
    for producer, taker in problem.edges():
        # A result that waits comes from the delay line of its value.
        drivers[taker].append(Delayed(producer, schedule.start[taker] - finish[producer]))
    wires = Wiring(
        {task.id: task.kind for task in problem.operations},
        {id: start % problem.interval for id, start in schedule.start.items()},
        {task.id: task.busy for task in problem.operations},
        problem.interval,
        {id: tuple(taken) for id, taken in drivers.items()},
    )
    binding = bind(wires, work)
    names = _unit_names(problem, binding)
    return {t.id.removeprefix(_PREFIX): names[t.kind, binding[t.id]] for t in problem.operations}


def _unit_names(problem: SchedulingProblem, binding: Binding) -> dict[tuple[str, int], str]:
    """Return the name of each unit, its kind and a number, by its kind and its place among those of the kind.

    Kinds that end in digits may make the name of a unit of another kind, as unit 0 of `k1` does that of unit
    10 of `k`: the kind that comes later leaves such a number out.
    """
    units: dict[str, set[int]] = {}
    for task in problem.operations:
        units.setdefault(task.kind, set()).add(binding[task.id])
    names: dict[tuple[str, int], str] = {}
    taken: set[str] = set()
    for kind, places in units.items():
        free = (name for name in (f"{kind}{number}" for number in itertools.count()) if name not in taken)
        mine = {(kind, place): name for place, name in zip(sorted(places), free, strict=False)}
        names |= mine
        taken.update(mine.values())
    return names


def _refused(text: str) -> float:
    raise ValueError(f"{text} is not a number of JSON")


def _integer(text: str) -> int:
    if len(text) > _MAX_DIGITS:
        raise ValueError(f"the integer {text[:_MAX_DIGITS]}... is too large")
    return int(text)


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        repeated = next(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        raise ValueError(f"the key '{repeated[:40]}' occurs twice")
    return found


def _shown(value: object) -> str:
    text = json.dumps(value, ensure_ascii=True)
    return text if len(text) <= 60 else f"{text[:60]}..."


class _Reader:
    """Reads the data of a graph, recording what is wrong."""

    def __init__(self, report: Report) -> None:
        self._report = report

    def graph(self, data: Any) -> BareGraph | None:
        if not isinstance(data, dict):
            self._error("E801", "not a graph: the top level must be an object")
            return None
        for key in sorted(data.keys() - _KEYS):
            self._error("E801", f"unknown key {_shown(key)}")
        for key in ("kinds", "operations", "edges"):
            if key not in data:
                self._error("E801", f"the key '{key}' is missing")
        interval = self._number(data.get("initiation_interval", 1), "initiation_interval", 1, MAX_INTERVAL)
        minimize = data.get("minimize", "latency")
        if minimize not in _MINIMIZE:
            self._error("E801", f"minimize is {_shown(minimize)}, not one of {', '.join(_MINIMIZE)}")
        known, limits = self._kinds(data.get("kinds", {}))
        kinds = self._operations(data.get("operations", []), known)
        edges = self._edges(data.get("edges", []), kinds)
        if self._report.failed:
            return None
        return BareGraph(_problem(interval, known, limits, kinds, edges), minimize)

    def _kinds(self, data: Any) -> tuple[dict[str, tuple[int, int]], dict[str, int]]:
        """Return latency and interval of each kind, and limits."""
        found: dict[str, tuple[int, int]] = {}
        limits: dict[str, int] = {}
        if not isinstance(data, dict) or len(data) > MAX_KINDS:
            self._error("E801", f"kinds must be an object of at most {MAX_KINDS} kinds")
            return found, limits
        for kind, item in data.items():
            where = f"kinds.{kind[:40]}"
            if not self._name(kind, f"the name of {where}"):
                continue
            unknown = isinstance(item, dict) and item.keys() - {"latency", "initiation_interval", "limit"}
            if not isinstance(item, dict) or unknown or "latency" not in item:
                wanted = "'latency' and perhaps 'initiation_interval' and 'limit'"
                self._error("E801", f"{where} must be an object with {wanted}")
                continue
            own = item.get("initiation_interval", 1)
            found[kind] = (
                self._number(item["latency"], f"{where}.latency", 0, MAX_LATENCY),
                self._number(own, f"{where}.initiation_interval", 1, MAX_LATENCY),
            )
            if item.get("limit") is not None:
                limits[kind] = self._number(item["limit"], f"{where}.limit", 0, MAX_OPERATIONS)
        return found, limits

    def _operations(self, data: Any, known: Mapping[str, Any]) -> dict[str, str]:
        kinds: dict[str, str] = {}
        if not isinstance(data, list) or len(data) > MAX_OPERATIONS:
            self._error("E801", f"operations must be a list of at most {MAX_OPERATIONS}")
            return kinds
        for position, item in enumerate(data):
            where = f"operations[{position}]"
            if not isinstance(item, dict) or item.keys() != {"id", "kind"}:
                self._error("E801", f"{where} must be an object with 'id' and 'kind'")
                continue
            id, kind = item["id"], item["kind"]
            if not self._name(id, f"{where}.id"):
                continue
            if id in kinds:
                self._error("E802", f"{where}: the id '{id}' occurs twice")
            if not isinstance(kind, str) or kind not in known:
                self._error("E802", f"{where}: unknown kind {_shown(kind)}")
                continue
            kinds[id] = kind
        return kinds

    def _edges(self, data: Any, known: Mapping[str, str]) -> list[tuple[str, str]]:
        edges: list[tuple[str, str]] = []
        if not isinstance(data, list) or len(data) > MAX_EDGES:
            self._error("E801", f"edges must be a list of at most {MAX_EDGES}")
            return edges
        for position, item in enumerate(data):
            where = f"edges[{position}]"
            if not isinstance(item, list) or len(item) != 2 or not all(isinstance(end, str) for end in item):
                self._error("E801", f"{where} must be a list of two ids")
                continue
            unknown = [end for end in item if end not in known]
            for end in unknown:
                self._error("E802", f"{where}: unknown operation {_shown(end)}")
            if not unknown:
                edges.append((item[0], item[1]))
        return edges

    def _name(self, value: Any, where: str) -> bool:
        good = isinstance(value, str) and 0 < len(value) <= MAX_ID and value.isprintable()
        if not good:
            self._error("E801", f"{where} must be printable text of 1 to {MAX_ID} characters")
        return good

    def _number(self, value: Any, where: str, least: int, most: int) -> int:
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            self._error("E801", f"{where} is {_shown(value)}, not an integer from {least} to {most}")
            return least
        return value

    def _error(self, code: str, message: str) -> None:
        if self._report.errors < _MOST_ERRORS:
            self._report.error(code, message)


def _problem(
    interval: int,
    known: Mapping[str, tuple[int, int]],
    limits: Mapping[str, int],
    kinds: Mapping[str, str],
    edges: Iterable[tuple[str, str]],
) -> SchedulingProblem:
    """Return the problem; each operation has one result, and a port for each edge that ends in it."""
    takers: dict[str, list[tuple[str, str]]] = {_PREFIX + id: [] for id in kinds}
    ports: Counter[str] = Counter()
    for producer, taker in edges:
        takers[_PREFIX + producer].append((_PREFIX + taker, str(ports[taker])))
        ports[taker] += 1
    tasks = tuple(Task(_PREFIX + id, kind, *known[kind]) for id, kind in kinds.items())
    values = tuple(TaskValue(id, id, tuple(sinks)) for id, sinks in takers.items())
    return SchedulingProblem(tasks, values, interval, dict(limits), "cycles")
