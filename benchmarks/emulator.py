"""Measure the emulator: one vectoring unit of 24 stages and 32-bit mantissas, and the PUMA 560 plan.

    python benchmarks/emulator.py [--samples N] [--repeat K]

On one core, in one run: NumPy, numba if it is installed, and, if there is a C compiler (`cc`), the C model of
the plan and a hand-written loop of the same vectoring over blocks, both with -O3 for this machine.  A unit
operation is one of a CAU; samples go in as numbers and come out as numbers, rounding to words included.
All must give the same bits.  Times are the best of K, in process time; ratios are to the fastest.
"""

import argparse
import copy
import ctypes
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

import cordicc
from cordicc.arith.cau import Cau, standard_table
from cordicc.arith.compiled import available, compiled_arithmetic
from cordicc.arith.reduction import SCALE_BITS
from cordicc.arith.sequences import pi_fixed
from cordicc.emulate import functional
from cordicc.emulate.sampling import draw
from cordicc.observation import machine_of
from cordicc.targets.model import CAU_KINDS

CORPUS = Path(__file__).resolve().parents[1] / "tests" / "corpus"
STAGES = 24
MOST_SAMPLES = 1_000_000
PROBLEM = """
name: vectoring
inputs: {x: [-1, 1], y: [-1, 1]}
equations:
  - norm = hypot(x, y)
  - angle = atan2(y, x)
"""
FLAGS = ["-std=c99", "-O3", "-march=native", "-shared", "-fPIC"]

HAND_WRITTEN = """
#include <math.h>
#include <stdint.h>
#include <string.h>
#define BLOCK 256
static const int64_t ANGLES[] = {@ANGLES@};
static int64_t unpack(float v, int64_t *e) {
    int64_t bits; double d = v; memcpy(&bits, &d, 8);
    int64_t zero = -(d == 0), s = bits >> 63;
    *e = ((((bits >> 52) & 0x7ff) - 1022 - 24) & ~zero) | (-4096 & zero);
    return ((((bits & 0xfffffffffffff) | 0x10000000000000) >> 29 ^ s) - s) & ~zero;
}
static int64_t shifted(int64_t m, int64_t right) {
    int64_t left = right < 0 ? -right : 0, count = right > 0 ? right : 0;
    if (left > 62) left = 62;
    if (count > 62) count = 62;
    return (int64_t)((uint64_t)m << left) + ((INT64_C(1) << count) >> 1) >> count;
}
static double power(int64_t e) {
    if (e < -1022) e = -1022;
    if (e > 1023) e = 1023;
    int64_t bits = (e + 1023) << 52; double d; memcpy(&d, &bits, 8); return d;
}
void run(const double *x, const double *y, int64_t count, double *norm, double *angle) {
    static int64_t a[BLOCK], b[BLOCK], c[BLOCK], ae[BLOCK], be[BLOCK], e[BLOCK];
    for (int64_t begin = 0; begin < count; begin += BLOCK) {
        int n = (int)(count - begin < BLOCK ? count - begin : BLOCK);
        const double *u = x + begin, *v = y + begin;
        for (int i = 0; i < n; i++) a[i] = unpack((float)u[i], &ae[i]);
        for (int i = 0; i < n; i++) b[i] = unpack((float)v[i], &be[i]);
        for (int i = 0; i < n; i++) e[i] = (ae[i] > be[i] ? ae[i] : be[i]) - @ROOM@;
        for (int i = 0; i < n; i++) {
            int64_t side = a[i] >> 63, up = b[i] >> 63;
            c[i] = ((@HALF_TURN@ ^ up) - up) & side;
            a[i] = (shifted(a[i], e[i] - ae[i]) ^ side) - side;
            b[i] = (shifted(b[i], e[i] - be[i]) ^ side) - side;
        }
        for (int step = 0; step < @STAGES@; step++) {
            int64_t half = (INT64_C(1) << step) >> 1, turn = ANGLES[step];
            for (int i = 0; i < n; i++) {
                int64_t mask = b[i] >> 63, by = (b[i] + half) >> step;
                b[i] -= (((a[i] + half) >> step) ^ mask) - mask;
                a[i] += by < 0 ? -by : by;
                c[i] += (turn ^ mask) - mask;
            }
        }
        for (int i = 0; i < n; i++) {
            int64_t low = a[i] & 7, high = a[i] >> 3, g = @GAIN@;
            int64_t carry = (low * g + (INT64_C(1) << @GAIN_SHIFT_LESS_1@)) >> 3;
            int64_t q = (high * g + carry) >> (@GAIN_SHIFT@ - 3);
            norm[begin + i] = (float)((double)q * power(e[i] - @SCALE_BITS@));
        }
        for (int i = 0; i < n; i++) {
            int64_t least = v[i] >= 0 ? 0 : -@HALF_TURN@, most = v[i] > 0 || u[i] < 0 ? @HALF_TURN@ : 0;
            int64_t t = c[i] < least ? least : c[i];
            t = t > most ? most : t;
            float word = (float)((double)t * @ANGLE_UNIT@);
            float pi = 3.14159250259399414f;
            word = word > pi ? pi : word < -pi ? -pi : word;
            angle[begin + i] = (float)u[i] == 0 && (float)v[i] == 0 ? NAN : word;
        }
    }
}
"""

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
    target = copy.deepcopy(plan.target)
    target["arithmetic"]["units"]["standard"]["iterations"] = STAGES
    return replace(plan, target=target)


