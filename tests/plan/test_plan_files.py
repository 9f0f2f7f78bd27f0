"""Reading plan.json: whatever the file holds ends in a plan that runs or in a diagnostic."""

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from cordicc.artefacts import artefacts
from cordicc.base.diagnostics import CordiccError
from cordicc.base.text_tables import plain
from cordicc.cli.main import main
from cordicc.cli.simulation_text import comparison_data, comparison_sheet
from cordicc.emulate import functional, observation
from cordicc.ir import sampling
from cordicc.ir.sampling import Workspace
from cordicc.plan.file import dump, parse
from cordicc.plan.model import Plan
from cordicc.readback import check_plan
from tests.support.paths import EXAMPLES
from tests.support.plans import compiled
from tests.support.selection import quick

PROBLEM = """
name: small
inputs: {x: [0.25, 0.5], a: [-1, 1]}
equations:
  - z = x*cos(a) + 0.1
  - b = x*a
outputs: {z: {max_error: 1e-5}, b: {}}
"""
SAMPLES = {"columns": {"x": [0.25, 0.5], "a": [-1, 1.0]}}
HOSTILE = ["1e400", "1" + "0" * 400, "-1", "1e9", "1000000000", '""', r'"\ud800"', "[]", "{}", "null", "true"]
NEVER_FIT = ("1e400", "1" + "0" * 400, r'"\ud800"')
"""Values that are refused wherever they stand."""


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    path = tmp_path_factory.mktemp("small") / "small.yaml"
    path.write_text(PROBLEM, encoding="utf-8")
    data: dict[str, Any] = json.loads(compiled(path).to_json())
    data["problem"]["samples"] = SAMPLES
    return data


def load(content: str) -> Plan:
    return check_plan(parse(content, "plan.json"))


