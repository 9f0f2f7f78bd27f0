"""What `cordicc simulate` does: streams of samples through a plan, and the texts about their errors."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import click

from cordicc.arith.intervals import Interval
from cordicc.certify.plans import StatedBounds
from cordicc.console import Progress, show
from cordicc.diagnostics import Diagnostic
from cordicc.emulate import cycle, extremes, functional, golden
from cordicc.emulate.histogram import Errors, Worst
from cordicc.emulate.judging import MOST_BEYOND, Judged, Judgement, Limits
from cordicc.emulate.sampling import draw_parts
from cordicc.emulate.streaming import REFERENCE_SAMPLES, Report, Samples, run_parts
from cordicc.emulate.tables import PART_ROWS, Columns, read_table
from cordicc.emulate.writing import Write, csv_header, csv_rows, table_writer
from cordicc.ir.text import parse_graph
from cordicc.observation import DEFAULT_SAMPLES, angles_of, machine_of, reference_samples
from cordicc.plan import Plan
from cordicc.sheet import Sheet
from cordicc.summary import comparison_data, comparison_sheet, count

_BAR = 40
_NUMBER_BYTES = 12
_MARGIN = 2.0


class Run(NamedTuple):
    """A plan, how it is run, and how results are told."""

    plan: Plan
    cycle_accurate: bool
    as_json: bool
    tell: Callable[[Iterable[Diagnostic]], None]

    @property
    def inputs(self) -> list[str]:
        """Return the names of the inputs."""
        return [item["name"] for item in self.plan.problem["inputs"]]

    def simulator(self, first: Samples, total: int) -> Callable[[Samples], dict[str, Any]]:
        """Return what runs a part, fit for about `total` samples of which `first` are the first."""
        machine = machine_of(self.plan)
        if self.cycle_accurate:
            return partial(cycle.run, self.plan, machine)
        return partial(functional.run, self.plan, functional.accelerated(self.plan, machine, first, total))


class Reference(NamedTuple):
    """How many samples are compared in high precision (None: none with anything); whether to search.

    With `fewer`, large problems have fewer: as many as `reference_samples` says.
    """

    samples: int | None
    search: bool
    fewer: bool = False

    @classmethod
    def of(cls, samples: int | None, none: bool, search: bool) -> Reference:
        """Return what the options ask for."""
        wanted = REFERENCE_SAMPLES if samples is None else samples
        return cls(None if none else wanted, search, samples is None)


def run_samples(
    run: Run, inputs: Path | None, random: int | None, seed: int, outputs: Path | None, reference: Reference
) -> int:
    """Run a plan on samples of a file or drawn ones; write the outputs and print the errors.

    Returns the exit status: 1 if a sample is beyond a bound that the plan states, which is told as well.
    """
    plan = run.plan
    if inputs is None:
        total: int | None = random or DEFAULT_SAMPLES
        expected = random or DEFAULT_SAMPLES
        parts = draw_parts(plan.problem, expected, seed, PART_ROWS)
    else:
        table = read_table(inputs, Columns(run.inputs))
        run.tell(table.warnings)
        total, parts = None, table.parts
        expected = inputs.stat().st_size // (_NUMBER_BYTES * max(1, len(run.inputs)))
    first = next(parts)
    simulate = run.simulator(first, expected)
    progress = Progress(total, "samples")
    with ExitStack() as stack:
        stack.callback(progress.done)
        take = _sink(outputs, list(plan.outputs), stack)
        stream = _again(first, parts)
        if reference.samples is None:
            told: str | Sheet = _only_run(run, stream, simulate, take, progress)
            beyond: list[Diagnostic] = []
        else:
            graph, angles = parse_graph(plan.problem["program"], "plan.json"), angles_of(plan.problem)
            precise = reference_samples(graph) if reference.fewer else reference.samples
            stated = StatedBounds.of(plan)
            limits = None if stated is None else Limits(stated.values, stated.inside)
            report = run_parts(graph, angles, stream, simulate, take, progress.reached, precise, limits)
            found = _search(plan, report, simulate) if reference.search else None
            beyond = _beyond(report.judgement, found or {})
            told = (
                _json(plan, report, found) if run.as_json else _sheet(plan, report, found, reference.search)
            )
    _tell(told, err=str(outputs) == "-")
    run.tell(beyond)
    return 1 if beyond else 0


def _tell(told: str | Sheet, *, err: bool = False) -> None:
    """Print a JSON text or a sheet."""
    if isinstance(told, Sheet):
        show(told, err=err)
    else:
        click.echo(told, nl=False, err=err)


def _beyond(judgement: Judgement | None, found: Mapping[str, Worst | None]) -> list[Diagnostic]:
    """Return a diagnostic for each output with samples beyond its bound, those of a search included."""
    if judgement is None:
        return []
    for name, worst in found.items():
        if worst is not None:
            judgement.add_found(name, worst)
    diagnostics = []
    for name, judged in judgement.found.items():
        if judged.worst is None:
            continue
        values = ", ".join(f"{n} = {number!r}" for n, number in judged.worst.inputs.items())
        message = (
            f"the error of '{name}' exceeds its proven bound {judged.bound:.3g}, {_how_many(judged)}: "
            f"{judged.worst.error:.3g} at {values}"
        )
        hint = "a fault in cordicc, please report it, unless plan.json was changed"
        diagnostics.append(Diagnostic("E620", message, hint=hint))
    return diagnostics


def _how_many(judged: Judged) -> str:
    more = " or more" if judged.beyond >= MOST_BEYOND else ""
    return f"in {judged.beyond}{more} of {count(judged.inside, 'sample')} inside"


def _again(first: Samples, rest: Iterator[Samples]) -> Iterator[Samples]:
    yield first
    yield from rest


def _sink(path: Path | None, names: list[str], stack: ExitStack) -> Write:
    """Return what takes the outputs of each part."""
    if path is None:
        return lambda outputs: None
    if str(path) == "-":
        click.echo(csv_header(names), nl=False)
        return lambda outputs: click.echo(csv_rows(names, outputs), nl=False)
    return stack.enter_context(table_writer(path, names))


def _only_run(
    run: Run,
    parts: Iterator[Samples],
    simulate: Callable[[Samples], dict[str, Any]],
    take: Write,
    progress: Progress,
) -> str | Sheet:
    samples = valid = 0
    for part in parts:
        outputs = simulate(part)
        take(outputs)
        samples, valid = samples + len(outputs["valid"]), valid + int(outputs["valid"].sum())
        progress.reached(samples)
    if run.as_json:
        data = {"name": run.plan.name, "target": run.plan.target["name"], "samples": samples, "valid": valid}
        return _dumped(data)
    return Sheet(f"{run.plan.name} on {run.plan.target['name']}: {count(samples, 'sample')}, {valid} valid")


def _search(
    plan: Plan, report: Report, simulate: Callable[[Samples], dict[str, Any]]
) -> dict[str, Worst | None] | None:
    """Search for larger errors of each output; None where inputs depend on one another."""
    if plan.problem.get("samples"):
        return None
    graph = parse_graph(plan.problem["program"], "plan.json")
    ranges = {item["name"]: Interval(item["lo"], item["hi"]) for item in plan.problem["inputs"]}
    inside = {
        name: [w for w in worst if all(each.lo <= w.inputs[n] <= each.hi for n, each in ranges.items())]
        for name, worst in report.worst.items()
    }
    return {
        name: extremes.search(graph, is_angle, name, ranges, inside[name], simulate)
        for name, is_angle in angles_of(plan.problem).items()
    }


def _dumped(data: Mapping[str, Any]) -> str:
    return json.dumps(data, indent=2, sort_keys=True, allow_nan=False) + "\n"


def _json(plan: Plan, report: Report, found: Mapping[str, Worst | None] | None) -> str:
    data = comparison_data(plan, report.comparison)
    data |= {"referenced": report.referenced, "screened": report.screened}
    for name, record in data["accuracy"].items():
        record["histogram"] = [[lower, number] for lower, number in report.errors[name].rows()]
        record["worst"] = [_worst_data(worst) for worst in report.worst[name]]
        record["screening_error"] = report.screening_error[name] if report.screened else None
        record["judged"] = _judged_data(report.judgement, name)
        if found is not None:
            worst = found[name]
            record["search"] = None if worst is None else _worst_data(worst)
    return _dumped(data)


def _judged_data(judgement: Judgement | None, output: str) -> dict[str, Any] | None:
    if judgement is None or output not in judgement.found:
        return None
    judged = judgement.found[output]
    return {
        "samples": judged.samples,
        "inside": judged.inside,
        "beyond": judged.beyond,
        "worst_beyond": None if judged.worst is None else _worst_data(judged.worst),
    }


def _worst_data(worst: Worst) -> dict[str, Any]:
    return {"error": worst.error, "sample": worst.sample, "inputs": worst.inputs}


def _sheet(plan: Plan, report: Report, found: Mapping[str, Worst | None] | None, details: bool) -> Sheet:
    judged = {} if report.judgement is None else report.judgement.found
    sheet = comparison_sheet(plan, report.comparison, judged)
    lines = []
    if report.screened:
        gaps = [gap for gap in report.screening_error.values() if gap is not None]
        known = f", there at most {max(gaps):.2g} from it" if gaps else ""
        lines.append(
            f"  {count(report.referenced, 'sample')} against high precision, {report.screened} against "
            f"double precision{known}; the worst of these again against high precision"
        )
    lines += _details(plan, report, found) if details else []
    return replace(sheet, blocks=(*sheet.blocks, *lines))


def _details(plan: Plan, report: Report, found: Mapping[str, Worst | None] | None) -> list[str]:
    """Return lines with the histogram and the worst inputs of each output."""
    lines: list[str] = []
    angles = angles_of(plan.problem)
    for name, errors in report.errors.items():
        unit = " rad" if angles[name] else ""
        lines += ["", f"{name}: errors", *_bars(errors, unit), *_worst_lines(name, report, found, unit)]
    return lines


def _bars(errors: Errors, unit: str) -> list[str]:
    rows = errors.rows()
    most = max((number for _, number in rows), default=1)
    width = len(str(most))
    lines = []
    for lower, number in rows:
        label = "exactly 0" if lower == 0 else f"{lower:8.2g} to {2 * lower:8.2g}{unit}"
        bar = "#" * -(-_BAR * number // most)
        lines.append(f"  {label:<{20 + len(unit)}}  {number:>{width}}  {bar}".rstrip())
    return lines


def _worst_lines(name: str, report: Report, found: Mapping[str, Worst | None] | None, unit: str) -> list[str]:
    """Return a line for each of the worst samples, and for what the search found."""
    worst = list(report.worst[name])
    top = None if found is None else found[name]
    if top is not None:
        worst = [top, *worst]
    lines = []
    for each in worst:
        origin = "search" if each.sample is None else f"sample {each.sample}"
        values = ", ".join(f"{n} = {number!r}" for n, number in each.inputs.items())
        lines.append(f"  {each.error:.3g}{unit}, {origin}: {values}")
    if found is None:
        lines.append("  no search: the inputs depend on one another")
    return lines


def check_expected(run: Run, inputs: Path, expected: Path, tolerance: float | None) -> int:
    """Compare the outputs with expected ones, print the worst rows, return the exit status: 1 if any differs.

    Without a tolerance the largest difference allowed is the column `tol_<output>` of the file, else the
    plan's bound, else twice the largest error that the plan has observed.
    """
    plan, angles = run.plan, angles_of(run.plan.problem)
    table = read_table(inputs, Columns(run.inputs))
    own = [golden.TOLERANCE + name for name in angles] if tolerance is None else []
    optional = [*own, "valid"]
    answers = read_table(expected, Columns(list(angles), "output", optional, nan=True))
    run.tell([*table.warnings, *answers.warnings])
    allowed = {name: _allowed(plan, name) if tolerance is None else tolerance for name in angles}
    first = next(table.parts)
    simulate = run.simulator(first, inputs.stat().st_size // (_NUMBER_BYTES * max(1, len(run.inputs))))
    verdict = golden.check_golden(_again(first, table.parts), answers.parts, angles, allowed, simulate)
    limits = {n: None if golden.TOLERANCE + n in answers.names else limit for n, limit in allowed.items()}
    _tell((_verdict_json if run.as_json else _verdict_sheet)(plan, verdict, limits))
    return 0 if verdict.agrees else 1


def _allowed(plan: Plan, output: str) -> float:
    record = plan.accuracy[output]
    bound = record["bound"]
    if bound is not None and not bound["conditions"]:  # it holds for every valid sample
        return float(bound["value"])
    return _MARGIN * float(record["observed"]["max"] or 0.0)


def _verdict_sheet(plan: Plan, verdict: golden.Verdict, limits: Mapping[str, float | None]) -> Sheet:
    agrees = "as expected" if verdict.agrees else "not as expected"
    title = f"{plan.name} on {plan.target['name']}: {count(verdict.rows, 'row')}, {agrees}"
    lines = []
    if verdict.validity:
        rows = count(verdict.validity, "row")
        lines.append(f"  {rows} valid in one alone, first row {verdict.first_invalid}")
    angles = angles_of(plan.problem)
    for name, errors in verdict.differences.items():
        unit = " rad" if angles[name] else ""
        limit = limits[name]
        may = "its column" if limit is None else f"{limit:.3g}{unit}"
        seen = "-" if errors.largest is None else f"{errors.largest:.3g}{unit}"
        lines.append(
            f"  {name}: largest difference {seen}, allowed {may}, {count(verdict.beyond[name], 'row')} beyond"
        )
    for row, name, simulated, expected, allowed in verdict.wrong:
        lines.append(f"  row {row}, {name}: {simulated!r} instead of {expected!r}, allowed {allowed:.3g}")
    return Sheet(title, tuple(lines))


def _verdict_json(plan: Plan, verdict: golden.Verdict, limits: Mapping[str, float | None]) -> str:
    keys = ("row", "output", "simulated", "expected", "allowed")
    outputs = {
        name: {
            "largest": errors.largest,
            "rms": errors.rms,
            "allowed": limits[name],
            "beyond": verdict.beyond[name],
        }
        for name, errors in verdict.differences.items()
    }
    return _dumped(
        {
            "name": plan.name,
            "target": plan.target["name"],
            "rows": verdict.rows,
            "agrees": verdict.agrees,
            "validity_differs": verdict.validity,
            "outputs": outputs,
            "wrong": [dict(zip(keys, line, strict=True)) for line in verdict.wrong],
        }
    )
