"""A stage trace for people, as JSON and as CSV."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping
from typing import Any

from cordicc.base.text_tables import Facts, Heading, Sheet, Table
from cordicc.studies.stage_trace import StageSignal, StageTrace, TracedWord

_WORDS = ("value", "port", "width", "fraction", "hex", "integer", "number")
_SIGNALS = ("cycle", "plan_cycle", "signal", "width", "hex", "integer", "comment")


def hexadecimal(word: int, width: int) -> str:
    """Return the bits of a word, in two's complement if it is negative."""
    return f"{word & ((1 << width) - 1):0{-(-width // 4)}x}"


def sheet_of(trace: StageTrace) -> Sheet:
    """Return a trace as tables: operands, results, then the signals by cycle."""
    plan, operation, sample = trace.plan, trace.operation, trace.sample
    interval = plan.initiation_interval
    slot = f", slot {operation.start % interval} of {interval}" if interval > 1 else ""
    inputs = ", ".join(f"{name} = {number!r}" for name, number in sample.numbers.items())
    validity = "valid" if trace.invalid is None else f"invalid: {trace.invalid}"
    facts = Facts(
        (
            (
                "operation",
                f"{operation.mode or operation.op}, for {operation.equation}".removesuffix(", for "),
            ),
            ("unit", f"{operation.unit}, {trace.instance} of module {trace.module}"),
            ("cycles", f"{operation.start} to {operation.finish} of the plan{slot}"),
            ("sample", f"{sample.number} of {sample.among}, {validity}"),
            ("inputs", inputs),
        )
    )
    words = Table(
        ("", *_WORDS),
        tuple(
            (f"{kind} {word.name}", *map(str, _cells(word).values()))
            for kind, some in (("operand", trace.operands), ("result", trace.results))
            for word in some
        ),
        right=(3, 4, 5, 6),
    )
    signals = Table(
        ("cycle", "of plan", *_SIGNALS[2:]),
        tuple(tuple(map(str, _row(trace, signal).values())) for signal in trace.signals),
        right=(0, 1, 3, 4, 5),
    )
    title = f"{plan.name} on {plan.target.name}: operation {operation.id}"
    return Sheet(title, (facts, "", words, Heading("Signals of the unit"), signals))


def _cells(word: TracedWord) -> dict[str, Any]:
    """Return what the table says of an operand or result."""
    width = word.format.width_bits
    number = "invalid" if word.number is None else repr(word.number)
    return dict(
        zip(
            _WORDS,
            (
                word.value,
                word.port or "-",
                width,
                word.format.fraction_bits,
                hexadecimal(word.word, width),
                word.word,
                number,
            ),
            strict=True,
        )
    )


def _row(trace: StageTrace, signal: StageSignal) -> dict[str, Any]:
    """Return a signal as a row."""
    bits = hexadecimal(signal.word, signal.width)
    when = (signal.cycle, trace.operation.start + signal.cycle)
    cells = (*when, signal.name, signal.width, bits, signal.word, signal.comment)
    return dict(zip(_SIGNALS, cells, strict=True))


def csv_text(trace: StageTrace) -> str:
    """Return the signals as comma-separated values under a header."""
    text = io.StringIO()
    writer = csv.DictWriter(text, _SIGNALS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_row(trace, signal) for signal in trace.signals)
    return text.getvalue()


def json_text(trace: StageTrace) -> str:
    """Return all that is known as one JSON object."""
    plan, operation, sample = trace.plan, trace.operation, trace.sample
    data = {
        "name": plan.name,
        "target": plan.target.name,
        "initiation_interval": plan.initiation_interval,
        "operation": {
            "id": operation.id,
            "op": operation.op,
            "mode": operation.mode,
            "unit": operation.unit,
            "start": operation.start,
            "finish": operation.finish,
        },
        "module": trace.module,
        "instance": trace.instance,
        "sample": {
            "number": sample.number,
            "among": sample.among,
            "inputs": dict(sample.numbers),
            "valid": trace.invalid is None,
            "invalid": trace.invalid,
        },
        "operands": [_word_data(word) for word in trace.operands],
        "results": [_word_data(word) for word in trace.results],
        "signals": [_row(trace, signal) | {"signed": signal.signed} for signal in trace.signals],
    }
    return json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def _word_data(word: TracedWord) -> Mapping[str, Any]:
    own = {"name": word.name, "port": word.port, "number": word.number, "valid": word.ok}
    return _cells(word) | own
