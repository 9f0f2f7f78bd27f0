"""Proven bounds beside the errors that are found: the corpus on a fixed-point target.

For every output: the bound; the largest error of random samples inside its conditions and of a search that
tries to make it large; their ratio; the share of the corpus samples, and of random ones, that are inside.

The reference for many samples is the interval evaluation of the plan's exact operations in binary64, whose
width is its own error bound; an error counts by the nearest end, so it is certain.  The first 10,000 samples,
and the worst of the random ones and of those searched, are evaluated again from the equations as written,
with 113 bits.  Fails if an error is beyond its bound, fewer than 99 % of the corpus samples of an output are
inside, an output has no bound, or the median ratio of all is above 10.

    python benchmarks/certified.py [--samples N] [--target NAME] [NAME ...]
"""

from __future__ import annotations

import argparse
import csv
import math
import statistics
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.compiled.compiled_cau import available, compiled_arithmetic
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.certify.boxes import Boxes
from cordicc.certify.certificate import Bound
from cordicc.certify.error_network import ErrorNetwork, Step, network
from cordicc.certify.own_bounds import inside
from cordicc.certify.plans import bounds_of
from cordicc.certify.predicates import meets
from cordicc.certify.sweep import errors, forward
from cordicc.emulate import functional
from cordicc.emulate.climb import climb, climbing
from cordicc.emulate.observation import exact
from cordicc.ir import sampling
from cordicc.ir.meaning.intervals import Interval
from cordicc.pipeline import Options, plan_file
from cordicc.plan.model import Plan
from cordicc.targets.target import CAU_KINDS

CORPUS = Path(__file__).resolve().parents[1] / "tests" / "whole" / "corpus"
LEAST_SHARE = 0.99
MOST_RATIO = 10.0
BLOCK = 8192
CLIMBERS, ROUNDS = 128, 60
FIRST_ROWS, WORST_ROWS = 10_000, 200
"""Samples evaluated with 113 bits."""

COMPILED_FROM = 2_000_000
"""Unit operations from which compiled units are loaded."""

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]


@dataclass(frozen=True, slots=True)
class Run:
    """A plan, its network, its bounds and the arithmetic that runs it."""

    plan: Plan
    net: ErrorNetwork
    bounds: Mapping[str, Bound]
    machine: Arithmetic


def apart(error: Floats, angle: bool) -> Floats:
    """Return |error|, of angles modulo 2 pi."""
    size = np.abs(error)
    return np.minimum(np.mod(size, math.tau), math.tau - np.mod(size, math.tau)) if angle else size


def simulated(run: Run, points: Columns) -> dict[str, Floats]:
    return functional.run(run.plan, run.machine, points)


def found(
    run: Run, outputs: Sequence[str], steps: Sequence[Step], points: Columns, results: Columns
) -> dict[str, tuple[Floats, float]]:
    """Return by output what the errors are at least, -inf for samples that do not count, and the reference's.

    `steps` are those upstream of the outputs, `results` what the plan gives for the points.
    """
    boxes = {name: Boxes(points[name], points[name]) for name in run.net.inputs}
    made = forward(run.net, steps, boxes, {}, exact=True)
    moved = forward(run.net, steps, boxes, {}) if any(run.bounds[o].where for o in outputs) else made
    certain = {}
    for output in outputs:
        box, _ = made.operand(run.net.outputs[output])
        width = (box.hi - box.lo) / 2
        error = apart(results[output] - (box.lo + width), run.net.angles[output]) - width
        where = run.bounds[output].where
        held = meets(run.net, output, where, moved) if where else ~moved.empty(run.net.upstream(output))
        own = float(np.nanmax(np.where(np.isfinite(width), width, 0.0)))
        certain[output] = (
            np.where(results["valid"].astype(bool) & held & ~np.isnan(error), error, -np.inf),
            own,
        )
    return certain


def searched(run: Run, output: str, start: Columns) -> tuple[dict[str, Floats], Floats]:
    """Return points where the error is large: first the sample's own bound climbs, then the error."""
    steps = run.net.upstream(output)
    limit = run.bounds[output]

    def own(points: Columns) -> Floats:
        boxes = {name: Boxes(points[name], points[name]) for name in run.net.inputs}
        bound = errors(run.net, steps, output, forward(run.net, steps, boxes, {}))
        held = inside(run.net, {output: limit.where}, points)[output]
        return np.where(np.isfinite(bound) & held, bound, -np.inf)

    def error(points: Columns) -> Floats:
        return found(run, [output], steps, points, simulated(run, points))[output][0]

    ranges = {name: Interval(each.lo, each.hi) for name, each in run.net.inputs.items()}
    high, _ = climb(climbing(ranges, start, climbers=CLIMBERS, rounds=ROUNDS, seed=3), own)
    mixed = {name: np.concatenate([high[name], start[name]]) for name in run.net.inputs}
    return climb(climbing(ranges, mixed, climbers=CLIMBERS, rounds=ROUNDS, seed=4), error)


def table(path: Path) -> dict[str, Floats]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


