"""A run of a plan on samples, part by part: of a file or drawn, written, compared and judged."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cordicc.backends.text.summary import count
from cordicc.base.arrays import Samples
from cordicc.base.diagnostics import Diagnostic, InvalidInput, Severity
from cordicc.base.text_tables import Sheet
from cordicc.certify.error_network import network
from cordicc.certify.own_bounds import own_bounds
from cordicc.certify.plans import StatedBounds
from cordicc.cli.console import Progress
from cordicc.cli.simulation_text import dumped, errors_json, errors_sheet, facts_data, print_told
from cordicc.cli.streams import deliver
from cordicc.emulate import cycle, extremes, functional
from cordicc.emulate.checking import CheckTally, beyond_limits, without_value
from cordicc.emulate.fact_tally import FactTally
from cordicc.emulate.histogram import Worst
from cordicc.emulate.judging import MOST_BEYOND, ConditionalBounds, Judged, Judgement
from cordicc.emulate.long_run import REFERENCE_SAMPLES, RunFindings, run_parts
from cordicc.emulate.observation import reference_samples
from cordicc.emulate.sample_columns import Columns
from cordicc.emulate.sample_tables import PART_ROWS, read_table
from cordicc.emulate.writing import Write, csv_header, csv_rows, table_writer
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.sampling import DEFAULT_SAMPLES, draw_parts
from cordicc.plan.file import BROKEN
from cordicc.plan.model import Plan

BOUND = "bound_"
"""Before the name of an output: the column with the bound of the sample's own error."""

_NUMBER_BYTES = 12
"""About what a number takes in a CSV file."""


class SampleRun(NamedTuple):
    """A plan, how it is run, how results are told; whether each sample's own bounds are written."""

    plan: Plan
    cycle_accurate: bool
    as_json: bool
    tell: Callable[[Iterable[Diagnostic]], None]
    own_bounds: bool = False

    @property
    def inputs(self) -> list[str]:
        """Return the names of the inputs."""
        return list(self.plan.problem.input_names)

    @property
    def columns(self) -> list[str]:
        """Return the names of the columns that are written, but for `valid`."""
        outputs = list(self.plan.outputs)
        if not self.own_bounds:
            return outputs
        if twice := [name for name in outputs if name.startswith(BOUND) and name[len(BOUND) :] in outputs]:
            message = f"output '{twice[0]}' has the name of a column of --own-bounds"
            raise InvalidInput([Diagnostic("E612", message, hint="rename the output")])
        return [*outputs, *(BOUND + name for name in outputs)]

    def about_rows(self, file: Path) -> int:
        """Return about how many samples a file of inputs has."""
        return file.stat().st_size // (_NUMBER_BYTES * max(1, len(self.inputs)))

    def simulator(self, first: Samples, total: int) -> Callable[[Samples], dict[str, Any]]:
        """Return what runs a part, fit for about `total` samples of which `first` are the first."""
        machine = self.plan.arithmetic
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
    run: SampleRun,
    inputs: Path | None,
    random: int | None,
    seed: int,
    outputs: Path | None,
    reference: Reference,
) -> int:
    """Run a plan on samples of a file or drawn ones; write the outputs and print the errors.

    Returns the exit status: 1 if a sample is beyond a bound that the plan states, which is told as well.
    """
    plan = run.plan
    if inputs is None:
        total: int | None = random or DEFAULT_SAMPLES
        expected = random or DEFAULT_SAMPLES
        parts = draw_parts(plan.problem.workspace, expected, seed, PART_ROWS)
    else:
        table = read_table(inputs, Columns(run.inputs))
        run.tell(table.warnings)
        total, parts = None, table.parts
        expected = run.about_rows(inputs)
    first = next(parts)
    simulate = run.simulator(first, expected)
    progress, checks = Progress(total, "samples"), CheckTally(plan.problem)
    with ExitStack() as stack:
        stack.callback(progress.done)
        take = _sink(outputs, run.columns, stack)
        each = _with_own_bounds(plan, simulate) if run.own_bounds else simulate
        stream = again(first, parts)
        facts = FactTally.of(plan)
        if reference.samples is None:
            told: str | Sheet = _only_run(run, stream, each, take, progress, facts)
            beyond: list[Diagnostic] = []
        else:
            graph, angles = plan.problem.program, plan.problem.angles
            precise = reference_samples(graph) if reference.fewer else reference.samples
            stated = StatedBounds.of(plan)
            limits = None if stated is None else ConditionalBounds(stated.values, stated.inside)
            each = checks.watching(each)
            report = run_parts(graph, angles, stream, each, take, progress.reached, precise, limits, facts)
            found = _search(plan, report, simulate) if reference.search else None
            beyond = _beyond(report.judgement, found or {})
            told = (
                errors_json(plan, report, found, checks)
                if run.as_json
                else errors_sheet(plan, report, found, reference.search, checks)
            )
    print_told(told, err=str(outputs) == "-")
    if facts is not None:
        run.tell(facts.told("sample" if inputs is None else "row"))
    run.tell([*beyond, *beyond_limits(checks, Severity.WARNING), *without_value(checks)])
    return 1 if beyond else 0


