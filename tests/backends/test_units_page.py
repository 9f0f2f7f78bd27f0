"""docs/units.md says what units do to the bit: an interpreter written from it has the emulator's outputs."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.arith.numbers.slack import EXACT, Slack
from cordicc.emulate import functional
from cordicc.ir.ops import OPS
from cordicc.plan.file import dump
from cordicc.plan.model import Formats, Operand, Operation, Plan
from cordicc.targets.target_file import load_target
from tests.support.c_models import KINDS, Generator, variants
from tests.support.origins import problem_of
from tests.support.paths import EXAMPLES
from tests.support.plan_interpreter import Interpreter
from tests.support.plans import planned
from tests.support.selection import quick

Case = tuple[str, dict[str, Any]]
Words = dict[str, np.ndarray]

TARGETS = ["fixed24", "ecp5", "single-rotation"]
ROOTS: list[Case] = [("lightcone", {}), ("vector", {"m": -1, "sign": 1}), ("vector", {"m": -1, "sign": -1})]
UNITS = [case for case in variants() if case[0] in KINDS]


def samples(plan: Plan, count: int, seed: int) -> Words:
    """Return words in the ranges of the inputs; many are few, small, 0 or at an end."""
    rng = np.random.default_rng(seed)
    found: Words = {}
    for item in plan.problem.inputs:
        fraction = plan.formats.values[item.name].fraction
        lo, hi = math.ceil(math.ldexp(item.lo, fraction)), math.floor(math.ldexp(item.hi, fraction))
        drawn = rng.integers(lo, hi + 1, count)
        few = np.round(drawn / (hi - lo) * 16) * (hi - lo) // 16 + rng.integers(-2, 3, count)
        small = np.round(drawn * 2.0 ** -rng.integers(1, 22, count))
        kinds = [drawn, drawn, few, small, np.zeros(count), np.full(count, hi)]
        found[item.name] = np.clip(np.choose(rng.integers(0, 6, count), kinds), lo, hi).astype(np.int64)
    return found


def check(plan: Plan, words: Words) -> int:
    """Compare an interpreter's outputs with the emulator's; return how many samples are valid."""
    points = plan.formats.values
    numbers = {name: np.ldexp(column, -points[name].fraction) for name, column in words.items()}
    expected = functional.run(plan, plan.arithmetic, numbers)
    interpreter = Interpreter(json.loads(dump(plan)))
    for at in range(expected["valid"].size):
        own = interpreter.run({name: int(column[at]) for name, column in words.items()})
        for name, word in own.items():
            number = math.nan if word is None else math.ldexp(word, -plan.formats.outputs[name].fraction)
            wanted = float(expected[name][at])
            same = number == wanted or (math.isnan(number) and math.isnan(wanted))
            assert same, (name, number, wanted, {key: int(column[at]) for key, column in words.items()})
    return int(expected["valid"].sum())


def arithmetic(target: str) -> dict[str, Any]:
    """Return a target's arithmetic; words have 27 bits outside too, so that outputs show every bit."""
    spec = load_target("fixed24" if target == "single-rotation" else target, guard_bits=3).arithmetic
    format_, units = {**spec["format"], "width": 27, "guard": 0}, dict(spec["units"])
    if target == "single-rotation":
        format_["rounding"] = "half-even"
        units["implicit"] = {**units["implicit"], "rule": target}
    return {"format": format_, "units": units}


