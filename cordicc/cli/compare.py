"""What `cordicc simulate --compare` does: a user's own answers beside those of a plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cordicc.backends.text.summary import count
from cordicc.base.arrays import Samples
from cordicc.base.diagnostics import Diagnostic, InvalidInput
from cordicc.base.text_tables import Sheet
from cordicc.certify.own_bounds import own_bounds
from cordicc.certify.plans import StatedBounds
from cordicc.cli.sample_run import SampleRun, again
from cordicc.cli.simulation_text import dumped, facts_data, print_told
from cordicc.emulate.expected import TOLERANCE, Allowed, ExpectedVerdict, check_golden
from cordicc.emulate.fact_tally import FactTally
from cordicc.emulate.sample_columns import Columns
from cordicc.emulate.sample_tables import read_table
from cordicc.plan.model import Plan

_MARGIN = 2.0
"""Times the largest error observed is allowed where no bound holds."""


def check_expected(run: SampleRun, inputs: Path, expected: Path, tolerance: float | None) -> int:
    """Compare the outputs with expected ones, print the worst rows, return the exit status: 1 if any differs.

    Without a tolerance the largest difference allowed is the column `tol_<output>` of the file, else what is
    proven of the row: the plan's bound where it holds, or the row's own if that is less; where neither is
    there, as of a row that breaks what the problem assumes, twice the largest error observed.
    """
    plan, angles = run.plan, run.plan.problem.angles
    table = read_table(inputs, Columns(run.inputs))
    own = [TOLERANCE + name for name in angles] if tolerance is None else []
    optional = [*own, "valid"]
    answers = read_table(expected, Columns(list(angles), "output", optional, nan=True, some=True))
    run.tell([*table.warnings, *answers.warnings])
    _require_outputs(answers.names, own)
    angles = {name: is_angle for name, is_angle in angles.items() if name in answers.names}
    limits = {name: _limit(plan, name) if tolerance is None else _Limit(None, tolerance) for name in angles}
    first = next(table.parts)
    simulate = run.simulator(first, run.about_rows(inputs))
    facts = FactTally.of(plan)
    allowed = _allowed(plan, limits)

    def counted(samples: Samples) -> dict[str, Any]:
        if facts is not None:
            facts.kept(samples)
        return simulate(samples)

    verdict = check_golden(again(first, table.parts), answers.parts, angles, allowed, counted)
    stated = {n: None if TOLERANCE + n in answers.names else limit for n, limit in limits.items()}
    told = (
        _verdict_json(plan, verdict, stated, facts) if run.as_json else _verdict_sheet(plan, verdict, stated)
    )
    print_told(told)
    if facts is not None:
        run.tell(facts.told("row"))
    return 0 if verdict.agrees else 1


def _require_outputs(names: Sequence[str], tolerances: Sequence[str]) -> None:
    """Raise InvalidInput for a tolerance of an output of which nothing is expected."""
    for column in tolerances:
        output = column.removeprefix(TOLERANCE)
        if column in names and output not in names:
            message = f"output '{output}' is missing from the header, but '{column}' is there"
            raise InvalidInput([Diagnostic("E612", message)])


class _Limit(NamedTuple):
    """The largest difference allowed where a bound is proven, None if none is stated, and elsewhere."""

    proven: float | None
    elsewhere: float


def _limit(plan: Plan, output: str) -> _Limit:
    figures = plan.accuracy.get(output)
    if figures is None:
        return _Limit(None, 0.0)
    usual = _MARGIN * (figures.observed.max or 0.0)
    if figures.bound is None or figures.bound.conditions is None:
        return _Limit(None, usual)
    return _Limit(figures.bound.value, usual)


def _allowed(plan: Plan, limits: Mapping[str, _Limit]) -> Allowed:
    """Return what tells the largest differences allowed of samples."""
    proven = {name: limit.proven for name, limit in limits.items() if limit.proven is not None}
    stated, facts = StatedBounds.of(plan) if proven else None, FactTally.of(plan)

    def allowed(samples: Samples) -> dict[str, Any]:
        shape = next(iter(samples.values())).shape
        found: dict[str, Any] = {name: np.full(shape, limit.elsewhere) for name, limit in limits.items()}
        if stated is not None:
            kept = np.ones(shape, dtype=bool)
            if facts is not None:
                kept = facts.kept(samples) & facts.facts.exactly(samples)
            held, own = stated.inside(samples), own_bounds(stated.net, list(proven), samples)
            for name, value in proven.items():
                least = np.fmin(np.where(held[name], value, np.inf), own[name])
                found[name] = np.where(kept & np.isfinite(least), least, found[name])
        return found

    return allowed


def _verdict_sheet(plan: Plan, verdict: ExpectedVerdict, limits: Mapping[str, _Limit | None]) -> Sheet:
    agrees = "as expected" if verdict.agrees else "not as expected"
    title = f"{plan.name} on {plan.target.name}: {count(verdict.rows, 'row')}, {agrees}"
    lines = []
    if verdict.validity:
        rows = count(verdict.validity, "row")
        lines.append(f"  {rows} valid in one alone, first row {verdict.first_invalid}")
    angles = plan.problem.angles
    for name, errors in verdict.differences.items():
        unit = " rad" if angles[name] else ""
        limit = limits[name]
        may = "its column" if limit is None else f"{limit.elsewhere:.3g}{unit}"
        if limit is not None and limit.proven is not None:
            may = f"the bound of the row, {limit.proven:.3g}{unit} or less"
        seen = "-" if errors.largest is None else f"{errors.largest:.3g}{unit}"
        lines.append(
            f"  {name}: largest difference {seen}, allowed {may}, {count(verdict.beyond[name], 'row')} beyond"
        )
    if missing := [name for name in plan.outputs if name not in limits]:
        lines.append(f"  not compared, since nothing is expected of them: {', '.join(missing)}")
    for row, name, simulated, expected, allowed in verdict.wrong:
        lines.append(f"  row {row}, {name}: {simulated!r} instead of {expected!r}, allowed {allowed:.3g}")
    return Sheet(title, tuple(lines))


def _stated(limit: _Limit | None) -> float | None:
    """Return the largest difference allowed in any row, as far as one number says it; None for a column."""
    if limit is None:
        return None
    return limit.elsewhere if limit.proven is None else limit.proven


def _verdict_json(
    plan: Plan, verdict: ExpectedVerdict, limits: Mapping[str, _Limit | None], facts: FactTally | None
) -> str:
    keys = ("row", "output", "simulated", "expected", "allowed")
    outputs = {
        name: {
            "largest": errors.largest,
            "rms": errors.rms,
            "allowed": _stated(limits[name]),
            "beyond": verdict.beyond[name],
        }
        for name, errors in verdict.differences.items()
    }
    return dumped(
        {
            "name": plan.name,
            "target": plan.target.name,
            "rows": verdict.rows,
            "not_compared": [name for name in plan.outputs if name not in limits],
            "agrees": verdict.agrees,
            "validity_differs": verdict.validity,
            "facts": facts_data(facts),
            "outputs": outputs,
            "wrong": [dict(zip(keys, line, strict=True)) for line in verdict.wrong],
        }
    )
