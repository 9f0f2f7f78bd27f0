"""The texts that the command line prints of a plan and of a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.backends.labels import MOST, most_within, percent
from cordicc.base.text_tables import Facts, Sheet, Table, plain
from cordicc.emulate.accuracy import Comparison
from cordicc.emulate.judging import Judged
from cordicc.plan.model import Plan
from cordicc.plan.plain_data import bound_data
from cordicc.plan.stated_accuracy import StatedBound
from cordicc.targets.target import CAU_KINDS


def _seconds(seconds: float) -> str:
    """Return a time in the unit that suits it."""
    for factor, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs"), (1e9, "ns")):
        if seconds * factor >= 1 or unit == "ns":
            return f"{seconds * factor:.4g} {unit}"
    raise AssertionError


def count(number: int, noun: str) -> str:
    """Return a number and its noun, in the plural but for 1."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def plan_text(plan: Plan) -> str:
    """Return the summary of a plan, ending in a newline."""
    return plain(plan_sheet(plan))


def plan_sheet(plan: Plan, last: str = "") -> Sheet:
    """Return the summary of a plan, and a last line."""
    caus = plan.processors()
    others = [f"{n} {kind}" for kind, n in plan.units_by_kind().items() if kind not in CAU_KINDS]
    proven = {name: _proven(plan, name) for name in ("processors", "latency", "fifo_words")}
    by_kind = f"{caus['standard']} standard, {caus['implicit']} implicit"
    longest = plan.critical_path()
    path = " + ".join(f"{cycles} {kind}" for kind, cycles in longest.items())
    rate = plan.clock_hz / plan.initiation_interval
    rows = [
        ("processors", f"{count(caus['total'], 'CAU')}: {by_kind} ({proven['processors']})"),
        ("operators", ", ".join(others) or "none"),
        ("chosen", _chosen(plan)),
        (
            "latency",
            f"{count(plan.latency_cycles, 'cycle')}, {_seconds(plan.latency_seconds)} ({proven['latency']})",
        ),
        ("  CAUs alone", f"{count(plan.cau_cycles, 'cycle')}, {_seconds(plan.cau_cycles / plan.clock_hz)}"),
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
    end = ("", f"  {last}") if last else ()
    title = f"{plan.name} on {plan.target.name}"
    return Sheet(title, (Facts(tuple(rows)), "", _accuracy(plan), *end))


def _chosen(plan: Plan) -> str:
    """Say how the operations were chosen."""
    if not plan.selection.searched:
        return "as the rules give them, without a search"
    return "the cheapest of the alternatives found, " + ("proven" if plan.selection.proven else "not proven")


def explanation_text(plan: Plan) -> str:
    """Return, for each operation, the equation it came from and the steps that led to it."""
    lines = [f"{plan.name}: where the operations come from", ""]
    for operation in plan.operations:
        source = f"from the equation of {operation.equation}" if operation.equation else "from no equation"
        lines.append(f"  {operation.id}  {operation.mode} on {operation.unit}, {source}")
        lines += [f"      {step}" for step in operation.derivation]
    return "\n".join(lines) + "\n"


def _proven(plan: Plan, name: str) -> str:
    if plan.optimal[name]:
        return "proven optimal for these operations"
    return f"at least {plan.bounds[name]}"


def _figure(number: float | None, unit: str = "") -> str:
    return "-" if number is None else f"{number:.3g}{unit}"


def _bound(bound: StatedBound | None, unit: str) -> str:
    """Return a bound in words; under conditions with the share of the default samples that meet them."""
    if bound is None:
        return "not derived"
    share = f", {percent(bound.share_of_samples)} of samples" if bound.conditions else ""
    return _figure(bound.value, unit) + share


_ACCURACY = ("output", "largest error", "rms error", "bound")


def _accuracy(plan: Plan) -> Table:
    any_bound = any(most_within(figures.bound) is not None for figures in plan.accuracy.values())
    rows: list[tuple[str, ...]] = []
    for output in plan.problem.outputs:
        figures = plan.accuracy[output.name]
        unit = " rad" if output.is_angle else ""
        seen, bound = figures.observed, figures.bound
        row = (output.name, _figure(seen.max, unit), _figure(seen.rms, unit), _bound(bound, unit))
        rows.append((*row, _figure(most_within(bound), unit)) if any_bound else row)
    header = (*_ACCURACY, f"{MOST} proven within") if any_bound else _ACCURACY
    return Table(header, tuple(rows))


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
    header = _ACCURACY + (("holds for", "beyond") if judged else ())
    rows: list[tuple[str, ...]] = []
    for output in plan.problem.outputs:
        name, unit = output.name, " rad" if output.is_angle else ""
        seen = comparison.observed[name]
        row = (name, _figure(seen.max, unit), _figure(seen.rms, unit))
        rows.append((*row, *_judged(plan, judged.get(name), name, unit)) if judged else (*row, "not derived"))
    return Sheet(title, (*lines, Table(header, tuple(rows))))


def _judged(plan: Plan, judged: Judged | None, output: str, unit: str) -> tuple[str, str, str]:
    """Return a bound, the samples that it holds for, and how many of these are beyond it."""
    if judged is None:
        return "not derived", "-", "-"
    held = "every valid sample"
    bound = plan.accuracy[output].bound
    if bound is not None and bound.conditions:
        held = f"{percent(judged.share or 0.0)} of valid samples"
    return _figure(judged.bound, unit), held, str(judged.beyond) if judged.beyond else "none"


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
