"""The trade-off of processors, latency, initiation interval and FIFO words of a problem."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path

from cordicc.backends.front import Mark
from cordicc.diagnostics import Diagnostic, InvalidInput
from cordicc.pipeline import Options, plan_file
from cordicc.plan import Operand, Plan
from cordicc.schedule.engine import Effort
from cordicc.schedule.place import place
from cordicc.schedule.request import Limits
from cordicc.schedule.verify import verify
from cordicc.targets.model import CAU_KINDS

INTERVALS = (1, 2, 4, 8, 16)
MOST_POINTS = 30
_EFFORT = Effort(schedule=4.0, words=0.05)
"""FIFO words of large problems stay with a small gap; to prove all of them would take minutes."""

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
        tip = (
            f"interval {self.initiation_interval}, latency {self.latency}, {self.fifo_words} FIFO words\n"
            f"{counts}\n{_certificate(self)}"
        )
        return Mark(self.processors, self.latency, self.initiation_interval, self.fifo_words, tip)


@dataclass(frozen=True, slots=True)
class Front:
    """The points of a problem that no other point beats, and how many were looked at."""

    name: str
    title: str
    target: str
    copies: int
    points: tuple[Point, ...]
    tried: int


def workers(jobs: int | None, cluster: str | None) -> Executor:
    """Return what runs the points: processes, by default one a core, or a Dask cluster.

    Raises InvalidInput (E804) if there is no such cluster, or the package `distributed` is missing.
    """
    if cluster is None:
        return ProcessPoolExecutor(jobs or os.cpu_count() or 1, get_context("spawn"))
    try:
        from distributed import Client

        executor: Executor = Client(cluster, timeout=10).get_executor()
    except ImportError:
        hint = "pip install 'cordicc[cluster]'"
        raise InvalidInput([Diagnostic("E804", "--cluster needs Dask", hint=hint)]) from None
    except (OSError, ValueError) as error:
        raise InvalidInput([Diagnostic("E804", f"cannot reach the cluster '{cluster}': {error}")]) from None
    return executor


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
    bases = _bases(path, target, units, copies)
    with executor:
        tasks = [
            executor.submit(_point, base, choice, interval, processors)
            for choice, base in bases.items()
            for interval, processors in _choices(base, MOST_POINTS // len(bases))
        ]
        done: list[Future[Point]] = []
        for task in as_completed(tasks):
            done.append(task)
            progress(len(done), len(tasks))
        found = [task.result() for task in tasks]
    name = next(iter(bases.values())).name
    title = f"Trade-off of {name}" + (f", {copies} copies" if copies > 1 else "")
    return Front(name, title, Path(target).stem, copies, _front(found), len(found))


def _bases(path: Path, target: str, units: str, copies: int) -> dict[str, Plan]:
    """Return a plan for each choice of CAUs that makes a difference."""
    bases = {units: plan_file(path, Options(target, units)).plan}
    if units == "auto":
        standard = plan_file(path, Options(target, "standard")).plan
        if standard.operations != bases["auto"].operations:
            bases["standard"] = standard
    return {choice: replicated(plan, copies) for choice, plan in bases.items()}


def replicated(plan: Plan, copies: int) -> Plan:
    """Return a plan with several instances of all operations; it has yet to be placed."""

    def of_copy(name: str, copy: int) -> str:
        return f"{name.partition('.')[0]}#{copy}{''.join(name.partition('.')[1:])}" if copy else name

    def operand(item: Operand, copy: int) -> Operand:
        return item if item.value is None else Operand(of_copy(item.value, copy))

    every = range(copies)
    operations = tuple(
        replace(
            o,
            id=of_copy(o.id, copy),
            operands=tuple(operand(item, copy) for item in o.operands),
            results=tuple(None if name is None else of_copy(name, copy) for name in o.results),
        )
        for copy in every
        for o in plan.operations
    )
    inputs = [{**item, "name": of_copy(item["name"], c)} for c in every for item in plan.problem["inputs"]]
    formats = {of_copy(name, c): spec for c in every for name, spec in plan.formats.values.items()}
    return replace(
        plan,
        operations=operations,
        outputs={of_copy(name, c): operand(item, c) for c in every for name, item in plan.outputs.items()},
        problem={**plan.problem, "inputs": inputs},
        formats=replace(plan.formats, values=formats),
    )


def _choices(plan: Plan, most: int) -> list[tuple[int, int]]:
    """Return intervals with numbers of CAUs, from the fewest to one for each operation."""
    counts = [sum(o.kind == kind for o in plan.operations) for kind in CAU_KINDS]
    share = max(1, (most - 1) // (len(INTERVALS) - 1))
    chosen = [(INTERVALS[0], sum(counts))]
    for interval in INTERVALS[1:]:
        least, full = sum(-(-count // interval) for count in counts), sum(counts)
        steps = min(share, full - least + 1)
        # The first additional units shorten the latency most, so the steps grow.
        spread = {least + (full - least) * k * k // max(1, (steps - 1) ** 2) for k in range(steps)}
        chosen += [(interval, number) for number in sorted(spread)]
    return chosen


def _point(base: Plan, units: str, interval: int, processors: int) -> Point:
    limits = Limits("latency", interval, processors, None, _EFFORT)
    plan = place(base, limits)
    verify(plan)
    return Point(
        units, interval, processors, plan.processors()["total"], plan.latency_cycles, plan.fifo_words,
        plan.units_by_kind(), dict(plan.bounds), dict(plan.optimal),
    )  # fmt: skip


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


def as_text(front: Front) -> str:
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
    rows: list[tuple[str, ...]] = [header]
    for point in front.points:
        counts = [str(point.unit_counts.get(kind, 0)) for kind in (*CAU_KINDS, "mul")]
        figures = (str(point.latency), str(point.fifo_words), point.units, _certificate(point))
        rows.append((str(point.initiation_interval), str(point.processors), *counts, *figures))
    widths = [max(len(row[i]) for row in rows) for i in range(len(header))]
    lines = [
        "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    head = f"{front.name} on {front.target}: {len(front.points)} of {front.tried} points are unbeaten"
    again = "Each is 'cordicc compile --ii INTERVAL --max-processors CAUs --minimize latency --units UNITS'."
    return "\n".join([head, *lines, *([again] if front.copies == 1 else [])]) + "\n"
