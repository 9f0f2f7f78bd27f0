"""Measure the units' errors on two's-complement words and compare them with the proven bounds.

    python benchmarks/accuracy.py [--part exhaustive|random|all] [--samples N] [--bits W] [--jobs J]

The units are those that `cordicc.arith.unit.sizing` gives for 1 ulp, last rounding included, and run through
their public methods. A w-bit word of a length has w - 1 fraction bits, one of an angle w - 3 (+-4 rad).

Exhaustive: every pair of 12-bit words, as the module's `PAIRS` says, third operands zero or drawn. Random: N
samples of W-bit words (24) for each operation (default ten million), of which a quarter is adversarial: axes,
tiny vectors, powers of two and their neighbours, the largest words, angles at and beside multiples of
pi/4, |C| at and just below R.

Columns. `unrounded`: the largest error of the unit's result before it is rounded to a word, in ulp of a
word; `rounded`: after that. `bound`: the proven bound of the latter (of the former where the result is not
rounded). Results that leave the word's range are not counted; `lost` would be results within it, or
solvable equations, that came out invalid, and makes the command fail, as an error beyond its bound, beyond
1 ulp or below a quarter of the bound does. For an implicit operation `residual` is |B cos t + A sin t - C| at
the unit's own t, in ulp of the operands; `angle` the same over R in ulp of an angle, and `rounded` that of t
as a word. For m = -1, R is the larger of |C| and sqrt(A^2 - B^2 + C^2).

The reference is NumPy's long double; its functions err by less than 2^-62 (2^-51 where it is a double), so
by less than 2^-27 ulp of 24 bits (2^-21 of 30). The worst sample of every row is evaluated again by mpmath
at 200 bits, and a difference of more than 2^-20 ulp makes the command fail.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import mpmath
import numpy as np
from numpy.typing import NDArray

from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.arith.unit.cau import Cau
from cordicc.arith.unit.sizing import LAST_ROUNDING_ULP, OPERATIONS, internal_errors_ulp, size_unit

EXHAUSTIVE_BITS = 12
RANDOM_BITS = 24
BLOCK = 1 << 16
SEED = 1992
LIMIT_ULP = 1.0
LARGEST_RATIO = 4.0
RULES = ("single-rotation", "root-free")

Words = NDArray[np.int64]
Reals = NDArray[np.float64]
Extended = NDArray[np.longdouble]
mp = mpmath.MPContext()
mp.prec = 200


class Job(NamedTuple):
    """An operation on a unit; `branch` for implicit operations only."""

    operation: str
    unit: Cau
    bits: int
    branch: str = ""

    @property
    def angle_places(self) -> tuple[bool, ...]:
        """Which operands are angles."""
        if self.operation in ("rotate-circular", "rotate-hyperbolic"):
            return (False, False, True)
        return (False,) * (2 if self.operation == "lightcone" else 3)

    @property
    def length(self) -> FixedPoint:
        return FixedPoint(self.bits, self.bits - 1)

    @property
    def angle(self) -> FixedPoint:
        return FixedPoint(self.bits, self.bits - 3)

    def decoded_angle(self, values: Reals) -> Reals:
        """Return angles rounded to words, circular ones as the emulator does."""
        circular = self.operation.endswith("-circular")
        return self.angle.decode((self.angle.encode_angle if circular else self.angle.encode)(values))

    def run(self, operands: list[Reals]) -> tuple[Reals, Reals]:
        """Return the unit's two results, not rounded."""
        kind, _, system = self.operation.partition("-")
        m = {"circular": 1, "linear": 0, "hyperbolic": -1, "": -1}[system]
        if kind == "rotate":
            return self.unit.rotate(m, *operands)
        if kind == "vector":
            return self.unit.vector(m, 1, *operands)
        if kind == "lightcone":
            return self.unit.lightcone(*operands)
        return self.unit.implicit(m, self.branch, *operands)


class Functions(NamedTuple):
    """The functions of a reference: NumPy's long double or mpmath."""

    cos: Callable[[Any], Any]
    sin: Callable[[Any], Any]
    cosh: Callable[[Any], Any]
    sinh: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]
    log: Callable[[Any], Any]
    atan2: Callable[[Any, Any], Any]


