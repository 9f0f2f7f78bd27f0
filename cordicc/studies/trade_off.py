"""The trade-off of processors, latency, initiation interval and FIFO words of a problem."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path

from cordicc.backends.pictures.pareto_plot import Mark
from cordicc.backends.report.page import Explored
from cordicc.base.diagnostics import CordiccError, Diagnostic, Unattainable
from cordicc.base.text_tables import Sheet, Table
from cordicc.ir.graph import Graph
from cordicc.ir.text import print_graph
from cordicc.pipeline import Options, plan_file
from cordicc.plan.copies import replicated
from cordicc.plan.model import Plan
from cordicc.plan.verify import verify
from cordicc.schedule.place import place, scheduling_problem
from cordicc.schedule.request import Limits
from cordicc.schedule.solver.engine import Effort
from cordicc.studies.cluster import executor as executor_of
from cordicc.studies.processes import process_pool
from cordicc.targets.target import CAU_KINDS
from cordicc.targets.target_file import load_target

INTERVALS = (1, 2, 4, 8, 16)
"""Multiples of the shortest interval that the units of the target keep."""

_SPARE = 100
"""Operations of one unit for which there is time in the plan from which the points are made."""
MOST_POINTS = 30
_EFFORT = Effort(schedule=4.0, words=0.03, binding=0.0, threads=1)
"""FIFO words of large problems stay with a small gap, to prove all of them would take minutes; and the
figures do not depend on the multiplexers."""

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Point:
    """A verified plan: its figures, proven lower bounds, and the options of `cordicc compile` for it."""

    units: str
    initiation_interval: int
    max_processors: int
    processors: int
    latency: int
    fifo_words: int
    unit_counts: dict[str, int]
    bounds: dict[str, int]
    optimal: dict[str, bool]

    def figures(self) -> tuple[int, int, int, int]:
        """Return what the front weighs against each other."""
        return self.initiation_interval, self.processors, self.latency, self.fifo_words

    def mark(self) -> Mark:
        """Return the point as it is plotted."""
        counts = ", ".join(f"{count} {kind}" for kind, count in self.unit_counts.items())
        figures = (self.processors, self.latency, self.initiation_interval, self.fifo_words)
        return Mark(*figures, counts, _certificate(self))


@dataclass(frozen=True, slots=True)
class Front:
    """The points of a problem that no other point beats, and how many were looked at."""

    name: str
    title: str
    target: str
    copies: int
    points: tuple[Point, ...]
    tried: int
    program: Graph
    """The equations as written, to recognise plans of the same problem."""

    def plot(self) -> Explored:
        """Return what is plotted."""
        return Explored(self.title, [point.mark() for point in self.points])

    def is_of(self, plan: Plan) -> bool:
        """Tell whether a plan is of the same problem, target and copies."""
        same = Path(plan.options.target).stem == self.target
        same = same and plan.options.copies == self.copies
        # Their texts, since the equation that a node comes from takes no part in the equality of graphs.
        return same and print_graph(plan.problem.program) == print_graph(self.program)


def workers(jobs: int | None, cluster: str | None) -> Executor:
    """Return what runs the points: processes, by default one a core, or a Dask cluster.

    Raises InvalidInput (E721) if the cluster cannot be used.
    """
    if cluster is not None:
        return executor_of(cluster)
    count = jobs or os.cpu_count() or 1
    pool = process_pool(count, _load)
    for _ in range(count):
        pool.submit(_load)  # they start while the problem is being compiled
    return pool


def explore(
    path: Path, target: str, units: str, copies: int, executor: Executor, progress: Progress
) -> Front:
    """Return the front of a problem, for `copies` instances that share the units.

    Args:
        path: the problem file.
        target: a shipped target or a file.
        units: as `--units` of `compile`; `auto` looks at implicit and at standard CAUs.
        copies: instances of the problem, one of each enters every interval.
        executor: runs the points.
        progress: called with the points done and all points.

    Raises:
        InvalidInput: the file, the target or an option is invalid.
        Unattainable: no number format that holds a value.
    """
    busy = max(unit.initiation_interval for unit in load_target(target).units.values())
    with executor:
        # Units that are busy are so for about as long, whatever the plan's guard bits make of them.
        bases = _bases(path, target, units, copies, busy if busy == 1 else _SPARE * busy, executor)
        shortest = max(
            unit.initiation_interval for base in bases.values() for unit in base.target.units.values()
        )
        tasks: dict[Future[list[Point]], int] = {}
        # The longest first: shared units take most, and those of long intervals are shared most.
        for interval in (shortest * times for times in reversed(INTERVALS)):
            for choice, base in bases.items():
                counts = _counts(base, interval, MOST_POINTS // len(bases))
                tasks[executor.submit(_points, base, choice, interval, counts)] = len(counts)
        done, every = 0, sum(tasks.values())
        for task in as_completed(tasks):
            done += tasks[task]
            progress(done, every)
        found = [point for task in tasks for point in task.result()]
    first = next(iter(bases.values()))
    name, program = first.name, first.problem.program
    title = f"Trade-off of {name}" + (f", {copies} copies" if copies > 1 else "")
    return Front(name, title, Path(target).stem, copies, _front(found), len(found), program)


def _load() -> None:
    """Load in a worker what solving takes, before there is anything to solve."""
    import_module("ortools.sat.python.cp_model")


def _bases(
    path: Path, target: str, units: str, copies: int, interval: int, executor: Executor
) -> dict[str, Plan]:
    """Return a plan for each choice of CAUs that makes a difference."""
    choices: tuple[str, ...] = (units,)
    if units == "auto" and load_target(target).has_implicit:
        choices = ("implicit", "standard")
    if len(choices) > 1 and isinstance(executor, ProcessPoolExecutor):
        # A worker of a cluster may not have the file.
        asked = [executor.submit(_plan, path, target, choice, interval) for choice in choices]
        made = [task.result() for task in asked]
    else:
        made = [_plan(path, target, choice, interval) for choice in choices]
    plans = [_plan_or_raise(each) for each in made]
    bases = {choice: replicated(plan, copies) for choice, plan in zip(choices, plans, strict=True)}
    if all(plan.operations == plans[0].operations for plan in plans):
        return {units: bases[choices[0]]}
    return bases


_Failure = tuple[type[CordiccError], tuple[Diagnostic, ...]]
"""An error as it travels between processes."""


def _plan(path: Path, target: str, units: str, interval: int) -> Plan | _Failure:
    try:
        return plan_file(path, Options(target, units, Limits(initiation_interval=interval))).plan
    except Unattainable as error:
        # Those of its kinds that say more are made of other things than findings.
        return Unattainable, error.diagnostics
    except CordiccError as error:
        return type(error), error.diagnostics


def _plan_or_raise(made: Plan | _Failure) -> Plan:
    if isinstance(made, Plan):
        return made
    kind, diagnostics = made
    raise kind(diagnostics)


def _counts(plan: Plan, interval: int, most: int) -> list[int]:
    """Return numbers of CAUs to look at, from the fewest to one for each operation; `most` in all."""
    problem = scheduling_problem(plan, interval)
    full = sum(count for kind, count in problem.counts().items() if kind in CAU_KINDS)
    least = sum(problem.fewest(kind) for kind in CAU_KINDS)
    share = max(1, (most - 1) // (len(INTERVALS) - 1))
    steps = min(share, full - least + 1)
    # The first additional units shorten the latency most, so the steps grow.
    return sorted({least + (full - least) * k * k // max(1, (steps - 1) ** 2) for k in range(steps)})


def _points(base: Plan, units: str, interval: int, counts: Sequence[int]) -> list[Point]:
    """Return a point for each number of CAUs, until more of them cannot shorten the latency."""
    points: list[Point] = []
    for processors in counts:
        plan = place(base, Limits("latency", interval, processors, None, _EFFORT))
        verify(plan)
        points.append(
            Point(
                units,
                interval,
                processors,
                plan.processors()["total"],
                plan.latency_cycles,
                plan.fifo_words,
                plan.units_by_kind(),
                dict(plan.bounds),
                dict(plan.optimal),
            )
        )
        # The fewest CAUs for the least latency there is: all that follow would be this point again.
        if plan.latency_cycles == scheduling_problem(base, interval).earliest().latency:
            break
    return points


def _front(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points that no other is at least as good as in all figures, without repeats."""
    first: dict[tuple[int, ...], Point] = {}
    for point in points:
        first.setdefault(point.figures(), point)
    kept = [
        point
        for point in first.values()
        if not any(
            other is not point and all(a <= b for a, b in zip(other.figures(), point.figures(), strict=True))
            for other in first.values()
        )
    ]
    return tuple(sorted(kept, key=Point.figures))