@dataclass(slots=True)
class Seen:
    """What is seen of an output: worst error, the reference's own, samples inside and beyond, worst rows."""

    worst: float = 0.0
    width: float = 0.0
    kept: int = 0
    beyond: int = 0
    share: float = 0.0
    rows: list[tuple[float, dict[str, float]]] = field(default_factory=list)

    def add(self, errors: Floats, bound: float, points: Columns) -> None:
        self.worst = max(self.worst, float(errors.max(initial=0.0)))
        self.beyond += int((errors > bound).sum())
        for at in np.argsort(-errors)[:WORST_ROWS]:
            if np.isfinite(errors[at]):
                row = {name: float(column[at]) for name, column in points.items()}
                self.rows.append((float(errors[at]), row))
        self.rows = sorted(self.rows, key=lambda row: -row[0])[: 2 * WORST_ROWS]


def measured(run: Run, count: int, corpus: Columns) -> tuple[dict[str, Seen], int]:
    """Return what is seen of every output, and how many random samples are valid."""
    seen = {output: Seen() for output in run.net.outputs}
    limits = {output: math.inf if b.value is None else b.value for output, b in run.bounds.items()}
    valid = 0
    first: dict[str, Floats] = {}
    for points in sampling.draw_parts(run.plan.problem.workspace, count, 1, BLOCK):
        results = simulated(run, points)
        valid += int(results["valid"].sum())
        first = first or {name: column[results["valid"]][:2000] for name, column in points.items()}
        for output, (error, own) in found(run, list(seen), run.net.steps, points, results).items():
            seen[output].add(error, limits[output], points)
            seen[output].kept += int(np.isfinite(error).sum())
            seen[output].width = max(seen[output].width, own)
    for output, each in seen.items():
        points, heights = searched(run, output, first)
        each.add(heights, limits[output], points)
        each.share = float(inside(run.net, {output: run.bounds[output].where}, corpus)[output].mean())
        rows = {name: np.array([row[name] for _, row in each.rows]) for name in run.net.inputs}
        each.beyond += high_precision_beyond(run, [output], rows)[output]
    drawn = sampling.draw(run.plan.problem.workspace, count, 1)
    rows = {name: column[:FIRST_ROWS] for name, column in drawn.items()}
    for output, beyond in high_precision_beyond(run, list(seen), rows).items():
        seen[output].beyond += beyond
    return seen, valid


def high_precision_beyond(run: Run, outputs: Sequence[str], points: Columns) -> dict[str, int]:
    """Count by output the samples whose error against the equations as written is beyond the bound."""
    values, defined = exact(run.plan.problem, points)
    results = simulated(run, points)
    beyond = {}
    for output in outputs:
        held = inside(run.net, {output: run.bounds[output].where}, points)[output]
        held = held & results["valid"].astype(bool) & defined
        error = apart(results[output] - values[output], run.net.angles[output])
        bound = run.bounds[output].value
        beyond[output] = 0 if bound is None else int((error[held] > bound).sum())
    return beyond


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--target", default="fixed24")
    options = parser.parse_args()
    every = sorted(p.stem for p in CORPUS.glob("*.yaml") if not p.stem.startswith("rej_"))
    ratios, failed, without = [], False, 0
    print("| problem | output | bound | worst | ratio | corpus inside | random inside | reference | where |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in options.names or every:
        plan = plan_file(CORPUS / f"{name}.yaml", Options(options.target)).plan
        begin = time.perf_counter()
        bounds = bounds_of(plan)
        seconds = time.perf_counter() - begin
        net = network(plan)
        caus = sum(operation.kind in CAU_KINDS for operation in plan.operations)
        long = available() and options.samples * caus > COMPILED_FROM
        machine = compiled_arithmetic(plan.arithmetic) if long else plan.arithmetic
        run = Run(plan, net, bounds, machine)
        seen, valid = measured(run, options.samples, table(CORPUS / f"{name}.inputs.csv"))
        for output, each in seen.items():
            bound = bounds[output]
            without += bound.value is None
            failed |= each.beyond > 0 or each.share < LEAST_SHARE
            value = math.inf if bound.value is None else bound.value
            ratios.append(value / each.worst)
            where = " and ".join(p.text for p in bound.where) or bound.reason or ""
            mark = f" BEYOND {each.beyond}" if each.beyond else ""
            print(
                f"| {name} | {output} | {value:.3g} | {each.worst:.3g} | {value / each.worst:.2f}{mark} "
                f"| {each.share:.3f} | {each.kept / max(1, valid):.5f} | {each.width:.1e} | {where} |",
                flush=True,
            )
        print(f"<!-- {name}: bounds in {seconds:.1f} s -->", file=sys.stderr, flush=True)
    print(
        f"\n{len(ratios)} outputs, {without} without a bound, median ratio {statistics.median(ratios):.2f}, "
        f"largest {max(ratios):.3g}"
    )
    return int(failed or without > 0 or statistics.median(ratios) > MOST_RATIO)


if __name__ == "__main__":
    sys.exit(main())
