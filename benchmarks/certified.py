"""Proven bounds beside the errors that are found: the corpus on a fixed-point target.

For every output: the bound; the largest error of random samples inside its conditions and of a search that
tries to make it large; their ratio; the share of the corpus samples, and of random ones, that are inside.

The reference for many samples is the interval evaluation of the plan's exact operations in binary64, whose
width is its own error bound; an error counts by the nearest end, so it is certain.  The worst samples and
the first ones are evaluated again from the equations as written, with 113 bits.  Fails if an error is beyond
its bound, or fewer than 99 % of the corpus samples of an output are inside.

    python benchmarks/certified.py [--samples N] [--target NAME] [NAME ...]
"""

from __future__ import annotations

import argparse
import csv
import math
import statistics
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.intervals import Interval
from cordicc.certify.boxes import Boxes
from cordicc.certify.certificate import Bound
from cordicc.certify.network import Network, network
from cordicc.certify.plans import UNIT_PROGRAM, bounds_of
from cordicc.certify.predicates import inside
from cordicc.certify.sweep import errors, forward
from cordicc.emulate import functional, sampling
from cordicc.emulate.climb import climb
from cordicc.ir.text import parse_graph
from cordicc.observation import exact, machine_of
from cordicc.pipeline import Options, plan_file
from cordicc.plan import Plan

CORPUS = Path(__file__).resolve().parents[1] / "tests" / "corpus"
LEAST_SHARE = 0.99
BLOCK = 20_000
CLIMBERS, ROUNDS = 128, 60
HIGH_PRECISION_ROWS = 200

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]


@dataclass(frozen=True, slots=True)
class Run:
    """A plan, its network and its bounds."""

    plan: Plan
    net: Network
    bounds: Mapping[str, Bound]


def apart(error: Floats, angle: bool) -> Floats:
    """Return |error|, of angles modulo 2 pi."""
    size = np.abs(error)
    return np.minimum(np.mod(size, math.tau), math.tau - np.mod(size, math.tau)) if angle else size


def certain_error(run: Run, output: str, points: Columns, simulated: Floats) -> tuple[Floats, float]:
    """Return what the errors are at least, and the largest width of the reference."""
    steps = run.net.upstream(output)
    boxes = {name: Boxes(points[name], points[name]) for name in run.net.inputs}
    made = forward(run.net, steps, boxes, {}, exact=True)
    box, _ = made.operand(run.net.outputs[output])
    width = (box.hi - box.lo) / 2
    error = apart(simulated - (box.lo + width), run.net.angles[output]) - width
    return np.where(made.empty, -np.inf, error), float(np.nanmax(np.where(np.isfinite(width), width, 0.0)))


def simulated(run: Run, points: Columns) -> dict[str, Floats]:
    return functional.run(run.plan, machine_of(run.plan), points)


def found(run: Run, output: str, points: Columns, outputs: Columns) -> tuple[Floats, float]:
    """Return the errors of samples, -inf for those that do not count, and the reference's own error."""
    error, width = certain_error(run, output, points, outputs[output])
    held = inside(run.net, output, run.bounds[output].where, points)
    return np.where(outputs["valid"] & held & ~np.isnan(error), error, -np.inf), width


def searched(run: Run, output: str, start: Columns) -> tuple[dict[str, Floats], Floats]:
    """Return points where the error is large: first the sample's own bound climbs, then the error."""
    steps = run.net.upstream(output)
    limit = run.bounds[output]

    def own(points: Columns) -> Floats:
        boxes = {name: Boxes(points[name], points[name]) for name in run.net.inputs}
        bound = errors(run.net, steps, output, forward(run.net, steps, boxes, {}))
        held = inside(run.net, output, limit.where, points)
        return np.where(np.isfinite(bound) & held, bound, -np.inf)

    def error(points: Columns) -> Floats:
        return found(run, output, points, simulated(run, points))[0]

    ranges = {name: Interval(each.lo, each.hi) for name, each in run.net.inputs.items()}
    high, _ = climb(ranges, start, own, climbers=CLIMBERS, rounds=ROUNDS, seed=3)
    mixed = {name: np.concatenate([high[name], start[name]]) for name in run.net.inputs}
    return climb(ranges, mixed, error, climbers=CLIMBERS, rounds=ROUNDS, seed=4)


