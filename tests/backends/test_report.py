"""The report: self-contained, complete, readable mathematics, safe whatever the texts."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from cordicc.backends.pictures import error_chart, schedule_chart
from cordicc.backends.pictures.pareto_plot import Mark
from cordicc.backends.report import page, report_tables
from cordicc.backends.report.typesetting import LONGEST, typeset
from cordicc.backends.report.unit_accuracy import own_errors
from cordicc.backends.text import mathml, recognition
from cordicc.backends.text.formulas import Formulas
from cordicc.ir.text import parse_graph
from cordicc.plan.model import Plan, Selection, Unit
from cordicc.plan.origin import PlanEquation, PlanOptions, PlanTarget
from cordicc.plan.stated_accuracy import OutputAccuracy, SeenErrors, StatedBound
from cordicc.targets.target_file import load_target
from tests.support import hand_plans as plans
from tests.support.hard_plans import ALL, HOSTILE
from tests.support.selection import quick


@pytest.fixture(params=quick(ALL, *(name for name in ALL if name != "puma")), ids=str)
def plan(request: pytest.FixtureRequest) -> Plan:
    return ALL[request.param]


def page_of(plan: Plan, explored: page.Explored | None = None) -> str:
    return page.render(plan, explored)


class _Page(HTMLParser):
    """Collects tags, ids, links and the texts of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.scripts: dict[str, str] = {}
        self.policy = ""
        self._script: str | None = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.tags.append(tag)
        self.ids += [found["id"]] if "id" in found else []
        self.links += [value for name, value in attrs if name in ("src", "href", "action", "data", "srcset")]
        assert not [name for name in found if name.startswith("on")]
        if found.get("http-equiv") == "Content-Security-Policy":
            self.policy = found["content"]
        self._script = found.get("type", "code") if tag == "script" else None

    def handle_endtag(self, tag):
        self._script = None

    def handle_data(self, data):
        if self._script is not None:
            self.scripts[self._script] = self.scripts.get(self._script, "") + data


