"""Compile the public corpus and print what each plan costs and how near it stays to the answers.

    python benchmarks/corpus.py [--target NAME]

Columns: CAUs, multipliers of two variables, latency and CAU latency in cycles, FIFO words, the worst
error of any output as a share of its tolerance, and the time to compile in seconds.  Times on a
machine that does other work are no more than a hint; compare them within one run.
"""

import argparse
import csv
import math
import time
from pathlib import Path

import numpy as np

import cordicc

CORPUS = Path(__file__).resolve().parents[1] / "tests" / "whole" / "corpus"


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def worst_share(plan: cordicc.Plan, name: str) -> float:
    """Return the largest error over tolerance of any output; infinite if a sample is invalid."""
    expected = table(CORPUS / f"{name}.expected.csv")
    outputs = plan.simulate(table(CORPUS / f"{name}.inputs.csv"))
    if not outputs["valid"].all():
        return math.inf
    worst = 0.0
    for output in plan.problem.outputs:
        error = np.abs(outputs[output.name] - expected[output.name])
        if output.is_angle:
            error = np.minimum(error, np.abs(error - math.tau))
        worst = max(worst, float(np.max(error / expected[f"tol_{output.name}"])))
    return worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--target", default="kinematic")
    target = parser.parse_args().target
    header = ("problem", "CAUs", "mul", "cycles", "CAU cycles", "FIFO", "error/tol", "s")
    print(("{:24}" + "{:>11}" * 7).format(*header))
    total = 0
    for path in sorted(CORPUS.glob("*.yaml")):
        if path.stem.startswith("rej_"):
            continue
        start = time.perf_counter()
        plan = cordicc.compile(path, target=target)
        seconds = time.perf_counter() - start
        caus = plan.processors()["total"]
        total += caus
        row = (path.stem, caus, plan.units_by_kind().get("mul", 0), plan.latency_cycles, plan.cau_cycles)
        print("{:24}{:11}{:11}{:11}{:11}".format(*row), end="")
        print(f"{plan.fifo_words:11}{worst_share(plan, path.stem):11.3f}{seconds:11.2f}")
    print(f"{'sum':24}{total:11}")


if __name__ == "__main__":
    main()
