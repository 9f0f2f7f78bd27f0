"""`cordicc diff`: what differs between two plans, in the words of the summary."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from cordicc.backends.text.area_facts import area_facts
from cordicc.backends.text.formulas import Formulas
from cordicc.base.text_tables import Block, Heading, Sheet, Table
from cordicc.plan.model import Plan
from cordicc.plan.plain_data import as_dict
from cordicc.targets.target import CAU_KINDS

_NUMBERED = re.compile(r"\bo[0-9]+(?:\.(\w+))?")


@dataclass(frozen=True, slots=True)
class Difference:
    """A thing that differs: its section, its name, and what it is in either plan, None where absent."""

    section: str
    name: str
    first: Any
    second: Any


def differences(first: Plan, second: Plan) -> list[Difference]:
    """Return everything that differs between two plans; none if and only if their files say the same."""
    found: list[Difference] = []
    for section, read in _SECTIONS.items():
        mine, theirs = (dict(read(plan)) for plan in (first, second))
        found += [
            Difference(section, name, mine.get(name), theirs.get(name))
            for name in dict.fromkeys([*mine, *theirs])
            if mine.get(name) != theirs.get(name)
        ]
    found += _operations(first, second)
    if not found:
        mine, theirs = as_dict(first), as_dict(second)
        found = [
            Difference("other", key, "differs", "differs")
            for key in {**mine, **theirs}
            if mine.get(key) != theirs.get(key)
        ]
    return found


def _figures(plan: Plan) -> Iterator[tuple[str, Any]]:
    counts = plan.units_by_kind()
    yield "CAUs", plan.processors()["total"]
    for kind in (*CAU_KINDS, *sorted(set(counts) - set(CAU_KINDS))):
        yield f"  {kind}", counts.get(kind, 0)
    yield "latency, cycles", plan.latency_cycles
    yield "  CAUs alone", plan.cau_cycles
    yield "latency, seconds", plan.latency_seconds
    yield "interval", plan.initiation_interval
    yield "FIFO words", plan.fifo_words
    yield "FIFOs", len(plan.fifos)
    yield from area_facts(plan)
    for name, proven in plan.optimal.items():
        yield f"{name} proven", "optimal" if proven else f"at least {plan.bounds[name]}"


def _options(plan: Plan) -> Iterator[tuple[str, Any]]:
    yield "target", plan.target.name
    yield "clock, Hz", plan.clock_hz
    for name, value in sorted(plan.arithmetic.spec["format"].items()):
        yield f"format, {name.replace('_', ' ')}", value
    for name, value in sorted(plan.options.recorded.items()):
        if name not in ("file", "target"):
            yield f"--{name.replace('_', '-')}", value


def _problem(plan: Plan) -> Iterator[tuple[str, Any]]:
    yield "name", plan.name
    for item in plan.problem.inputs:
        yield f"input {item.name}", f"[{item.lo!r}, {item.hi!r}]"
    for name, value in plan.problem.constants.items():
        yield f"constant {name}", value
    for equation in plan.problem.equations:
        yield f"equation {equation.target}", equation.text
    for output in plan.problem.outputs:
        yield f"output {output.name}", f"max_error {output.max_error}, wrap {output.wrap}"
    for check in plan.problem.checks:
        yield f"check {check.name}", f"{check.text}, max {check.max}, unit {check.unit}"


def _accuracy(plan: Plan) -> Iterator[tuple[str, Any]]:
    for name, figures in plan.accuracy.items():
        yield f"{name}, largest error", figures.observed.max
        yield f"{name}, rms error", figures.observed.rms
        yield f"{name}, bound", None if figures.bound is None else figures.bound.value


def _checks(plan: Plan) -> Iterator[tuple[str, Any]]:
    for name, figures in plan.checks.items():
        yield f"{name}, largest", figures.observed.max
        yield f"{name}, rms", figures.observed.rms
        yield f"{name}, samples without a value", figures.undefined


def _units(plan: Plan) -> Iterator[tuple[str, Any]]:
    """Yield what each kind of unit is, for targets that differ."""
    for kind, unit in plan.target.units.items():
        yield f"{kind} latency", unit.latency
        yield f"{kind} area", unit.area


_SECTIONS = {
    "problem": _problem,
    "options": _options,
    "units of the target": _units,
    "figures": _figures,
    "accuracy": _accuracy,
    "checks": _checks,
}


def _operations(first: Plan, second: Plan) -> list[Difference]:
    """Return the operations that one plan has and the other has not, by what they compute."""
    mine, theirs = _computed(first), _computed(second)
    gone, come = mine - theirs, theirs - mine
    return [
        Difference("operations", name, gone[name] or None, come[name] or None)
        for name in sorted(gone | come, key=lambda name: (name not in gone, name))
    ]


def _computed(plan: Plan) -> Counter[str]:
    """Return what operations compute; numbers of operations differ for no reason and are left out."""
    formulas = Formulas(plan)
    caus = [
        f"{o.mode}: " + _NUMBERED.sub(lambda found: f"<{found[1] or 'value'}>", formulas.of(o)[0].text)
        for o in plan.operations
        if o.kind in CAU_KINDS
    ]
    others = [f"{o.mode} in the equation of {o.equation}" for o in plan.operations if o.kind not in CAU_KINDS]
    return Counter([*caus, *others])


def as_sheet(first: Plan, second: Plan, found: list[Difference], heads: tuple[str, str]) -> Sheet:
    """Return the differences as tables by section, under the names of the two plans."""
    names = [f"{plan.name} on {plan.target.name}" for plan in (first, second)]
    if not found:
        return Sheet(f"{names[0]}: the plans are the same")
    blocks: list[Block] = []
    for section in dict.fromkeys(each.section for each in found):
        rows = [(d.name, _shown(d.first), _shown(d.second)) for d in found if d.section == section]
        blocks += [Heading(section), Table(("", *heads), tuple(rows))]
    return Sheet(" and ".join(names), tuple(blocks))


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def as_json(found: list[Difference]) -> str:
    """Return the differences as one JSON object."""
    listed = [
        {"section": d.section, "name": d.name.strip(), "first": d.first, "second": d.second} for d in found
    ]
    data = {"same": not found, "differences": listed}
    return json.dumps(data, indent=2, sort_keys=True, ensure_ascii=False) + "\n"