class TestPage:
    def test_self_contained(self, plan):
        text = page_of(plan)
        page = _Page(text)
        assert not {"link", "img", "iframe", "object", "base", "form"} & set(page.tags)
        assert all(link.startswith("#") for link in page.links)
        assert {link[1:] for link in page.links} <= set(page.ids)
        assert "@import" not in text
        assert "url(" not in re.sub(r"url\(#[\w-]+\)", "", text)

    def test_ids_are_unique(self, plan):
        ids = _Page(page_of(plan)).ids
        assert len(ids) == len(set(ids))

    def test_deterministic(self, plan):
        assert page_of(plan) == page_of(plan)

    def test_only_its_own_script_may_run(self, plan):
        page = _Page(page_of(plan))
        assert page.tags.count("script") == 2
        digest = base64.b64encode(hashlib.sha256(page.scripts["code"].encode()).digest()).decode()
        assert f"script-src 'sha256-{digest}'" in page.policy
        assert "default-src 'none'" in page.policy

    def test_script_knows_every_connection(self, plan):
        page = _Page(page_of(plan))
        data = json.loads(page.scripts["application/json"])
        cards = {name.removeprefix("about-") for name in page.ids if name.startswith("about-")}
        assert {box for pair in data["links"] for box in pair} <= cards
        assert set(data["order"]) == cards
        assert len(data["order"]) == len(cards)

    def test_hostile_texts_stay_texts(self):
        text = page_of(ALL["hostile"])
        assert "<script>alert" not in text
        assert HOSTILE.split("\x00")[0] not in text
        ET.fromstring("<html>" + "".join(re.findall(r"<svg.*?</svg>", text, re.DOTALL)) + "</html>")

    def test_formulas_are_well_formed(self, plan):
        for formula in re.findall(r"<math.*?</math>", page_of(plan), re.DOTALL):
            assert ET.fromstring(formula).tag == "math"

    def test_says_what_is_known(self):
        plan = plans.planar()
        plan = replace(
            plan,
            accuracy={
                "theta1": OutputAccuracy(SeenErrors(1e-6, 1e-7), StatedBound(2e-6, "|C| < 0.9 R", 0.5)),
                "theta2": OutputAccuracy(SeenErrors(None, None)),
            },
        )
        text = page_of(plan)
        for part in (
            "proven optimal",
            "not proven optimal; at least 27, gap 15.6%",
            "2.000e-06",
            "|C| &lt; 0.9 R, 50 % of the samples",
            'alttext="x**2 + y**2"',
            "x = 0.1 &amp; y &lt; 0",
            "cordicc compile planar-2r.yaml --target kinematic --units auto --ii 1",
            "not asked for; &#39;cordicc compile --certify&#39; derives one",
        ):
            assert part in text
        assert text.count('<td class="n">—</td>') == 5

    def test_a_bound_that_was_not_found_has_its_reason(self):
        accuracy = {"theta1": OutputAccuracy(SeenErrors(None, None), bound_reason="a pole")}
        rows = report_tables.accuracy(replace(plans.planar(), accuracy=accuracy))
        assert rows[0].where == "a pole"

    def test_tables_are_complete(self):
        plan = plans.puma()
        text = page_of(plan)
        for item in (*plan.operations, *plan.fifos):
            assert f'<th scope="row">{item.id}</th>' in text

    def test_units_of_an_unknown_kind(self):
        plan = plans.planar()
        plan = replace(plan, units=(*plan.units, Unit("d1", "divider", 9)))
        assert '<th scope="row">divider</th>' in page_of(plan)
        assert "idle" in schedule_chart.render(plan)

    def test_facts_that_were_used_are_named(self):
        plan = plans.planar()
        plan = replace(
            plan,
            problem=replace(plan.problem, assumptions=("x > 0", "y < 1")),
            selection=Selection(True, True, ("x > 0",)),
        )
        assert report_tables.assumptions(plan) == [("x > 0", True), ("y < 1", False)]
        assert page_of(plan).count("the plan rests on it") == 1

    def test_target_data(self):
        plan = replace(plans.planar(), target=PlanTarget.of(load_target("kinematic")))
        text = page_of(plan)
        for part in ("10 MHz, a cycle of 100 ns", "ieee-single", "30 iterations", "2 align"):
            assert part in text

    def test_trade_off(self):
        marks = [Mark(1, 100, 1, 20, "1 implicit", "proven"), Mark(2, 50, 1, 10, "2 implicit", "CAUs >= 1")]
        text = page_of(plans.planar(), page.Explored("Trade-off of planar-2r", marks))
        assert "CAUs &gt;= 1" in text
        assert "Latency in cycles over CAUs" in text
        assert 'href="#trade-off"' in text
        assert "trade-off" not in page_of(plans.planar())

    @pytest.mark.parametrize(
        ("options", "shown"),
        [
            (PlanOptions("a b.yaml", ii=4), "'a b.yaml' --units auto --ii 4 --minimize processors"),
            (PlanOptions("a", "t"), "a --target t --units auto --ii 1 --minimize processors"),
            (PlanOptions("a", certify=True), "a --units auto --ii 1 --minimize processors --certify"),
            (PlanOptions("a", certify=False), "a --units auto --ii 1 --minimize processors --no-certify"),
            (PlanOptions("a", effort=2.5), "a --units auto --ii 1 --minimize processors --effort 2.5"),
            (PlanOptions(), "planar-2r.yaml --units auto --ii 1 --minimize processors"),
        ],
    )
    def test_command(self, options, shown):
        assert page.command(replace(plans.planar(), options=options)) == f"cordicc compile {shown}"


class TestNotebookFragment:
    def test_without_scripts_and_styles_of_its_own(self, plan):
        seen = _Page(page.fragment(plan))
        assert not {"script", "style", "link"} & set(seen.tags)
        assert seen.tags.count("svg") == 1

    def test_hostile_texts_stay_texts(self):
        assert "<script>" not in page.fragment(ALL["hostile"])


def plain(formula: str) -> str:
    """Return the characters of some MathML."""
    text = "".join(ET.fromstring(f"<m>{formula}</m>".replace("&nbsp;", " ")).itertext())
    return text.replace("\u2062", "").replace("\u2061", "")