def _certificate(point: Point) -> str:
    """Say what is proven, and the gap of what is not."""
    figures = {
        "CAUs": ("processors", point.processors),
        "latency": ("latency", point.latency),
        "FIFO words": ("fifo_words", point.fifo_words),
    }
    open_figures = [
        f"{label} >= {point.bounds[name]}" for label, (name, _) in figures.items() if not point.optimal[name]
    ]
    return ", ".join(open_figures) or "proven"


def as_json(front: Front) -> str:
    """Return the front as one JSON object."""
    data = {
        "name": front.name,
        "target": front.target,
        "copies": front.copies,
        "tried": front.tried,
        "points": [asdict(point) for point in front.points],
    }
    return json.dumps(data, indent=2, sort_keys=True) + "\n"


def as_sheet(front: Front) -> Sheet:
    """Return the front as a table."""
    header = (
        "interval",
        "CAUs",
        "standard",
        "implicit",
        "mul",
        "latency",
        "FIFO words",
        "units",
        "certificate",
    )
    rows = []
    for point in front.points:
        counts = [str(point.unit_counts.get(kind, 0)) for kind in (*CAU_KINDS, "mul")]
        figures = (str(point.latency), str(point.fifo_words), point.units, _certificate(point))
        rows.append((str(point.initiation_interval), str(point.processors), *counts, *figures))
    head = f"{front.name} on {front.target}: {len(front.points)} of {front.tried} points are unbeaten"
    again = "All with the operations of fewest CAUs; for a point, perhaps quicker by other operations,\n"
    again += "'cordicc compile --ii INTERVAL --max-processors CAUs --minimize latency --units UNITS"
    again += f" --copies {front.copies}'." if front.copies > 1 else "'."
    return Sheet(head, (Table(header, tuple(rows), indent=0), again))
