"""The command line: outputs, exit status, diagnostics."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

import cordicc
from tests.support.command_line import run
from tests.support.paths import EXAMPLES
from tests.support.selection import quick

FILES = ["datapath.svg", "plan.json", "report.html", "schedule.svg", "simulate.py"]


@pytest.fixture(scope="module")
def planar(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("planar")
    assert run("compile", EXAMPLES / "planar_2r.yaml", "-o", folder).exit_code == 0
    return folder


PROBLEMS = sorted(p.stem for p in EXAMPLES.glob("*.yaml"))


@pytest.mark.parametrize("example", quick(PROBLEMS, "wheel_beta"))
def test_examples_compile_twice_to_the_same_bytes(example: str, tmp_path: Path) -> None:
    for folder in ("one", "two"):
        result = run("compile", EXAMPLES / f"{example}.yaml", "-o", tmp_path / folder)
        assert result.exit_code == 0
        assert result.stderr == ""
    assert sorted(p.name for p in (tmp_path / "one").iterdir()) == FILES
    for name in FILES:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_the_same_bytes_in_another_process(planar: Path, tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "cordicc",
        "compile",
        str(EXAMPLES / "planar_2r.yaml"),
        "-o",
        str(tmp_path),
    ]
    environment = {"PYTHONHASHSEED": "12345"}
    subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (planar / name).read_bytes()


def test_default_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("compile", EXAMPLES / "wheel_beta.yaml", "-q").exit_code == 0
    assert (tmp_path / "build" / "wheel-beta" / "plan.json").exists()


def test_the_paper_on_its_processor() -> None:
    plan = cordicc.compile(EXAMPLES / "wheel_beta.yaml", target="imscor24", units="standard")
    caus = [o for o in plan.operations if o.kind == "standard"]
    assert [o.mode for o in caus] == ["circular vectoring", "hyperbolic vectoring", "circular vectoring"]
    assert plan.cau_cycles == 132
    first, second, third = caus
    assert second.operands[0].value == first.results[0]
    assert third.operands[1].value == second.results[0]
    assert third.operands[2].value == first.results[1]
    assert third.operands[0].value == second.operands[1].value
    delayed = {fifo.value for fifo in plan.fifos}
    assert {third.operands[0].value, first.results[1]} <= delayed


@pytest.mark.parametrize(("target", "cycles"), [("krieger96", 66), ("kinematic", 48)])
def test_one_implicit_unit(target: str, cycles: int) -> None:
    plan = cordicc.compile(EXAMPLES / "wheel_beta.yaml", target=target)
    assert plan.processors() == {"standard": 0, "implicit": 1, "total": 1}
    assert plan.cau_cycles == cycles


def test_json_is_one_object(tmp_path: Path) -> None:
    result = run("compile", EXAMPLES / "planar_2r.yaml", "-o", tmp_path, "--json")
    data = json.loads(result.stdout)
    assert data["format"] == "cordicc-plan"
    assert not {"units", "operations", "fifos"} & set(data)
    whole = json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))
    assert data == {k: v for k, v in whole.items() if k not in ("units", "operations", "fifos")}


def test_limits(tmp_path: Path) -> None:
    few = run("compile", EXAMPLES / "planar_2r.yaml", "-o", tmp_path / "a", "--max-processors", 1)
    assert few.exit_code == 1
    assert "E402" in few.stderr
    assert "--max-processors 2" in few.stderr
    quick = run("compile", EXAMPLES / "planar_2r.yaml", "-o", tmp_path / "b", "--max-latency", 50)
    assert quick.exit_code == 1
    assert "E403" in quick.stderr
    assert not (tmp_path / "a").exists()
    assert not (tmp_path / "b").exists()


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--units", "implicit", "--target", "imscor24"], "E404"),
        (["--target", "no-such-target"], "E501"),
    ],
)
def test_bad_options(arguments: list[str], code: str, tmp_path: Path) -> None:
    result = run("compile", EXAMPLES / "planar_2r.yaml", "-o", tmp_path / "out", *arguments)
    assert result.exit_code == 2
    assert code in result.stderr
    assert not (tmp_path / "out").exists()


def test_simulate_csv(planar: Path, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("y,extra,x\n0.1,1,0.3\n9,1,0.3\n", encoding="utf-8")
    outputs = [tmp_path / "functional.csv", tmp_path / "clocked.csv"]
    for out, flags in zip(outputs, ([], ["--cycle-accurate"]), strict=True):
        result = run(
            "simulate", planar / "plan.json", "--inputs", tmp_path / "in.csv", "--outputs", out, *flags
        )
        assert result.exit_code == 0
        assert "extra" in result.stderr
    assert outputs[0].read_bytes() == outputs[1].read_bytes()
    header, first, second = outputs[0].read_text(encoding="utf-8").splitlines()
    assert header == "theta1,theta2,valid"
    assert first.endswith(",1")
    assert second == "nan,nan,0"


def test_simulate_a_problem_file() -> None:
    result = run("simulate", EXAMPLES / "wheel_beta.yaml", "--random", 50, "--json")
    assert result.exit_code == 0
    data = json.loads(result.stdout)
    assert data["valid"] == data["samples"] == 50
    assert data["accuracy"]["beta"]["observed"]["max"] < 1e-6


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("x\n0.3\n", "E612"),
        ("x,y\n0.3\n", "E613"),
        ("x,y\n0.3,inf\n", "E614"),
        ("x,y\n0.3,1_0\n", "E614"),
        ("x,y,x\n1,2,3\n", "E612"),
        ("", "E612"),
        ("\n\n", "E612"),
    ],
)
def test_bad_csv(planar: Path, tmp_path: Path, text: str, code: str) -> None:
    (tmp_path / "in.csv").write_text(text, encoding="utf-8")
    result = run("simulate", planar / "plan.json", "--inputs", tmp_path / "in.csv")
    assert result.exit_code == 2
    assert code in result.stderr


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("", "in.csv: error[E612]: the file is empty"),
        ("x;y\n1;2\n", "  hint: fields are separated by commas"),
        ("x,y\n0.3,1e400\n", "in.csv:2:5: error[E614]: '1e400' is not a finite number (column 'y')"),
        ("x,y\n nan,0.1\n", "in.csv:2:2: error[E614]: 'nan' is not a finite number (column 'x')"),
        ("x,y\n0.3,abc\n", "    0.3,abc\n        ^^^\n"),
        ('x,y\n0.3,"a,b"\n', "in.csv:2:1: error[E614]: 'a,b' is not a decimal number"),
        ("x,y\n0.3\n", "1 field in a row under a header of 2"),
    ],
)
def test_bad_csv_is_shown(planar: Path, tmp_path: Path, text: str, shown: str) -> None:
    (tmp_path / "in.csv").write_text(text, encoding="utf-8")
    assert shown in run("simulate", planar / "plan.json", "--inputs", tmp_path / "in.csv").stderr


def test_csv_to_stdout_and_without_rows(planar: Path, tmp_path: Path) -> None:
    (tmp_path / "in.csv").write_text("x,y\n0.3,0.1\n", encoding="utf-8")
    result = run("simulate", planar / "plan.json", "--inputs", tmp_path / "in.csv", "--outputs", "-")
    assert result.stdout.splitlines()[0] == "theta1,theta2,valid"
    assert "1 sample, 1 valid" in result.stderr
    (tmp_path / "in.csv").write_text("x,y\n", encoding="utf-8")
    result = run("simulate", planar / "plan.json", "--inputs", tmp_path / "in.csv")
    assert result.exit_code == 0
    assert "  theta1  -              -          not derived" in result.stdout


def test_output_paths(planar: Path, tmp_path: Path) -> None:
    plan = planar / "plan.json"
    for path, message in (
        (tmp_path / "no" / "a.svg", "no such folder"),
        (tmp_path, "is a folder, not a file"),
    ):
        result = run("draw", plan, "-o", path)
        assert result.exit_code == 2
        assert f"error[E600]: {message}" in result.stderr
    assert not (tmp_path / "no").exists()
    assert run("draw", plan, "-o", "-").stdout == run("draw", plan).stdout
    (tmp_path / "link.svg").symlink_to(tmp_path / "real.svg")
    assert run("draw", plan, "-o", tmp_path / "link.svg").exit_code == 0
    assert (tmp_path / "link.svg").is_symlink()
    assert run("draw", plan, "-o", "/dev/null").exit_code == 0
    assert not Path("/dev/null").is_file()


def test_drawing_a_problem_file() -> None:
    result = run("draw", EXAMPLES / "planar_2r.yaml")
    assert result.exit_code == 2
    assert "hint: this looks like a problem file: compile it first" in result.stderr


def test_one_of_each(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("inputs: {x: [0, 1]}\nequations: [y = x]\n", encoding="utf-8")
    assert "p: 1 input, 1 equation, 1 output, no errors" in run("check", tmp_path / "p.yaml").stdout
    shown = run("compile", tmp_path / "p.yaml", "-o", tmp_path / "out").stdout
    assert "    longest path  none\n" in shown


def _broken(data: dict, change) -> str:
    change(data)
    return json.dumps(data)


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.update(version=99),
        lambda d: d.pop("fifos"),
        lambda d: d["fifos"][0].update(depth=1),
        lambda d: d["operations"][0].update(start=7),
        lambda d: d["operations"][-1].update(op="no-such-op"),
        lambda d: d["target_data"]["arithmetic"].update(units={}),
        lambda d: d["problem"].update(program="nonsense"),
        lambda d: d["operations"][0].update(params={"m": "x"}),
        lambda d: d["outputs"]["theta1"].update(value="nobody"),
        lambda d: d["problem"].update(unit_program=d["problem"]["program"]),
        lambda d: d["problem"].update(unit_program=d["problem"]["unit_program"].replace("m=1", "m=-1", 1)),
        lambda d: d["accuracy"]["theta1"]["observed"].update(rms=None, histogram=[]),
        lambda d: d["accuracy"]["theta1"].update(observed=None),
        lambda d: d["target_data"]["units"]["add"].update(latency=1e300),
        lambda d: d["options"].update(copies=1e300),
    ],
)
def test_broken_plans_are_refused(planar: Path, tmp_path: Path, change) -> None:
    data = json.loads((planar / "plan.json").read_text(encoding="utf-8"))
    (tmp_path / "plan.json").write_text(_broken(data, change), encoding="utf-8")
    result = run("simulate", tmp_path / "plan.json", "--random", 5)
    assert result.exit_code == 2, result.output
    assert "error[E60" in result.stderr


@pytest.mark.parametrize("text", ["", "[]", "{", "[" * 100_000, '{"format": "cordicc-plan"}', "\x00"])
def test_files_that_are_no_plans(tmp_path: Path, text: str) -> None:
    (tmp_path / "plan.json").write_text(text, encoding="utf-8")
    result = run("simulate", tmp_path / "plan.json")
    assert result.exit_code == 2
    assert "error[E60" in result.stderr


@pytest.mark.parametrize("view", ["datapath", "schedule", "graph"])
def test_draw(planar: Path, tmp_path: Path, view: str) -> None:
    out = tmp_path / "picture.svg"
    assert run("draw", planar / "plan.json", "--view", view, "-o", out).exit_code == 0
    shown = run("draw", planar / "plan.json", "--view", view)
    assert shown.stdout == out.read_text(encoding="utf-8")
    if view != "graph":
        assert shown.stdout == (planar / f"{view}.svg").read_text(encoding="utf-8")


def test_generated_script(planar: Path, tmp_path: Path) -> None:
    command = [sys.executable, str(planar / "simulate.py"), "--random", "20"]
    result = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=True)
    assert "20 samples, 20 valid" in result.stdout


def test_check_lists_all_mistakes(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(
        "inputs: {x: [1, 0]}\nequations:\n  - y = cosine(x)\n  - z = q\n", encoding="utf-8"
    )
    result = run("check", tmp_path / "p.yaml")
    assert result.exit_code == 2
    assert result.stderr.count("error[") == 3
    assert run("check", EXAMPLES / "puma560.yaml").exit_code == 0


def test_targets(tmp_path: Path) -> None:
    listed = run("targets").stdout
    names = [line.split()[0] for line in listed.splitlines()]
    assert names == [
        "artix7", "ecp5", "fixed24", "generic", "ice40up",
        "imscor24", "kinematic", "krieger96", "serial16", "serial24",
    ]  # fmt: skip
    text = run("targets", "kinematic").stdout
    (tmp_path / "mine.yaml").write_text(
        text.replace("latency: 48", "latency: 50").replace("pre_rotate: 1", "pre_rotate: 3"), encoding="utf-8"
    )
    plan = cordicc.compile(EXAMPLES / "wheel_beta.yaml", target=str(tmp_path / "mine.yaml"))
    assert plan.cau_cycles == 50


@pytest.mark.parametrize(
    ("equation", "code"),
    [("y = acos(x + 10)", "E320"), ("y = sqrt(-1 - x**2)", "E320")],
)
def test_provably_outside_the_domain(tmp_path: Path, equation: str, code: str) -> None:
    (tmp_path / "p.yaml").write_text(f"inputs: {{x: [0, 1]}}\nequations: [{equation}]\n", encoding="utf-8")
    result = run("compile", tmp_path / "p.yaml", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert code in result.stderr


def test_partly_outside_the_domain_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("inputs: {x: [0, 2]}\nequations: [y = acos(x)]\n", encoding="utf-8")
    result = run("compile", tmp_path / "p.yaml", "-o", tmp_path / "out")
    assert result.exit_code == 0
    assert "warning[W320]" in result.stderr
    assert "for example x = " in result.stderr


@pytest.mark.parametrize(
    ("equation", "warned"),
    [
        ("y = 1/(b - a/4)", True),
        ("y = tan(a)", True),
        ("y = b**-1", True),
        ("y = 1/a", False),
        ("y = tan(a/3)", False),
        ("y = 1/(sign(b) + 1/2)", False),  # jumps over 0
    ],
)
def test_a_pole_inside_the_ranges_is_a_warning(tmp_path: Path, equation: str, warned: bool) -> None:
    text = f"inputs: {{b: [-2, 2], a: [0.1, 3]}}\nequations: ['{equation}', 'z = a*b']\noutputs: [y, z]\n"
    (tmp_path / "p.yaml").write_text(text, encoding="utf-8")
    result = run("check", tmp_path / "p.yaml")
    assert result.exit_code == 0
    assert ("W321" in result.stderr) is warned


def test_a_hyperbolic_equation_with_two_solutions_needs_a_branch(tmp_path: Path) -> None:
    text = "inputs: {x: [2, 3]}\nequations:\n  - {solve: x*cosh(t) + sinh(t) = 4, for: t}\n"
    (tmp_path / "p.yaml").write_text(text, encoding="utf-8")
    result = run("check", tmp_path / "p.yaml")
    assert result.exit_code == 2
    assert "E322" in result.stderr


def test_output_folder_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    result = run("compile", EXAMPLES / "wheel_beta.yaml", "-o", tmp_path / "file")
    assert result.exit_code == 2
    assert "error[E600]: is a file, not a folder" in result.stderr


def test_start_up_imports_nothing_heavy() -> None:
    code = "import sys, cordicc.cli.main; print(*sorted(m for m in sys.modules if '.' not in m))"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "sympy", "networkx", "ortools", "mpmath", "ruamel", "jinja2", "flint"} & set(
        result.stdout.split()
    )