def hand_written(folder: Path, unit: Cau, samples: Answer) -> Callable[[], Answer]:
    table = standard_table(unit, 1)
    shift = table.coordinate_bits + 1 - SCALE_BITS
    text = filled(
        HAND_WRITTEN,
        ANGLES=", ".join(f"INT64_C({angle})" for angle in table.angles),
        STAGES=STAGES,
        ROOM=unit.fraction_bits - unit.operand_bits,
        HALF_TURN=f"INT64_C({pi_fixed(unit.angle_bits)})",
        GAIN=f"INT64_C({table.inverse_gain})",
        GAIN_SHIFT_LESS_1=shift - 1,
        GAIN_SHIFT=shift,
        SCALE_BITS=SCALE_BITS,
        ANGLE_UNIT=float(2.0**-unit.angle_bits).hex(),
    )
    run = library(folder, "hand", text).run
    x, y = samples["x"], samples["y"]
    norm, angle = np.empty(x.size), np.empty(x.size)

    def call() -> Answer:
        run(pointer(x), pointer(y), ctypes.c_int64(x.size), pointer(norm), pointer(angle))
        return {"norm": norm, "angle": angle}

    return call


def c_model(folder: Path, plan: cordicc.Plan, samples: Answer) -> Callable[[], Answer]:
    from cordicc.backends import c_model as backend

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
) -> None:
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
    fastest = min(seconds.values())
    for name, spent in seconds.items():
        rate = args.samples / spent
        print(
            f"  {name:<14} {rate / 1e6:8.2f} M samples/s  {rate * operations / 1e6:8.2f} M unit operations/s"
            f"  {spent / fastest:6.2f} times the fastest"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=400_000)
    parser.add_argument("--repeat", type=int, default=5)
    args = parser.parse_args()
    if args.samples > MOST_SAMPLES:
        parser.error(f"at most {MOST_SAMPLES} samples: longer runs take compiled units by themselves")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "vectoring.yaml").write_text(PROBLEM, encoding="utf-8")
        vectoring = shortened(cordicc.compile(folder / "vectoring.yaml"))
        puma = cordicc.compile(CORPUS / "puma560.yaml")
        for title, plan in (("24-stage vectoring unit", vectoring), ("PUMA 560", puma)):
            samples = draw(plan.problem, args.samples, 0)
            machine = machine_of(plan)
            runs: dict[str, Callable[[], Answer]] = {"NumPy": _emulator(plan, machine, samples)}
            if available():
                runs["numba"] = _emulator(plan, compiled_arithmetic(machine), samples)
            if shutil.which("cc") and find_spec("cordicc.backends.c_model"):
                runs["C model"] = c_model(folder, plan, samples)
            if shutil.which("cc") and plan is vectoring:
                runs["C by hand"] = hand_written(folder, machine.caus["standard"], samples)
            measure(title, plan, runs, args)


def _emulator(plan: cordicc.Plan, machine: functional.Arithmetic, samples: Answer) -> Callable[[], Answer]:
    return lambda: functional.run(plan, machine, samples)


if __name__ == "__main__":
    main()
