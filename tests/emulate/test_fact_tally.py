"""What a problem assumes of its inputs, tested on samples: of what breaks it nothing is claimed."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.emulate.fact_tally import FactTally
from cordicc.pipeline import Options, plan_file
from tests.support.command_line import run

CIRCLE = """\
name: circle
inputs: {c: [-1, 1], s: [-1, 1], x: [1, 2]}
assume: [c**2 + s**2 = 1]
equations:
  - d = hypot(c*x, s*x)
  - e = x/4
outputs: [d, e]
"""
ORDERED = """\
name: ordered
inputs: {x: [-1, 1], y: [0, 1]}
assume: [x > 0, y <= 1/2]
equations: [t = abs(x)*y]
outputs: [t]
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "p.yaml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def circle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan on fixed point, with bounds, whose inputs come from samples on the circle."""
    folder = tmp_path_factory.mktemp("circle")
    angles = np.linspace(-3, 3, 40).tolist()
    rows = "".join(f"{math.cos(a)!r},{math.sin(a)!r},{1.5 + a / 10!r}\n" for a in angles)
    (folder / "s.csv").write_text("c,s,x\n" + rows)
    path = write(folder, CIRCLE.replace("assume", "samples: s.csv\nassume"))
    assert run("compile", path, "--target", "fixed24", "-o", folder / "out", "-q").exit_code == 0
    return folder / "out"


@pytest.fixture
def rows(tmp_path: Path) -> Path:
    """Three rows, of which the second one is not on the circle."""
    path = tmp_path / "in.csv"
    path.write_text("c,s,x\n0.6,0.8,1.1\n0.5,0.5,1.5\n-0.8,0.6,1.3\n")
    return path


def test_a_row_that_breaks_a_fact_is_named_and_no_bound_is_claimed(circle: Path, rows: Path) -> None:
    result = run("simulate", circle, "--inputs", rows, "--json")
    assert result.exit_code == 0
    assert "warning[W617]: 1 of 3 rows breaks what the problem assumes" in result.stderr
    assert "the first is row 2, where 'c**2 + s**2 = 1' has the sides 0.5 and 1.0" in result.stderr
    assert "E620" not in result.stderr
    data = json.loads(result.stdout)
    assert data["facts"]["broken"] == 1
    assert data["facts"]["first"]["sample"] == 2
    judged = data["accuracy"]["d"]["judged"]
    assert (judged["samples"], judged["beyond"]) == (2, 0)
    wrong = max(record["unfounded"] for record in data["accuracy"].values())
    assert wrong > 0.1 > 1e-4 > max(record["observed"]["max"] for record in data["accuracy"].values())


def test_its_values_are_delivered(circle: Path, rows: Path, tmp_path: Path) -> None:
    result = run("simulate", circle, "--inputs", rows, "--outputs", tmp_path / "out.csv", "--own-bounds")
    assert result.exit_code == 0
    assert "1 sample not as the problem assumes, not in the figures above" in result.stdout
    names, *lines = (tmp_path / "out.csv").read_text().split()
    made = [dict(zip(names.split(","), line.split(","), strict=True)) for line in lines]
    assert [each["valid"] for each in made] == ["1", "1", "1"]
    assert float(made[1]["d"]) == pytest.approx(1.5, abs=1e-6)
    assert [each["bound_e"] == "nan" for each in made] == [False, True, False]


def test_one_that_keeps_them_is_still_judged(circle: Path, rows: Path, tmp_path: Path) -> None:
    data = json.loads((circle / "plan.json").read_text())
    for record in data["accuracy"].values():
        record["bound"]["value"] = 1e-12
    (tmp_path / "plan.json").write_text(json.dumps(data))
    result = run("simulate", tmp_path, "--inputs", rows)
    assert result.exit_code == 1
    assert "in 2 of 2 samples inside" in result.stderr


def test_without_a_reference_and_beside_expected_values(circle: Path, rows: Path, tmp_path: Path) -> None:
    data = json.loads(run("simulate", circle, "--inputs", rows, "--no-reference", "--json").stdout)
    assert data["facts"]["broken"] == 1
    (tmp_path / "expected.csv").write_text("e\n0.275\n0.375\n0.325\n")
    result = run("simulate", circle, "--compare", rows, tmp_path / "expected.csv", "--json")
    assert "warning[W617]: 1 of 3 rows" in result.stderr
    assert json.loads(result.stdout)["facts"]["first"]["fact"] == "c**2 + s**2 = 1"


