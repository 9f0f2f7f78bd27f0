"""The report: one self-contained HTML page with figures, pictures and tables."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from cordicc.backends import datapath, labels, schedule_chart
from cordicc.backends.palette import LOOKS
from cordicc.backends.svg import clean
from cordicc.plan import Plan

DASH = "—"
RECORDED_OPTIONS = ("target", "units", "ii", "max_processors", "max_latency", "minimize", "time_limit")
GOALS = (("processors", "processors"), ("latency", "latency, cycles"), ("fifo_words", "FIFO words"))


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of the summary: value, note, and what is known about its optimality."""

    name: str
    value: str
    note: str = ""
    proof: str = ""


@dataclass(frozen=True, slots=True)
class Accuracy:
    """A row of the accuracy table, as text."""

    output: str
    bound: str
    where: str
    most: str
    rms: str


@dataclass(frozen=True, slots=True)
class WordFormat:
    """A row of the table of number formats: a value, and how its words are read."""

    value: str
    width: int
    fraction: int
    largest: str
    ulp: str


def render(plan: Plan) -> str:
    """Return the page."""
    environment = Environment(
        loader=PackageLoader("cordicc.backends", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=lambda item: item if isinstance(item, Markup) else clean(str(item)),
    )
    spans = labels.spans(plan)
    return environment.get_template("report.html.j2").render(
        plan=plan,
        headline=labels.headline(plan),
        figures=_figures(plan),
        units=_units(plan),
        accuracy=[_accuracy(name, plan.accuracy.get(name)) for name in plan.outputs],
        inputs=plan.problem.get("inputs", []),
        constants=sorted(plan.problem.get("constants", {}).items()),
        equations=[
            _equation(str(item["target"]), str(item["text"])) for item in plan.problem.get("equations", [])
        ],
        warnings=plan.problem.get("warnings", []),
        operations=sorted(plan.operations, key=lambda item: (item.start, labels.kind_rank(item.kind))),
        derived=[item for item in plan.operations if item.derivation],
        chosen="proven the cheapest of the alternatives found"
        if plan.selection.proven
        else "the cheapest alternatives found, not proven to be",
        fifos=[(fifo, *spans[fifo.id]) for fifo in plan.fifos],
        words=sum(fifo.depth for fifo in plan.fifos),
        formats=_formats(plan),
        operand=labels.operand,
        decimal=lambda item: labels.constant(str(item)),
        function=labels.function,
        command=command(plan),
        datapath=_inline(datapath.render(plan)),
        schedule=_inline(schedule_chart.render(plan)),
        dash=DASH,
    )


def command(plan: Plan) -> str:
    """Return the command line that makes this plan again."""
    words = ["cordicc", "compile", plan.options.get("file", f"{plan.name}.yaml")]
    for name in RECORDED_OPTIONS:
        value = plan.options.get(name)
        if value is not None:
            words += [f"--{name.replace('_', '-')}", str(value)]
    return shlex.join(words)


def _inline(svg: str) -> Markup:
    """Mark a finished picture as safe; its texts are escaped already."""
    return Markup(svg)


def _equation(target: str, text: str) -> str:
    """Write an equation so that the name it defines is seen."""
    text = " ".join(text.split())
    if text.startswith("solve"):
        return text
    if "=" not in text:
        return f"{target} = {text}"
    defines = text.partition("=")[0].strip() == target
    return text if defines else f"{text}    for {target}"


def _figures(plan: Plan) -> list[Figure]:
    kinds = Counter(unit.kind for unit in plan.units)
    caus = sum(kinds[kind] for kind in labels.CAU_KINDS)
    clock = labels.clock_hz(plan)

    def time(count: int) -> str:
        return labels.seconds(count, clock) if clock else ""

    split = ", ".join(f"{kinds[kind]} {kind}" for kind in labels.CAU_KINDS if kinds[kind])
    words = sum(fifo.depth for fifo in plan.fifos)
    interval = plan.initiation_interval
    return [
        Figure("Processors (CAUs)", str(caus), split, _proof(plan, "processors", caus)),
        Figure(
            "Latency, cycles",
            str(plan.latency_cycles),
            time(plan.latency_cycles),
            _proof(plan, "latency", plan.latency_cycles),
        ),
        Figure("of which CAU stages", str(plan.cau_cycles), time(plan.cau_cycles)),
        Figure(
            "Initiation interval, cycles", str(interval), f"a sample every {time(interval)}" if clock else ""
        ),
        Figure("FIFO words", str(words), f"{len(plan.fifos)} segments", _proof(plan, "fifo_words", words)),
    ]


def _proof(plan: Plan, goal: str, value: int) -> str:
    """Say whether a figure is proven optimal, or how far the bound lies below it."""
    if plan.optimal.get(goal):
        return "proven optimal"
    bound = plan.bounds.get(goal)
    if bound is None:
        return "no bound"
    gap = f", gap {(value - bound) / value:.1%}" if value else ""
    return f"not proven optimal; at least {bound}{gap}"


def _formats(plan: Plan) -> list[WordFormat]:
    """Return the formats that the plan states: inputs and results, then outputs."""
    outputs = {f"output {name}": spec for name, spec in plan.formats.outputs.items()}
    return [_word_format(name, spec) for name, spec in (plan.formats.values | outputs).items()]


def _word_format(name: str, spec: Mapping[str, int]) -> WordFormat:
    ulp = Fraction(2) ** -spec["fraction"]
    largest = ((1 << (spec["width"] - 1)) - 1) * ulp
    return WordFormat(name, spec["width"], spec["fraction"], f"{float(largest):.6g}", f"{float(ulp):.3g}")


def _units(plan: Plan) -> list[tuple[str, int, str]]:
    """Return kind, count and latencies of the units, CAUs first."""
    rows = []
    for kind in sorted({unit.kind for unit in plan.units}, key=labels.kind_rank):
        latencies = sorted({unit.latency for unit in plan.units if unit.kind == kind})
        count = sum(unit.kind == kind for unit in plan.units)
        name = LOOKS[kind].label if kind in LOOKS else kind
        rows.append((name, count, ", ".join(map(str, latencies))))
    return rows


def _accuracy(name: str, record: Any) -> Accuracy:
    known = record or {}
    bound, observed = known.get("bound") or {}, known.get("observed") or {}
    where = bound.get("where")
    share = bound.get("share_of_samples")
    note = [str(where)] if where else []
    note += [f"{float(share):.4g} of the samples"] if isinstance(share, (int, float)) else []
    return Accuracy(
        name,
        _error(bound.get("value")),
        ", ".join(note),
        _error(observed.get("max")),
        _error(observed.get("rms")),
    )


def _error(value: Any) -> str:
    return f"{float(value):.3e}" if isinstance(value, (int, float)) else DASH
