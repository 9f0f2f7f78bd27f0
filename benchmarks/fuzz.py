"""Fuzz the reader of problems, the whole compiler and the reader of plans (see tests/fuzzing.py).

    python benchmarks/fuzz.py [--seconds 60] [--seed 0] [--only TARGET] [--keep FOLDER]

Prints, by target, cases and how they ended, crashes (each kind once), the longest time and the peak memory
of the process.  The same seed makes the same cases.  Exit status 1 after a crash.
"""

import argparse
import re
import resource
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from hypothesis import HealthCheck, Phase, given, seed, settings

from tests.support.fuzzing import TARGETS, Target

ROUND = 50
"""Cases between two looks at the clock."""

PATIENCE_SECONDS = 60
"""Processor time after which a case counts as a crash."""

ADDRESS_SPACE = 6 << 30
LONGEST_SHOWN = 1500


class Hang(Exception):
    """A case takes too long."""


def _hang(*_: object) -> None:
    raise Hang(f"more than {PATIENCE_SECONDS} s of processor time")


@dataclass
class Tally:
    """What the cases of a target showed."""

    cases: int = 0
    ends: Counter[str] = field(default_factory=Counter)
    crashes: dict[str, tuple[str, str]] = field(default_factory=dict)
    longest: float = 0.0
    slowest: str = ""

    def run(self, target: Target, text: str) -> None:
        """Run a case."""
        signal.setitimer(signal.ITIMER_PROF, PATIENCE_SECONDS)
        start = time.process_time()
        try:
            self.ends[target.run(text)] += 1
        except Exception as error:
            self._crash(error, text)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
        spent = time.process_time() - start
        self.cases += 1
        if spent > self.longest:
            self.longest, self.slowest = spent, text

    def _crash(self, error: Exception, text: str) -> None:
        place = traceback.extract_tb(error.__traceback__)[-1]
        kind = f"{type(error).__name__} at {Path(place.filename).name}:{place.lineno}"
        if kind not in self.crashes or len(text) < len(self.crashes[kind][0]):
            self.crashes[kind] = (text, "".join(traceback.format_exception(error)))
        self.ends["crash"] += 1


def fuzz(name: str, seconds: float, first: int) -> Tally:
    """Run cases of a target for some seconds of wall clock, at least one round of them."""
    target, tally = TARGETS[name], Tally()
    end = time.monotonic() + seconds
    number = first * 1_000_000
    while True:

        @seed(number)
        @settings(
            max_examples=ROUND,
            database=None,
            deadline=None,
            derandomize=False,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(target.strategy)
        def one(text: str) -> None:
            if time.monotonic() < end or not tally.cases:
                tally.run(target, text)

        one()
        number += 1
        if time.monotonic() >= end:
            return tally


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0, help="wall clock for all targets together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=sorted(TARGETS), help="one target")
    parser.add_argument("--keep", type=Path, help="folder for the inputs of crashes")
    options = parser.parse_args()
    signal.signal(signal.SIGPROF, _hang)
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    warnings.simplefilter("error")
    names = [options.only] if options.only else list(TARGETS)
    crashed = False
    for name in names:
        tally = fuzz(name, options.seconds / len(names), options.seed)
        crashed |= bool(tally.crashes)
        for kind, (text, trace) in tally.crashes.items():
            print(f"--- {name}: {kind}\n{trace[-LONGEST_SHOWN:]}\n{text[:LONGEST_SHOWN]!r}\n")
            if options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                kept = options.keep / re.sub(r"\W+", "-", f"{name} {kind}")
                kept.write_bytes(text.encode("utf-8", "surrogatepass"))
        ends = ", ".join(f"{count} {how}" for how, count in tally.ends.most_common(8))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
        print(
            f"{name}: {tally.cases} cases, {len(tally.crashes)} kinds of crash, "
            f"longest {tally.longest:.2f} s, peak {peak / 1e6:.0f} MB; {ends}",
            flush=True,
        )
        print(f"  slowest: {tally.slowest[:300]!r}", flush=True)
    sys.exit(crashed)


if __name__ == "__main__":
    main()
