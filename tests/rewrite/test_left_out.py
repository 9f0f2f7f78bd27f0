"""What the search leaves out is said, and so is how to get more."""

from __future__ import annotations

from pathlib import Path

import pytest

import cordicc
from cordicc.backends.text.summary import plan_sheet
from cordicc.base.text_tables import plain
from cordicc.rewrite.exact import field
from cordicc.rewrite.search import realisations
from tests.support.rewriting import problem_of, searched, units

LINKS = "q2 = acos((x**2 + y**2 - 0.18)/0.18)\nq1 = atan2(y, x) - atan2(0.3*sin(q2), 0.3 + 0.3*cos(q2))"
BOX = "x=0.1:0.4, y=-0.4:0.4"


def test_nothing_is_left_out_of_a_small_problem(tmp_path: Path) -> None:
    choice = searched(problem_of(tmp_path, BOX, LINKS, "q1, q2"))
    assert choice.proven
    assert choice.left_out == ()


def test_a_problem_too_large_for_the_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(realisations, "MOST_NODES", 10)
    choice = searched(problem_of(tmp_path, BOX, LINKS, "q1, q2"))
    assert not choice.searched
    assert [words for words in choice.left_out if "operations, too many for --effort 1" in words]


def test_algebra_that_outgrows_its_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(field, "MOST_TERMS", 6)
    choice = searched(problem_of(tmp_path, BOX, LINKS, "q1, q2"))
    assert [words for words in choice.left_out if "of algebra, too large for --effort 1" in words]


def test_fixed_point_has_no_common_denominators(tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    lines = "".join(f"  - {line}\n" for line in LINKS.splitlines())
    path.write_text(f"inputs: {{x: [0.1, 0.4], y: [-0.4, 0.4]}}\nequations:\n{lines}")
    plan = cordicc.compile(path, target="fixed24", certify=False)
    assert any("common denominators" in words for words in plan.selection.left_out)
    assert "common denominators" in plain(plan_sheet(plan))
    assert cordicc.load_plan(_written(tmp_path, plan)).selection == plan.selection


def _written(folder: Path, plan: cordicc.Plan) -> Path:
    path = folder / "plan.json"
    path.write_text(plan.to_json(), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("equations", "caus"),
    [
        ("u = cos(a + b - a)\nv = sin((a + b) - a)", ["rotate"]),
        ("u = cos(a - (a - b))\nv = sin(b)", ["rotate"]),
        ("u = atan2(a, b)\nv = atan2(-a, -b)", ["vector"]),
        ("u = atan2(a, b)\nv = atan2(-a, b)\nw = atan2(b, a)", ["vector"]),
    ],
)
def test_no_unit_does_what_another_does_already(tmp_path: Path, equations: str, caus: list[str]) -> None:
    names = ", ".join(line.split(" ")[0] for line in equations.splitlines())
    graph = searched(problem_of(tmp_path, "a=-1:1, b=-1:1", equations, names)).graph
    assert units(graph) == caus
