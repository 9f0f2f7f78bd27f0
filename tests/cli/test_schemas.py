"""The published schemas accept what the loaders accept, and refuse what is wrong in form."""

import copy
import io
import json
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.expressions.syntax import CONSTANT_NAMES, FUNCTIONS
from cordicc.frontend.load import KEYS, load_problem, parse_problem
from cordicc.frontend.robots.dh import CONVENTIONS, FIELDS, MAX_JOINTS
from cordicc.targets.target_file import (
    FUNCTIONS_OF_KIND,
    REQUIRED_KINDS,
    load_target,
    shipped_targets,
    target_text,
)
from tests.support.command_line import run
from tests.support.paths import ROOT
from tests.support.selection import examples, quick

PROBLEMS = sorted(
    [*(ROOT / "examples").glob("*.yaml"), *(ROOT / "tests" / "whole" / "corpus").glob("*.yaml")]
)
CASES = sorted((ROOT / "tests" / "whole" / "errors").glob("*.yaml"))


@cache
def schema(kind: str) -> dict[str, Any]:
    return json.loads((ROOT / "cordicc" / "schema" / f"{kind}.schema.json").read_text(encoding="utf-8"))


def reader() -> YAML:
    yaml = YAML(typ="safe", pure=True)
    yaml.version = "1.2"
    return yaml


