"""Plans in notebooks, and the example notebook, whose cells are run as they stand."""

from __future__ import annotations

import ast
import json
from typing import Any

import pytest

from cordicc import Plan
from cordicc.api import Picture
from tests.support import hand_plans as plans
from tests.support.paths import EXAMPLES


@pytest.fixture(scope="module")
def plan() -> Plan:
    return Plan.of(plans.planar())


def run_cell(source: str, names: dict[str, Any]) -> Any:
    """Execute a cell and return the value of its last line, as a notebook shows it."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last is not None else None


def test_a_plan_says_what_it_is_in_one_line(plan: Plan) -> None:
    text = repr(plan)
    assert text.startswith("<Plan planar-2r: kinematic · 2 CAUs")
    assert "\n" not in text


def test_a_plan_shows_its_datapath_and_figures(plan: Plan) -> None:
    page = plan._repr_html_()
    assert page.count("<svg") == 1
    for text in ("Datapath of planar-2r", "Latency, cycles", "theta2"):
        assert text in page


@pytest.mark.parametrize("view", ["datapath", "schedule", "graph"])
def test_pictures(plan: Plan, view: str) -> None:
    picture = plan.picture(view)
    assert isinstance(picture, Picture)
    assert picture._repr_svg_().startswith("<svg")


def test_the_report_as_text(plan: Plan) -> None:
    assert plan.report().startswith("<!DOCTYPE html>")


def test_example_notebook(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    notebook = json.loads((EXAMPLES / "planar_2r.ipynb").read_text(encoding="utf-8"))
    assert not any(cell.get("outputs") for cell in notebook["cells"])
    monkeypatch.chdir(EXAMPLES)
    names: dict[str, Any] = {}
    shown = [
        run_cell("".join(cell["source"]), names) for cell in notebook["cells"] if cell["cell_type"] == "code"
    ]
    assert isinstance(shown[0], Plan)
    assert isinstance(shown[1], Picture)
    assert 0.8 < shown[2] <= 1
    printed = capsys.readouterr().out
    assert float(printed.split()[2]) < 1e-6
    assert printed.count("CAUs,") == 3