def of_one(
    case: Case, target: str, *, size: float = 4, fraction: int = 21, slack: Slack = EXACT, taken: int = 2
) -> Plan:
    """Return the plan of one operation of inputs within +-size, whose first results are outputs."""
    op, params = case
    definition = OPS[op]
    inputs = [f"x{at}" for at in range(definition.arity)]
    results = tuple(f"o.{name}" for name in definition.results)
    outputs = {f"y{at}": Operand(value=name) for at, name in enumerate(results[:taken])}
    kind = KINDS.get(op, op)
    operands = tuple(Operand(value=name) for name in inputs)
    made = Operation(
        "o", op, params, kind, op, kind, 0, 0, definition.ports, operands, results, "y", slack=slack
    )
    point, own = BinaryPoint(27, fraction), BinaryPoint(27, 26 - math.frexp(size)[1])
    return replace(
        Generator(arithmetic(target), 0).plan([case], 1),
        problem=problem_of("one operation", dict.fromkeys(inputs, (-size, size)), outputs),
        operations=(made,),
        outputs=outputs,
        formats=Formats(
            dict.fromkeys(inputs, own) | dict.fromkeys(results, point), dict.fromkeys(outputs, point)
        ),
    )


def label(value: object) -> str:
    if isinstance(value, tuple) and isinstance(value[0], str):
        return "-".join([value[0], *(str(each) for each in value[1].values())])
    return str(value)


@pytest.mark.parametrize("case", variants(), ids=label)
@pytest.mark.parametrize("target", quick(TARGETS, "fixed24"))
def test_every_operation(case: Case, target: str) -> None:
    """Operands of any kind: constants, inputs twice, binary points far apart, outputs with another one."""
    for seed in range(3):
        plan = Generator(arithmetic(target), seed).plan([case], 3)
        check(plan, samples(plan, 60, seed))


@pytest.mark.parametrize("case", UNITS, ids=label)
@pytest.mark.parametrize("target", quick(TARGETS, "ecp5"))
@pytest.mark.parametrize("fraction", [15, 21, 24])
def test_operations_of_units(case: Case, target: str, fraction: int) -> None:
    plan = of_one(case, target, fraction=fraction)
    assert check(plan, samples(plan, 150, fraction)) > 25


@pytest.mark.parametrize("case", [case for case in UNITS if case[0] == "rotate"], ids=label)
@pytest.mark.parametrize("size", [0.2, 12.0, 700.0])
def test_angles_of_all_sizes(case: Case, size: float) -> None:
    """No quarter turn, many, and so many that angles are reduced by a product; factors beyond any word."""
    plan = of_one(case, "ecp5", size=size, fraction=10)
    assert check(plan, samples(plan, 200, 3)) > 40


SLACKS = [EXACT, Slack(0.02, 0.01), Slack(0.003, 0.002, relative=True), Slack(2.0**-22, 2.0**-23)]


def near_the_end(plan: Plan, count: int) -> Words:
    """Return A, B, C of an implicit operation beside the end of reach, |C| = R, some with A or B alone."""
    (operation,) = plan.operations
    words, slack = samples(plan, count, 7), operation.slack
    rng = np.random.default_rng(8)
    for name in ("x0", "x1"):
        words[name] *= rng.random(count) < 0.85
    a, b = words["x0"].astype(float), words["x1"].astype(float)
    reach = np.sqrt(np.maximum(b * b + int(operation.params["m"]) * a * a, 0))
    largest = np.maximum(np.maximum(np.abs(a), np.abs(b)), 1)
    # Beyond and before, by some places or about as much as the slack allows.
    allowed = slack.beyond * (2 ** np.ceil(np.log2(largest)) if slack.relative else 2.0**23)
    places = rng.choice([1, -1, 2, -3, 9, -30], count) * 2.0 ** rng.integers(0, 19, count)
    off = np.where(rng.random(count) < 0.7, allowed * rng.uniform(-1.5, 1.5, count), places)
    c = np.round((reach + off * (rng.random(count) < 0.8)) * rng.choice([1, -1], count))
    return {**words, "x2": np.clip(c, -(1 << 25), 1 << 25).astype(np.int64)}


@pytest.mark.parametrize("case", [case for case in UNITS if case[0] == "implicit"], ids=label)
@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("slack", SLACKS, ids=str)
def test_end_of_reach(case: Case, target: str, slack: Slack) -> None:
    plan = of_one(case, target, slack=slack)
    assert check(plan, near_the_end(plan, 500)) > 20