@cache
def validator(kind: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(schema(kind))


def findings(kind: str, data: object) -> list[str]:
    return [e.message for e in validator(kind).iter_errors(data)]


def loads(path: Path) -> bool:
    try:
        load_problem(path)
    except InvalidInput:
        return False
    return True


@pytest.mark.parametrize("kind", ["problem", "target", "plan"])
def test_the_command_prints_a_valid_schema(kind: str) -> None:
    result = run("schema", kind)
    assert result.exit_code == 0
    assert json.loads(result.stdout) == schema(kind)
    jsonschema.Draft202012Validator.check_schema(schema(kind))


@pytest.mark.parametrize("path", [p for p in PROBLEMS if not p.stem.startswith("rej_")], ids=lambda p: p.stem)
def test_every_problem_is_accepted(path: Path) -> None:
    assert findings("problem", reader().load(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    "path", quick(CASES, *(p for p in CASES if p.stem != "deep_yaml")), ids=lambda p: p.stem
)
def test_what_is_refused_is_wrong(path: Path) -> None:
    try:
        refused = bool(findings("problem", reader().load(path.read_bytes().decode("utf-8"))))
    except (YAMLError, ValueError, RecursionError):
        return  # no YAML that an editor could check
    assert not (refused and loads(path))


VALID = """
{inputs: {x: [0, 1]}, equations: [y = x]}
{name: , description: , constants: , inputs: {x: [0, 1]}, equations: [y = x], outputs: , assume: , branches: }
{name: 3, inputs: {x: {range: [-90*deg, 1e-3], unit: rad}}, equations: [y = x + 1]}
{inputs: {x: {range: [0, 1], unit: }}, equations: [y = x + 1], outputs: {y: }}
{constants: {l: 400 mm, t: 30 deg, k: 2*l, n: -.5}, inputs: {x: [0, n + 1]}, equations: ["y = k*x + t"]}
{inputs: {off: [0, 1], y: [0, 1]}, equations: [no = off + y], outputs: {no: {max_error: 1e-5}}}
{inputs: {x: [0, 1]}, equations: [q = acos(x)], outputs: {q: {wrap: false, max_error: 2*deg}}}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t) = x", for: t, branch: "+"}]}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t) = x", for: t, branch: t >= 0}]}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t) = x", for: t}], branches: all}
{inputs: {x: [1, 2], y: [1, 2]}, equations: [{solve: ["x*cos(t) = 1", "sin(t) = y/3"], for: t}]}
{inputs: {x: [1, 1.2], y: [1, 1.2]}, equations: [
{solve: ["cos(a) + cos(a + b) = x", "sin(a) + sin(a + b) = y"], for: [a, b], branch: "-"}]}
{inputs: {x: [1, 2]}, equations: [{vector: "p = [x, 2, 3]"}, "n = norm(p) + dot(p, [1, 0, 0])"]}
{inputs: {q: [0, 1]}, equations: [{dh: {frame: T, convention: standard, joints: [{d: q}, {alpha: pi/2}]}}]}
{inputs: {q: [0, 1]}, equations: [{dh: {frame: T, convention: modified, joints: [{}]}}], outputs: [T_px]}
{inputs: {x: [1, 2]}, equations: [y = x], assume: [x > 0, "x**2 <= 4", "x = x"]}
""".strip().split("\n")

INVALID = """
{equations: [y = 1]}
{inputs: {x: [0, 1]}}
{inputs: , equations: [y = x]}
{inputs: {}, equations: [y = x]}
{inputs: {x: [0, 1]}, equations: []}
{inputs: {x: [0, 1]}, equations: {y: x}}
{inputs: {x: [0, 1]}, equations: [y = x], output: [y]}
{inputs: {x: [0]}, equations: [y = x]}
{inputs: {x: [0, 1, 2]}, equations: [y = x]}
{inputs: {x: {lo: 0, hi: 1}}, equations: [y = x]}
{inputs: {x: {unit: m}}, equations: [y = x]}
{inputs: {x: 3}, equations: [y = x]}
{inputs: {x: [0, null]}, equations: [y = x]}
{inputs: {1x: [0, 1]}, equations: [y = 1]}
{inputs: {sin: [0, 1]}, equations: [y = 1]}
{inputs: {valid: [0, 1]}, equations: [y = 1]}
{constants: [1], inputs: {x: [0, 1]}, equations: [y = x]}
{constants: {pi: 3}, inputs: {x: [0, 1]}, equations: [y = x]}
{constants: {k: }, inputs: {x: [0, 1]}, equations: [y = x]}
{constants: {k: [1]}, inputs: {x: [0, 1]}, equations: [y = x]}
{inputs: {x: [0, 1]}, equations: [y]}
{inputs: {x: [0, 1]}, equations: [2*y = x]}
{inputs: {x: [0, 1]}, equations: [y == x]}
{inputs: {x: [0, 1]}, equations: [y = x^2]}
{inputs: {x: [0, 1]}, equations: [y = x % 2]}
{inputs: {x: [0, 1]}, equations: [3]}
{inputs: {x: [0, 1]}, equations: [null]}
{inputs: {x: [0, 1]}, equations: [{y: x}]}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t) = x"}]}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t)", for: t, branch: "+"}]}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t) = x", for: t, branch: up}]}
{inputs: {x: [0, 1]}, equations: [{solve: "cos(t) = x", for: t, branch: "+", hint: 1}]}
{inputs: {x: [0, 1]}, equations: [{solve: ["cos(t) = x"], for: t}]}
{inputs: {x: [0, 1]}, equations: [{solve: ["cos(t) = x", "sin(t) = x", "sin(t) = 1"], for: t}]}
{inputs: {x: [0, 1]}, equations: [{solve: ["cos(t) = x", "sin(t) = x"], for: [t, t]}]}
{inputs: {x: [0, 1]}, equations: [{vector: [x, x]}]}
{inputs: {x: [0, 1]}, equations: [{vector: "p = [x, x]", for: p}]}
{inputs: {x: [0, 1]}, equations: [{dh: {frame: T, joints: [{theta: x}]}}]}
{inputs: {x: [0, 1]}, equations: [{dh: {frame: T, convention: other, joints: [{theta: x}]}}]}
{inputs: {x: [0, 1]}, equations: [{dh: {frame: T, convention: standard, joints: []}}]}
{inputs: {x: [0, 1]}, equations: [{dh: {frame: T, convention: standard, joints: [{phi: x}]}}]}
{inputs: {x: [0, 1]}, equations: [{dh: {frame: 3, convention: standard, joints: [{theta: x}]}}]}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: y}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: []}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: [y, y]}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: [{y: {wrap: false}}]}
{inputs: {x: [0, 1]}, equations: [y = acos(x)], outputs: {y: {wrap: maybe}}}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: {y: {max_error: 0}}}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: {y: {max_error: }}}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: {y: {tolerance: 1}}}
{inputs: {x: [0, 1]}, equations: [y = x], outputs: {y: [wrap]}}
{inputs: {x: [0, 1]}, equations: [y = x], assume: x > 0}
{inputs: {x: [0, 1]}, equations: [y = x], assume: [x]}
{inputs: {x: [0, 1]}, equations: [y = x], assume: [x == 1]}
{inputs: {x: [0, 1]}, equations: [y = x], branches: both}
{inputs: {x: [0, 1]}, equations: [y = x], samples: [a.csv]}
{name: .hidden, inputs: {x: [0, 1]}, equations: [y = x]}
{name: a/b, inputs: {x: [0, 1]}, equations: [y = x]}
{name: [a], inputs: {x: [0, 1]}, equations: [y = x]}
{description: {a: b}, inputs: {x: [0, 1]}, equations: [y = x]}
[inputs, equations]
nothing
""".strip().split("\n")


def joined(lines: list[str]) -> list[str]:
    """Return the texts; a line that starts a nested item belongs to the one before."""
    texts: list[str] = []
    for line in lines:
        if line.startswith("{solve"):
            texts[-1] += line
        else:
            texts.append(line)
    return texts


@pytest.mark.parametrize(
    ("text", "valid"), [*((t, True) for t in joined(VALID)), *((t, False) for t in INVALID)]
)
def test_loader_and_schema_agree(text: str, valid: bool) -> None:
    try:
        parse_problem(Source("p.yaml", text))
        loaded = ""
    except InvalidInput as error:
        loaded = str(error)
    found = findings("problem", reader().load(text))
    assert (not loaded) is valid, loaded
    assert (not found) is valid, found


def places(data: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the place of everything in the data."""
    yield at
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from places(value, (*at, key))


def changed(data: Any, at: tuple[Any, ...], value: Any) -> Any:
    """Return the data with another value at a place; the value `...` removes it."""
    if not at:
        return value
    made = copy.deepcopy(data)
    parent = made
    for key in at[:-1]:
        parent = parent[key]
    if value is ...:
        del parent[at[-1]]
    else:
        parent[at[-1]] = value
    return made


SMALL = [reader().load(text) for text in joined(VALID)]
STRANGE = (
    ...,
    None,
    True,
    0,
    -1.5,
    "",
    "x",
    "x = 1",
    "all",
    "+",
    [],
    ["x"],
    [0, 1],
    {},
    {"x": 1},
    {"solve": "x"},
)


@settings(max_examples=examples(150), deadline=None)
@given(st.data())
def test_what_the_schema_refuses_the_loader_refuses(data: st.DataObject) -> None:
    """Whatever is changed in a valid file, an editor raises no false alarm."""
    start = data.draw(st.sampled_from(SMALL))
    at = data.draw(st.sampled_from(list(places(start))))
    made = changed(start, at, data.draw(st.sampled_from(STRANGE if at else STRANGE[1:])))
    out = io.StringIO()
    reader().dump(made, out)
    try:
        parse_problem(Source("p.yaml", out.getvalue()))
    except InvalidInput:
        return
    assert findings("problem", made) == []


def test_the_problem_schema_knows_every_key_and_name() -> None:
    whole = schema("problem")
    assert set(whole["properties"]) == set(KEYS)
    assert set(whole["$defs"]["name"]["not"]["enum"]) == {*FUNCTIONS, *CONSTANT_NAMES, "valid"}
    table = whole["$defs"]["dh"]["properties"]["dh"]["properties"]
    assert tuple(table["convention"]["enum"]) == CONVENTIONS
    assert tuple(table["joints"]["items"]["properties"]) == FIELDS
    assert table["joints"]["maxItems"] == MAX_JOINTS


def test_the_target_schema_knows_every_kind_and_function() -> None:
    units = schema("target")["properties"]["units"]
    assert set(units["required"]) == set(REQUIRED_KINDS)
    assert {
        kind: set(unit["properties"]["functions"]["items"]["enum"])
        for kind, unit in units["properties"].items()
    } == FUNCTIONS_OF_KIND


@cache
def target_data(name: str) -> Any:
    return reader().load(target_text(name).text)


@pytest.mark.parametrize("name", shipped_targets())
def test_every_target_is_accepted(name: str) -> None:
    assert findings("target", target_data(name)) == []


TARGET_PLACES = [(name, at) for name in ("kinematic", "fixed24", "ecp5") for at in places(target_data(name))]
TARGET_VALUES = (
    ...,
    None,
    True,
    -1,
    0,
    1,
    3.5,
    "auto",
    "x",
    [],
    ["add"],
    {},
    {"rule": "root-free"},
    {"kind": "ieee-single"},
)


@settings(max_examples=examples(200), deadline=None)
@given(st.data())
def test_what_the_target_schema_refuses_the_loader_refuses(
    tmp_path_factory: Any, data: st.DataObject
) -> None:
    name, at = data.draw(st.sampled_from(TARGET_PLACES))
    made = changed(
        target_data(name), at, data.draw(st.sampled_from(TARGET_VALUES if at else TARGET_VALUES[1:]))
    )
    path = tmp_path_factory.getbasetemp() / "target.yaml"
    with path.open("w", encoding="utf-8") as file:
        reader().dump(made, file)
    try:
        load_target(path)
    except InvalidInput:
        return
    assert findings("target", made) == []


@pytest.mark.parametrize(
    ("name", "at", "value"),
    [
        ("kinematic", ("colour",), 1),
        ("kinematic", ("clock_hz",), ...),
        ("kinematic", ("clock_hz",), 0),
        ("kinematic", ("angle_unit",), "turn"),
        ("kinematic", ("name",), 3),
        ("kinematic", ("units", "gpu"), {}),
        ("kinematic", ("units", "mul"), ...),
        ("kinematic", ("units", "mul", "latency"), 0),
        ("kinematic", ("units", "mul", "latency"), "auto"),
        ("kinematic", ("units", "mul", "functions"), ["add"]),
        ("kinematic", ("units", "mul", "functions"), []),
        ("kinematic", ("units", "mul", "area"), "big"),
        ("kinematic", ("units", "mul", "latencies"), 3),
        ("kinematic", ("units", "mul", "latencies"), {"mul": "long"}),
        ("kinematic", ("units", "mul", "initiation_interval"), 0),
        ("kinematic", ("units", "standard", "arithmetic"), ...),
        ("kinematic", ("units", "standard", "arithmetic"), "auto"),
        ("kinematic", ("units", "standard", "arithmetic", "mantissa_bits"), 99),
        ("kinematic", ("units", "standard", "arithmetic", "exponent_bits"), 8),
        ("kinematic", ("units", "implicit", "arithmetic", "rule"), ...),
        ("kinematic", ("units", "implicit", "arithmetic", "rule"), "magic"),
        ("kinematic", ("units", "implicit", "arithmetic", "rule"), None),
        ("kinematic", ("format", "kind"), "posit"),
        ("kinematic", ("format", "width"), 24),
        ("fixed24", ("format", "width"), ...),
        ("fixed24", ("format", "width"), 99),
        ("fixed24", ("format", "rounding"), "up"),
        ("fixed24", ("format", "guard"), "some"),
        ("fixed24", ("units", "implicit", "arithmetic"), "auto"),
        ("fixed24", ("units", "standard", "stages", "normalise"), None),
        ("fixed24", ("units", "standard", "stages", "reduce", "cycles"), None),
    ],
)
def test_target_loader_and_schema_refuse(name: str, at: tuple[str, ...], value: Any, tmp_path: Path) -> None:
    made = changed(target_data(name), at, value)
    with (tmp_path / "t.yaml").open("w", encoding="utf-8") as file:
        reader().dump(made, file)
    with pytest.raises(InvalidInput):
        load_target(tmp_path / "t.yaml")
    assert findings("target", made)
