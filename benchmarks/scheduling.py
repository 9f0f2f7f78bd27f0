"""Schedule the public corpus and generated graphs, and print what was proven and how long it took.

    python benchmarks/scheduling.py corpus [--words 14]   every problem at intervals 1, 2, 4, 8, 16
    python benchmarks/scheduling.py generated             200 to 100,000 operations
    python benchmarks/scheduling.py explore               the front of every problem of up to 60 operations
    python benchmarks/scheduling.py wheel                 the wheel suspension on imscor24, limits included

`s` is the time for processors and latency, `all s` that with FIFO words.  `>= n` beside a figure is a lower
bound that it does not meet; every schedule is verified, and those of the corpus run clock by clock with the
same bits as operation by operation.  Times on a machine that does other work are no more than a hint;
compare them within one run.
"""

from __future__ import annotations

import argparse
import os
import random
import time
from collections.abc import Sequence
from pathlib import Path

from cordicc.base.diagnostics import Unattainable
from cordicc.base.text_tables import plain
from cordicc.emulate import cycle, functional
from cordicc.ir import sampling
from cordicc.pipeline import Options, plan_file
from cordicc.plan.model import Plan
from cordicc.plan.verify import verify
from cordicc.schedule.place import place, scheduling_problem
from cordicc.schedule.request import MULTIPLIERS, PROCESSORS, Limits
from cordicc.schedule.solver.dependences import network
from cordicc.schedule.solver.engine import Effort, solve
from cordicc.schedule.solver.goals import FIFO_WORDS, LATENCY
from cordicc.schedule.solver.latency_bounds import latency_bound
from cordicc.schedule.solver.modulo_list import list_schedule
from cordicc.schedule.solver.scheduling_problem import SchedulingProblem, Task, TaskValue
from cordicc.studies.trade_off import as_sheet, explore, workers

ROOT = Path(__file__).resolve().parents[1]
INTERVALS = (1, 2, 4, 8, 16)
_SAMPLES = 20
LATENCIES = {"standard": 44, "implicit": 48, "mul": 4}