def test_a_strict_fact_is_kept_by_the_words_too(tmp_path: Path) -> None:
    plan = plan_file(write(tmp_path, ORDERED), Options("fixed24")).plan
    tally = FactTally.of(plan)
    assert tally is not None
    x = np.array([0.5, 1e-9, -0.25, 0.5, 0.5])
    y = np.array([0.5, 0.25, 0.25, 0.5 + 1e-9, 0.75])
    # 1e-9 is above 0, but its word is not; what is beyond 1/2 is so however it is rounded.
    assert tally.kept({"x": x, "y": y}).tolist() == [True, False, False, False, False]
    assert tally.kept({"x": x[:1], "y": y[:1]}).tolist() == [True]
    assert (tally.samples, tally.broken) == (6, 4)
    assert tally.first is not None
    assert (tally.first.sample, tally.first.text, tally.first.as_words) == (1, "x > 0", True)
    assert (
        "row 2, where 'x > 0' has the sides 0.0 and 0.0 as words of the target"
        in tally.told("row")[0].message
    )


def test_an_input_without_words_counts_by_its_number(tmp_path: Path) -> None:
    text = ORDERED.replace("y: [0, 1]}", "y: [0, 1], unused: [0, 900]}").replace("x > 0", "unused > 10")
    tally = FactTally.of(plan_file(write(tmp_path, text), Options("fixed24")).plan)
    assert tally is not None
    half = np.array([0.5, 0.5])
    assert tally.kept({"x": half, "y": half, "unused": np.array([800.0, 5.0])}).tolist() == [True, False]


def test_drawn_samples_are_tested_and_figures_are_those_of_the_others(tmp_path: Path) -> None:
    plan = cordicc.compile(write(tmp_path, ORDERED.replace("abs(x)", "sqrt(x**2)")), effort=0.1)
    seen = plan.accuracy["t"].observed
    assert seen.max is not None
    assert seen.max < 1e-6
    assert 0.2 < sum(count for _, count in seen.histogram) / 10_000 < 0.3
    (tmp_path / "plan.json").write_text(plan.to_json())
    result = run("simulate", tmp_path, "--report", "--random", 200)
    assert result.exit_code == 0
    assert "of 200 samples break what the problem assumes; the first is sample" in result.stderr


def test_where_no_drawn_sample_keeps_them_nothing_is_observed(tmp_path: Path) -> None:
    result = run("compile", write(tmp_path, CIRCLE), "-o", tmp_path / "out", "--effort", 0.1)
    assert result.exit_code == 0
    assert (
        "no errors are observed: none of 10000 samples from the ranges keeps what is assumed" in result.stderr
    )
    assert run("simulate", tmp_path / "out", "--report", "--random", 9).exit_code == 0


def test_copies_have_facts_of_their_own(tmp_path: Path) -> None:
    plan = cordicc.compile(write(tmp_path, ORDERED), copies=2, effort=0.1)
    assert [fact.text for fact in plan.problem.facts.items][2:] == ["x > 0 of copy 2", "y <= 1/2 of copy 2"]
    (tmp_path / "plan.json").write_text(plan.to_json())
    read = cordicc.load_plan(tmp_path)
    assert read.to_json() == plan.to_json()
    good, bad = np.array([0.5, 0.5]), np.array([0.5, -0.5])
    kept = read.problem.facts.kept({"x_1": good, "y_1": good, "x_2": bad, "y_2": good})
    assert kept.tolist() == [True, False]


@pytest.mark.parametrize(
    ("key", "value"),
    [("facts", []), ("fact_program", "%0 = input[name=q]\noutput left0 = %0\noutput right0 = %0\n")],
)
def test_a_plan_whose_facts_are_not_those_it_assumes(
    key: str, value: object, circle: Path, tmp_path: Path
) -> None:
    data = json.loads((circle / "plan.json").read_text())
    data["problem"][key] = value
    (tmp_path / "plan.json").write_text(json.dumps(data))
    result = run("simulate", tmp_path)
    assert result.exit_code == 2
    assert "E603" in result.stderr


def test_rows_of_few_digits_have_no_bound(circle: Path, tmp_path: Path) -> None:
    rows = "".join(f"{math.cos(a):.7f},{math.sin(a):.7f},1.5\n" for a in (0.3, 1.1, 2.0))
    (tmp_path / "rows.csv").write_text("c,s,x\n" + rows)
    end = run("simulate", circle / "plan.json", "--inputs", tmp_path / "rows.csv")
    assert end.exit_code == 0
    assert "W618" in end.output
    assert "3 of 3 rows" in end.output
    assert "W617" not in end.output