NUMPY = Functions(np.cos, np.sin, np.cosh, np.sinh, np.sqrt, np.log, np.arctan2)
MPMATH = Functions(mp.cos, mp.sin, mp.cosh, mp.sinh, mp.sqrt, mp.log, mp.atan2)


class Error(NamedTuple):
    """Errors of one result in ulp, NaN where it does not count; `lost` invalid results that should not be."""

    result: str
    unrounded: Reals
    rounded: Reals | None
    lost: int


class Tally(NamedTuple):
    """Worst errors of one result over samples, and the operands of the worst unrounded one."""

    samples: int = 0
    unrounded: float = 0.0
    rounded: float | None = None
    lost: int = 0
    worst: tuple[float, ...] = ()

    def __add__(self, other: Any) -> Tally:
        first = self if self.unrounded >= other.unrounded else other
        both = [r for r in (self.rounded, other.rounded) if r is not None]
        return Tally(
            self.samples + other.samples,
            first.unrounded,
            max(both) if both else None,
            self.lost + other.lost,
            first.worst,
        )


def exact_results(operation: str, f: Functions, operands: list[Any]) -> list[tuple[str, Any]]:
    """Return the exact results of an explicit operation, by the names of their bounds."""
    x, y, *rest = operands
    if operation == "rotate-circular":
        cos, sin = f.cos(rest[0]), f.sin(rest[0])
        return [("vector", x * cos - y * sin), ("vector", y * cos + x * sin)]
    if operation == "rotate-linear":
        return [("vector", y + x * rest[0])]
    if operation == "rotate-hyperbolic":
        cosh, sinh = f.cosh(rest[0]), f.sinh(rest[0])
        return [("vector", x * cosh + y * sinh), ("vector", y * cosh + x * sinh)]
    if operation == "vector-circular":
        return [("norm", f.sqrt(x * x + y * y)), ("angle", rest[0] + f.atan2(y, x))]
    if operation == "vector-linear":
        return [("quotient", rest[0] + y / x)]
    if operation == "vector-hyperbolic":
        u, v = x + y, x - y
        return [("norm", f.sqrt(u * v)), ("angle", rest[0] + f.log(u / v) / 2)]
    return [("norm", f.sqrt(x * y)), ("angle", f.log(x / y) / 2)]


def exact_residual(operation: str, f: Functions, operands: list[Any], t: Any) -> tuple[Any, Any]:
    """Return |B cos t + A sin t - C| and R, or with cosh and sinh and S."""
    A, B, C = operands
    if operation == "implicit-circular":
        return abs(B * f.cos(t) + A * f.sin(t) - C), f.sqrt(A * A + B * B)
    return abs(B * f.cosh(t) + A * f.sinh(t) - C), f.sqrt(abs((A - B) * (A + B) + C * C))


def explicit_errors(job: Job, operands: list[Reals]) -> list[Error]:
    """Return the errors of both results of an explicit operation."""
    values = job.run(operands)[1 if job.operation.endswith("-linear") else 0 :]
    exact = exact_results(job.operation, NUMPY, [v.astype(np.longdouble) for v in operands])
    errors = []
    fits = np.ones(len(operands[0]), dtype=bool)
    if job.operation == "rotate-hyperbolic":  # its bound is that of the larger result, which must be a word
        for _, value in exact:
            fits &= np.abs(value) < 1
    if job.operation == "vector-circular":  # (0, 0) has no angle
        fits &= (operands[0] != 0) | (operands[1] != 0)
    for (name, wanted), value in zip(exact, values, strict=True):
        format_ = job.angle if name == "angle" else job.length
        encode = (
            format_.encode_angle if job.operation == "vector-circular" and name == "angle" else format_.encode
        )
        rounded = format_.decode(encode(value))
        largest = format_.largest_word * format_.ulp
        inside = fits & np.isfinite(wanted) & (np.abs(wanted) <= largest - format_.ulp)
        counts = fits & ~np.isnan(rounded) & np.isfinite(wanted)
        errors.append(
            Error(
                name,
                _ulps(value - wanted, format_, counts),
                _ulps(rounded - wanted, format_, counts),
                int((inside & np.isnan(rounded)).sum()),
            )
        )
    return errors


def _ulps(difference: Extended, format_: FixedPoint, counts: NDArray[np.bool_]) -> Reals:
    return np.where(counts, np.abs(difference) / format_.ulp, np.nan).astype(np.float64)


