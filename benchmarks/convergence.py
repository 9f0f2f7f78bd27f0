"""Run the implicit rules over every input of a small format and compare with the proven bound.

    python benchmarks/convergence.py [--bits N] [--jobs J]
        [--rule single-rotation|root-free|paper|paper-integer|all]

An input is a vector (A, B) = (x, y) other than (0, 0), a target C with |C| <= R and a branch; the numbers
are the integers from -2^(N-1) to 2^(N-1), which holds every N-bit word and the negative of every one.

Reduction. Both units make x >= 0 before the first step: a start with x < 0 is negated (half a turn), and
branch "+" is branch "-" of (-x, y) with the angle negated. Both are exact on integers, so (x, y, C) on
either branch and (-x, -y, C), (-x, y, C), (x, -y, C) meet the kernel as (|x|, +-y, C). Running the kernel
over x >= 0, every y and every C is therefore complete; each run stands for four inputs (two where x = 0).
No further symmetry is used: rounding half up and sgn(0) = +1 are not symmetric in y.

Vectors enter with GUARD_BITS more fraction bits. Printed are the inputs covered, the worst residual |B cos
t + A sin t - C| in ulp of the format, the worst |t - exact| divided by the condition number |dt/dC| =
1/sqrt(R^2 - C^2), so in ulp too, and the inputs beyond the bound of `cordicc.arith.kernels.circular_bound`,
which depends on R, or on the other branch's side of x = 0 by more than it allows.

The paper's rule (Krieger and Hosticka 1996, eq. 9, vector scaled by 1 - eta 2^-2S after each step) runs
in double precision, so its failures are the rule's own, over the same inputs and over random unit vectors
with C = sin(uniform) and with uniform C. It has no proven bound: a failure is a residual above 1e-4 R,
6.5 times its last angle. `paper-integer` is the same in fixed point, by the library's kernel with
PAPER_GUARD_BITS more bits (random vectors: PAPER_BITS), and counts the failures that it reports as valid.
"""

import argparse
import math
import multiprocessing
import time
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.kernels import micro_rotations, shift_sequences
from cordicc.arith.kernels.circular_bound import ImplicitBound, implicit_residual_bound
from cordicc.studies.scaled_kernels import implicit_scaled

RULES = ("single-rotation", "root-free", "paper", "paper-integer")
PAPERS = ("paper", "paper-integer")
GUARD_BITS = 6
PAPER_GUARD_BITS = 20
PAPER_BITS = 30
ANGLE_BITS = 30
BLOCK = 1 << 15
FAILED = 1e-4
SAMPLES = 2_000_000

Reals = NDArray[np.float64]
Int64 = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Tally(NamedTuple):
    """Worst errors over inputs; `share` is the largest ratio of a residual to its bound.

    `beyond` counts residuals above the bound, `unflagged` those of them that the unit reports as valid.
    """

    inputs: int = 0
    residual: float = 0.0
    angle: float = 0.0
    beyond: int = 0
    share: float = 0.0
    unflagged: int = 0

    def __add__(self, other: Any) -> "Tally":
        return Tally(
            self.inputs + other.inputs,
            max(self.residual, other.residual),
            max(self.angle, other.angle),
            self.beyond + other.beyond,
            max(self.share, other.share),
            self.unflagged + other.unflagged,
        )


def sequence_of(rule: str, bits: int) -> shift_sequences.Sequence:
    """Return the steps whose last angle moves the largest vector by less than a fifth of an ulp."""
    if rule in PAPERS:
        return shift_sequences.krieger96()
    return (
        shift_sequences.root_free(1, bits + 4)
        if rule == "root-free"
        else shift_sequences.standard(1, bits + 3)
    )


def bound_of(rule: str, bits: int) -> ImplicitBound:
    """Return the bound in ulp of the format."""
    largest = math.ldexp(math.sqrt(2), bits - 1)
    return implicit_residual_bound(sequence_of(rule, bits), GUARD_BITS, ANGLE_BITS, largest)


