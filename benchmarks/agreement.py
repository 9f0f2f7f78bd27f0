"""Run random problems on every path there is, and compare them with an evaluation by mpmath.

    python benchmarks/agreement.py [--problems 3000] [--first 0] [--jobs 2] [--effort F]

The problem of a seed is compiled for one of the shipped targets, an interval of 1 to 7 and 1 to 3 copies, in
turn.  The words of the emulator have to be those of its units compiled by numba, of the cycle-accurate run
and of the C model, bit for bit; numbers and `valid` have to agree with mpmath's within what rounding can do:
a value may be off by 32 times what errors of 2^-20, or of the coarsest fixed-point format, move it by;
what a plan states to count as on a border may count so.
Exit status 1 after a difference or a traceback.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cordicc
from cordicc.arith.compiled.compiled_cau import available, compiled_arithmetic
from cordicc.base.arrays import Samples
from cordicc.base.diagnostics import InvalidInput, Unattainable
from cordicc.emulate import cycle, functional
from cordicc.plan.copies import name_of
from cordicc.plan.model import Plan
from cordicc.targets.target_file import shipped_targets
from tests.support.c_models import COMPILER, check
from tests.support.random_problems import (
    RandomProblem,
    beside_borders,
    clear_validity,
    draw,
    is_clear,
    random_problem,
    resolution,
    spread,
)

ERRING = 2.0**-20
TIMES = 32


class Difference(Exception):
    """Two paths disagree."""


def same(name: str, one: Mapping[str, Any], other: Mapping[str, Any]) -> None:
    """Raise Difference unless two runs have the same bits."""
    for key, column in one.items():
        if not np.array_equal(np.asarray(column), np.asarray(other[key]), equal_nan=True):
            raise Difference(f"{name}: '{key}'")


def stated(plan: Plan) -> float:
    """Return the most that a plan states to count as on a border of a domain, in units of its operands."""
    slacks = [operation.slack for operation in plan.operations]
    return max((slack.beyond for slack in slacks if not slack.relative), default=0.0)


def judge(
    problem: RandomProblem, plan: Plan, samples: Samples, outputs: Mapping[str, Any], suffix: str
) -> int:
    """Compare outputs with mpmath's; return how many samples were compared."""
    erring = max(ERRING, 8 * resolution(plan))
    valid, clear = clear_validity(problem, samples, erring)
    compared = 0
    for index in np.flatnonzero(clear):
        sample = {name: float(column[index]) for name, column in samples.items()}
        got = bool(outputs["valid"][index])
        if got and not valid[index] and is_clear(problem, samples, int(index), max(erring, stated(plan))):
            raise Difference(f"valid without a value at {sample}")
        if not (got and valid[index]):
            continue
        exact, moved = problem.evaluate(sample), spread(problem, sample, erring)
        if exact is None or moved is None:
            continue
        compared += 1
        for name in problem.outputs:
            error = abs(float(outputs[name + suffix][index]) - exact[name])
            allowed = TIMES * moved[name] + 8 * erring * max(1.0, abs(exact[name]))
            if plan.problem.angles[name + suffix]:
                error = abs(math.remainder(error, math.tau))
            if not error <= allowed:
                raise Difference(
                    f"'{name}' is {outputs[name + suffix][index]!r}, not {exact[name]!r}: {sample}"
                )
    return compared


def run(problem: RandomProblem, options: dict[str, Any], path: Path) -> tuple[str, int]:
    """Return how a problem ended, and how many samples were compared with mpmath."""
    path.write_text(problem.text, encoding="utf-8")
    try:
        plan = cordicc.compile(path, certify=False, **options)
    except (InvalidInput, Unattainable) as error:
        return error.diagnostics[0].code, 0
    copies = options["copies"]
    parts = []
    for copy in range(copies):
        border = beside_borders(problem, 2, copy)
        drawn = draw(problem, 24, copy)
        size = len(next(iter(border.values())))
        parts.append({n: np.concatenate([border[n], c[: 40 - size]])[:24] for n, c in drawn.items()})
    names = [name if copies == 1 else name_of(name, c + 1) for c in range(copies) for name in parts[0]]
    columns = [column for part in parts for column in part.values()]
    samples = dict(zip(names, columns, strict=True))
    outputs = plan.simulate(samples)
    same("cycle-accurate", outputs, cycle.run(plan, plan.arithmetic, samples))
    if available():
        same("numba", outputs, functional.run(plan, compiled_arithmetic(plan.arithmetic), samples))
    if COMPILER is not None:
        try:
            check(plan, samples, path.parent)
        except AssertionError as error:
            raise Difference(f"C model: {error}") from error
    compared = 0
    for copy, part in enumerate(parts):
        suffix = "" if copies == 1 else name_of("", copy + 1)
        compared += judge(problem, plan, part, outputs, suffix)
    return "agree", compared


def case(item: tuple[int, float]) -> tuple[int, str, int, str, dict[str, Any]]:
    """Return seed, how its problem ended, the samples compared, a trace, and the options."""
    seed, effort = item
    warnings.simplefilter("error")
    targets = shipped_targets()
    options = {
        "target": targets[seed % len(targets)],
        "ii": 1 + seed // len(targets) % 7,
        "copies": 1 + (seed % 11 == 0) + (seed % 22 == 0),
        "effort": effort,
    }
    with tempfile.TemporaryDirectory() as folder:
        try:
            end, compared = run(random_problem(seed), options, Path(folder) / "problem.yaml")
            return seed, end, compared, "", options
        except Difference as error:
            return seed, "DIFFERENT", 0, str(error), options
        except Exception:
            return seed, "TRACEBACK", 0, traceback.format_exc(), options


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--problems", type=int, default=3000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first problem")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--effort", type=float, default=0.02)
    options = parser.parse_args()
    begin, ends, total, bad = time.monotonic(), Counter[str](), 0, 0
    seeds = [(seed, options.effort) for seed in range(options.first, options.first + options.problems)]
    with multiprocessing.Pool(options.jobs) as pool:
        for seed, end, compared, more, chosen in pool.imap_unordered(case, seeds, chunksize=4):
            ends[end] += 1
            total += compared
            if end in ("DIFFERENT", "TRACEBACK"):
                bad += 1
                print(f"--- seed {seed}, {chosen}: {end}\n{more}\n{random_problem(seed).text}", flush=True)
    print(f"{options.problems} problems, {total} samples compared with mpmath")
    for end, count in sorted(ends.items()):
        print(f"  {end:12} {count}")
    print(f"{time.monotonic() - begin:.0f} s")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