def implicit_errors(job: Job, operands: list[Reals]) -> list[Error]:
    """Return the residuals of an implicit operation whose equations all have a solution."""
    t, _ = job.run(operands)
    extended = [v.astype(np.longdouble) for v in operands]
    residual, scale = exact_residual(job.operation, NUMPY, extended, t.astype(np.longdouble))
    rounded_t = job.decoded_angle(t)
    rounded, _ = exact_residual(job.operation, NUMPY, extended, rounded_t.astype(np.longdouble))
    counts = ~np.isnan(t)
    if job.operation == "implicit-hyperbolic":
        scale = np.maximum(scale, np.abs(extended[2]))
        counts &= scale < 1
    turned = counts & ~np.isnan(rounded_t)
    return [
        Error("residual", _ulps(residual, job.length, counts), None, int(np.isnan(t).sum())),
        Error(
            "angle", _ulps(residual / scale, job.angle, turned), _ulps(rounded / scale, job.angle, turned), 0
        ),
    ]


def tallied(job: Job, words: list[Words]) -> dict[str, Tally]:
    """Run a block of operands."""
    implicit = job.operation.startswith("implicit")
    if implicit:
        words = [column[solvable(job, *words)] for column in words]
    operands = [
        (job.angle if is_angle else job.length).decode(column)
        for column, is_angle in zip(words, job.angle_places, strict=True)
    ]
    tallies: dict[str, Tally] = {}
    if not len(operands[0]):
        return tallies
    with np.errstate(all="ignore"):
        errors = (implicit_errors if implicit else explicit_errors)(job, operands)
    for error in errors:
        counted = ~np.isnan(error.unrounded)
        tally = Tally(lost=error.lost)
        if counted.any():
            index = int(np.nanargmax(error.unrounded))
            worst = tuple(float(column[index]) for column in operands)
            largest = None if error.rounded is None else float(np.nanmax(error.rounded))
            tally = Tally(int(counted.sum()), float(error.unrounded[index]), largest, error.lost, worst)
        tallies[error.result] = tallies.get(error.result, Tally()) + tally
    return tallies


def solvable(job: Job, A: Words, B: Words, C: Words) -> NDArray[np.bool_]:
    """Return where an implicit equation has a solution on the job's branch, decided in integers."""
    if job.operation == "implicit-circular":
        return np.asarray((C * C <= A * A + B * B) & ((A != 0) | (B != 0)))
    # |A| > |B|: always.  |A| = |B|: B e^t = C or B e^-t = C.  |A| < |B|: C beyond the least |y|, on its side.
    same_side = (np.sign(B) == np.sign(C)) & (C != 0)
    return np.asarray((np.abs(A) > np.abs(B)) | (same_side & (A * A + C * C >= B * B)))


def pairs_of(job: Job, first: Words, second: Words, rng: np.random.Generator) -> Iterator[list[Words]]:
    """Yield the operands that a pair of words stands for, third operands being zero or drawn."""
    zero = np.zeros_like(first)
    largest = job.length.largest_word
    drawn = rng.integers(-largest, largest + 1, len(first))
    if job.operation == "lightcone":
        yield [first, second]
    elif job.operation in ("rotate-circular", "rotate-hyperbolic", "rotate-linear"):
        yield [first, second, drawn]
        yield [first, zero, second]
    elif job.operation.startswith("vector"):
        yield [first, second, zero]
    else:
        if job.operation == "implicit-circular":
            yield [first, second, np.rint(np.hypot(first, second) * drawn / largest).astype(np.int64)]
        else:
            yield [first, second, drawn]
        yield [zero, first, second]
        yield [first, zero, second]


