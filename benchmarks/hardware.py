"""The Verilog of every problem of a folder: simulated, linted and checked, with times.

For each problem, target and interval the folder `rtl/` is written with the samples of the corpus
(NAME.inputs.csv beside NAME.yaml, if there is one) and random ones; its bench runs under Verilator, for the
first problems under Icarus Verilog too; both tops go through `verilator --lint-only -Wall` and the checks of
yosys, which have to be silent.  Fails if anything does.

    python benchmarks/hardware.py [FOLDER] [--targets fixed24,...] [--intervals 1,4] [--samples N]
        [--icarus N] [--only NAME,...] [--effort FACTOR]
"""

from __future__ import annotations

import argparse
import csv
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cordicc.artefacts import ARTEFACTS
from cordicc.base.diagnostics import CordiccError
from cordicc.ir.sampling import draw
from cordicc.pipeline import Options, plan_file
from cordicc.plan.model import Plan
from cordicc.schedule.request import Limits

CORPUS = Path(__file__).resolve().parents[1] / "tests" / "whole" / "corpus"
SEED = 4
UNOPTIMISED = [f"OPT_{kind}=-O0" for kind in ("FAST", "SLOW", "GLOBAL")]
"""For the make that builds a model of Verilator, which takes longer than it runs for so few samples."""


@dataclass(frozen=True, slots=True)
class Result:
    """What one plan showed: text and seconds of each tool, the text empty if it was not run."""

    said: str
    seconds: float


def main() -> int:
    """Print the table; return 1 if a tool is not content."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", type=Path, default=CORPUS)
    parser.add_argument("--targets", default="fixed24")
    parser.add_argument("--intervals", default="1,4")
    parser.add_argument("--samples", type=int, default=10_000)
    parser.add_argument("--icarus", type=int, default=2, help="problems that run under Icarus Verilog too")
    parser.add_argument("--only", default="")
    parser.add_argument("--effort", type=float, default=0.1)
    args = parser.parse_args()
    missing = [tool for tool in ("verilator", "yosys", "iverilog") if shutil.which(tool) is None]
    if missing:
        print(f"not installed: {', '.join(missing)}", file=sys.stderr)
        return 2
    only = set(filter(None, args.only.split(",")))
    files = [file for file in sorted(args.folder.glob("*.yaml")) if not file.stem.startswith("rej_")]
    files = [file for file in files if not only or file.stem in only]
    print(f"{'problem':24} {'target':10} {'II':>3} {'samples':>8} ", end="")
    print(f"{'verilator':>12} {'icarus':>12} {'lint':>8} {'yosys':>8}")
    bad = 0
    for number, file in enumerate(files):
        for target in args.targets.split(","):
            for interval in map(int, args.intervals.split(",")):
                bad += not _tried(file, target, interval, args, number < args.icarus)
    print(f"{bad} plans that differ or of which a tool complains" if bad else "all equal and silent")
    return int(bad > 0)


def _tried(file: Path, target: str, interval: int, args: argparse.Namespace, icarus: bool) -> bool:
    """Print the line of a plan; tell whether everything is well."""
    head = f"{file.stem:24} {target:10} {interval:>3}"
    try:
        options = Options(target, "auto", Limits("processors", interval), False, 1, args.effort)
        plan = _with_samples(plan_file(file, options).plan, file, args.samples)
        count = len(next(iter((plan.problem.samples or {}).values())))
        texts = ARTEFACTS["verilog"].emit(plan, count)
    except CordiccError as error:
        print(f"{head}  {error.diagnostics[0].message[:70]}")
        return False
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "rtl"
        for path, text in texts.items():
            (Path(name) / path).parent.mkdir(parents=True, exist_ok=True)
            (Path(name) / path).write_text(text, encoding="utf-8")
        simulated = _run(["make", "-s", "verilate", *UNOPTIMISED], folder)
        passed = simulated.said.splitlines()[-1:] or [""]
        also = _run(["make", "-s", "sim"], folder) if icarus else Result("", 0.0)
        lint = _run(["make", "-s", "lint"], folder)
        checks = [_checked(folder, top) for top in ("core", "axis")]
    check = Result("".join(each.said for each in checks), sum(each.seconds for each in checks))
    ok = passed[0].startswith("PASS") and not lint.said and not check.said
    ok = ok and (not icarus or also.said.startswith("PASS"))
    samples = passed[0].split()[1] if passed[0].startswith("PASS") else "-"
    other = f"{_word(also.said.startswith('PASS'), also)}" if icarus else ""
    print(
        f"{head} {samples:>8}  {_word(samples != '-', simulated):>12} {other:>12} "
        f"{_word(not lint.said, lint):>8} {_word(not check.said, check):>8}",
        flush=True,
    )
    for each in (simulated, also, lint, check):
        if each.said and not each.said.startswith("PASS"):
            print(f"    {each.said[:400]}")
    return ok


def _with_samples(plan: Plan, file: Path, count: int) -> Plan:
    """Return the plan with the rows of its table and random ones as its samples."""
    columns = draw(plan.problem.workspace, count, SEED)
    table = file.with_suffix(".inputs.csv")
    if table.exists():
        with table.open(encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
        columns = {
            name: np.concatenate([[float(row[name]) for row in rows], column])
            for name, column in columns.items()
        }
    samples = {name: tuple(map(float, column)) for name, column in columns.items()}
    return replace(plan, problem=replace(plan.problem, samples=samples))


def _checked(folder: Path, top: str) -> Result:
    sources = sorted(file.name for file in folder.glob("*.v") if not file.stem.endswith("_tb"))
    (name,) = (name.removesuffix("_axis.v") for name in sources if name.endswith("_axis.v"))
    script = f"read_verilog {' '.join(sources)}; hierarchy -check -top {name}_{top}; proc; check -assert"
    return _run(["yosys", "-q", "-p", script], folder)


def _run(command: list[str], folder: Path) -> Result:
    began = time.perf_counter()
    end = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    said = (end.stdout + end.stderr).strip() or ("" if end.returncode == 0 else f"status {end.returncode}")
    return Result(said, time.perf_counter() - began)


def _word(well: bool, result: Result) -> str:
    return f"{'ok' if well else 'FAIL'} {result.seconds:.0f} s"


if __name__ == "__main__":
    sys.exit(main())
