"""Kill `cordicc compile` at random moments, and run two at once: the output folder is always one whole set.

    python benchmarks/kill.py [--kills 20] [--races 5] [--seed 0]

Each kill is a SIGKILL to a run that writes over the results of another one, half of them at any moment and
half while files are being written.  Prints each moment and what the folder then held; exits 1 if that is
neither all old nor all new, or if a file lies beside.
"""

import argparse
import hashlib
import os
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROBLEM = """
inputs: {x: [0.2, 0.45], y: [0.1, 0.4]}
equations:
  - r = hypot(x, y)
  - q = atan2(y, x)
"""
SETS = {"old": ("--target", "imscor24"), "new": ("--target", "krieger96")}


def command(folder: Path, options: tuple[str, ...], *more: str) -> list[str]:
    return [sys.executable, "-m", "cordicc", "compile", "p.yaml", "-o", str(folder), "-q", *options, *more]


def digest(folder: Path) -> str:
    found = hashlib.sha256()
    for path in sorted(folder.iterdir()) if folder.exists() else ():
        found.update(path.name.encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def beside(base: Path) -> list[str]:
    """Return what lies in the folder of a run besides the problem and the results."""
    return sorted(path.name for path in base.iterdir() if path.name not in ("p.yaml", "out"))


def killed(base: Path, delay: float, at_writing: bool) -> None:
    """Start a run and kill it after a time; counted from the moment it starts to write, if so wanted."""
    process = subprocess.Popen(command(base / "out", SETS["new"]), cwd=base)
    if at_writing:
        while process.poll() is None and not beside(base):
            time.sleep(0.0002)
    time.sleep(delay)
    process.send_signal(signal.SIGKILL)
    process.wait()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--races", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    source = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as name:
        base = Path(name)
        (base / "p.yaml").write_text(PROBLEM)
        digests, times = {}, []
        for which, options in list(SETS.items()) * 3:
            start = time.monotonic()
            subprocess.run(command(base / "out", options), cwd=base, check=True)
            times.append(time.monotonic() - start)
            digests[digest(base / "out")] = which
        whole = statistics.median(times)
        wrong = 0
        for number in range(given.kills):
            subprocess.run(command(base / "out", SETS["old"]), cwd=base, check=True)
            at_writing = number % 2 == 1
            delay = source.uniform(0, 0.01 if at_writing else 1.1 * whole)
            killed(base, delay, at_writing)
            held, left = digests.get(digest(base / "out"), "neither"), beside(base)
            wrong += held == "neither"
            moment = f"{1000 * delay:7.1f} ms after {'writing began' if at_writing else 'the start'}"
            print(f"{number + 1:3} killed {moment:32} {held}{'  left ' + ', '.join(left) if left else ''}")
        for number in range(given.races):
            runs = [subprocess.Popen(command(base / "out", options), cwd=base) for options in SETS.values()]
            failed = [run for run in runs if run.wait() != 0]
            held, left = digests.get(digest(base / "out"), "neither"), beside(base)
            wrong += held == "neither" or bool(failed) or bool(left)
            print(f"{number + 1:3} two runs at once {held}{'  left ' + ', '.join(left) if left else ''}")
    print("the folder was one whole set each time" if not wrong else f"{wrong} times it was not")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    os.environ.setdefault("PYTHONPATH", str(Path(__file__).resolve().parents[1]))
    main()
