"""Samples judged by the bounds that a plan states: in parts, in double precision, by a search, from files."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cordicc
from cordicc.certify.plans import StatedBounds
from cordicc.emulate import functional, judging
from cordicc.emulate.histogram import Worst
from cordicc.emulate.judging import ConditionalBounds, Judged, Judgement
from cordicc.emulate.long_run import run_parts
from cordicc.ir import sampling
from tests.support.command_line import run
from tests.support.plans import compiled

TEXT = """\
name: singular
inputs: {x: [-1, 1], y: [-1, 1]}
equations:
  - a = atan2(y, x)
  - s = x + y
outputs: [a, s]
"""


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> cordicc.Plan:
    path = tmp_path_factory.mktemp("judging") / "p.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return compiled(path, target="fixed24", effort=0.1)


@pytest.fixture(scope="module")
def file(plan: cordicc.Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("judging") / "plan.json"
    path.write_text(plan.to_json(), encoding="utf-8")
    return path


def judged(
    plan: cordicc.Plan, samples: dict[str, np.ndarray], part: int, reference: int, limits: ConditionalBounds
) -> dict[str, Judged]:
    count = len(samples["x"])
    parts = [{n: c[i : i + part] for n, c in samples.items()} for i in range(0, count, part)]
    report = run_parts(
        plan.problem.program,
        plan.problem.angles,
        parts,
        lambda each: functional.run(plan, plan.arithmetic, each),
        lambda made: None,
        lambda count: None,
        reference,
        limits,
    )
    assert report.judgement is not None
    return report.judgement.found


def with_bound(plan: cordicc.Plan, output: str, value: float, folder: Path) -> Path:
    """Write a plan that states another bound."""
    data = json.loads(plan.to_json())
    data["accuracy"][output]["bound"]["value"] = value
    path = folder / "changed.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_where_is_judged_for_every_sample(plan: cordicc.Plan) -> None:
    stated = StatedBounds.of(plan)
    assert stated is not None
    assert plan.accuracy["a"].bound.conditions
    assert not plan.accuracy["s"].bound.conditions
    size = np.array([1e-5, 1e-4, 0.01, 0.7])
    held = stated.inside({"x": size, "y": -size})
    assert held["a"].tolist() == [False, False, True, True]
    assert held["s"].all()
    many = {n: column * 0.01 for n, column in sampling.draw(plan.problem.workspace, 20_000, 3).items()}
    whole = stated.inside(many)["a"]
    assert 0.99 <= whole.mean() < 1
    again = [stated.inside({n: c[i : i + 777] for n, c in many.items()})["a"] for i in range(0, 20_000, 777)]
    assert np.array_equal(whole, np.concatenate(again))


@pytest.mark.parametrize("factor", [1, 1e-5])
def test_parts_and_reference_change_no_judgement(plan: cordicc.Plan, factor: float) -> None:
    stated = StatedBounds.of(plan)
    assert stated is not None
    limits = ConditionalBounds({name: factor * value for name, value in stated.values.items()}, stated.inside)
    samples = sampling.draw(plan.problem.workspace, 3000, 5)
    samples["x"][7] = 2.0
    whole = judged(plan, samples, 3000, 3000, limits)
    assert whole["a"].samples == 2999
    assert whole["s"].inside == 2999
    assert all((each.beyond > 0) == (factor < 1) for each in whole.values())
    for part, reference in ((500, 3000), (700, 1000), (3000, 0)):
        assert judged(plan, samples, part, reference, limits) == whole
    for each in whole.values():
        assert each.worst is None or each.worst.error > each.bound


def test_beyond_is_established_for_so_many_only(plan: cordicc.Plan, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(judging, "MOST_BEYOND", 10)
    samples = sampling.draw(plan.problem.workspace, 500, 5)
    stated = StatedBounds.of(plan)
    assert stated is not None
    limits = ConditionalBounds({"s": 1e-12}, stated.inside)
    for reference in (500, 0, 4):
        assert judged(plan, samples, 100, reference, limits)["s"].beyond == 10


def test_no_double_makes_a_sample_beyond(plan: cordicc.Plan) -> None:
    """What double precision calls an error, and high precision does not, is none."""
    graph, angles = plan.problem.program, plan.problem.angles
    judgement = Judgement(
        graph, angles, ConditionalBounds({"s": 0.1}, lambda inputs: {"s": np.ones(3, bool)})
    )
    inputs = {"x": np.array([0.1, 0.2, 0.3]), "y": np.array([0.5, 0.5, 0.5])}
    outputs = {"s": np.array([0.6, 0.7, 1.0])}
    errors = {"s": np.array([0.5, np.nan, 0.01])}
    judgement.add(judging.Part(np.arange(3), inputs, outputs, errors, precise=False))
    assert judgement.found["s"].beyond == 0
    judgement.add(judging.Part(np.arange(3), inputs, outputs, {"s": np.array([0.0, 0.0, 0.2])}, precise=True))
    assert judgement.found["s"] == Judged(0.1, 6, 6, 1, Worst(0.2, 3, {"x": 0.3, "y": 0.5}))
    assert math.isclose(judgement.found["s"].share or 0, 1)
    assert Judged(1.0).share is None


def test_a_sample_that_a_search_found_is_judged(plan: cordicc.Plan) -> None:
    stated = StatedBounds.of(plan)
    assert stated is not None
    judgement = Judgement(plan.problem.program, {}, ConditionalBounds(stated.values, stated.inside))
    judgement.add_found("a", Worst(1.0, None, {"x": 1e-6, "y": 0.0}))  # outside
    judgement.add_found("s", Worst(0.0, None, {"x": 1e-6, "y": 0.0}))  # within
    assert not any(each.beyond for each in judgement.found.values())
    judgement.add_found("a", Worst(1.0, None, {"x": 0.5, "y": 0.0}))
    assert judgement.found["a"].beyond == 1


def test_simulate_says_how_bounds_fare(file: Path, tmp_path: Path) -> None:
    rows = ["1e-5,1e-5", "3,0", *("0.5,0.25" for _ in range(298))]
    (tmp_path / "in.csv").write_text("x,y\n" + "\n".join(rows) + "\n", encoding="utf-8")
    for more in ((), ("--reference", 0), ("--cycle-accurate",)):
        command = ("simulate", file, "--inputs", tmp_path / "in.csv", *more)
        result = run(*command)
        assert result.exit_code == 0
        header, first, second = result.stdout.splitlines()[2:5]
        assert header.endswith("bound         holds for                 beyond")
        assert first.endswith("  99.66 % of valid samples  none")
        assert second.endswith("  every valid sample        none")
        found = json.loads(run(*command, "--json").stdout)["accuracy"]["a"]["judged"]
        assert found == {"samples": 299, "inside": 298, "beyond": 0, "worst_beyond": None}


@pytest.mark.parametrize("more", [(), ("--reference", 10), ("--report",), ("--json",)])
def test_a_sample_beyond_its_bound_is_an_error(
    plan: cordicc.Plan, tmp_path: Path, more: tuple[object, ...]
) -> None:
    result = run("simulate", with_bound(plan, "s", 1e-9, tmp_path), "--random", 300, *more)
    assert result.exit_code == 1
    assert "error[E620]: the error of 's' exceeds its proven bound 1e-09, in " in result.stderr
    assert "please report it" in result.stderr
    assert "'a'" not in result.stderr
    if "--json" in more:
        found = json.loads(result.stdout)["accuracy"]["s"]["judged"]
        assert found["beyond"] > 200
        assert found["worst_beyond"]["error"] > 1e-9


def test_without_a_reference_nothing_is_judged(plan: cordicc.Plan, tmp_path: Path) -> None:
    path = with_bound(plan, "s", 1e-9, tmp_path)
    assert run("simulate", path, "--random", 300, "--no-reference").exit_code == 0


def test_a_plan_without_bounds_judges_nothing(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(TEXT, encoding="utf-8")
    result = run("simulate", tmp_path / "p.yaml", "--random", 50)
    assert "beyond" not in result.stdout
    assert "not derived" in result.stdout
    data = json.loads(run("simulate", tmp_path / "p.yaml", "--random", 50, "--json").stdout)
    assert data["accuracy"]["a"]["judged"] is None


@pytest.mark.parametrize(
    ("place", "value"),
    [("operation", "o99"), ("operation", None), ("kind", "own bound"), ("threshold", 1e300)],
)
def test_conditions_of_a_changed_plan(plan: cordicc.Plan, tmp_path: Path, place: str, value: Any) -> None:
    data = json.loads(plan.to_json())
    data["accuracy"]["a"]["bound"]["conditions"][0][place] = value
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    result = run("simulate", path, "--random", 50)
    assert result.exit_code == (2 if place == "operation" else 0)
    assert ("E603" in result.stderr) == (place == "operation")
