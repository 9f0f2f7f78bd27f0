"""Run the hyperbolic implicit rules over every input of a small format and compare with the proven bound.

    python benchmarks/convergence_hyperbolic.py [--bits N] [--jobs J]

An input is (A, B, C) of the integers from -2^(N-1) to 2^(N-1) for which B cosh t + A sinh t = C has a
solution in the convergence domain (1.118 by single rotations, 2.236 by root-free ones); where it has two,
each is an input.

Reduction. A unit negates the equation where A < 0 and |A| >= |B|, and takes the second of two solutions as
the mirror image, -A for A and -t for t. Both are exact on integers, so the kernels meet every input as one
with A > 0, A >= |B|, or with |B| > |A| and the solution that has x >= 0. The runs cover those; each stands
for two inputs.

Vectors enter with GUARD_BITS more fraction bits. Printed are the worst residual |B cosh t + A sinh t - C|
and the worst error of the second result against sqrt(A^2 - B^2 + C^2) divided by its own condition number,
in ulp of the format, and the inputs beyond the bounds of `cordicc.arith.kernels.hyperbolic_bound`, which
depend on A, B, C.
"""

import argparse
import multiprocessing
import time
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cordicc.arith.kernels import micro_rotations, shift_sequences
from cordicc.arith.kernels.hyperbolic_bound import hyperbolic_residual_bound

RULES = ("single-rotation", "root-free")
GUARD_BITS = 10
ANGLE_BITS = 34

Int64 = NDArray[np.int64]


class Tally(NamedTuple):
    """Worst errors over inputs; `share` is the largest ratio of a residual to its bound."""

    inputs: int = 0
    residual: float = 0.0
    root: float = 0.0
    limit: float = 0.0
    beyond: int = 0
    share: float = 0.0

    def __add__(self, other: Any) -> "Tally":
        return Tally(
            self.inputs + other.inputs,
            max(self.residual, other.residual),
            max(self.root, other.root),
            max(self.limit, other.limit),
            self.beyond + other.beyond,
            max(self.share, other.share),
        )


def sequence_of(rule: str, bits: int) -> shift_sequences.Sequence:
    """Return the steps whose last angle moves the largest vector by some tenths of an ulp."""
    return (
        shift_sequences.root_free(-1, bits + 6)
        if rule == "root-free"
        else shift_sequences.standard(-1, bits + 5)
    )


def in_reach(A: Int64, B: Int64, C: Int64, domain: float) -> NDArray[np.bool_]:
    """Return where there is a solution whose angle is within the domain."""
    a, b, c = (v.astype(np.float64) for v in (A, B, C))
    one, two = (A > 0) & (np.abs(B) < A), np.abs(B) > np.abs(A)
    edge = (A > 0) & (np.abs(B) == A) & (B * C > 0)
    norm = np.sqrt(np.maximum(np.abs(a * a - b * b), 1))
    angle = np.full(a.shape, np.inf)
    angle[one] = (np.arcsinh(c[one] / norm[one])) - np.arctanh(b[one] / a[one])
    two &= (A * A - B * B + C * C >= 0) & (B * C > 0)
    angle[two] = np.arccosh(np.maximum(np.abs(c[two]) / norm[two], 1)) - np.arctanh(a[two] / np.abs(b[two]))
    angle[edge] = np.log(c[edge] / b[edge])
    return np.asarray(np.abs(angle) <= domain)


def column(rule: str, bits: int, A: int) -> Tally:
    """Return the tally of every B and C for one A."""
    side = 1 << (bits - 1)
    numbers = np.arange(-side, side + 1, dtype=np.int64)
    B, C = (v.ravel() for v in np.meshgrid(numbers, numbers))
    sequence = sequence_of(rule, bits)
    reached = in_reach(np.full_like(B, A), B, C, sequence.domain)
    if not reached.any():
        return Tally()
    B, C = B[reached], C[reached]
    table = shift_sequences.step_table(sequence, ANGLE_BITS)
    kernel = micro_rotations.implicit_root_free if rule == "root-free" else micro_rotations.implicit
    start_x, start_y, target = (v << GUARD_BITS for v in (np.full_like(B, A), B, C))
    x, _, _, z = kernel(start_x, start_y, target, np.zeros_like(B), table)
    t, x = np.ldexp(z.astype(np.float64), -ANGLE_BITS), np.ldexp(x / sequence.gain, -GUARD_BITS)
    a, b, c = np.full(len(B), float(A)), B.astype(np.float64), C.astype(np.float64)
    parts = hyperbolic_residual_bound(sequence, GUARD_BITS, ANGLE_BITS, float(side))
    assert parts.smallest_start < 1
    bound = parts.residual(a, b, c)
    residual = np.abs(b * np.cosh(t) + a * np.sinh(t) - c)
    root = np.sqrt((A * A - B * B + C * C).astype(np.float64))
    error = np.abs(np.abs(x) - root)
    beyond = (residual > bound) | (error > parts.root(a, b, c)) | (x < parts.smallest_end_x(a, b, c))
    condition = np.maximum(1, np.abs(c) / np.maximum(root, 1))
    return Tally(
        2 * len(B),
        float(residual.max()),
        float((error / condition)[root >= 1].max(initial=0)),
        float(bound.max()),
        2 * int(beyond.sum()),
        float((residual / bound).max()),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Run the hyperbolic implicit rules over a small format.")
    parser.add_argument("--bits", type=int, default=9, help="width of the format, sign included")
    parser.add_argument("--jobs", type=int, default=None, help="processes, default: all cores")
    options = parser.parse_args()
    if not 4 <= options.bits <= 11:
        parser.error("--bits must be from 4 to 11")
    side = 1 << (options.bits - 1)
    for rule in RULES:
        began = time.perf_counter()
        sequence, total = sequence_of(rule, options.bits), Tally()
        with multiprocessing.Pool(options.jobs) as pool:
            for tally in pool.imap_unordered(partial(column, rule, options.bits), range(-side, side + 1)):
                total += tally
        print(f"{rule}: {len(sequence.shifts)} iterations, last angle {sequence.resolution:.4g} rad")
        print(f"  every {options.bits}-bit input within {sequence.domain:.4f} rad: {total.inputs:,} inputs")
        print(f"    worst residual {total.residual:.6g} ulp, worst root / condition {total.root:.6g} ulp")
        share = 100 * total.beyond / total.inputs
        print(f"    beyond the bound (largest: {total.limit:.6g} ulp): {total.beyond:,} ({share:.4g} %)")
        tightness = total.limit / total.residual
        print(f"    bound / worst observed {tightness:.2f}, nearest {100 * total.share:.1f} %")
        print(f"  {time.perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
