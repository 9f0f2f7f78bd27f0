"""The texts that the command line prints of a plan."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.backends.labels import (
    MOST,
    duration,
    end_of_reach,
    most_within,
    needs_effort,
    proof,
    turned_down,
)
from cordicc.backends.text.area_facts import area_facts
from cordicc.base.text_tables import Block, Facts, Sheet, Table, percent
from cordicc.plan.model import Plan
from cordicc.plan.origin import PlanProblem
from cordicc.plan.stated_accuracy import CheckFigures, StatedBound
from cordicc.targets.target import CAU_KINDS


def count(number: int, noun: str) -> str:
    """Return a number and its noun, in the plural but for 1."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def plan_sheet(plan: Plan, last: str = "") -> Sheet:
    """Return the summary of a plan, and a last line."""
    caus = plan.processors()
    others = [f"{n} {kind}" for kind, n in plan.units_by_kind().items() if kind not in CAU_KINDS]
    proven = {name: proof(plan, name) for name in ("processors", "latency", "fifo_words")}
    by_kind = f"{caus['standard']} standard, {caus['implicit']} implicit"
    longest = plan.critical_path()
    path = " + ".join(f"{cycles} {kind}" for kind, cycles in longest.items())
    rate = plan.clock_hz / plan.initiation_interval
    rows = [
        ("processors", f"{count(caus['total'], 'CAU')}: {by_kind} ({proven['processors']})"),
        ("operators", ", ".join(others) or "none"),
        ("chosen", _chosen(plan)),
        *_left_out(plan),
        (
            "latency",
            f"{count(plan.latency_cycles, 'cycle')}, {duration(plan.latency_seconds)} ({proven['latency']})",
        ),
        ("  CAUs alone", f"{count(plan.cau_cycles, 'cycle')}, {duration(plan.cau_cycles / plan.clock_hz)}"),
        (
            "  longest path",
            f"{path} {'cycle' if sum(longest.values()) == 1 else 'cycles'}" if path else "none",
        ),
        ("interval", f"{count(plan.initiation_interval, 'cycle')}, {rate:.6g} samples/s"),
        ("FIFO words", f"{plan.fifo_words} in {count(len(plan.fifos), 'FIFO')} ({proven['fifo_words']})"),
    ]
    words = plan.arithmetic.system
    if isinstance(words, FixedSystem):
        rows.append(("words", f"{words.width_bits} bits outside, {words.operand_bits} between operations"))
    rows += area_facts(plan)
    end = (*_ends(plan), *(("", f"  {last}") if last else ()))
    title = f"{plan.name} on {plan.target.name}"
    tables = (_accuracy(plan), *checks_table(plan.problem, plan.checks), *_ends_of_reach(plan))
    return Sheet(title, (Facts(tuple(rows)), "", *tables, *end))


def _ends(plan: Plan) -> Iterator[str]:
    """Yield lines that say where the accuracy of outputs ends, each denominator once."""
    outputs: dict[tuple[str, str], list[str]] = {}
    below: dict[tuple[str, str], float] = {}
    for name, figures in plan.accuracy.items():
        for end in figures.ends:
            key = (end.size, end.equation)
            outputs.setdefault(key, []).append(name)
            below[key] = max(end.below, below.get(key, 0.0))
    for (size, equation), names in outputs.items():
        listed = ", ".join(dict.fromkeys(names))
        yield f"  accuracy of {listed} ends where {size} < {below[size, equation]:.2g} in the {equation}"


def _ends_of_reach(plan: Plan) -> tuple[Block, ...]:
    """Return what angles are off near the end of reach, where samples may come near it."""
    told = [(o, end_of_reach(o)) for o in plan.operations if o.end_error is not None]
    if not told:
        return ()
    rows = tuple((operation.equation or operation.id, text) for operation, text in told)
    return ("", "  near the end of reach, |C| = R, the angle of the equation of", Facts(rows, indent=4))


def _chosen(plan: Plan) -> str:
    """Say how the operations were chosen."""
    if not plan.selection.searched:
        return "as the equations give them, without a search"
    return "the cheapest of the alternatives found, " + ("proven" if plan.selection.proven else "not proven")


def _left_out(plan: Plan) -> list[tuple[str, str]]:
    """Say what was not among the alternatives, and how to get more."""
    rows = [("  left out", words) for words in plan.selection.left_out]
    if needs_effort(plan):
        rows.append(("  for more", f"a larger --effort than {plan.options.effort or 1:g}"))
    return rows


def explanation_text(plan: Plan) -> str:
    """Return, for each operation, the equation it came from and the steps that led to it."""
    lines = [f"{plan.name}: where the operations come from", ""]
    for operation in plan.operations:
        source = f"from the equation of {operation.equation}" if operation.equation else "from no equation"
        lines.append(f"  {operation.id}  {operation.mode} on {operation.unit}, {source}")
        lines += [f"      {step}" for step in operation.derivation]
    if plan.selection.turned_down:
        lines += ["", f"  {turned_down(plan)}"]
    return "\n".join(lines) + "\n"


def figure(number: float | None, unit: str = "") -> str:
    """Return a number to three digits with its unit; a dash for none."""
    return "-" if number is None else f"{number:.3g}{unit}"


def _bound(bound: StatedBound | None, unit: str) -> str:
    """Return a bound in words; under conditions with the share of the default samples that meet them."""
    if bound is None:
        return "not derived"
    share = f", {percent(bound.share_of_samples)} of samples" if bound.conditions else ""
    return figure(bound.value, unit) + share


ACCURACY_HEADER = ("output", "largest error", "rms error", "bound")


def checks_table(problem: PlanProblem, found: Mapping[str, CheckFigures]) -> tuple[Block, ...]:
    """Return an empty line and a table of how far checks are from 0; nothing where there are none."""
    rows: list[tuple[str, ...]] = []
    for name, figures in found.items():
        check, seen = problem.check(name), figures.observed
        unit = f" {check.unit}" if check.unit else ""
        allowed = "-" if check.max is None else figure(check.max, unit)
        missing = "none" if not figures.undefined else count(figures.undefined, "sample")
        rows.append((name, figure(seen.max, unit), figure(seen.rms, unit), allowed, missing))
    header: tuple[str, ...] = ("check", "largest", "rms", "max", "without a value")
    if not any(figures.undefined for figures in found.values()):
        header, rows = header[:-1], [row[:-1] for row in rows]
    return ("", Table(header, tuple(rows))) if rows else ()


def _accuracy(plan: Plan) -> Table:
    any_bound = any(most_within(figures.bound) is not None for figures in plan.accuracy.values())
    rows: list[tuple[str, ...]] = []
    for output in plan.problem.outputs:
        if output.name not in plan.accuracy:
            continue  # a plan that was not run
        figures = plan.accuracy[output.name]
        unit = " rad" if output.is_angle else ""
        seen, bound = figures.observed, figures.bound
        row = (output.name, figure(seen.max, unit), figure(seen.rms, unit), _bound(bound, unit))
        rows.append((*row, figure(most_within(bound), unit)) if any_bound else row)
    header = (*ACCURACY_HEADER, f"{MOST} proven within") if any_bound else ACCURACY_HEADER
    return Table(header, tuple(rows))
