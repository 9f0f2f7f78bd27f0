"""More samples of a plan, as integers, for the bench of somebody else: in hexadecimal and as CSV."""

from __future__ import annotations

import json
from collections.abc import Sequence
from hashlib import sha256
from typing import Any

import numpy as np

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.backends.rtl.bench_words import DEFAULT_COUNT, Run, bench_words, csv_lines, hex_lines
from cordicc.backends.rtl.names import stem
from cordicc.backends.rtl.word_ports import Ports, PortWord
from cordicc.base.diagnostics import Diagnostic, Unattainable
from cordicc.plan.file import dump
from cordicc.plan.model import Plan


def files(plan: Plan, run: Run, count: int = DEFAULT_COUNT) -> dict[str, str]:
    """Return the texts of the vectors by name, `rtl/vectors/` before each.

    NAME_samples_in.hex and NAME_samples_out.hex have a line a sample, as those of the bench;
    NAME_samples.csv has a column a port and `out_ok`, NAME_samples.json the formats of the columns.

    Args:
        plan: whose vectors they are.
        run: runs it.
        count: samples that are drawn at random.

    Raises:
        Unattainable: the words of the plan are in floating point (E421).
    """
    if not isinstance(plan.arithmetic.system, FixedSystem):
        message = (
            "vectors of integers cannot be written: the words of target "
            f"'{plan.target.name}' are in floating point"
        )
        raise Unattainable([Diagnostic("E421", message, hint="a fixed-point target: --target fixed24")])
    ports = Ports.of(plan)
    words = bench_words(ports, plan.problem.workspace, count, run)
    ins = list(zip(ports.inputs, words.given, strict=True))
    outs = list(zip(ports.outputs, words.wanted, strict=True))
    columns = [(port.port, column) for port, column in (*ins, *outs)]
    table = csv_lines([*columns, ("out_ok", words.ok.astype(np.int64))])
    described = {
        "format": "cordicc-vectors",
        "version": 1,
        "plan": plan.name,
        "plan_sha256": sha256(dump(plan).encode()).hexdigest(),
        "samples": words.count,
        "inputs": _described(ports.inputs),
        "outputs": _described(ports.outputs),
        "csv_sha256": sha256(table.encode()).hexdigest(),
    }
    base = f"rtl/vectors/{stem(plan.name)}_samples"
    return {
        f"{base}_in.hex": hex_lines(ins),
        f"{base}_out.hex": hex_lines(outs, words.ok),
        f"{base}.csv": table,
        f"{base}.json": json.dumps(described, indent=2, sort_keys=True, ensure_ascii=False) + "\n",
    }


def _described(ports: Sequence[PortWord]) -> list[dict[str, Any]]:
    return [
        {
            "name": port.name,
            "column": port.port,
            "width": port.width,
            "fraction": port.format.fraction_bits,
            "unit": port.unit,
            "invalid": -port.invalid,
        }
        for port in ports
    ]
