"""Build circuits of units for each kind of chip, and fit what a bit of each kind of logic takes.

    python benchmarks/units_area.py [--widths 16,24,28] [--devices ecp5-85k,...] [--jobs 2]
                                    [--counts FILE] [--write]

Makes circuits of every function of CORDIC units, of adders and multipliers, over widths of words; yosys
counts their cells.  Look-up tables and multiplier blocks are fitted by least squares of relative errors,
flip-flops by least absolute ones, which the table states of circuits that are not small, with no coefficient
below 0 and each drawn a little towards 1, as few circuits tell all of them apart.
`--write` puts the coefficients of these devices into the table from which estimates are made; the others
stay.  It takes some minutes for each device; with `--counts` only for circuits that changed, as the file
keeps what yosys counted by the text of a module.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cordicc.arith.circuits.circuit import Circuit
from cordicc.arith.circuits.units import Plain, unit_circuit
from cordicc.arith.circuits.uses import Use
from cordicc.arith.numbers.fixed_point import FixedPoint
from cordicc.backends.rtl.module_text import module_text
from cordicc.backends.synthesis import estimate
from cordicc.backends.synthesis.cell_bits import DSP_KINDS, FF_KINDS, LUT_KINDS, cell_bits
from cordicc.backends.synthesis.families import FAMILIES, synthesis_command
from cordicc.backends.synthesis.programs import BuildProgram, installed, run_first
from cordicc.base.text_tables import Sheet, Table, plain
from cordicc.plan.area import Area
from cordicc.targets.device import DEVICES, Device
from cordicc.targets.target import CAU_KINDS, Target
from cordicc.targets.target_file import load_target

TABLE = Path(estimate.__file__).with_name(estimate.TABLE)
ONE_OF_EACH = ("ecp5-85k", "artix7-100t", "ice40-up5k", "ice40-hx8k", "generic")
KINDS = {"lut": LUT_KINDS, "ff": FF_KINDS, "dsp": DSP_KINDS}
PULL = 0.03
"""Weight of a coefficient's distance from 1 beside relative errors."""

STEPS = {"lut": 1, "ff": 30, "dsp": 1}
FLAT = 0.02
"""Of the fit: how often squares are weighted, and the relative error below which they count as they are."""

SMALL = {"lut": 300, "ff": 300, "dsp": 1}
"""Cells by which counts are larger where errors are made relative: those of small circuits matter less."""

GUARD_BITS = 4
FUNCTIONS: tuple[tuple[str, str, int], ...] = (
    ("standard", "vector", 1),
    ("standard", "rotate", 1),
    ("standard", "vector", 0),
    ("standard", "rotate", 0),
    ("standard", "vector", -1),
    ("standard", "rotate", -1),
    ("standard", "lightcone", -1),
    ("implicit", "implicit", 1),
    ("implicit", "implicit", -1),
)
OPERATIONS: tuple[tuple[str, str, dict[str, Any], int], ...] = (
    ("add", "add", {}, 2),
    ("add", "min", {}, 2),
    ("add", "wrap", {}, 1),
    ("mul", "mul", {}, 2),
    ("cmul", "cmul", {"factor": "0.333333333"}, 1),
)


def circuits(width: int) -> Iterator[tuple[str, Circuit]]:
    """Yield names and circuits of units for words of a width, with the latencies of the target fixed24."""
    target = load_target("fixed24", GUARD_BITS if width + GUARD_BITS <= 30 else 30 - width, width)
    system = target.machine().system
    word = system.width_bits + system.guard_bits  # type: ignore[attr-defined]
    a, b, c, first = (FixedPoint(word, word - points) for points in (1, 1, 3, 2))
    for kind, op, m in FUNCTIONS:
        operands = (a, b) if op == "lightcone" else (a, b, c if op == "rotate" and m == 1 else a)
        angle = {"vector": 1, "implicit": 0}.get(op) if m == 1 else None
        yield f"{op} {m} {width}", _unit(target, kind, Use(op, m, operands, (first, first), angle=angle))
    for kind, op, params, count in OPERATIONS:
        use = Plain(op, tuple(params.items()), (a, b)[:count], first)
        yield f"{op} {width}", _unit(target, kind, use)


def _unit(target: Target, kind: str, use: Use | Plain) -> Circuit:
    latency = target.units[kind].latency
    while True:
        try:
            return unit_circuit("unit", target.machine(), kind, [use], latency)
        except ValueError:
            latency += 1
            if latency > 200 or kind not in CAU_KINDS:
                raise


def counted(
    circuit: Circuit, several: Sequence[BuildProgram], device: Device, known: dict[str, Any]
) -> tuple[str, Area]:
    """Return a version of yosys and its cells of a circuit, which `known` has by what was built or gets."""
    text = module_text(circuit)
    command = synthesis_command(device, "unit")
    key = hashlib.sha256(f"{several[0]} {command} {text}".encode()).hexdigest()
    if key not in known:
        version, area = _built(several, text, command, device)
        known[key] = {"yosys": version, **asdict(area)}
    figures = dict(known[key])
    return figures.pop("yosys"), Area(**figures)