@pytest.mark.parametrize("case", ROOTS, ids=label)
@pytest.mark.parametrize("slack", SLACKS, ids=str)
def test_roots_near_zero(case: Case, slack: Slack) -> None:
    light = case[0] == "lightcone"
    plan = of_one(case, "fixed24", slack=Slack(slack.beyond, 0.0, slack.relative and not light), taken=1)
    words = samples(plan, 300, 9)
    rng = np.random.default_rng(10)
    few = rng.integers(-(1 << 18), 1 << 18, 300) >> rng.integers(0, 18, 300)
    allowed = (
        np.abs(words["x0"]) * 2 * slack.beyond if slack.relative and not light else slack.beyond * 2.0**23
    )
    near = np.where(rng.random(300) < 0.3, few, allowed * rng.uniform(-1.5, 1.5, 300)).astype(np.int64)
    other = near if light else rng.choice([1, -1], 300) * (words["x0"] + near)
    words["x1"] = np.where(rng.random(300) < 0.8, np.clip(other, -(1 << 25), 1 << 25), words["x1"])
    check(plan, words)


@pytest.mark.parametrize("target", ["fixed24", "ecp5"])
@pytest.mark.parametrize("example", quick(["planar_2r", "wheel_beta", "puma560", "four_bar"], "planar_2r"))
def test_whole_plans(example: str, target: str) -> None:
    plan = planned(EXAMPLES / f"{example}.yaml", target=target)
    assert check(plan, samples(plan, 200, 11)) > 40


ARM = """\
name: arm
constants: {a: 0.35, b: 0.25}
inputs: {x: [-0.7, 0.7], y: [-0.7, 0.7]}
equations:
  - r2 = x**2 + y**2
  - elbow = acos((r2 - a**2 - b**2)/(2*a*b))
  - solve: x*cos(shoulder) + y*sin(shoulder) = (r2 + a**2 - b**2)/(2*a)
    for: shoulder
    branch: "-"
outputs: [shoulder, elbow]
"""


@pytest.mark.parametrize("target", ["fixed24", "ecp5"])
def test_an_arm_at_its_reach(target: str, tmp_path: Path) -> None:
    """Stretched and folded, a place beyond and before."""
    (tmp_path / "arm.yaml").write_text(ARM, encoding="utf-8")
    plan = planned(tmp_path / "arm.yaml", target=target)
    rng = np.random.default_rng(12)
    turns, lengths = rng.uniform(-math.pi, math.pi, 300), rng.choice([0.6, 0.1], 300)
    words = {
        name: np.round(np.ldexp(lengths * part(turns), plan.formats.values[name].fraction)).astype(np.int64)
        + rng.integers(-1, 2, 300)
        for name, part in (("x", np.cos), ("y", np.sin))
    }
    assert 100 < check(plan, words) < 300


CHANGES = [
    "slack",
    "within",
    "height",
    "rise",
    "room",
    "short",
    "upper",
    "unsettled",
    "stretched",
    "doubles",
    "angles",
]


@pytest.mark.parametrize("name", CHANGES)
def test_a_wrong_number_shows(name: str) -> None:
    """The interpreter takes its numbers from the plan, and the samples of the end of reach need them all."""
    plan = of_one(("implicit", {"m": 1, "branch": "-"}), "fixed24", slack=Slack(0.02, 0.01))
    words = near_the_end(plan, 1500)
    data = json.loads(dump(plan))
    cordic = data["cordic"]
    tables = [cordic["constants"], cordic["operations"]["o"]["reach"]]
    tables.append(cordic["units"]["implicit"]["steps"]["implicit-circular"])
    (table,) = (each for each in tables if name in each)

    def outputs() -> list[dict[str, int | None]]:
        interpreter = Interpreter(data)
        rows = [{each: int(column[at]) for each, column in words.items()} for at in range(1500)]
        return [interpreter.run(row) for row in rows]

    right, value = outputs(), table[name]
    # Half of each, with the last bits that thresholds have.
    table[name] = [each // 16 * 8 + 7 for each in value] if isinstance(value, list) else value // 2
    assert outputs() != right
