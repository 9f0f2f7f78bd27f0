"""The tables of the report, as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.backends import labels
from cordicc.backends.text.area_facts import area_facts
from cordicc.base.text_tables import percent
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanCheck, PlanUnitKind
from cordicc.plan.stated_accuracy import CheckFigures, OutputAccuracy
from cordicc.targets.target import CAU_KINDS

DASH = "—"


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of the summary: name, value, note, and what is known about its optimality."""

    name: str
    value: str
    note: str = ""
    proof: str = ""


@dataclass(frozen=True, slots=True)
class Accuracy:
    """A row of the accuracy table, as text."""

    output: str
    most: str
    rms: str
    bound: str
    within: str
    where: str


@dataclass(frozen=True, slots=True)
class CheckRow:
    """A row of the table of checks, as text; `worst` is the sample of the largest."""

    name: str
    text: str
    most: str
    rms: str
    allowed: str
    undefined: str
    worst: str


@dataclass(frozen=True, slots=True)
class WordFormat:
    """A row of the table of number formats: a value, and how its words are read."""

    value: str
    width: int
    fraction: int
    largest: str
    ulp: str


@dataclass(frozen=True, slots=True)
class TargetUnit:
    """A row of the table of the target's kinds of unit."""

    kind: str
    used: int
    latency: str
    interval: str
    stages: str
    adders: str
    area: str


def figures(plan: Plan) -> list[Figure]:
    """Return the figures of the summary."""
    kinds = Counter(unit.kind for unit in plan.units)
    caus = sum(kinds[kind] for kind in CAU_KINDS)

    def time(count: int) -> str:
        return labels.seconds(count, plan.clock_hz)

    split = ", ".join(f"{kinds[kind]} {kind}" for kind in CAU_KINDS if kinds[kind])
    words = sum(fifo.depth for fifo in plan.fifos)
    latency, interval = plan.latency_cycles, plan.initiation_interval
    return [
        Figure("Processors (CAUs)", str(caus), split, _proof(plan, "processors", caus)),
        Figure("Latency, cycles", str(latency), time(latency), _proof(plan, "latency", latency)),
        Figure("of which CAU stages", str(plan.cau_cycles), time(plan.cau_cycles)),
        Figure("Longest path, cycles", str(sum(plan.critical_path().values())), _longest(plan)),
        Figure("Initiation interval, cycles", str(interval), f"a sample every {time(interval)}"),
        Figure("FIFO words", str(words), f"{len(plan.fifos)} segments", _proof(plan, "fifo_words", words)),
        *(Figure(name.strip().capitalize(), "", text) for name, text in area_facts(plan)),
    ]


def _longest(plan: Plan) -> str:
    path = plan.critical_path()
    kinds = sorted(path, key=labels.kind_rank)
    return ", ".join(f"{path[kind]} in {labels.plain_kind(kind)}s" for kind in kinds)


def _proof(plan: Plan, goal: str, value: int) -> str:
    """Say whether a figure is proven optimal, or how far the bound lies below it."""
    known, bound = labels.proof(plan, goal), plan.bounds.get(goal)
    if plan.optimal.get(goal) or bound is None:
        return known
    gap = f", gap {(value - bound) / value:.1%}" if value else ""
    return f"not proven optimal; {known}{gap}"


def units(plan: Plan) -> list[tuple[str, int, str]]:
    """Return kind, count and latencies of the units, CAUs first."""
    rows = []
    for kind in sorted({unit.kind for unit in plan.units}, key=labels.kind_rank):
        latencies = sorted({unit.latency for unit in plan.units if unit.kind == kind})
        count = sum(unit.kind == kind for unit in plan.units)
        rows.append((labels.plain_kind(kind), count, ", ".join(map(str, latencies))))
    return rows


def accuracy(plan: Plan) -> list[Accuracy]:
    """Return the errors of each output."""
    angles = plan.problem.angles
    return [_accuracy(name, plan.accuracy.get(name), " rad" * angles[name]) for name in plan.outputs]


def _accuracy(name: str, known: OutputAccuracy | None, unit: str) -> Accuracy:
    seen = None if known is None else known.observed
    bound = None if known is None else known.bound
    most, rms = (DASH, DASH) if seen is None else (_error(seen.max, unit), _error(seen.rms, unit))
    if bound is None:
        reason = "" if known is None else known.bound_reason
        reason = reason or "not asked for; 'cordicc compile --certify' derives one"
        return Accuracy(name, most, rms, DASH, DASH, reason)
    note = [bound.where]
    if bound.share_of_samples < 1 or bound.conditions:
        note.append(f"{percent(bound.share_of_samples)} of the samples")
    within = _error(labels.most_within(bound), unit)
    return Accuracy(name, most, rms, _error(bound.value, unit), within, ", ".join(note))