def table(path: Path) -> dict[str, Floats]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def measured(run: Run, count: int, corpus: Columns) -> dict[str, tuple[float, float, float, float, int]]:
    """Return by output the worst error, both shares, the reference's error, and samples beyond the bound."""
    worst = dict.fromkeys(run.net.outputs, 0.0)
    width = dict.fromkeys(run.net.outputs, 0.0)
    beyond = dict.fromkeys(run.net.outputs, 0)
    kept = dict.fromkeys(run.net.outputs, 0)
    valid = 0
    drawn = sampling.draw(run.plan.problem, count, 1)
    first: dict[str, Floats] = {}
    for begin in range(0, count, BLOCK):
        points = {name: column[begin : begin + BLOCK] for name, column in drawn.items()}
        outputs = simulated(run, points)
        valid += int(outputs["valid"].sum())
        first = first or {name: column[outputs["valid"]][:2000] for name, column in points.items()}
        for output, bound in run.bounds.items():
            error, own = found(run, output, points, outputs)
            kept[output] += int(np.isfinite(error).sum())
            worst[output] = max(worst[output], float(error.max(initial=0.0)))
            width[output] = max(width[output], own)
            beyond[output] += int((error > (bound.value or math.inf)).sum())
    result = {}
    for output, bound in run.bounds.items():
        points, heights = searched(run, output, first)
        worst[output] = max(worst[output], float(heights.max(initial=0.0)))
        beyond[output] += int((heights > (bound.value or math.inf)).sum())
        beyond[output] += high_precision_beyond(run, output, points, first)
        share = float(inside(run.net, output, bound.where, corpus).mean())
        result[output] = (worst[output], share, kept[output] / max(1, valid), width[output], beyond[output])
    return result


def high_precision_beyond(run: Run, output: str, worst: Columns, first: Columns) -> int:
    """Count the samples whose error against the equations as written is beyond the bound."""
    rows = slice(0, HIGH_PRECISION_ROWS)
    points = {name: np.concatenate([worst[name][rows], first[name][rows]]) for name in run.net.inputs}
    values, defined = exact(run.plan.problem, points)
    outputs = simulated(run, points)
    held = inside(run.net, output, run.bounds[output].where, points) & outputs["valid"] & defined
    error = apart(outputs[output] - values[output], run.net.angles[output])
    return int((error[held] > (run.bounds[output].value or math.inf)).sum())


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
        run = Run(plan, network(plan, parse_graph(plan.problem[UNIT_PROGRAM], name)), bounds)
        corpus = table(CORPUS / f"{name}.inputs.csv")
        for output, (worst, share, random, width, beyond) in measured(run, options.samples, corpus).items():
            bound = bounds[output]
            without += bound.value is None
            failed |= beyond > 0 or share < LEAST_SHARE
            value = math.inf if bound.value is None else bound.value
            ratios.append(value / worst)
            where = " and ".join(p.text for p in bound.where) or bound.reason or ""
            mark = f" BEYOND {beyond}" if beyond else ""
            print(
                f"| {name} | {output} | {value:.3g} | {worst:.3g} | {value / worst:.2f}{mark} "
                f"| {share:.3f} | {random:.5f} | {width:.1e} | {where} |",
                flush=True,
            )
        print(f"<!-- {name}: bounds in {seconds:.1f} s -->", file=sys.stderr, flush=True)
    print(
        f"\n{len(ratios)} outputs, {without} without a bound, median ratio {statistics.median(ratios):.2f}, "
        f"largest {max(ratios):.3g}"
    )
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
