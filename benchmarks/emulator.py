"""Measure the emulator: one vectoring unit of 24 stages and 32-bit mantissas, and the PUMA 560 plan.

    python benchmarks/emulator.py [--samples N] [--repeat K]

On one core, in one run: NumPy, numba if it is installed, and, if there is a C compiler (`cc`), the C model of
the plan and loops over blocks by hand (`hand_written.c`, in the order of the plan's operations), both with
-O3 for this machine.  A unit operation is one of a CAU; samples go in as numbers and come out as numbers,
rounding to words included.  All must give the same bits.  Times are the best of K, in process time; ratios
are to the loops by hand, and the run fails if numba or the C model take more than twice as long.
"""

import argparse
import copy
import ctypes
import math
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import cordicc
from cordicc.arith.compiled.compiled_cau import available, compiled_arithmetic
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, pi_fixed
from cordicc.arith.numbers.floating import TAU_HEAD, TAU_TAIL
from cordicc.arith.numbers.formats import PI_SLACK
from cordicc.arith.unit.arithmetic import Arithmetic
from cordicc.arith.unit.cau import implicit_table, standard_table
from cordicc.emulate import functional
from cordicc.ir.sampling import draw
from cordicc.plan.model import Operand, dependence_order
from cordicc.targets.target import CAU_KINDS

CORPUS = Path(__file__).resolve().parents[1] / "tests" / "whole" / "corpus"
HAND_WRITTEN = Path(__file__).with_name("hand_written.c")
BLOCK = 256
STAGES = 24
MOST_TIMES = 2.0
MOST_SAMPLES = 1_000_000
PROBLEM = """
name: vectoring
inputs: {x: [-1, 1], y: [-1, 1]}
equations:
  - norm = hypot(x, y)
  - angle = atan2(y, x)
"""
FLAGS = ["-std=c99", "-O3", "-march=native", "-shared", "-fPIC"]

DRIVER = """
#include "@NAME@.h"
void run(const double *in, long count, double *out) {
    @NAME@_inputs words; @NAME@_outputs results;
    for (long i = 0; i < count; i++) {
        @NAME@_encode(in + i * @NAME@_INPUTS, &words);
        @NAME@_step(&words, &results);
        @NAME@_decode(&results, out + i * @NAME@_OUTPUTS);
    }
}
"""

Answer = dict[str, np.ndarray]


def filled(text: str, **values: object) -> str:
    for name, value in values.items():
        text = text.replace(f"@{name}@", str(value))
    return text


def library(folder: Path, name: str, text: str, *others: str) -> ctypes.CDLL:
    (folder / f"{name}.driver.c").write_text(text, encoding="utf-8")
    out = folder / f"{name}.so"
    sources = [str(folder / f"{name}.driver.c"), *(str(folder / other) for other in others)]
    subprocess.run(["cc", *FLAGS, "-DCORDICC_NO_MAIN", "-o", str(out), *sources, "-lm"], check=True)
    return ctypes.CDLL(str(out))


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def shortened(plan: cordicc.Plan) -> cordicc.Plan:
    """Return the plan with units of `STAGES` iterations."""
    spec: Any = copy.deepcopy(plan.arithmetic.spec)
    spec["units"]["standard"]["iterations"] = STAGES
    return replace(plan, target=replace(plan.target, arithmetic=Arithmetic.from_spec(spec)))


