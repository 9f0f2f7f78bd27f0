"""Every command runs once on a small input."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from cordicc.cli.main import COMMANDS
from tests.support.command_line import run

PROBLEM = "name: small\ninputs: {x: [0.5, 1], y: [-1, 1]}\nequations: ['t = atan2(y, x)']\n"
GRAPH = {
    "initiation_interval": 1,
    "minimize": "latency",
    "kinds": {"cau": {"latency": 4, "limit": None}},
    "operations": [{"id": "a", "kind": "cau"}, {"id": "b", "kind": "cau"}],
    "edges": [["a", "b"]],
}

ARGUMENTS: dict[str, Callable[[Path], list[object]]] = {
    "check": lambda here: [here / "small.yaml"],
    "compile": lambda here: [here / "small.yaml", "-o", here / "again"],
    "diff": lambda here: [here / "out", here / "out"],
    "draw": lambda here: [here / "out", "-o", "-"],
    "explain": lambda here: [here / "out"],
    "explore": lambda here: [here / "small.yaml", "-o", here / "front.svg", "--jobs", 1, "--json"],
    "schedule": lambda here: [here / "graph.json"],
    "schema": lambda here: ["plan"],
    "sequences": lambda here: [],
    "simulate": lambda here: [here / "out", "--random", 10],
    "synthesize": lambda here: ["--help"],  # what it runs may not be there, see test_synthesis
    "targets": lambda here: [],
    "trace": lambda here: ["vectoring", "--x", 1, "--y", 0.5],
}
"""By command, what it is called with in a folder with a problem, its plan and a graph."""


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("every")
    (folder / "small.yaml").write_text(PROBLEM, encoding="utf-8")
    (folder / "graph.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    assert run("compile", folder / "small.yaml", "-o", folder / "out", "-q").exit_code == 0
    return folder


def test_the_table_has_every_command() -> None:
    assert sorted(ARGUMENTS) == sorted(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_it_runs(command: str, here: Path) -> None:
    result = run(command, *ARGUMENTS[command](here))
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.strip()
