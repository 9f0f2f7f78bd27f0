"""`cordicc trace PLAN`: the stages of an operation, printed or written."""

from __future__ import annotations

from pathlib import Path

import click

from cordicc.api import load_plan
from cordicc.base.text_tables import harmless, plain
from cordicc.cli.arguments import is_stdout, require_unread, write_or_print
from cordicc.cli.console import show, tell
from cordicc.ir.sampling import DEFAULT_SAMPLES
from cordicc.studies.picked_sample import drawn_sample, sample_of_file
from cordicc.studies.stage_trace import stage_trace
from cordicc.studies.stage_trace_text import csv_text, json_text, sheet_of


def print_stages(
    path: Path,
    operation: str | None,
    inputs: Path | None,
    count: int | None,
    seed: int,
    sample: int,
    as_json: bool,
    as_csv: bool,
    output: Path | None,
) -> None:
    """Trace an operation of the plan at a path, on a sample of a file or drawn, and print or write that.

    Raises UsageError for options that exclude each other.
    """
    if operation is None:
        hint = "'cordicc explain PLAN' and its report say which there are"
        raise click.UsageError(f"a PLAN is traced for one of its operations, such as --operation o1; {hint}")
    if inputs is not None and count is not None:
        raise click.UsageError("--inputs and --random exclude each other")
    if as_json and as_csv:
        raise click.UsageError("--json and --csv exclude each other")
    require_unread("-o", output, path, path / "plan.json", inputs)
    plan = load_plan(path)
    if inputs is None:
        picked = drawn_sample(plan.problem, sample, count or DEFAULT_SAMPLES, seed)
    else:
        picked = sample_of_file(plan.problem, inputs, sample)
    tell(picked.warnings)
    trace = stage_trace(plan, operation, picked, str(path))
    suffix = "" if output is None or as_json or as_csv else output.suffix.lower()
    if as_json or suffix == ".json":
        write_or_print(output, json_text(trace))
    elif as_csv or suffix == ".csv":
        write_or_print(output, csv_text(trace))
    elif output is None or is_stdout(output):
        show(sheet_of(trace))
    else:
        write_or_print(output, plain(harmless(sheet_of(trace))))
