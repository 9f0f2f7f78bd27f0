"""The report: one self-contained HTML page with figures, formulas, pictures and tables."""

from __future__ import annotations

import base64
import hashlib
import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from cordicc.backends import labels
from cordicc.backends.escaping import clean
from cordicc.backends.palette import dark_rules
from cordicc.backends.pictures import datapath, error_chart, pareto_plot, schedule_chart, wiring
from cordicc.backends.report import report_tables
from cordicc.backends.report.cards import Cards, math
from cordicc.backends.report.typesetting import typeset
from cordicc.backends.text import mathml, recognition
from cordicc.plan.model import Plan

RECORDED_OPTIONS = (
    "target", "width", "clock", "units", "ii", "max_processors", "max_latency", "minimize", "copies",
    "certify", "effort",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Explored:
    """The trade-off of a problem: the title of its plot, and the points that no other beats."""

    title: str
    marks: Sequence[pareto_plot.Mark]


def render(plan: Plan, explored: Explored | None = None) -> str:
    """Return the page, with the trade-off of the plan's problem if that is known."""
    cards = Cards(plan)
    script = Markup(_template_text("report.js"))
    return (
        _environment()
        .get_template("report.html.j2")
        .render(
            plan=plan,
            headline=labels.headline(plan),
            figures=report_tables.figures(plan),
            units=report_tables.units(plan),
            accuracy=report_tables.accuracy(plan),
            checks=report_tables.checks(plan),
            most_share=labels.MOST,
            errors=[Markup(picture) for picture in error_chart.render(plan)],
            inputs=[(item.name, labels.shown_range(item)) for item in plan.problem.inputs],
            constants=sorted(plan.problem.constants.items()),
            assumptions=report_tables.assumptions(plan),
            warnings=plan.problem.warnings,
            recognised=recognition.recognised(plan, cards.formulas),
            operations=sorted(plan.operations, key=lambda item: (item.start, labels.kind_rank(item.kind))),
            formulas=lambda operation: [math(each) for each in cards.formulas.of(operation)],
            own_errors=cards.errors,
            chosen=report_tables.chosen(plan),
            fifos=[(fifo, *cards.netlist.spans[fifo.id]) for fifo in plan.fifos],
            words=sum(fifo.depth for fifo in plan.fifos),
            formats=report_tables.formats(plan),
            target_facts=report_tables.target_facts(plan),
            target_units=report_tables.target_units(plan),
            cards=cards.all(),
            command=command(plan),
            datapath=[Markup(picture) for picture in datapath.pieces(plan)],
            schedule=Markup(schedule_chart.piece(plan)),
            explored=explored,
            front="" if explored is None else Markup(pareto_plot.render(explored.title, explored.marks)),
            links=_data({"links": _links(plan), "order": [clean(box) for box in cards.order()]}),
            style=Markup(_template_text("report.css")),
            dark=Markup(dark_rules("figure.picture svg")),
            script=script,
            script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
            dash=report_tables.DASH,
        )
    )


def fragment(plan: Plan) -> str:
    """Return the plan for a notebook: its figures, accuracy and datapath, as HTML without scripts."""
    return (
        _environment()
        .get_template("notebook.html.j2")
        .render(
            plan=plan,
            headline=labels.headline(plan),
            figures=report_tables.figures(plan),
            accuracy=report_tables.accuracy(plan),
            datapath=Markup(datapath.render(plan)),
        )
    )


def command(plan: Plan) -> str:
    """Return the command line that makes this plan again."""
    recorded = plan.options.recorded
    words = ["cordicc", "compile", plan.options.file or f"{plan.name}.yaml"]
    for name in RECORDED_OPTIONS:
        value = recorded.get(name)
        option = f"--{name.replace('_', '-')}"
        if isinstance(value, bool):
            words.append(option if value else option.replace("--", "--no-"))
        elif value not in (None, ""):
            words += [option, str(value)]
    return shlex.join(words)


def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("cordicc.backends.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=lambda item: item if isinstance(item, Markup) else clean(str(item)),
    )

    def formula(text: str) -> Markup:
        """Return a formula typeset, or as it is written."""
        made = typeset(clean(text))
        return Markup("<code>{}</code>").format(clean(text)) if made is None else Markup(made)

    def prose(text: str) -> Markup:
        """Return a sentence in which formulas stand between backticks, with a capital and a full stop."""
        text = text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")
        parts = text.split("`")
        return Markup("").join(
            formula(part) if index % 2 and index + 1 < len(parts) else escape(clean(part))
            for index, part in enumerate(parts)
        )

    environment.filters |= {
        "formula": formula,
        "prose": prose,
        "math": math,
        "sign": lambda text: math(mathml.name(clean(str(text)))),
        "decimal": lambda item: labels.constant(str(item)),
        "function": labels.function,
        "operand": lambda item: labels.operand(item).removesuffix(".value"),
        "kind": labels.plain_kind,
    }
    return environment


def _template_text(name: str) -> str:
    return files("cordicc.backends.report").joinpath("templates", name).read_text(encoding="utf-8")


def _links(plan: Plan) -> list[list[str]]:
    """Return which box feeds which, in pairs."""
    pairs = {(net.source.box, sink.box): None for net in wiring.nets(plan) for sink in net.sinks}
    return [[clean(one), clean(other)] for one, other in pairs]


def _data(data: Any) -> Markup:
    """Return data for the page's script; no text in it can end the element."""
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace("&", "\\u0026"))