def places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every leaf and container, only two of each array."""
    yield path
    items = data.items() if isinstance(data, dict) else enumerate(data[:2]) if isinstance(data, list) else ()
    for key, item in items:
        yield from places(item, (*path, key))


def replaced(data: Any, path: tuple[Any, ...], new: Any) -> Any:
    if not path:
        return new
    copy = dict(data) if isinstance(data, dict) else list(data)
    copy[path[0]] = replaced(data[path[0]], path[1:], new)
    return copy


@pytest.mark.parametrize("hostile", quick(HOSTILE, "1e400", "null"))
def test_every_place_by_a_hostile_value(base: dict[str, Any], hostile: str) -> None:
    accepted = []
    refused = []
    for path in places(base):
        try:
            accepted.append(load(json.dumps(replaced(base, path, "@@")).replace('"@@"', hostile, 1)))
        except CordiccError as error:
            refused.append((path, error))
    assert len(refused) > 100
    for path, error in refused:
        assert error.exit_status == 2
        assert all(re.fullmatch("E60[0-9]", d.code) for d in error.diagnostics), path
    assert bool(accepted) == (hostile not in NEVER_FIT)
    for plan in accepted:
        inputs = sampling.draw(plan.problem.workspace, 3, 0)
        outputs = functional.run(plan, plan.arithmetic, inputs)
        comparison = observation.compare(plan, inputs, outputs)
        plain(comparison_sheet(plan, comparison, {}))
        json.dumps(comparison_data(plan, comparison), allow_nan=False)
        dump(plan)


BROKEN = {
    "clock 1e400": (("clock_hz",), "1e400"),
    "clock of 400 digits": (("target_data", "clock_hz"), "1" * 400),
    "lo of minus infinity": (("problem", "inputs", 0, "lo"), "-1e400"),
    "lo above hi": (("problem", "inputs", 0, "lo"), "7"),
    "no columns": (("problem", "samples", "columns"), "{}"),
    "unequal columns": (("problem", "samples", "columns", "x"), "[0.3]"),
    "missing column": (("problem", "samples", "columns"), '{"x": [0.3]}'),
    "column of text": (("problem", "samples", "columns", "x"), '[0.3, "a"]'),
    "column out of range": (("problem", "samples", "columns", "x"), "[0.3, 1e999]"),
    "latency": (("latency", "cycles"), "1000000000"),
    "unit latency": (("units", 0, "latency"), "1000000000"),
    "depth": (("fifos", 0, "depth"), "1000000000"),
    "start": (("operations", 0, "start"), "1000000000"),
    "interval": (("initiation_interval",), "1000001"),
    "lone surrogate": (("problem", "description"), r'"\ud800"'),
    "key with a lone surrogate": (("options",), r'{"\ud800": 1}'),
    "options of wrong types": (("options", "ii"), '"4"'),
    "copies that are none": (("options",), '{"copies": 0}'),
    "deep": (("options",), "[" * 500 + "]" * 500),
    "fifo words": (("fifo_words",), "1"),
    "processors": (("processors", "total"), "0"),
    "other outputs": (("problem", "outputs", 0, "name"), '"q"'),
    "outputs twice": (("problem", "outputs", 0, "name"), '"b"'),
    "tiny constant": (("operations", 0, "params"), '{"factor": "1e-40"}'),
}


@pytest.mark.parametrize("case", BROKEN)
@pytest.mark.parametrize("flags", [[], ["--cycle-accurate"]], ids=["functional", "clocked"])
def test_the_command_line_refuses(base: dict[str, Any], case: str, flags: list[str], tmp_path: Path) -> None:
    path, value = BROKEN[case]
    file = tmp_path / "plan.json"
    file.write_text(json.dumps(replaced(base, path, "@@")).replace('"@@"', value, 1), encoding="utf-8")
    result = CliRunner().invoke(main, ["simulate", str(file), "--random", "3", *flags])
    assert isinstance(result.exception, SystemExit)
    assert result.exit_code == 2
    assert "error[E60" in result.stderr
    assert "Traceback" not in result.output


def test_the_fifo_words_are_limited(base: dict[str, Any]) -> None:
    fifos = [{**base["fifos"][0], "id": f"g{i}", "depth": 1_000_000} for i in range(51)]
    with pytest.raises(CordiccError, match=r"FIFO words is 51000000, more than|fifo_words"):
        load(json.dumps({**base, "fifos": fifos, "fifo_words": 51_000_000}))


def test_outputs_follow_the_problem(base: dict[str, Any], tmp_path: Path) -> None:
    plan = load(json.dumps(base, sort_keys=True))
    assert list(plan.outputs) == list(plan.accuracy) == ["z", "b"]
    (tmp_path / "plan.json").write_text(json.dumps(base, sort_keys=True), encoding="utf-8")
    out = tmp_path / "out.csv"
    arguments = ["simulate", str(tmp_path / "plan.json"), "--random", "3", "--outputs", str(out)]
    assert CliRunner().invoke(main, arguments).exit_code == 0
    assert out.read_text(encoding="utf-8").splitlines()[0] == "z,b,valid"
    page = artefacts(plan)["report.html"]
    table = page[page.index("largest observed") :]
    heads = re.findall(r'<th scope="row">(.*?)</th><td class="n">', table)
    assert [re.sub("<.*?>", "", head) for head in heads][:2] == ["z", "b"]


def test_a_written_plan_reads_back(base: dict[str, Any]) -> None:
    plan = load(json.dumps(base))
    assert load(dump(plan)) == plan
    assert json.loads(dump(plan)) == base


def test_samples_of_the_widest_range() -> None:
    drawn = sampling.draw(Workspace({"x": (-1.7e308, 1.7e308)}), 100, 0)["x"]
    assert all(map(math.isfinite, drawn))
    assert drawn.min() < -1e308 < 1e308 < drawn.max()


def test_a_folder_stands_for_its_plan(tmp_path: Path) -> None:
    file = str(EXAMPLES / "planar_2r.yaml")
    assert CliRunner().invoke(main, ["compile", file, "-q", "-o", str(tmp_path / "out")]).exit_code == 0
    for command in (["explain"], ["simulate", "--random", "10"], ["draw", "-o", str(tmp_path / "p.svg")]):
        words = [command[0], str(tmp_path / "out"), *command[1:]]
        assert CliRunner().invoke(main, words, catch_exceptions=False).exit_code == 0
    refused = CliRunner().invoke(main, ["explain", str(tmp_path)])
    assert refused.exit_code == 2
    assert "E600" in refused.output