def exhaustive_block(job: Job, row: int) -> dict[str, Tally]:
    """Run every second word with the rows of first words that a block holds."""
    words = np.arange(-job.length.largest_word, job.length.largest_word + 1, dtype=np.int64)
    height = max(1, BLOCK // len(words))
    first, second = (v.ravel() for v in np.meshgrid(words[row : row + height], words, indexing="ij"))
    rng = np.random.default_rng([SEED, OPERATIONS.index(job.operation), row])
    total: dict[str, Tally] = {}
    for operands in pairs_of(job, first, second, rng):
        _merge(total, tallied(job, [np.clip(o, words[0], words[-1]) for o in operands]))
    return total


def random_block(job: Job, block: int, samples: int) -> dict[str, Tally]:
    """Run a block of drawn operands, every fourth of them adversarial."""
    count = min(BLOCK, samples - block * BLOCK)
    rng = np.random.default_rng([SEED, OPERATIONS.index(job.operation), block])
    columns = [_drawn(job, is_angle, count, rng) for is_angle in job.angle_places]
    if job.operation == "implicit-circular":
        columns[2] = _targets(job, columns[0], columns[1], rng)
    return tallied(job, columns)


def _drawn(job: Job, is_angle: bool, count: int, rng: np.random.Generator) -> Words:
    """Return words: uniform; over a range of sizes; and special ones."""
    largest = job.length.largest_word
    words = rng.integers(-largest, largest + 1, count)
    if not is_angle and job.operation not in ("rotate-circular", "vector-circular", "implicit-circular"):
        words >>= rng.integers(0, job.bits // 2, count)  # many results leave the range otherwise
    special = rng.random(count) < 0.25
    powers = (1 << rng.integers(0, job.bits - 1, count)) + rng.integers(-1, 2, count)
    if is_angle:
        eighths = np.rint(rng.integers(0, 6, count) * np.ldexp(np.pi / 4, job.angle.fraction_bits))
        powers = np.where(
            rng.random(count) < 0.7, eighths.astype(np.int64) + rng.integers(-2, 3, count), powers
        )
    tiny = rng.integers(0, 4, count)
    kind = rng.integers(0, 4, count)
    edge = np.choose(kind, [powers, tiny, np.zeros_like(tiny), largest - tiny])
    edge = np.where(rng.random(count) < 0.5, -edge, edge)
    return np.clip(np.where(special, edge, words), -largest, largest)


def _targets(job: Job, A: Words, B: Words, rng: np.random.Generator) -> Words:
    """Return C with |C| <= R where a word can be: a random sine, or at R and a few ulp below."""
    norm = np.hypot(A, B)
    target = norm * np.sin(rng.uniform(-np.pi / 2, np.pi / 2, len(norm)))
    near = np.floor(norm) - rng.integers(0, 3, len(norm))
    near = np.where(rng.random(len(norm)) < 0.5, -near, near)
    words = np.where(rng.random(len(norm)) < 0.2, near, np.trunc(target)).astype(np.int64)
    return np.clip(words, -job.length.largest_word, job.length.largest_word)


def _merge(total: dict[str, Tally], part: dict[str, Tally]) -> None:
    for name, tally in part.items():
        total[name] = total.get(name, Tally()) + tally


def measured(job: Job, samples: int | None, pool: Any) -> dict[str, Tally]:
    """Return the tallies of a job: of `samples` drawn operands, or of every pair if None."""
    if samples is None:
        words = 2 * job.length.largest_word + 1
        parts = pool.imap(partial(exhaustive_block, job), range(0, words, max(1, BLOCK // words)))
    else:
        parts = pool.imap(partial(random_block, job, samples=samples), range(-(-samples // BLOCK)))
    total: dict[str, Tally] = {}
    for part in parts:
        _merge(total, part)
    return total


def checked_again(job: Job, result: str, worst: tuple[float, ...]) -> float:
    """Return the worst sample's unrounded error in ulp, by mpmath."""
    values = [float(v[0]) for v in job.run([np.array([v]) for v in worst])]
    operands = [mp.mpf(v) for v in worst]
    format_ = job.angle if result == "angle" else job.length
    if job.operation.startswith("implicit"):
        residual, scale = exact_residual(job.operation, MPMATH, operands, mp.mpf(values[0]))
        if job.operation == "implicit-hyperbolic":
            scale = max(scale, abs(operands[2]))
        return float((residual / scale if result == "angle" else residual) / format_.ulp)
    exact = exact_results(job.operation, MPMATH, operands)
    pairs = zip(exact, values[-len(exact) :], strict=True)
    return max(float(abs(mp.mpf(v) - wanted) / format_.ulp) for (name, wanted), v in pairs if name == result)


def last_rounding_ulp(job: Job, result: str) -> float:
    """Return the largest error of a word; `encode_angle` takes up to pi and 1/4 ulp to the word before pi."""
    if result != "angle" or not job.operation.endswith("-circular"):
        return LAST_ROUNDING_ULP
    return max(LAST_ROUNDING_ULP, float(mp.frac(mp.ldexp(mp.pi, job.angle.fraction_bits))) + 0.25)


def row(job: Job, result: str, tally: Tally) -> tuple[str, list[str]]:
    """Return a line of the table and what is wrong with it."""
    inside = internal_errors_ulp(job.unit, job.operation, job.bits)[result]
    worst, bound = tally.unrounded, inside
    if tally.rounded is not None:
        worst, bound = tally.rounded, inside + last_rounding_ulp(job, result)
    wrong = []
    if tally.unrounded > inside or worst > bound:
        wrong.append("beyond the bound")
    if worst > LIMIT_ULP:
        wrong.append(f"more than {LIMIT_ULP:g} ulp")
    if bound > LARGEST_RATIO * worst:
        wrong.append("bound too large")
    if tally.lost:
        wrong.append(f"{tally.lost} results lost")
    difference = abs(checked_again(job, result, tally.worst) - tally.unrounded)
    if difference > 2.0**-20:
        wrong.append(f"the reference is off by {difference:.2g} ulp")
    name = job.operation if not job.branch else f"{job.operation} {job.branch} ({job.unit.rule})"
    rounded = "" if tally.rounded is None else f"{tally.rounded:.3f}"
    figures = f"{tally.unrounded:.3f} | {rounded} | {bound:.3f} | {bound / worst:.2f}"
    return f"| {name} | {result} | {tally.samples:,} | {figures} |", [f"{name}, {result}: {w}" for w in wrong]


def jobs(bits: int) -> Iterator[Job]:
    """Yield every operation on the unit sized for it and its like."""
    explicit = [name for name in OPERATIONS if not name.startswith("implicit")]
    standard = size_unit(explicit, bits).unit
    yield from (Job(operation, standard, bits) for operation in explicit)
    for rule in RULES:
        unit = size_unit(["implicit-circular", "implicit-hyperbolic"], bits, rule=rule).unit
        yield from (Job("implicit-circular", unit, bits, branch) for branch in "+-")
        yield from (Job("implicit-hyperbolic", unit, bits, branch) for branch in "+-")


def table(bits: int, samples: int | None, pool: Any) -> list[str]:
    """Print the table of one part and return what is wrong."""
    began = time.perf_counter()
    wrong: list[str] = []
    what = (
        f"every pair of {bits}-bit words" if samples is None else f"{samples:,} samples of {bits}-bit words"
    )
    print(f"\n{what}, errors in ulp\n")
    print("| operation | result | counted | unrounded | rounded | bound | bound/worst |")
    print("|---|---|---:|---:|---:|---:|---:|")
    units: dict[str, Cau] = {}
    for job in jobs(bits):
        units["implicit, " + job.unit.rule if job.unit.rule else "standard"] = job.unit
        for result, tally in measured(job, samples, pool).items():
            line, problems = row(job, result, tally)
            print(line, flush=True)
            wrong += problems
    print()
    for name, unit in units.items():
        print(
            f"{name}: {unit.iterations} iterations, {unit.fraction_bits} and {unit.angle_bits} fraction bits"
        )
    print(f"{time.perf_counter() - began:.0f} s", file=sys.stderr)
    return wrong


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Measure the units' errors and compare them with the bounds."
    )
    parser.add_argument("--part", choices=("exhaustive", "random", "all"), default="all")
    parser.add_argument("--samples", type=int, default=10_000_000, help="random samples of each operation")
    parser.add_argument("--bits", type=int, default=RANDOM_BITS, help="width of the random words")
    parser.add_argument("--jobs", type=int, default=None, help="processes, default: all cores")
    options = parser.parse_args()
    if options.samples < 1 or not 8 <= options.bits <= 30:
        parser.error("--samples must be positive, --bits from 8 to 30")
    wrong: list[str] = []
    with multiprocessing.Pool(options.jobs) as pool:
        if options.part != "random":
            wrong += table(EXHAUSTIVE_BITS, None, pool)
        if options.part != "exhaustive":
            wrong += table(options.bits, options.samples, pool)
    if wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