def constants(machine: Arithmetic, steps: int) -> str:
    """Return the constants of the hand-written loops."""
    unit = machine.caus["standard"]
    table = standard_table(unit, 1)
    assert table.shifts == tuple(range(steps))
    shift = table.coordinate_bits + 1 - SCALE_BITS
    lines = {
        "BLOCK": BLOCK,
        "VECTOR_STEPS": steps,
        "ROOM": unit.fraction_bits - unit.operand_bits,
        "SCALE_BITS": SCALE_BITS,
        "HALF_TURN": f"INT64_C({pi_fixed(unit.angle_bits)})",
        "ANGLE_SCALE": float(2.0**unit.angle_bits).hex(),
        "GAIN": f"INT64_C({table.inverse_gain})",
        "GAIN_SHIFT": shift,
        "PI_LIMIT": (math.pi + PI_SLACK).hex(),
        "TAU": math.tau.hex(),
        "TAU_HEAD": TAU_HEAD.hex(),
        "TAU_TAIL": TAU_TAIL.hex(),
    }
    growth: tuple[int, ...] = ()
    implicit = machine.caus.get("implicit")
    if implicit is not None and implicit.iterations == steps:
        solved = implicit_table(implicit, 1)
        assert solved.steps.angles == table.angles
        assert solved.quarter_turns
        growth = solved.steps.target_factors
        lines |= {
            "IMPLICIT_STEPS": steps,
            "TOLERANCE": int(solved.reach.columns.short[-1]),
            "FACTOR_BITS": FACTOR_BITS,
        }
    text = "".join(f"#define {name} ({value})\n" for name, value in lines.items())
    for name, numbers in (("ANGLES", table.angles), ("GROWTH", growth)):
        listed = ", ".join(f"INT64_C({number})" for number in numbers)
        text += f"static const int64_t {name}[] = {{{listed}}};\n" if numbers else ""
    return text


def calls(plan: cordicc.Plan) -> str:
    """Return a function that runs a plan on columns of samples, block by block."""
    names: dict[str, str] = {}
    fixed: dict[str, str] = {}

    def operand(each: Operand) -> str:
        if each.value is not None:
            return names[each.value]
        assert each.constant is not None
        return fixed.setdefault(each.constant, f"k{len(fixed)}")

    inputs = plan.problem.input_names
    lines = []
    for at, name in enumerate(inputs):
        names[name] = f"v{len(names)}"
        lines.append(f"for (int i = 0; i < n; i++) {names[name]}[i] = (float)in[{at}][begin + i];")
    for operation in dependence_order(plan):
        values = [operand(each) for each in operation.operands]
        if operation.op == "cmul":
            values.append(operand(Operand(constant=str(operation.params["factor"]))))
        if operation.op in ("vector", "implicit"):
            assert operation.params["m"] == 1
            sign = operation.params.get("sign") or {"+": 1, "-": -1}[str(operation.params["branch"])]
            values.append(str(sign))
        for result in operation.results:
            made = f"v{len(names)}"
            names[result or made] = made
            values.append(made)
        function = {"cmul": "mul"}.get(operation.op, operation.op)
        lines.append(f"{function}({', '.join(values)}, n);")
    for at, each in enumerate(plan.outputs.values()):
        lines.append(f"for (int i = 0; i < n; i++) out[{at}][begin + i] = {operand(each)}[i];")
    arrays = ", ".join(f"{name}[BLOCK]" for name in (*names.values(), *fixed.values()))
    start = "".join(f"    for (int i = 0; i < BLOCK; i++) {n}[i] = {t}F;\n" for t, n in fixed.items())
    body = "".join(f"        {line}\n" for line in lines)
    return (
        f"static float {arrays};\nvoid run(const double **in, long count, double **out)\n{{\n{start}"
        "    for (long begin = 0; begin < count; begin += BLOCK) {\n"
        f"        int n = (int)(count - begin < BLOCK ? count - begin : BLOCK);\n{body}    }}\n}}\n"
    )


def hand_written(folder: Path, plan: cordicc.Plan, samples: Answer) -> Callable[[], Answer]:
    machine = plan.arithmetic
    here = folder / f"{plan.name}.hand"
    here.mkdir()
    (here / "constants.h").write_text(
        constants(machine, machine.caus["standard"].iterations), encoding="utf-8"
    )
    (here / "calls.h").write_text(calls(plan), encoding="utf-8")
    run = library(here, "hand", HAND_WRITTEN.read_text(encoding="utf-8")).run
    columns = [np.ascontiguousarray(samples[name]) for name in plan.problem.input_names]
    out = {name: np.empty(columns[0].size) for name in plan.outputs}
    ins, outs = ((ctypes.c_void_p * len(a))(*(c.ctypes.data for c in a)) for a in (columns, out.values()))

    def call() -> Answer:
        run(ins, ctypes.c_long(columns[0].size), outs)
        return out

    return call


