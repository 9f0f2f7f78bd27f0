"""Long simulations: parts of any size, files, error statistics, the search for large errors."""

import io
import json
import math
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.cli import sample_run
from cordicc.emulate import accuracy, functional, sample_tables
from cordicc.emulate.histogram import Errors, worst_first
from cordicc.emulate.long_run import run_parts
from cordicc.emulate.observation import exact
from cordicc.ir import sampling
from cordicc.ir.meaning.doubles import screen
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.sampling import Workspace
from tests.support.command_line import run
from tests.support.corpus import PROBLEMS, VARIED
from tests.support.paths import CORPUS, EXAMPLES
from tests.support.plans import compiled
from tests.support.selection import quick, slow


@pytest.fixture(scope="module")
def plan() -> cordicc.Plan:
    return compiled(EXAMPLES / "planar_2r.yaml")


@pytest.fixture(scope="module")
def file(plan: cordicc.Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stream") / "plan.json"
    path.write_text(plan.to_json(), encoding="utf-8")
    return path


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("part", [1, 7, 100, 1000])
def test_samples_drawn_in_parts_are_the_same(own: bool, part: int) -> None:
    rows = {"a": [1.0, 2.0, 3.0], "b": [4.0, 5.0, 6.0]} if own else None
    workspace = Workspace({"a": (-1.0, 2.0), "b": (0.0, 0.3)}, rows)
    whole = sampling.draw(workspace, 100, 7)
    parts = list(sampling.draw_parts(workspace, 100, 7, part))
    for name, column in whole.items():
        assert np.array_equal(column, np.concatenate([each[name] for each in parts]))


def test_parts_and_reference_change_no_figure(plan: cordicc.Plan) -> None:
    graph, angles = plan.problem.program, plan.problem.angles
    machine = plan.arithmetic
    samples = sampling.draw(plan.problem.workspace, 1500, 3)
    samples["x"][5:9] = 9.0
    outputs = functional.run(plan, machine, samples)
    whole = accuracy.compare(exact(plan.problem, samples), angles, outputs)
    for part, reference in ((1500, 1500), (400, 10_000), (700, 300), (64, 0)):
        cut = [{n: c[i : i + part] for n, c in samples.items()} for i in range(0, 1500, part)]
        taken: list[np.ndarray] = []
        report = run_parts(
            graph,
            angles,
            cut,
            lambda each: functional.run(plan, machine, each),
            lambda made: taken.append(made["theta1"]),  # noqa: B023
            lambda samples: None,
            reference,
        )
        assert np.array_equal(np.concatenate(taken), outputs["theta1"], equal_nan=True)
        assert report.referenced == min(1500, reference)
        assert report.screened == 1500 - report.referenced
        seen = report.comparison
        assert (seen.samples, seen.valid) == (whole.samples, whole.valid)
        assert (seen.lost, seen.gained, seen.lost_at) == (whole.lost, whole.gained, whole.lost_at)
        for name, observed in whole.observed.items():
            assert seen.observed[name].max == observed.max
            assert seen.observed[name].at == observed.at
            assert seen.observed[name].rms == pytest.approx(observed.rms, rel=1e-6)
            assert sum(count for _, count in report.errors[name].rows()) == report.errors[name].count
            assert report.worst[name][0].inputs == {n: c[observed.at] for n, c in samples.items()}


@pytest.mark.parametrize("name", quick(PROBLEMS, *VARIED))
def test_screening_is_near_the_reference(name: str) -> None:
    problem, _ = cordicc.check(CORPUS / f"{name}.yaml")
    with (CORPUS / f"{name}.inputs.csv").open(encoding="utf-8") as text:
        data = np.genfromtxt(text, delimiter=",", names=True, max_rows=40)
    inputs = {spec.name: np.atleast_1d(data[spec.name]).astype(float) for spec in problem.inputs}
    values, defined = reference_outputs(problem.graph, inputs)
    screened, screenable = screen(problem.graph, inputs)
    assert np.array_equal(defined, screenable)
    for spec in problem.outputs:
        gap = np.abs(values[spec.name] - screened[spec.name])
        gap = np.minimum(gap, np.abs(gap - math.tau)) if spec.is_angle else gap
        assert np.nanmax(gap / (1 + np.abs(values[spec.name]))) < 1e-9


SCREENED = """
inputs: {a: [-2, 2], b: [0.5, 3], c: [-0.9, 0.9]}
equations:
  - t1 = asin(c) + acos(c) + atan(a) + atan2(a, b) + tan(c)
  - t2 = sinh(a) + cosh(a) + tanh(a) + asinh(a) + acosh(b + 1) + atanh(c) + exp(a) + log(b)
  - t3 = abs(a) + sign(a) + min(a, b) + max(a, c) + b**-1.5 + a**3 + hypot(a, b) - sqrt(b)/b
  - solve: b*cosh(t4) + a*sinh(t4) = 4
    for: t4
    branch: "-"
  - solve: b*cosh(t5) + (a + 6)*sinh(t5) = c
    for: t5
  - solve: [b*cos(t6) + a*sin(t6) = c, c*cos(t6) - b*sin(t6) = a]
    for: t6
"""


def test_screening_knows_every_function(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(SCREENED, encoding="utf-8")
    problem, _ = cordicc.check(tmp_path / "p.yaml")
    generator = np.random.Generator(np.random.PCG64(0))
    inputs = {s.name: generator.uniform(float(s.lo), float(s.hi), 300) for s in problem.inputs}
    inputs["a"][:3], inputs["b"][:2], inputs["c"][:2] = [0.0, -2.0, 2.0], 0.5, 0.0
    values, defined = reference_outputs(problem.graph, inputs)
    screened, screenable = screen(problem.graph, inputs)
    assert defined.any()
    assert not defined.all()
    assert np.array_equal(defined, screenable)
    for name, column in values.items():
        assert np.allclose(column[defined], screened[name][defined], rtol=1e-9, atol=1e-9)


def test_errors_whose_squares_overflow() -> None:
    errors = Errors()
    errors.add(np.array([3e200, 4e200]), np.arange(2))
    errors.add(np.array([1.0, 2.0]), np.arange(2))
    assert errors.rms == pytest.approx(2.5e200)
    assert errors.largest == 4e200


def test_errors_and_their_histogram() -> None:
    errors = Errors(keep=3)
    errors.add(np.array([0.0, 0.5, 0.75, 1.0]), np.arange(4))
    errors.add(np.array([4.0, 1.0]), np.arange(4, 6))
    errors.add(np.array([]), np.arange(0))
    assert errors.rows() == [(0.0, 1), (0.5, 2), (1.0, 2), (2.0, 0), (4.0, 1)]
    assert errors.worst == [(4.0, 4), (1.0, 3), (1.0, 5)]
    assert errors.rms == pytest.approx(math.sqrt((0.25 + 0.5625 + 1 + 16 + 1) / 6))
    assert (Errors().largest, Errors().rms, Errors().rows()) == (None, None, [])
    assert worst_first(np.array([1.0, 3, 3, 2]), np.array([9, 8, 7, 6]), 2).tolist() == [2, 1]


def test_search_finds_no_smaller_error(file: Path) -> None:
    command = ("simulate", file, "--random", 500, "--report")
    data = json.loads(run(*command, "--json").stdout)
    for record in data["accuracy"].values():
        assert record["search"]["error"] >= record["observed"]["max"]
        inputs = {name: [value] for name, value in record["search"]["inputs"].items()}
        assert 0.2 <= inputs["x"][0] <= 0.45
    text = run(*command).stdout
    assert "theta1: errors" in text
    assert ", search: x = " in text
    assert run(*command).stdout == text


@pytest.mark.exhaustive(reason="compiles the PUMA 560 for a line of text")
def test_inputs_that_depend_on_one_another_are_not_searched() -> None:
    text = run("simulate", EXAMPLES / "puma560.yaml", "--random", 50, "--report").stdout
    plan = compiled(EXAMPLES / "puma560.yaml")
    assert ("no search: the inputs depend on one another" in text) == (plan.problem.samples is not None)


def test_csv_and_npz_in_parts(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    generator = np.random.Generator(np.random.PCG64(1))
    x, y = generator.uniform(0.2, 0.45, 300), generator.uniform(-0.2, 0.4, 300)
    y[17] = 2.0
    rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), y.tolist(), strict=True))
    (tmp_path / "in.csv").write_text("x,y\n" + rows, encoding="utf-8")
    np.savez_compressed(tmp_path / "in.npz", y=y, x=x)
    outs = []
    for part in (65536, 64, 100):
        monkeypatch.setattr(sample_run, "PART_ROWS", part)
        monkeypatch.setattr(sample_tables.read_table, "__defaults__", (part,))
        for source in ("in.csv", "in.npz"):
            for out in ("out.csv", "out.npz"):
                command = ("simulate", file, "--inputs", tmp_path / source, "--outputs", tmp_path / out)
                assert run(*command).exit_code == 0
                outs.append((out, (tmp_path / out).read_bytes()))
    assert len(set(outs)) == 2
    with np.load(tmp_path / "out.npz") as made:
        assert made.files == ["theta1", "theta2", "valid"]
        assert made["valid"].dtype == bool
        assert not made["valid"][17]
        assert np.array_equal(np.isnan(made["theta1"]), ~made["valid"])
        text = np.genfromtxt(io.BytesIO(dict(outs)["out.csv"]), delimiter=",", names=True)
        assert np.array_equal(text["theta1"], made["theta1"], equal_nan=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.csv", "in.npz", "out.csv", "out.npz"]


@pytest.mark.parametrize(
    ("arrays", "shown"),
    [
        ({"x": [0.3]}, "E612]: input 'y' is missing"),
        ({"x": [0.3], "y": [0.1, 0.2]}, "E613]: arrays of different lengths (x: 1, y: 2)"),
        ({"x": [0.3, 0.3], "y": [0.1, np.nan]}, "E614]: row 2 of array 'y' is not a finite number"),
        ({"x": [[0.3]], "y": [[0.1]]}, "E614]: array 'x' is not a one-dimensional array"),
        ({"x": ["a"], "y": ["b"]}, "E614]: array 'x' is not a one-dimensional array"),
    ],
)
def test_bad_npz_is_shown(file: Path, tmp_path: Path, arrays: dict[str, object], shown: str) -> None:
    np.savez(tmp_path / "in.npz", **{name: np.array(column) for name, column in arrays.items()})
    result = run("simulate", file, "--inputs", tmp_path / "in.npz")
    assert result.exit_code == 2
    assert shown in result.stderr


def test_what_is_no_npz(file: Path, tmp_path: Path) -> None:
    (tmp_path / "in.npz").write_bytes(b"PK")
    assert run("simulate", file, "--inputs", tmp_path / "in.npz").exit_code == 2
    assert run("simulate", file, "--inputs", tmp_path / "none.npz").exit_code == 2


def test_a_failed_run_leaves_no_file(file: Path, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("x,y\n0.3,abc\n", encoding="utf-8")
    for out in ("out.csv", "out.npz"):
        result = run("simulate", file, "--inputs", tmp_path / "in.csv", "--outputs", tmp_path / out)
        assert result.exit_code == 2
    assert [path.name for path in tmp_path.iterdir()] == ["in.csv"]


def test_reference_options(file: Path) -> None:
    text = run("simulate", file, "--random", 300, "--reference", 100).stdout
    assert "100 samples against high precision, 200 against double precision, there at most" in text
    assert run("simulate", file, "--random", 5, "--no-reference").stdout.endswith("5 samples, 5 valid\n")
    data = json.loads(run("simulate", file, "--random", 5, "--no-reference", "--json").stdout)
    assert (data["samples"], data["valid"]) == (5, 5)
    for options in (
        ("--no-reference", "--report"),
        ("--tolerance", "1"),
        ("--no-reference", "--reference", 1),
    ):
        assert run("simulate", file, *options).exit_code == 2


@pytest.mark.parametrize("name", ["planar_2r", slow("puma560")])
def test_compare_with_golden_data(name: str, tmp_path: Path) -> None:
    files = (CORPUS / f"{name}.inputs.csv", CORPUS / f"{name}.expected.csv")
    plan = tmp_path / "plan.json"
    plan.write_text(compiled(CORPUS / f"{name}.yaml").to_json(), encoding="utf-8")
    result = run("simulate", plan, "--compare", *files)
    assert result.exit_code == 0, result.output
    assert "200 rows, as expected" in result.stdout
    result = run("simulate", plan, "--compare", *files, "--tolerance", 1e-9, "--json")
    assert result.exit_code == 1
    data = json.loads(result.stdout)
    assert not data["agrees"]
    assert len(data["wrong"]) == 10
    shares = [abs(line["simulated"] - line["expected"]) for line in data["wrong"]]
    assert shares == sorted(shares, reverse=True)


def golden(file: Path, folder: Path, inputs: str, expected: str, *options: object):
    (folder / "in.csv").write_text(inputs, encoding="utf-8")
    (folder / "out.csv").write_text(expected, encoding="utf-8")
    return run("simulate", file, "--compare", folder / "in.csv", folder / "out.csv", *options)


def test_compare_counts_turns_and_validity(file: Path, tmp_path: Path) -> None:
    inputs = "x,y\n0.3,0.1\n0.4,0.2\n9,0\n"
    (tmp_path / "in.csv").write_text(inputs, encoding="utf-8")
    run("simulate", file, "--inputs", tmp_path / "in.csv", "--outputs", tmp_path / "made.csv")
    rows = [line.split(",") for line in (tmp_path / "made.csv").read_text(encoding="utf-8").splitlines()]
    rows[1][0] = repr(float(rows[1][0]) + math.tau)
    text = "\n".join(",".join(row[:2]) for row in rows) + "\n"
    assert golden(file, tmp_path, inputs, text).exit_code == 0
    rows[2][1] = repr(float(rows[2][1]) + 0.001)
    rows[3][0] = rows[3][1] = "1"
    text = "\n".join(",".join(row[:2]) for row in rows) + "\n"
    result = golden(file, tmp_path, inputs, text)
    assert result.exit_code == 1
    assert "3 rows, not as expected" in result.stdout
    assert "1 row valid in one alone, first row 3" in result.stdout
    assert "  row 2, theta2: " in result.stdout
    assert golden(file, tmp_path, inputs, text, "--tolerance", "0.1").exit_code == 1


@pytest.mark.parametrize(
    ("expected", "shown"),
    [
        ("theta3,valid\n1,1\n", "E612]: output 'theta2' is missing from the header"),
        ("1,2\n", "E612]: there is no header"),
        ("theta1,theta2\n1,2\n1,2\n", "E615]: there are only 1 rows of inputs"),
        ("theta1,theta2\n", "E615]: there are only 0 rows of expected outputs"),
        ("theta1,theta2\n1,x\n", "E614]: 'x' is not a decimal number"),
    ],
)
def test_golden_data_that_does_not_fit(file: Path, tmp_path: Path, expected: str, shown: str) -> None:
    result = golden(file, tmp_path, "x,y\n0.3,0.1\n", expected)
    assert result.exit_code == 2
    assert shown in result.stderr


def test_a_name_that_could_be_a_number_is_a_header(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("inf\n1.5\n", encoding="utf-8")
    table = sample_tables.read_table(tmp_path / "a.csv", sample_tables.Columns(["inf"]))
    assert next(table.parts)["inf"].tolist() == [1.5]


def test_compare_some_of_the_outputs(file: Path, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("x,y\n0.3,0.1\n", encoding="utf-8")
    made = run("simulate", file, "--inputs", tmp_path / "in.csv", "--outputs", "-").stdout.splitlines()
    result = golden(file, tmp_path, "x,y\n0.3,0.1\n", "theta2\n" + made[1].split(",")[1] + "\n")
    assert result.exit_code == 0
    assert "not compared, since nothing is expected of them: theta1" in result.stdout


EDGE = """\
inputs: {x: [-0.8, 0.8], y: [-0.8, 0.8]}
constants: {l1: 0.4, l2: 0.3}
equations:
  - w = sqrt(x + 0.5)
  - r2 = x**2 + y**2
  - solve: x*cos(t) + y*sin(t) = (r2 + l1**2 - l2**2) / (2*l1)
    for: t
    branch: "-"
outputs: [t, w]
"""


@pytest.fixture(scope="module")
def edge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("edge")
    (folder / "edge.yaml").write_text(EDGE, encoding="utf-8")
    path = folder / "plan.json"
    plan = compiled(folder / "edge.yaml", target="fixed24", effort=0.1)
    path.write_text(plan.to_json(), encoding="utf-8")
    return path


def test_causes_of_samples_without_value(edge: Path) -> None:
    result = run("simulate", edge, "--random", 3000, "--json")
    data = json.loads(result.stdout)
    causes = {(each["equation"], each["reason"]): each for each in data["undefined"]}
    assert set(causes) == {("t", "no solution"), ("w", "the root of a negative number")}
    assert sum(each["samples"] for each in causes.values()) == 3000 - data["valid"]
    assert min(each["first"] for each in causes.values()) < 10
    assert "no solution in the equation of 't', first sample" in run("simulate", edge, "--random", 500).stdout


def test_own_bounds_hold_sample_by_sample(edge: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.npz"
    result = run("simulate", edge, "--random", 3000, "--own-bounds", "--outputs", out)
    assert result.exit_code == 0, result.output
    plan = cordicc.load_plan(edge)
    samples = sampling.draw(plan.problem.workspace, 3000, 0)
    values, defined = exact(plan.problem, samples)
    with np.load(out) as made:
        both = made["valid"] & defined
        assert both.sum() > 1500
        for name in ("t", "w"):
            own = made[f"bound_{name}"]
            assert np.isnan(own[~made["valid"]]).all()
            error = np.abs(made[name] - values[name])
            assert (np.minimum(error, np.abs(error - math.tau))[both] <= own[both]).all()
            least = plan.accuracy[name].bound.own_bounds
            assert np.median(own[both]) == pytest.approx(least["0.5"], rel=0.1)
            assert least["0.5"] <= least["0.9"] <= least["0.99"] <= plan.accuracy[name].bound.value
    assert run("simulate", edge, "--own-bounds").exit_code == 2


def test_compare_allows_what_is_proven_of_the_row(edge: Path, tmp_path: Path) -> None:
    inputs = "x,y\n0.3,0.1\n"
    (tmp_path / "in.csv").write_text(inputs, encoding="utf-8")
    made = run("simulate", edge, "--inputs", tmp_path / "in.csv", "--own-bounds", "--outputs", "-").stdout
    header, row = (line.split(",") for line in made.splitlines()[:2])
    angle, own = (float(row[header.index(name)]) for name in ("t", "bound_t"))
    bound = cordicc.load_plan(edge).accuracy["t"].bound.value
    assert own < bound
    for share, status in ((0.9, 0), (1.1, 1)):
        result = golden(edge, tmp_path, inputs, f"t\n{angle + share * own!r}\n", "--json")
        assert result.exit_code == status
        data = json.loads(result.stdout)
        assert data["outputs"]["t"]["allowed"] == bound
        assert data["not_compared"] == ["w"]
    assert golden(edge, tmp_path, inputs, "t,tol_t\n5,nan\n").exit_code == 1
    assert golden(edge, tmp_path, inputs, "t\n5\n", "--tolerance", "inf").exit_code == 2
    orphan = golden(edge, tmp_path, inputs, "t,tol_w\n5,1\n")
    assert (orphan.exit_code, "'w' is missing from the header, but 'tol_w'" in orphan.stderr) == (2, True)
    misspelt = golden(edge, tmp_path, inputs, "t,ww\n5,1\n")
    assert (misspelt.exit_code, "output 'w' is missing" in misspelt.stderr) == (2, True)


def test_own_bounds_need_names_and_operations(edge: Path, tmp_path: Path) -> None:
    data = json.loads(edge.read_text(encoding="utf-8"))
    del data["problem"]["unit_program"]
    for figures in data["accuracy"].values():
        figures["bound"] = None
    (tmp_path / "plan.json").write_text(json.dumps(data), encoding="utf-8")
    result = run("simulate", tmp_path / "plan.json", "--own-bounds", "--outputs", tmp_path / "o.csv")
    assert (result.exit_code, "E603" in result.stderr) == (2, True)
    (tmp_path / "twice.yaml").write_text(
        "inputs: {x: [0, 1]}\nequations:\n  - t = 2*x\n  - bound_t = 3*x\noutputs: [t, bound_t]\n",
        encoding="utf-8",
    )
    result = run("simulate", tmp_path / "twice.yaml", "--own-bounds", "--outputs", tmp_path / "o.csv")
    assert (result.exit_code, "'bound_t' has the name of a column" in result.stderr) == (2, True)


def test_compare_excludes_other_sources(file: Path) -> None:
    assert run("simulate", file, "--compare", "a", "b", "--random", 5).exit_code == 2