def angle_by_kernel(rule: str, bits: int, x: Int64, y: Int64, target: Int64) -> Reals:
    """Return the angles of branch "-" in radians, by the library's kernel; x >= 0."""
    table = shift_sequences.step_table(sequence_of(rule, bits), ANGLE_BITS)
    x, y, target = (v << GUARD_BITS for v in (x, y, target))
    z = np.zeros_like(x)
    if rule == "root-free":
        z = micro_rotations.implicit_root_free(x, y, target, z, table)[3]
    else:
        quarter = (shift_sequences.pi_fixed(ANGLE_BITS) + 1) >> 1
        x, y, z = micro_rotations.quarter_turn(x, y, target, z, quarter)
        z = micro_rotations.implicit(x, y, target, z, table)[3]
    return np.ldexp(z.astype(np.float64), -ANGLE_BITS)


def angle_by_paper(x: Reals, y: Reals, target: Reals) -> Reals:
    """Return the angles turned by eq. 9 with the paper's sequence and scaling."""
    sequence = shift_sequences.krieger96()
    x, y, z = x.copy(), y.copy(), np.zeros_like(x)
    for shift, eta in zip(sequence.shifts, sequence.eta, strict=True):
        h = 2.0**-shift
        sigma = np.where((y < target) == (x >= 0), 1.0, -1.0)
        scale = 1 - eta * h * h
        keep, turn = (1 - h * h) * scale, 2 * h * scale * sigma
        x, y = keep * x - turn * y, keep * y + turn * x
        z += 2 * math.atan(h) * sigma
    return z


def angle_by_paper_in_integers(x: Reals, y: Reals, target: Reals, bits: int) -> tuple[Reals, Mask]:
    """Return the angles turned by eq. 9 in fixed point, the start rounded to `bits`, and the valid flags."""
    table = shift_sequences.step_table(shift_sequences.krieger96(), ANGLE_BITS)
    words = [np.rint(np.ldexp(v, bits)).astype(np.int64) for v in (x, y, target)]
    _, _, z, valid = implicit_scaled(words[0], words[1], words[2], np.zeros_like(words[0]), table)
    return np.ldexp(z.astype(np.float64), -ANGLE_BITS), valid


def measured(rule: str, bits: int, x: Any, y: Any, target: Any, weight: int) -> Tally:
    """Return the tally of solvable inputs, each counted `weight` times."""
    A, B, C = (v.astype(np.float64) for v in (x, y, target))
    R = np.hypot(A, B)
    flagged = np.zeros(len(R), dtype=np.bool_)
    if rule in PAPERS:
        if rule == "paper":
            t = angle_by_paper(A, B, C)
        else:
            t, valid = angle_by_paper_in_integers(A, B, C, PAPER_GUARD_BITS if bits else PAPER_BITS)
            flagged = ~valid
        bound, wrong_side = FAILED * R, np.zeros(len(R), dtype=np.bool_)
    else:
        t = angle_by_kernel(rule, bits, x, y, target)
        parts = bound_of(rule, bits)
        bound = parts.residual(R)
        wrong_side = A * np.cos(t) - B * np.sin(t) < parts.smallest_end_x(R)
    residual = np.abs(B * np.cos(t) + A * np.sin(t) - C)
    wanted, start = np.arcsin(np.clip(C / R, -1, 1)), np.arctan2(B, A)
    error = np.abs(_wrapped(t - (wanted - start)))
    if rule in PAPERS:  # either solution is right: the rule does not choose
        error = np.minimum(error, np.abs(_wrapped(t - (np.pi - wanted - start))))
    relative = error * np.sqrt(np.maximum((R - C) * (R + C), 0))
    beyond = (residual > bound) | wrong_side
    return Tally(
        weight * len(R),
        float(residual.max()),
        float(relative.max()),
        weight * int(beyond.sum()),
        float((residual / bound).max()),
        weight * int((beyond & ~flagged).sum()),
    )