def c_model(folder: Path, plan: cordicc.Plan, samples: Answer) -> Callable[[], Answer]:
    from cordicc.backends.c import c_model as backend

    files = backend.files(plan)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    (source,) = (name for name in files if name.endswith(".c"))
    name = source.removesuffix(".c")
    run = library(folder, name, filled(DRIVER, NAME=name), source).run
    rows = np.ascontiguousarray(np.stack(list(samples.values()), axis=1))
    out = np.empty((len(rows), len(plan.outputs)))

    def call() -> Answer:
        run(pointer(rows), ctypes.c_long(len(rows)), pointer(out))
        return {output: out[:, at] for at, output in enumerate(plan.outputs)}

    return call


def measure(
    title: str, plan: cordicc.Plan, runs: dict[str, Callable[[], Answer]], args: argparse.Namespace
) -> bool:
    """Print the speeds; tell whether numba and the C model are fast enough."""
    operations = sum(operation.kind in CAU_KINDS for operation in plan.operations)
    print(f"{title}: {operations} unit operations a sample, {args.samples} samples")
    expected = runs["NumPy"]()
    valid = expected["valid"]
    seconds = {}
    for name, run in runs.items():
        answer = run()
        for output in plan.outputs:
            assert np.array_equal(answer[output][valid], expected[output][valid]), (name, output)
        best = float("inf")
        for _ in range(args.repeat):
            before = time.process_time()
            run()
            best = min(best, time.process_time() - before)
        seconds[name] = best
    yardstick = seconds.get("C by hand", min(seconds.values()))
    for name, spent in seconds.items():
        rate = args.samples / spent
        print(
            f"  {name:<14} {rate / 1e6:8.2f} M samples/s  {rate * operations / 1e6:8.2f} M unit operations/s"
            f"  {spent / yardstick:6.2f} times {'C by hand' if 'C by hand' in seconds else 'the fastest'}"
        )
    slow = [name for name in ("numba", "C model") if seconds.get(name, 0.0) > MOST_TIMES * yardstick]
    return "C by hand" not in seconds or not slow


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=400_000)
    parser.add_argument("--repeat", type=int, default=5)
    args = parser.parse_args()
    if args.samples > MOST_SAMPLES:
        parser.error(f"at most {MOST_SAMPLES} samples: longer runs take compiled units by themselves")
    good = True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "vectoring.yaml").write_text(PROBLEM, encoding="utf-8")
        vectoring = shortened(cordicc.compile(folder / "vectoring.yaml"))
        puma = cordicc.compile(CORPUS / "puma560.yaml")
        for title, plan in (("24-stage vectoring unit", vectoring), ("PUMA 560", puma)):
            samples = draw(plan.problem.workspace, args.samples, 0)
            machine = plan.arithmetic
            runs: dict[str, Callable[[], Answer]] = {"NumPy": _emulator(plan, machine, samples)}
            if available():
                runs["numba"] = _emulator(plan, compiled_arithmetic(machine), samples)
            if shutil.which("cc") and find_spec("cordicc.backends.c.c_model"):
                runs["C model"] = c_model(folder, plan, samples)
            if shutil.which("cc"):
                runs["C by hand"] = hand_written(folder, plan, samples)
            good &= measure(title, plan, runs, args)
    return int(not good)


def _emulator(plan: cordicc.Plan, machine: Arithmetic, samples: Answer) -> Callable[[], Answer]:
    return lambda: functional.run(plan, machine, samples)


if __name__ == "__main__":
    sys.exit(main())
