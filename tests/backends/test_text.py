"""Plans in words, and the differences of two."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import cordicc
from cordicc.backends.text.explanation import explanation
from cordicc.backends.text.plan_differences import differences
from cordicc.base.codes import CODES
from cordicc.base.text_tables import plain
from cordicc.cli.main import main
from cordicc.plan.file import dump
from cordicc.plan.model import Plan, Selection
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled
from tests.support.selection import quick


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def planar() -> Plan:
    return compiled(EXAMPLES / "planar_2r.yaml")


CASES = {
    "wheel_suspension": ("wheel_suspension", {}),
    "wheel_beta.imscor24": ("wheel_beta", {"target": "imscor24"}),
    "planar_2r.fixed24": ("planar_2r", {"target": "fixed24"}),
    "quadruped_leg.latency": ("quadruped_leg", {"minimize": "latency", "units": "standard"}),
    "puma560.ii4": ("puma560", {"ii": 4, "effort": 0.1}),
}


@pytest.mark.parametrize("case", quick(CASES, *list(CASES)[:3]))
def test_explanations(case: str, golden) -> None:
    example, options = CASES[case]
    plan = compiled(EXAMPLES / f"{example}.yaml", **options)
    golden(f"explain/{case}.txt", plain(explanation(plan)))


def test_what_is_not_proven_is_not_claimed(planar: Plan) -> None:
    text = plain(explanation(planar))
    assert "Why there is no cheaper plan" in text
    loose = replace(
        planar,
        optimal=dict.fromkeys(planar.optimal, False),
        bounds={name: bound - 1 for name, bound in planar.bounds.items()},
        selection=Selection(searched=True, proven=False),
        options=replace(planar.options, time_limit_struck=True),
    )
    text = plain(explanation(loose))
    assert "What is known of cheaper plans" in text
    assert text.count("so at most 1 fewer are possible") == 3
    assert "proven the least" not in text
    assert "not proven the cheapest of these" in text
    assert "--time-limit" in text
    unsearched = plain(explanation(replace(planar, selection=Selection())))
    assert "alternatives were not searched" in unsearched


def test_plans_without_units_and_constant_outputs(tmp_path: Path) -> None:
    text = "inputs: {x: [0, 1]}\nequations: [y = x, z = 2*x + 1, c = 3]\noutputs: [y, z, c]\n"
    (tmp_path / "p.yaml").write_text(text, encoding="utf-8")
    shown = run("explain", tmp_path / "p.yaml").stdout
    assert "There is none" in shown
    assert "  y  = x\n  z  = 1 + 2*x\n  c  = 3\n" in shown
    assert "no operation needs one" in shown


def test_explanations_have_one_notation(planar: Plan) -> None:
    """Formulas of units are written as the equations are."""
    text = plain(explanation(planar))
    assert "**2" in text
    assert "^" not in text


def test_a_problem_file_is_compiled_first(planar: Plan) -> None:
    assert run("explain", EXAMPLES / "planar_2r.yaml").stdout == plain(explanation(planar))


def test_codes() -> None:
    shown = run("explain", "E302").stdout
    assert shown.startswith("E302 (error, exit status 2): ")
    assert CODES["E302"] in shown
    assert "exit status 1" in run("explain", "E402").stdout
    assert "(warning)" in run("explain", "W102").stdout
    unknown = run("explain", "E999")
    assert unknown.exit_code == 2
    assert "no code E999" in unknown.stderr


@pytest.mark.parametrize("text", ["", "{}", "[1]"])
def test_files_that_are_no_plans(text: str, tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(text, encoding="utf-8")
    assert run("explain", tmp_path / "plan.json").exit_code == 2
    assert run("diff", tmp_path / "plan.json", tmp_path / "plan.json").exit_code == 2
    assert run("diff", tmp_path / "none.json", tmp_path / "plan.json").exit_code == 2


def written(path: Path, plan: Plan) -> Path:
    path.write_text(dump(plan), encoding="utf-8")
    return path


def test_diff(planar: Plan, tmp_path: Path) -> None:
    other = compiled(EXAMPLES / "planar_2r.yaml", target="krieger96", units="standard")
    first, second = written(tmp_path / "a.json", planar), written(tmp_path / "b.json", other)
    same = run("diff", first, first)
    assert (same.exit_code, same.stdout) == (0, "planar-2r on kinematic: the plans are the same\n")
    shown = run("diff", first, second)
    assert shown.exit_code == 1
    for part in ("options\n", "figures\n", "accuracy\n", "operations\n", "units of the target\n"):
        assert f"\n{part}" in shown.stdout
    assert re.search(r"^ +a +b$", shown.stdout, re.MULTILINE)
    assert re.search(r"^  CAUs +2 +5$", shown.stdout, re.MULTILINE)
    as_json = run("diff", first, second, "--json")
    data = json.loads(as_json.stdout)
    assert as_json.exit_code == 1
    assert data["same"] is False
    listed = {(d["section"], d["name"]): (d["first"], d["second"]) for d in data["differences"]}
    assert listed["figures", "CAUs"] == (2, 5)
    assert listed["options", "--units"] == ("auto", "standard")
    assert json.loads(run("diff", first, first, "--json").stdout) == {"differences": [], "same": True}


def test_diff_sees_the_problem(tmp_path: Path, planar: Plan) -> None:
    text = (EXAMPLES / "planar_2r.yaml").read_text(encoding="utf-8")
    (tmp_path / "planar_2r.yaml").write_text(text.replace("l1: 0.35", "l1: 0.36"), encoding="utf-8")
    found = differences(planar, cordicc.compile(tmp_path / "planar_2r.yaml"))
    assert ("problem", "constant l1", 0.35, 0.36) in [(d.section, d.name, d.first, d.second) for d in found]


def test_everything_that_differs_is_seen(planar: Plan) -> None:
    """What no section tells of, such as a description, comes under 'other'."""
    assert differences(planar, planar) == []
    found = differences(planar, replace(planar, problem=replace(planar.problem, description="another")))
    assert [(d.section, d.name) for d in found] == [("other", "description"), ("other", "problem")]
    fifo = replace(planar.fifos[0], id="f99")
    found = differences(planar, replace(planar, fifos=(fifo, *planar.fifos[1:])))
    assert [(d.section, d.name) for d in found] == [("other", "fifos")]