def _wrapped(angle: Reals) -> Reals:
    return angle - 2 * np.pi * np.rint(angle / (2 * np.pi))


def column(rule: str, bits: int, x: int) -> Tally:
    """Return the tally of every y and C for one x."""
    side = 1 << (bits - 1)
    total = Tally()
    targets = np.arange(-side, side + 1, dtype=np.int64)
    rows = max(1, BLOCK // len(targets))
    for first in range(-side, side + 1, rows):
        y, target = np.meshgrid(
            np.arange(first, min(first + rows, side + 1), dtype=np.int64), targets, indexing="ij"
        )
        square = x * x + y * y
        solvable = (target * target <= square) & (square > 0)
        if solvable.any():
            y, target = y[solvable], target[solvable]
            total += measured(rule, bits, np.full_like(y, x), y, target, 4 if x else 2)
    return total


def exhaustive(rule: str, bits: int, jobs: int) -> Tally:
    """Return the tally of every input of the format."""
    total = Tally()
    with multiprocessing.Pool(jobs) as pool:
        for tally in pool.imap_unordered(partial(column, rule, bits), range((1 << (bits - 1)) + 1)):
            total += tally
    return total


def random_targets(rule: str, uniform_sine: bool, samples: int = SAMPLES) -> Tally:
    """Return the paper's tally over random unit vectors and targets."""
    rng = np.random.default_rng(1996)
    total = Tally()
    for _ in range(0, samples, BLOCK):
        count = min(BLOCK, samples - total.inputs)
        start = rng.uniform(-np.pi, np.pi, count)
        target = rng.uniform(-1, 1, count)
        if not uniform_sine:
            target = np.sin(target * np.pi / 2)
        total += measured(rule, 0, np.cos(start), np.sin(start), target, 1)
    return total


def show(name: str, tally: Tally, limit: float, unit: str, kind: str, flags: bool = False) -> None:
    print(f"  {name}: {tally.inputs:,} inputs")
    print(f"    worst residual {tally.residual:.6g} {unit}")
    print(f"    worst angle error / condition number {tally.angle:.6g} {unit}")
    share = 100 * tally.beyond / tally.inputs
    print(f"    beyond the {kind} (largest: {limit:.6g} {unit}): {tally.beyond:,} ({share:.4g} %)")
    if flags:
        print(f"    of these reported as valid: {tally.unflagged:,}")
    print(f"    {kind} / worst observed {limit / tally.residual:.2f}, nearest {100 * tally.share:.1f} %")


def main() -> None:
    parser = argparse.ArgumentParser(description="Run the implicit rules over every input of a small format.")
    parser.add_argument("--bits", type=int, default=10, help="width of the format, sign included")
    parser.add_argument("--rule", choices=(*RULES, "all"), default="all")
    parser.add_argument("--jobs", type=int, default=None, help="processes, default: all cores")
    options = parser.parse_args()
    if not 4 <= options.bits <= 12:
        parser.error("--bits must be from 4 to 12")
    radius = math.ldexp(math.sqrt(2), options.bits - 1)
    for rule in RULES if options.rule == "all" else (options.rule,):
        began = time.perf_counter()
        sequence = sequence_of(rule, options.bits)
        print(f"{rule}: {len(sequence.shifts)} iterations, last angle {sequence.resolution:.4g} rad")
        name = f"every {options.bits}-bit input, both branches"
        if rule in PAPERS:
            flags = rule == "paper-integer"
            whole = exhaustive(rule, options.bits, options.jobs)
            show(name, whole, FAILED * radius, "ulp", "limit", flags)
            for uniform, which in ((False, "C = sin(uniform)"), (True, "uniform C")):
                random = random_targets(rule, uniform)
                show(f"random unit vectors, {which}", random, FAILED, "R", "limit", flags)
        else:
            parts = bound_of(rule, options.bits)
            assert parts.smallest_norm <= 1
            show(name, exhaustive(rule, options.bits, options.jobs), parts.residual(radius), "ulp", "bound")
        print(f"  {time.perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