class TestMathml:
    @pytest.mark.parametrize(
        ("text", "shown"),
        [
            ("theta1", "θ1"),
            ("V2y", "V2y"),
            ("px", "px"),
            ("reach", "reach"),
            ("lambda", "λ"),
            ("T_r13", "Tr13"),
            ("q_left_2", "qleft,2"),
            ("_", "_"),
        ],
    )
    def test_names(self, text, shown):
        made = mathml.name(text)
        assert plain(made.markup) == shown
        assert made.text == text

    @pytest.mark.parametrize(
        ("value", "shown"),
        [
            ("0.25", "0.25"),
            ("1/3", "13"),
            ("-2", "−2"),
            ("1e-30", "1×10−30"),
            ("12e20", "1.2×1021"),
            ("pi?", "pi?"),
        ],
    )
    def test_numbers(self, value, shown):
        assert plain(mathml.number(value).markup) == shown

    @pytest.mark.parametrize(
        ("text", "shown"),
        [
            ("A = 2*(V2y - V1y)*S", "A=2(V2y−V1y)S"),
            ("x - (y - z)", "x−(y−z)"),
            ("x - -y", "x+y"),
            ("(x + y)*z**2", "(x+y)z2"),
            ("-x**2", "−x2"),
            ("(-x)**2", "(−x)2"),
            ("cos(x)**2*y", "cos2x⋅y"),
            ("cos(a)*cos(b)", "cosacosb"),
            ("cos(x + 1)", "cos(x+1)"),
            ("2*cos(x)", "2cosx"),
            ("abs(x - 1)", "|x−1|"),
            ("acos(u/v)", "arccos(uv)"),
            ("reach*lift", "reach⋅lift"),
            ("x*0.5", "x⋅0.5"),
            ("x/2/y", "x2y"),
            ("2**-3", "2−3"),
            ("x**0.5", "x"),
            ("30*deg", "30⋅°"),
            ("[x, 0] + 2*[y, 1]", "[x,0]+2[y,1]"),
            ("x**2 + y**2 = 1", "x2+y2=1"),
            ("x >= 0", "x≥0"),
            ("-S**4 + 1.2*S**2 + ...", "−S4+1.2S2+⋯"),
        ],
    )
    def test_texts_as_formulas(self, text, shown):
        made = typeset(text)
        assert made is not None
        assert plain(made) == shown

    def test_solves(self):
        made = typeset("solve B*cos(beta) + A*sin(beta) = C for beta, branch -")
        assert made is not None
        assert plain(made) == "Bcosβ+Asinβ=C solved for β, branch −"
        made = typeset("solve [a*x = 1, rotate([b, 0], y) = [x, y]] for [x, y], branch x > 0")
        assert made is not None
        assert plain(made) == "ax=1 and rotate([b,0],y)=[x,y] solved for x and y, branch x>0"

    @pytest.mark.parametrize("text", ["", "x +", "its rest", "x = = y", "x" * (LONGEST + 1), "(" * 500])
    def test_what_is_no_formula_stays_a_text(self, text):
        assert typeset(text) is None

    def test_what_cannot_be_typeset_is_shown_as_it_is(self):
        plan = plans.planar()
        problem = replace(plan.problem, equations=(PlanEquation("theta1", "theta1 = <b>("),))
        assert "<code>theta1 = &lt;b&gt;(</code>" in page_of(replace(plan, problem=problem))


class TestFormulas:
    def texts(self, builder: plans.Builder, value: str) -> list[str]:
        plan = builder.plan({"y": value})
        return [made.text for made in Formulas(plan).of(plan.operations[-1])]

    @pytest.mark.parametrize(
        ("op", "operands", "params", "shown"),
        [
            ("add", ("x", -0.5), {}, ["y = x - 0.5"]),
            ("mul", ("x", "x"), {}, ["y = x**2"]),
            ("cmul", ("x",), {"factor": "-0.25"}, ["y = -0.25*x"]),
            ("shift", ("x",), {"exponent": -1}, ["y = 0.5*x"]),
            ("shift", ("x",), {"exponent": 9}, ["y = 2**9*x"]),
            ("neg", ("x",), {}, ["y = -x"]),
            ("vector", ("x", "z", 0.0), {"m": 1, "sign": 1}, ["y = sqrt(x**2 + z**2)"]),
            ("vector", ("x", "z", "x"), {"m": 0, "sign": -1}, ["y = x"]),
            ("rotate", ("x", 0.0, "z"), {"m": 1}, ["y = x*cos(z)"]),
            ("rotate", ("x", "z", "x"), {"m": -1}, ["y = x*cosh(x) + z*sinh(x)"]),
            ("implicit", ("x", 0.5, 1.0), {"m": 1, "branch": "+"}, ["0.5*cos(y) + x*sin(y) = 1"]),
            ("implicit", (0.0, "x", "z"), {"m": -1, "branch": "+"}, ["x*cosh(y) = z"]),
            ("guard", ("x", "z"), {"condition": "positive"}, ["y = x, valid if z > 0"]),
            ("flip", ("x", "z"), {}, ["y = x if z ≥ 0, else -x"]),
        ],
    )
    def test_operations(self, op, operands, params, shown):
        builder = plans.Builder("one", {"x": (0, 1), "z": (0, 1)})
        assert self.texts(builder, builder.add(op, *operands, **params)[0]) == shown

    def test_short_parts_are_written_out_and_long_ones_named(self):
        builder = plans.Builder("long", {"x": (0, 1)})
        value = "x"
        for _ in range(20):
            (value,) = builder.add("add", value, 1.0)
        (text,) = self.texts(builder, value)
        assert text.count("+") <= 6
        assert "o1" in text

    def test_every_operation_has_a_formula(self, plan):
        formulas = Formulas(plan)
        for operation in plan.operations:
            used = [name for name in operation.results if name]
            assert len(formulas.of(operation)) >= (1 if used else 0)