def _with_own_bounds(
    plan: Plan, simulate: Callable[[Samples], dict[str, Any]]
) -> Callable[[Samples], dict[str, Any]]:
    """Return what runs a plan and bounds the error of each sample.

    nan stands for a sample that is invalid, or that breaks what the problem assumes.
    Raises InvalidInput for a plan without the operations that a proof needs, or with those of another.
    """
    try:
        net = network(plan)
    except BROKEN:
        message = "the plan has no unit program of its operations, without which nothing can be proven"
        raise InvalidInput([Diagnostic("E603", message, hint="compile the problem again")]) from None
    facts = FactTally.of(plan)

    def run(samples: Samples) -> dict[str, Any]:
        outputs = simulate(samples)
        valid = outputs["valid"].astype(bool)
        if facts is not None:
            valid &= facts.kept(samples) & facts.facts.exactly(samples)
        own = own_bounds(net, list(plan.outputs), {n: column[valid] for n, column in samples.items()})
        for name, bounds in own.items():
            outputs[BOUND + name] = np.full(valid.shape, np.nan)
            outputs[BOUND + name][valid] = bounds
        return outputs

    return run


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


def again(first: Samples, rest: Iterator[Samples]) -> Iterator[Samples]:
    """Return a stream of samples of which the first part was taken."""
    yield first
    yield from rest


def _sink(path: Path | None, names: list[str], stack: ExitStack) -> Write:
    """Return what takes the outputs of each part."""
    if path is None:
        return lambda outputs: None
    if str(path) == "-":
        deliver(csv_header(names))
        return lambda outputs: deliver(csv_rows(names, outputs))
    return stack.enter_context(table_writer(path, names))


def _only_run(
    run: SampleRun,
    parts: Iterator[Samples],
    simulate: Callable[[Samples], dict[str, Any]],
    take: Write,
    progress: Progress,
    facts: FactTally | None,
) -> str | Sheet:
    samples = valid = 0
    for part in parts:
        outputs = simulate(part)
        take(outputs)
        if facts is not None:
            facts.kept(part)
        samples, valid = samples + len(outputs["valid"]), valid + int(outputs["valid"].sum())
        progress.reached(samples)
    if run.as_json:
        data = {"name": run.plan.name, "target": run.plan.target.name, "samples": samples, "valid": valid}
        return dumped(data | {"facts": facts_data(facts)})
    return Sheet(f"{run.plan.name} on {run.plan.target.name}: {count(samples, 'sample')}, {valid} valid")


def _search(
    plan: Plan, report: RunFindings, simulate: Callable[[Samples], dict[str, Any]]
) -> dict[str, Worst | None] | None:
    """Search for larger errors of each output; None where inputs depend on one another."""
    if plan.problem.samples is not None or plan.problem.facts.dependent:
        return None
    graph, facts = plan.problem.program, FactTally.of(plan)
    ranges = {item.name: Interval(item.lo, item.hi) for item in plan.problem.inputs}
    inside = {
        name: [w for w in worst if all(each.lo <= w.inputs[n] <= each.hi for n, each in ranges.items())]
        for name, worst in report.worst.items()
    }

    def run(samples: Samples) -> dict[str, Any]:
        outputs = simulate(samples)
        # What breaks a fact is as good as invalid: nothing is claimed of it.
        return outputs if facts is None else {**outputs, "valid": outputs["valid"] & facts.kept(samples)}

    return {
        name: extremes.search(graph, is_angle, name, ranges, inside[name], run)
        for name, is_angle in plan.problem.angles.items()
    }