def checks(plan: Plan) -> list[CheckRow]:
    """Return how far the checks are from 0."""
    return [_check(plan.problem.check(name), figures) for name, figures in plan.checks.items()]


def _check(check: PlanCheck, figures: CheckFigures) -> CheckRow:
    unit = f" {check.unit}" if check.unit else ""
    seen, worst = figures.observed, figures.worst_input or {}
    return CheckRow(
        check.name,
        check.text,
        _error(seen.max, unit),
        _error(seen.rms, unit),
        _error(check.max, unit),
        str(figures.undefined) if figures.undefined else DASH,
        ", ".join(f"{name} = {number:.6g}" for name, number in worst.items()) or DASH,
    )


def _error(value: float | None, unit: str) -> str:
    return DASH if value is None else f"{value:.3e}{unit}"


def formats(plan: Plan) -> list[WordFormat]:
    """Return the formats that the plan states: inputs and results, then outputs."""
    outputs = {f"output {name}": point for name, point in plan.formats.outputs.items()}
    return [_word_format(name, point) for name, point in {**plan.formats.values, **outputs}.items()]


def _word_format(name: str, point: BinaryPoint) -> WordFormat:
    ulp = Fraction(2) ** -point.fraction
    largest = ((1 << (point.width - 1)) - 1) * ulp
    return WordFormat(name, point.width, point.fraction, f"{float(largest):.6g}", f"{float(ulp):.3g}")


def target_facts(plan: Plan) -> list[tuple[str, str]]:
    """Return what the target says besides its units, as pairs of a name and a text."""
    target, clock = plan.target, plan.clock_hz
    rows = [("Target", target.name)]
    if target.description:
        rows.append(("Description", " ".join(target.description.split())))
    rows.append(("Clock", f"{clock / 1e6:g} MHz, a cycle of {labels.seconds(1, clock)}"))
    rows.append(("Angles inside", {"rad": "radians", "turn": "turns"}.get(target.angle_unit, "?")))
    rows.append(("Number format", _spec(target.arithmetic.spec["format"])))
    inside: Mapping[str, Any] = target.arithmetic.spec["units"]
    for kind in sorted(inside, key=labels.kind_rank):
        article = "an" if kind == "implicit" else "a"
        rows.append((f"Inside {article} {labels.plain_kind(kind)}", _spec(inside[kind])))
    return rows


def _spec(spec: Mapping[str, Any]) -> str:
    """Write a format or the inside of a unit: `kind: ieee-single, ...`."""
    parts = [
        str(value) if name in ("kind", "rule") else f"{value} {str(name).replace('_', ' ')}"
        for name, value in sorted(spec.items(), key=lambda item: item[0] not in ("kind", "rule"))
    ]
    return ", ".join(parts)


def target_units(plan: Plan) -> list[TargetUnit]:
    """Return the target's kinds of unit, those of the plan first."""
    used = Counter(unit.kind for unit in plan.units)
    known = plan.target.units
    order = sorted(known, key=lambda kind: (not used[kind], labels.kind_rank(kind)))
    return [_target_unit(kind, used[kind], known[kind]) for kind in order]


def _target_unit(kind: str, used: int, unit: PlanUnitKind) -> TargetUnit:
    stages = ", ".join(f"{cycles} {stage.replace('_', ' ')}" for stage, cycles in unit.stages.items())
    interval = "1"  # every unit is a pipeline
    return TargetUnit(
        labels.plain_kind(kind), used, str(unit.latency), interval, stages, str(unit.adders), f"{unit.area:g}"
    )


def chosen(plan: Plan) -> str:
    """Say how the operations were chosen, and what was not among the alternatives."""
    return _found(plan) + "".join(f"; left out: {words}" for words in plan.selection.left_out)


def _found(plan: Plan) -> str:
    if not plan.selection.searched:
        return "as the rules give them, without a search for others"
    if plan.selection.proven:
        return "proven the cheapest of the alternatives found"
    more = f"; {labels.turned_down(plan)}" if plan.selection.turned_down else ""
    return f"the cheapest of the alternatives found, without a proof{more}"


def assumptions(plan: Plan) -> Sequence[tuple[str, bool]]:
    """Return what the problem assumes, and whether the plan rests on it."""
    stated = plan.problem.assumptions
    used = set(plan.selection.facts)
    return [(text, text in used) for text in dict.fromkeys([*stated, *plan.selection.facts])]
