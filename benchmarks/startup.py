"""Measure how long whole processes take, beside an interpreter that does nothing.

    python benchmarks/startup.py [--repeat N]

For each command the least user time and the least wall clock of N runs, in seconds, and what the slowest
imports of `cordicc compile` take.  A loaded machine shows in the wall clock; the ratio to `python -c pass`
says how the figures of two machines compare.
"""

import argparse
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMPILE = ["-m", "cordicc", "compile", str(ROOT / "examples" / "planar_2r.yaml"), "-q", "-o"]


def user_and_wall_seconds(arguments: list[str]) -> tuple[float, float]:
    """Run the interpreter once."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL, cwd=ROOT)
    wall = time.perf_counter() - start
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, wall


def import_seconds(arguments: list[str]) -> dict[str, float]:
    """Return the time of imports by package, each without what it imports itself."""
    command = [sys.executable, "-X", "importtime", *arguments]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    seconds: dict[str, float] = defaultdict(float)
    for own, name in re.findall(r"^import time:\s+(\d+) \|\s+\d+ \|\s+(\w+)", done.stderr, re.MULTILINE):
        seconds[name] += int(own) / 1e6
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, help="runs of each command, after one to warm up")
    repeat = parser.parse_args().repeat
    with tempfile.TemporaryDirectory() as folder:
        commands = {
            "python -c pass": ["-c", "pass"],
            "cordicc --help": ["-m", "cordicc", "--help"],
            "cordicc check examples/planar_2r.yaml": ["-m", "cordicc", "check", COMPILE[3]],
            "cordicc compile examples/planar_2r.yaml": [*COMPILE, folder],
        }
        base = 0.0
        print(f"{'command':<40}  {'user s':>7}  {'wall s':>7}  {'user / pass':>11}")
        for name, arguments in commands.items():
            runs = [user_and_wall_seconds(arguments) for _ in range(repeat + 1)][1:]
            user, wall = (min(column) for column in zip(*runs, strict=True))
            base = base or user
            print(f"{name:<40}  {user:7.3f}  {wall:7.3f}  {user / base:11.1f}")
        print("\nimports of cordicc compile, s (profiled, so slower)")
        by_time = sorted(import_seconds([*COMPILE, folder]).items(), key=lambda item: -item[1])
        for name, seconds in by_time[:8]:
            print(f"{name:<40}  {seconds:7.3f}")


if __name__ == "__main__":
    main()
