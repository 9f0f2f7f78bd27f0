"""What the README shows is what the commands print."""

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from cordicc.cli.main import main
from tests.support.paths import ROOT

README = ROOT / "README.md"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(command: str) -> str:
    program, *arguments = shlex.split(command)
    assert program == "cordicc"
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    return result.stdout


def test_console_blocks(folder: Path, request: pytest.FixtureRequest) -> None:
    """Each `$ cordicc` command of the README prints what is printed under it."""

    def actual(block: re.Match[str]) -> str:
        commands = re.findall(r"^\$ (.*)$", block[1], flags=re.MULTILINE)
        return "```console\n" + "\n".join(f"$ {c}\n{run(c)}".rstrip() for c in commands) + "\n```"

    text = README.read_text(encoding="utf-8")
    fresh = re.sub(r"```console\n(.*?)```", actual, text, flags=re.DOTALL)
    if request.config.getoption("--update-golden"):
        README.write_text(fresh, encoding="utf-8")
    assert fresh == README.read_text(encoding="utf-8")


def test_problem_in_the_readme(folder: Path) -> None:
    text = README.read_text(encoding="utf-8")
    problem = next(
        b for b in re.findall(r"```yaml\n(.*?)```", text, flags=re.DOTALL) if "name: planar-2r" in b
    )
    (folder / "arm.yaml").write_text(problem, encoding="utf-8")
    assert "no errors" in run("cordicc check arm.yaml")


def test_python_in_the_readme(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = README.read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    exec(compile(code, "README.md", "exec"), {})
    assert "'total': 2" in capsys.readouterr().out


def test_shell_commands_of_the_readme(folder: Path) -> None:
    text = README.read_text(encoding="utf-8")
    commands = re.findall(r"^(?:.* && )?(cordicc (?:compile|simulate) \S.*)$", text, flags=re.MULTILINE)
    (folder / "samples.csv").write_text("S\n0.4\n0.45\n", encoding="utf-8")
    run("cordicc compile examples/wheel_beta.yaml -q")
    assert len(commands) >= 3
    for command in commands:
        run(command)
    assert (folder / "angles.csv").read_text(encoding="utf-8").startswith("beta,valid\n")