class TestRecognition:
    def test_each_operation_is_with_its_equation(self):
        plan = plans.planar()
        groups = recognition.recognised(plan, Formulas(plan))
        assert [(group.target, len(group.units)) for group in groups] == [
            ("r2", 0),
            ("theta2", 1),
            ("theta1", 1),
        ]
        assert groups[0].rest == "By 2 multipliers, 1 adder."

    def test_why(self):
        plan = plans.wheel()
        program = parse_graph("%0 = input[name=S]\n%1 = acos(%0) @beta\noutput beta = %1\n")
        operation = next(o for o in plans.planar().operations if o.op == "implicit")
        moved = replace(operation, equation="beta", derivation=("`x = 1`, hence so",))
        plan = replace(plan, operations=(moved,), problem=replace(plan.problem, program=program))
        (unit,) = recognition.recognised(plan, Formulas(plan))[-1].units
        assert "`acos(C/B)` is the angle with" in unit.why[0]
        assert unit.why[-1] == "`x = 1`, hence so"

    def test_equations_without_operations_say_so(self):
        plan = plans.wheel()
        texts = {group.target: group.rest for group in recognition.recognised(plan, Formulas(plan))}
        plan = replace(plan, problem=replace(plan.problem, equations=(PlanEquation("gone", "gone = S"),)))
        assert texts["A"] == "By 1 constant multiplier."
        assert recognition.recognised(plan, Formulas(plan))[0].rest.startswith("No operation of its own")

    def test_steps_are_sentences_with_formulas(self):
        plan = plans.planar()
        operations = [replace(o, derivation=("for `x**2 < 1` so",)) for o in plan.operations]
        text = page_of(replace(plan, operations=tuple(operations)))
        assert re.search(r'<p class="step">For <math alttext="x\*\*2 &lt; 1">.*</math> so\.</p>', text)

    def test_own_errors(self):
        plan = replace(plans.planar(), target=PlanTarget.of(load_target("kinematic")))
        errors = own_errors(plan)
        assert set(errors) == {o.id for o in plan.operations}
        kinds = {o.op: errors[o.id] for o in plan.operations}
        assert kinds["add"] == "rounded once, within 0.5 ulp of its result"
        assert kinds["neg"] == kinds["guard"] == "exact"
        assert re.match(r"its angle leaves a residual of at most 0\.\d+ ulp", kinds["implicit"])


class TestErrorChart:
    def plan(self, histogram, bound=None):
        bound = None if bound is None else StatedBound(bound, "every valid sample", 1.0)
        figures = OutputAccuracy(SeenErrors(3e-7, 1e-7, histogram), bound)
        return replace(plans.planar(), accuracy={"theta1": figures})

    def test_bars_have_the_shares(self):
        (picture,) = error_chart.render(self.plan(((0.0, 5), (2.0**-23, 15), (2.0**-22, 80))))
        titles = re.findall(r"<title>(.*?)</title>", picture)
        assert titles == [
            "below 1.19e-07: 5 samples, 5.0%",
            "1.19e-07 to 2.38e-07: 15 samples, 15.0%",
            "2.38e-07 to 4.77e-07: 80 samples, 80.0%",
        ]

    def test_bound_and_largest_are_marked(self):
        (picture,) = error_chart.render(self.plan(((2.0**-23, 10),), 9e-7))
        assert 'aria-label="Errors of theta1: max 3.00e-07, rms 1.00e-07, bound 9.00e-07"' in picture
        assert picture.count("stroke-dasharray") == 2

    def test_without_errors_or_without_a_record(self):
        assert error_chart.render(plans.planar()) == []
        none = {"theta1": OutputAccuracy(SeenErrors(0.0, 0.0, ((0.0, 10),)))}
        (picture,) = error_chart.render(replace(plans.planar(), accuracy=none))
        assert "below" in "".join(ET.fromstring(picture).itertext())

    def test_tiny_errors_share_a_bar(self):
        histogram = tuple((2.0**-k, 1) for k in range(60, 20, -1))
        (picture,) = error_chart.render(self.plan(histogram))
        assert len(re.findall("<title>", picture)) <= 28