def _built(several: Sequence[BuildProgram], text: str, command: str, device: Device) -> tuple[str, Area]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "unit.v").write_text(text, encoding="ascii")
        lines = ["read_verilog unit.v", command, "tee -q -o count.json stat -json"]
        (folder / "run.ys").write_text("\n".join(lines) + "\n", encoding="ascii")
        yosys = run_first(several, ["-s", "run.ys"], folder)
        count = json.loads((folder / "count.json").read_text(encoding="utf-8"))
    return yosys.version, FAMILIES[device.family].area(count["design"]["num_cells_by_type"])


def fitted(
    rows: Sequence[Mapping[str, float]], counts: Sequence[int], kinds: Sequence[str], small: int, steps: int
) -> dict[str, float]:
    """Return what a bit of each kind takes, none below 0; 0 for a kind that is nowhere.

    One step fits the least squares, many the least absolute errors, of which one that is far off does not
    draw the others.
    """
    weight = 1 / (np.array(counts, float) + small)
    there = [kind for kind in kinds if any(row.get(kind) for row in rows)]
    while there:
        matrix = np.array([[row.get(kind, 0) for kind in there] for row in rows]) * weight[:, None]
        pulled = np.vstack([matrix, PULL * np.eye(len(there))])
        wanted = np.concatenate([np.array(counts) * weight, np.full(len(there), PULL)])
        share = np.ones(len(wanted))
        for _ in range(steps):
            found = np.linalg.lstsq(pulled * share[:, None], wanted * share, rcond=None)[0]
            errors = np.abs(matrix @ found - wanted[: len(counts)])
            share[: len(counts)] = 1 / np.sqrt(np.maximum(errors, FLAT))
        if (found >= 0).all():
            return {kind: round(float(each), 4) for kind, each in zip(there, found, strict=True)}
        there.remove(there[int(found.argmin())])
    return {}


def calibrated(
    device: Device, made: Sequence[tuple[str, Circuit]], found: Sequence[tuple[str, Area]]
) -> dict[str, Any]:
    """Return the entry of a device in the table, and print the errors by circuit."""
    rows = [cell_bits(circuit, device) for _, circuit in made]
    entry: dict[str, Any] = {
        "yosys": sorted({version for version, _ in found}),
        "circuits": len(made),
        "error": {},
    }
    table: dict[str, list[str]] = {name: [name] for name, _ in made}
    for figure, kinds in KINDS.items():
        counts = [getattr(area, figure) for _, area in found]
        entry[figure] = fitted(rows, counts, kinds, SMALL[figure], STEPS[figure])
        guess = [sum(row.get(kind, 0) * each for kind, each in entry[figure].items()) for row in rows]
        errors = [estimate.relative(g, n) for g, n in zip(guess, counts, strict=True) if n > SMALL[figure]]
        entry["error"][figure] = {
            "rms": round(float(np.sqrt(np.mean(np.square(errors)))), 4) if errors else 0.0,
            "max": round(float(np.max(np.abs(errors))), 4) if errors else 0.0,
        }
        for cells, g, n in zip(table.values(), guess, counts, strict=True):
            cells += [str(n), f"{g:.0f}"]
    header = ("circuit", *(text for figure in KINDS for text in (figure.upper(), "estimated")))
    print(plain(Sheet(device.name, (Table(header, tuple(map(tuple, table.values()))),))))
    print(json.dumps(entry, indent=2), flush=True)
    return entry


def main() -> None:
    """Calibrate, print, and write the table if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--widths", default="16,20,24,28")
    parser.add_argument("--devices", default=",".join(ONE_OF_EACH))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--counts", type=Path, help="keep what yosys counted here")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    made = [each for width in given.widths.split(",") for each in circuits(int(width))]
    several = installed("yosys")
    known = _read(given.counts)
    for device in (DEVICES[name] for name in given.devices.split(",")):
        found = []
        with ThreadPoolExecutor(given.jobs) as pool:
            build = partial(counted, several=several, device=device, known=known)
            for done, each in enumerate(pool.map(build, (circuit for _, circuit in made)), 1):
                found.append(each)
                print(f"{device.name}: {done} of {len(made)}", file=sys.stderr, flush=True)
                if given.counts is not None:
                    given.counts.write_text(json.dumps(dict(known)), encoding="utf-8")
        entry = calibrated(device, made, found)
        if given.write:
            table = {**_read(TABLE), estimate.table_name(device): entry}
            TABLE.write_text(json.dumps(table, indent=2, sort_keys=True) + "\n", encoding="utf-8")


def _read(path: Path | None) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if path is not None and path.exists():
        found = json.loads(path.read_text(encoding="utf-8"))
    return found


if __name__ == "__main__":
    main()
