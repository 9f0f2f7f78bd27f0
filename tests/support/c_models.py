"""C models compiled and run beside the emulator, and random plans of every operation for them."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cordicc.arith.numbers.fixed_point import FRACTIONS, fraction_bits_for
from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.backends.c import c_model
from cordicc.emulate import functional
from cordicc.ir.ops import GUARD_CONDITIONS, OPS, Level
from cordicc.plan.model import Formats, Operand, Operation, Plan
from cordicc.plan.origin import PlanOptions, PlanProblem
from tests.support.origins import problem_of, target_of

COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler 'cc'")
FLAGS = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror")
SANITIZED = ("-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")

Samples = Mapping[str, np.ndarray]


def build(files: Mapping[str, str], folder: Path, *flags: str) -> Path:
    """Write and compile a C model; return its program."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    (source,) = (name for name in files if name.endswith(".c"))
    assert COMPILER is not None
    command = [COMPILER, *FLAGS, *flags, source, "-o", "model"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder / "model"


def csv_text(samples: Samples) -> str:
    rows = zip(*(column.tolist() for column in samples.values()), strict=True)
    return "\n".join([",".join(samples), *(",".join(map(repr, row)) for row in rows)]) + "\n"


def run(program: Path, text: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([program], input=text, capture_output=True, text=True)


def check(plan: Plan, samples: Samples, folder: Path, *flags: str) -> dict[str, np.ndarray]:
    """Compare the C model with the emulator, bit for bit; return what both give."""
    expected = functional.run(plan, plan.arithmetic, samples)
    done = run(build(c_model.files(plan), folder, *flags), csv_text(samples))
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    assert header.split(",") == list(expected)
    found = np.array([[float(field) for field in row.split(",")] for row in rows]).T
    for name, column in zip(expected, found, strict=True):
        wanted = np.asarray(expected[name], dtype=np.float64)
        same = (wanted.view(np.int64) == column.view(np.int64)) | (np.isnan(wanted) & np.isnan(column))
        first = {key: repr(float(values[np.argmin(same)])) for key, values in samples.items()}
        assert same.all(), f"{name}: {wanted[~same][0]!r}, not {column[~same][0]!r}, for {first}"
    return expected


def adversarial(problem: PlanProblem, count: int, seed: int) -> dict[str, np.ndarray]:
    """Draw samples among which are range ends, zeros of either sign, small numbers, and ones out of range."""
    rng = np.random.default_rng(seed)
    samples = {}
    for item in problem.inputs:
        lo, hi = item.lo, item.hi
        drawn = lo + (hi - lo) * rng.random(count)
        small = np.clip(rng.normal(size=count) * 10.0 ** rng.integers(-12, 1, count), lo, hi)
        zero = np.clip(rng.choice([0.0, -0.0], count), lo, hi)
        beyond = np.where(rng.random(count) < 0.02, math.nextafter(hi, math.inf), drawn)
        few = np.clip(np.round(drawn * 4) / 4, lo, hi)
        choice = rng.integers(0, 9, count)
        kinds = [np.full(count, lo), np.full(count, hi), zero, small, beyond, few]
        samples[item.name] = np.select([choice == k for k in range(len(kinds))], kinds, drawn)
    return samples


KINDS = {"rotate": "standard", "vector": "standard", "lightcone": "standard", "implicit": "implicit"}
OPERATIONS = [d for d in OPS.values() if d.level in (Level.ARITHMETIC, Level.UNIT)]


def variants() -> list[tuple[str, dict[str, Any]]]:
    """Return every operation with every choice of its discrete parameters."""
    found: list[tuple[str, dict[str, Any]]] = []
    for definition in OPERATIONS:
        if definition.name == "implicit":
            branches = [(1, "+"), (1, "-"), (-1, "+"), (-1, "-"), (-1, "none")]
            cases = [{"m": m, "branch": branch} for m, branch in branches]
        elif definition.name == "vector":
            cases = [{"m": m, "sign": s} for m in (1, 0, -1) for s in (1, -1)]
        elif definition.name == "rotate":
            cases = [{"m": m} for m in (1, 0, -1)]
        elif definition.name == "guard":
            cases = [{"condition": c} for c in GUARD_CONDITIONS]
        elif definition.name == "cmul":
            cases = [{"factor": f} for f in ("-0.7853982", "3.0000002e-5")]
        elif definition.name == "shift":
            cases = [{"exponent": e} for e in (3, -7, 140, -180)]
        else:
            cases = [{}]
        found += [(definition.name, case) for case in cases]
    return found


class Generator:
    """Random plans over an arithmetic; fixed-point values get random binary points."""

    def __init__(self, arithmetic: Mapping[str, Any], seed: int) -> None:
        self.arithmetic = dict(arithmetic)
        self.rng = np.random.default_rng(seed)
        format_ = self.arithmetic["format"]
        self.fixed = format_["kind"] == "fixed-point"
        self.outside = format_.get("width", 32)
        self.inside = self.outside + format_.get("guard", 0)

    def plan(self, operations: list[tuple[str, dict[str, Any]]], inputs: int, *, wide: bool = False) -> Plan:
        """Return a plan in which operations take inputs, constants and one another's results."""
        values: dict[str, BinaryPoint] = {}
        ranges: dict[str, tuple[float, float]] = {}
        for k in range(inputs):
            size = float(2.0 ** self.rng.integers(-3, 4) * self.rng.uniform(0.5, 1))
            ranges[f"x{k}"] = (-size, size * 0.75)
            values[f"x{k}"] = BinaryPoint(self.outside, fraction_bits_for(size, self.outside))
        made = []
        for index, (op, params) in enumerate(operations):
            definition = OPS[op]
            results = tuple(f"o{index}.{name}" for name in definition.results)
            taken = tuple(self.operand(list(values), p in "AB" or p == "s") for p in definition.ports)
            kind = KINDS.get(op, op)
            item = (op, params, kind, op, kind, 0, 0, definition.ports, taken, results, f"eq{index}")
            made.append(Operation(f"o{index}", *item))
            values |= {name: BinaryPoint(self.inside, self.fraction(wide)) for name in results}
        last = [name for operation in made[-2:] for name in operation.results if name is not None]
        outputs = {f"y{k}": Operand(value=name) for k, name in enumerate(last)}
        shapes = {y: BinaryPoint(self.outside, self.fraction(False)) for y in outputs}
        return Plan(
            problem=problem_of("random plan", ranges, outputs),
            target=target_of(self.arithmetic, "test"),
            options=PlanOptions(),
            initiation_interval=1,
            latency_cycles=0,
            cau_cycles=0,
            units=(),
            operations=tuple(made),
            fifos=(),
            outputs=outputs,
            optimal={},
            bounds={},
            formats=Formats(values, shapes) if self.fixed else Formats(),
        )

    def operand(self, names: list[str], never_constant: bool) -> Operand:
        if not never_constant and self.rng.random() < 0.15:
            return Operand(constant=str(self.rng.choice(["0", "1", "-0.75", "0.1234567"])))
        recent = names[-6:] if self.rng.random() < 0.8 else names
        return Operand(value=str(self.rng.choice(recent)))

    def fraction(self, wide: bool) -> int:
        if wide and self.rng.random() < 0.4:
            return int(self.rng.integers(FRACTIONS.start, FRACTIONS.stop))
        return int(self.inside - self.rng.integers(1, 8))