def generated(count: int, interval: int, seed: int = 0, window: int | None = None) -> SchedulingProblem:
    """Return a random graph with as few units of each kind as the interval allows.

    An operation takes one to three results of the `window` operations before it, by default a twelfth
    of all; 4 of 10 are standard CAUs, 1 an implicit one, 5 multipliers.
    """
    rng = random.Random(seed)
    window = window or max(12, count // 12)
    kinds = [rng.choices(list(LATENCIES), (4, 1, 5))[0] for _ in range(count)]
    takers: list[list[tuple[str, str]]] = [[] for _ in range(count)]
    for index in range(count):
        for port in range(rng.choice((1, 2, 2, 3))):
            if index and rng.random() < 0.9:
                takers[rng.randrange(max(0, index - window), index)].append((f"o{index}", f"p{port}"))
    tasks = tuple(Task(f"o{index}", kind, LATENCIES[kind]) for index, kind in enumerate(kinds))
    values = tuple(TaskValue(f"o{index}.r", f"o{index}", tuple(sinks)) for index, sinks in enumerate(takers))
    limits = {kind: -(-kinds.count(kind) // interval) for kind in LATENCIES if kind in kinds}
    return SchedulingProblem(tasks, values, interval, limits, "cycles")


def problems() -> list[Path]:
    """Return the problems of the corpus and the examples."""
    found = [*(ROOT / "tests" / "whole" / "corpus").glob("*.yaml"), *(ROOT / "examples").glob("*.yaml")]
    return sorted(path for path in found if not path.stem.startswith("rej_"))


def figure(plan: Plan, name: str, value: int) -> str:
    """Return a figure, with its bound if it is not proven."""
    return str(value) if plan.optimal[name] else f"{value} >= {plan.bounds[name]}"


def check(plan: Plan) -> None:
    """Verify a plan, and that it gives the same bits clock by clock as operation by operation."""
    verify(plan)
    arithmetic, samples = plan.arithmetic, sampling.draw(plan.problem.workspace, _SAMPLES, 0)
    clocked = cycle.run(plan, arithmetic, samples)
    for name, column in functional.run(plan, arithmetic, samples).items():
        assert column.tobytes() == clocked[name].tobytes(), name


def corpus(words: float) -> None:
    """Print a row for every problem and interval."""
    print(("{:26}" + "{:>9}{:>4}" + "{:>13}" * 3 + "{:>8}" * 3).format(
        "problem", "ops", "II", "CAUs", "latency", "FIFO words", "gap %", "s", "all s"
    ))  # fmt: skip
    unproven = []
    for path in problems():
        base = plan_file(path, Options()).plan
        for interval in INTERVALS:
            began = time.perf_counter()
            solve(scheduling_problem(base, interval), [PROCESSORS, MULTIPLIERS, LATENCY])
            between = time.perf_counter()
            plan = place(base, Limits(initiation_interval=interval, effort=Effort(words=words)))
            first, seconds = between - began, time.perf_counter() - between
            check(plan)
            gap = 100 * (plan.fifo_words - plan.bounds["fifo_words"]) / max(plan.fifo_words, 1)
            cells = (
                figure(plan, "processors", plan.processors()["total"]),
                figure(plan, "latency", plan.latency_cycles),
                figure(plan, "fifo_words", plan.fifo_words),
            )
            head = f"{path.stem:26}{len(plan.operations):9}{interval:4}"
            times = f"{gap:8.1f}{first:8.1f}{seconds:8.1f}"
            print(head + "".join(f"{c:>13}" for c in cells) + times, flush=True)
            if not all(plan.optimal.values()):
                unproven.append((path.stem, len(plan.operations), interval, gap))
    print(f"\nnot proven: {len(unproven)}")
    for row in unproven:
        print("  {}, {} operations, interval {}: gap {:.1f} %".format(*row))


def graphs() -> None:
    """Print a row for every generated graph."""
    print(("{:>8}{:>5}{:>6}" + "{:>10}" * 4 + "{:>8}" * 2).format(
        "ops", "II", "seed", "bound", "list", "list s", "latency", "gap %", "s"
    ))  # fmt: skip
    for count, interval, seeds in ((200, 16, 5), (1000, 32, 3), (10_000, 64, 2), (100_000, 128, 1)):
        for seed in range(seeds):
            problem = generated(count, interval, seed)
            began = time.perf_counter()
            net = network(problem)
            bound = latency_bound(net)
            start = list_schedule(net, bound)
            assert start is not None, "pipelines have a free slot"
            listed = net.makespan(start)
            list_seconds = time.perf_counter() - began
            began = time.perf_counter()
            solved = solve(problem, [LATENCY])
            seconds = time.perf_counter() - began
            bound = solved.bounds["latency"]
            gap = 100 * (solved.latency - bound) / bound
            row = f"{count:8}{interval:5}{seed:6}{bound:10}{listed:10}{list_seconds:10.2f}{solved.latency:10}"
            print(row + f"{gap:8.2f}{seconds:8.1f}", flush=True)
    print("\nFIFO words at the least latency, as cycles of waiting")
    for count, interval in ((50, 8), (200, 16), (1000, 32)):
        began = time.perf_counter()
        solved = solve(generated(count, interval), [LATENCY, FIFO_WORDS], effort=Effort(words=10.0))
        words, bound = solved.fifo_words, solved.bounds["fifo_words"]
        gap = 100 * (words - bound) / max(words, 1)
        print(
            f"{count:8}{interval:5}{words:10}{bound:10}{gap:8.2f} %{time.perf_counter() - began:8.1f} s",
            flush=True,
        )


def fronts() -> None:
    """Print the time that each front takes, and its points."""
    for path in problems():
        if len(plan_file(path, Options()).plan.operations) > 60:
            continue
        began = time.perf_counter()
        front = explore(path, "kinematic", "auto", 1, workers(os.cpu_count(), None), lambda done, count: None)
        seconds = time.perf_counter() - began
        certified = sum(p.optimal["processors"] and p.optimal["latency"] for p in front.points)
        words = sum(p.optimal["fifo_words"] for p in front.points)
        print(
            f"{front.name:26}{front.tried:4} tried{len(front.points):4} on the front, {certified} proven in "
            f"latency and CAUs, {words} in FIFO words too, {seconds:6.1f} s",
            flush=True,
        )


def wheel() -> None:
    """Print the wheel suspension on imscor24, from pipelined to one CAU, and requests that cannot be met."""
    path = ROOT / "examples" / "wheel_suspension.yaml"
    front = explore(path, "imscor24", "auto", 1, workers(None, None), lambda done, count: None)
    print(plain(as_sheet(front)))
    base = plan_file(path, Options("imscor24")).plan
    requests: Sequence[Limits] = (
        Limits(initiation_interval=2, max_processors=1),
        Limits(initiation_interval=2, max_latency=150),
        Limits(initiation_interval=2, max_processors=2, max_latency=158),
    )
    for limits in requests:
        try:
            place(base, limits)
        except Unattainable as error:
            print(error)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=("corpus", "generated", "explore", "wheel"))
    parser.add_argument("--words", type=float, default=14.0, help="deterministic time for FIFO words")
    given = parser.parse_args()
    parts = {"corpus": lambda: corpus(given.words), "generated": graphs, "explore": fronts, "wheel": wheel}
    parts[given.part]()


if __name__ == "__main__":
    main()
