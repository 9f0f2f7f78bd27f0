"""Compare `valid` with the equations as written, on both sides of the borders of random problems.

    python benchmarks/validity.py [--problems 1000] [--first 0] [--targets kinematic fixed24 ...] [--effort F]

A problem counts if some of its samples have a value and others have none.  A sample is compared where the
equations, evaluated by mpmath, agree with themselves when inputs are moved by 2^-19 of their ranges and every
operation errs by as much, or by 8 steps of the coarsest format of a fixed-point plan: nearer to a border
either answer is right.  What is valid by the equations and invalid in the plan, because a value leaves its
number format, is counted apart; so is what has no direction or quotient in fixed point, as numbers are
rounded to 0 that are no larger than 8 steps.  Exit status 1 if a plan calls a sample valid that has no value,
or the other way round without such a reason, or ends in a traceback.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cordicc
from cordicc.base.arrays import Samples
from cordicc.base.diagnostics import InvalidInput, Unattainable
from cordicc.emulate.observation import first_invalid
from cordicc.ir.graph import Graph
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ops import Level
from cordicc.plan.model import Operation, Plan
from tests.support.random_problems import (
    RandomProblem,
    beside_borders,
    clear_validity,
    draw,
    is_clear,
    random_problem,
    resolution,
)

TARGETS = ("kinematic", "fixed24", "imscor24", "krieger96")
ERRING = 2.0**-19


def below_words(plan: Plan, culprit: Operation, sample: Mapping[str, float]) -> bool:
    """Tell whether fixed point has nothing but 0 for what an operation takes the direction or inverse of."""
    program = plan.unit_program
    assert program is not None
    made = [node for node in program.nodes if node.definition.level is not Level.LEAF]
    node = made[int(culprit.id.removeprefix("o")) - 1]
    if node.op == "vector" and node.m == 1:
        operands = node.operands[:2]
    elif node.op == "guard" and node.condition == "nonzero":
        operands = node.operands[1:]
    else:
        return False
    parts = Graph(program.nodes, {str(n): value for n, value in enumerate(operands)})
    values, _ = reference_outputs(parts, {name: np.array([x]) for name, x in sample.items()})
    return all(abs(float(column[0])) <= 8 * resolution(plan) for column in values.values())


def compare(problem: RandomProblem, target: str, effort: float, samples: Samples) -> tuple[str, str, int]:
    """Return how a problem fares on a target, more about it, and how many samples were compared."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.yaml"
        path.write_text(problem.text, encoding="utf-8")
        try:
            plan = cordicc.compile(path, target=target, certify=False, effort=effort)
        except (InvalidInput, Unattainable) as error:
            return error.diagnostics[0].code, "", 0
    erring = max(ERRING, 8 * resolution(plan))
    valid, clear = clear_validity(problem, samples, erring)
    compared = int(clear.sum())
    got = plan.simulate(samples)["valid"]
    for index in np.flatnonzero((got != valid) & clear):
        clear[index] = is_clear(problem, samples, int(index), erring)
    wrong = np.flatnonzero(got & ~valid & clear)
    if wrong.size:
        example = {name: float(c[wrong[0]]) for name, c in samples.items()}
        return "VALID WITHOUT A VALUE", str(example), compared
    lost = np.flatnonzero(~got & valid & clear)
    for index in lost:
        sample = {name: float(column[index]) for name, column in samples.items()}
        culprit = first_invalid(plan, plan.arithmetic, sample)
        if culprit is not None and below_words(plan, culprit, sample):
            continue
        if culprit is None or culprit.op in ("guard", "implicit", "vector", "lightcone"):
            return "LOST", f"{sample} {'' if culprit is None else culprit.op}", compared
    return ("left its format" if lost.size else "agree"), "", compared


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--problems", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first problem")
    parser.add_argument("--targets", nargs="+", default=list(TARGETS))
    parser.add_argument("--effort", type=float, default=0.05)
    options = parser.parse_args()
    warnings.simplefilter("error")
    ends: Counter[str] = Counter()
    compared = bad = found = 0
    seed, begin = options.first, time.monotonic()
    while found < options.problems:
        problem = random_problem(seed)
        seed += 1
        samples = draw(problem, 40)
        valid = problem.valid(samples)
        if valid.all() or not valid.any():
            continue
        border = beside_borders(problem, 12)
        samples = {name: np.concatenate([c, border[name]]) for name, c in samples.items()}
        found += 1
        for target in options.targets:
            try:
                end, more, count = compare(problem, target, options.effort, samples)
            except Exception:
                end, more, count = "TRACEBACK", traceback.format_exc(), 0
            ends[end] += 1
            compared += count
            if end.isupper() and not end[1].isdigit():
                bad += 1
                print(f"--- seed {seed - 1} on {target}: {end} {more}\n{problem.text}", flush=True)
    print(f"{found} problems of {seed - options.first} on {len(options.targets)} targets, {compared} samples")
    for end, count in sorted(ends.items()):
        print(f"  {end:24} {count}")
    print(f"{time.monotonic() - begin:.0f} s")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
