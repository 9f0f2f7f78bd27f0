"""What `cordicc simulate` prints of a run: errors, validity and bounds, as a sheet or as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from cordicc.backends.text.summary import ACCURACY_HEADER, checks_table, count, figure
from cordicc.base.text_tables import Sheet, Table, percent
from cordicc.cli.console import show
from cordicc.cli.streams import deliver
from cordicc.emulate.accuracy import Comparison
from cordicc.emulate.checking import CheckTally
from cordicc.emulate.fact_tally import FactTally
from cordicc.emulate.histogram import Errors, Worst
from cordicc.emulate.judging import Judged, Judgement
from cordicc.emulate.long_run import RunFindings
from cordicc.ir.facts import SIDES
from cordicc.plan.model import Plan
from cordicc.plan.plain_data import bound_data, check_data

_BAR = 40
_MOST_CAUSES = 5


def print_told(told: str | Sheet, *, err: bool = False) -> None:
    """Print a JSON text or a sheet."""
    if isinstance(told, Sheet):
        show(told, err=err)
    else:
        deliver(told, err=err)


def dumped(data: Mapping[str, Any]) -> str:
    """Return plain data as a JSON text."""
    return json.dumps(data, indent=2, sort_keys=True, allow_nan=False) + "\n"


def errors_json(
    plan: Plan, report: RunFindings, found: Mapping[str, Worst | None] | None, checks: CheckTally
) -> str:
    """Return what a run showed as JSON; `found` are the errors that a search found, None without one."""
    data = comparison_data(plan, report.comparison)
    data["checks"] = {
        name: check_data(plan.problem.check(name), record.figures) | {"beyond": record.beyond}
        for name, record in checks.found.items()
    }
    data |= {"referenced": report.referenced, "screened": report.screened}
    data["undefined"] = [
        {"equation": cause.equation, "reason": cause.reason, "samples": samples, "first": first + 1}
        for cause, samples, first in report.causes
    ]
    data["facts"] = facts_data(report.facts)
    for name, record in data["accuracy"].items():
        if report.facts is not None:
            record["unfounded"] = report.unfounded[name]
        record["histogram"] = [[lower, number] for lower, number in report.errors[name].rows()]
        record["worst"] = [_worst_data(worst) for worst in report.worst[name]]
        record["screening_error"] = report.screening_error[name] if report.screened else None
        record["judged"] = _judged_data(report.judgement, name)
        if found is not None:
            worst = found[name]
            record["search"] = None if worst is None else _worst_data(worst)
    return dumped(data)


def facts_data(facts: FactTally | None) -> dict[str, Any] | None:
    """Return how many samples break what the problem assumes, and the first; None if it assumes nothing."""
    if facts is None:
        return None
    first = None
    if facts.first is not None:
        first = asdict(facts.first) | {"sample": facts.first.sample + 1, "fact": facts.first.text}
        del first["text"]
        first |= {side: first[side] if math.isfinite(first[side]) else None for side in SIDES}
    return {"broken": facts.broken, "first": first}


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


def errors_sheet(
    plan: Plan,
    report: RunFindings,
    found: Mapping[str, Worst | None] | None,
    details: bool,
    checks: CheckTally,
) -> Sheet:
    """Return what a run showed; with details, histograms and worst inputs, those found by a search too."""
    judged = {} if report.judgement is None else report.judgement.found
    sheet = comparison_sheet(plan, report.comparison, judged)
    lines = [
        f"  {count(samples, 'sample')} without a value, {cause.reason} in the equation of "
        f"'{cause.equation}', first sample {first + 1}"
        for cause, samples, first in report.causes[:_MOST_CAUSES]
    ]
    if more := report.causes[_MOST_CAUSES:]:
        lines.append(f"  {count(sum(n for _, n, _ in more), 'sample')} without a value for other reasons")
    if report.facts is not None and report.facts.broken:
        largest = ", ".join(
            f"{name} {figure(error, ' rad' if plan.problem.angles[name] else '')}"
            for name, error in report.unfounded.items()
        )
        lines.append(
            f"  {count(report.facts.broken, 'sample')} not as the problem assumes, not in the figures above; "
            f"largest errors {largest}"
        )
    if report.screened:
        gaps = [gap for gap in report.screening_error.values() if gap is not None]
        known = f", there at most {max(gaps):.2g} from it" if gaps else ""
        lines.append(
            f"  {count(report.referenced, 'sample')} against high precision, {report.screened} against "
            f"double precision{known}; the worst of these again against high precision"
        )
    lines += _details(plan, report, found) if details else []
    figures = {name: record.figures for name, record in checks.found.items()}
    return replace(sheet, blocks=(*sheet.blocks, *checks_table(plan.problem, figures), *lines))


def _details(plan: Plan, report: RunFindings, found: Mapping[str, Worst | None] | None) -> list[str]:
    """Return lines with the histogram and the worst inputs of each output."""
    lines: list[str] = []
    angles = plan.problem.angles
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


def _worst_lines(
    name: str, report: RunFindings, found: Mapping[str, Worst | None] | None, unit: str
) -> list[str]:
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


def comparison_sheet(plan: Plan, comparison: Comparison, judged: Mapping[str, Judged]) -> Sheet:
    """Return the summary of a simulation; `judged` holds what bounds the plan states."""
    title = (
        f"{plan.name} on {plan.target.name}: {count(comparison.samples, 'sample')}, {comparison.valid} valid"
    )
    lines = []
    if comparison.lost:
        lines.append(f"  {count(comparison.lost, 'sample')} that the equations can do came out invalid")
    if comparison.gained:
        gained = count(comparison.gained, "sample")
        lines.append(f"  {gained} outside the domain of the equations came out valid")
    header = ACCURACY_HEADER + (("holds for", "beyond") if judged else ())
    rows: list[tuple[str, ...]] = []
    for output in plan.problem.outputs:
        name, unit = output.name, " rad" if output.is_angle else ""
        seen = comparison.observed[name]
        row = (name, figure(seen.max, unit), figure(seen.rms, unit))
        rows.append((*row, *_judged(plan, judged.get(name), name, unit)) if judged else (*row, "not derived"))
    return Sheet(title, (*lines, Table(header, tuple(rows))))


def _judged(plan: Plan, judged: Judged | None, output: str, unit: str) -> tuple[str, str, str]:
    """Return a bound, the samples that it holds for, and how many of these are beyond it."""
    if judged is None:
        return "not derived", "-", "-"
    held = "every valid sample"
    bound = plan.accuracy[output].bound
    if bound is not None and bound.conditions:
        held = "-" if judged.share is None else f"{percent(judged.share)} of valid samples"
    return figure(judged.bound, unit), held, str(judged.beyond) if judged.beyond else "none"


def comparison_data(plan: Plan, comparison: Comparison) -> dict[str, Any]:
    """Return the figures of a simulation as plain data."""
    return {
        "name": plan.name,
        "target": plan.target.name,
        "samples": comparison.samples,
        "valid": comparison.valid,
        "lost": comparison.lost,
        "gained": comparison.gained,
        "accuracy": {
            name: {
                "bound": _stated(plan, name),
                "observed": {"max": seen.max, "rms": seen.rms},
            }
            for name, seen in comparison.observed.items()
        },
    }


def _stated(plan: Plan, output: str) -> dict[str, Any] | None:
    figures = plan.accuracy.get(output)
    return None if figures is None or figures.bound is None else bound_data(figures.bound)
