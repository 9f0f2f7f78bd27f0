"""The formulas of a plan are what its operations compute."""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import cordicc
from cordicc.formulas import _UNIT_WRITERS, _WRITERS, LONGEST, Formulas
from cordicc.ir.ops import OPS, Level
from cordicc.plan import Operation, Plan, dependence_order
from cordicc.targets.model import CAU_KINDS

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TOKEN = re.compile(r"\s*([0-9.]+(?:e[-+]?[0-9]+)?|[A-Za-z_][\w.']*\(?|[-+*/^(),])")


def wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)


SMALL: dict[str, Callable[..., float]] = {
    "add": lambda p, a, b: a + b,
    "sub": lambda p, a, b: a - b,
    "mul": lambda p, a, b: a * b,
    "cmul": lambda p, a: a * float(p["factor"]),
    "shift": lambda p, a: a * 2.0 ** int(p["exponent"]),
    "neg": lambda p, a: -a,
    "abs": lambda p, a: abs(a),
    "wrap": lambda p, a: wrapped(a),
    "min": lambda p, a, b: min(a, b),
    "max": lambda p, a, b: max(a, b),
}


def cau(operation: Operation, *values: float) -> tuple[float, float]:
    """Return the results of a CAU operation in double precision."""
    params = operation.params
    if operation.op == "vector" and params["m"] == 1:
        x, y, z = values
        return math.hypot(x, y), z + params["sign"] * math.atan2(y, x)
    if operation.op == "vector" and params["m"] == 0:
        x, y, z = values
        return x, z + params["sign"] * y / x
    if operation.op == "vector":
        x, y, z = values
        return math.sqrt(x * x - y * y), z + params["sign"] * math.atanh(y / x)
    if operation.op == "rotate" and params["m"] == 1:
        x, y, z = values
        c, s = math.cos(z), math.sin(z)
        return x * c - y * s, y * c + x * s
    if operation.op == "rotate" and params["m"] == 0:
        x, y, z = values
        return x, y + x * z
    assert operation.op == "implicit"
    assert params["m"] == 1
    a, b, c = values
    offset = math.acos(c / math.hypot(a, b))
    angle = math.atan2(a, b) + (offset if params["branch"] == "+" else -offset)
    return angle, math.sqrt(max(0.0, a * a + b * b - c * c))


def computed(plan: Plan) -> dict[str, float]:
    """Return every value of a plan in the middle of the ranges, or at a row of its samples."""
    samples = plan.problem["samples"]
    values = {
        i["name"]: samples["columns"][i["name"]][7] if samples else i["lo"] + 0.55 * (i["hi"] - i["lo"])
        for i in plan.problem["inputs"]
    }
    for operation in dependence_order(plan):
        operands = [float(o.constant) if o.value is None else values[o.value] for o in operation.operands]
        if operation.kind in CAU_KINDS:
            results = cau(operation, *operands)
        else:
            results = (SMALL[operation.op](operation.params, *operands),)
        values |= {n: r for n, r in zip(operation.results, results, strict=True) if n is not None}
    return values


def evaluated(text: str, values: dict[str, float], t: float = math.nan) -> float:
    """Return the number of a formula: a space between operands is a product, `^` a power."""
    names: dict[str, Any] = {"t": t, "wrap": wrapped, "abs": abs, "min": min, "max": max}
    names |= {n: getattr(math, n) for n in ("cos", "sin", "sqrt", "atan2", "atanh", "log", "cosh", "sinh")}
    python, before, at = "", "", 0
    while at < len(text.rstrip()):
        match = TOKEN.match(text, at)
        assert match, text[at:]
        token, at = match[1], match.end()
        starts = token[0].isalnum() or token[0] == "_" or token == "("
        if starts and before and (before[-1].isalnum() or before[-1] in "_')"):
            python += "*"
        if token[0].isalpha() or token[0] == "_":
            name = token.removesuffix("(")
            key = name if name in names else "v[" + repr(name) + "]"
            python += key + ("(" if token.endswith("(") else "")
        else:
            python += "**" if token == "^" else token
        before = token
    number = eval(python, {"__builtins__": {}, **names, "v": values})
    assert isinstance(number, float | int)
    return float(number)


def check(line: str, values: dict[str, float]) -> None:
    name, _, right = line.partition(" = ")
    if right.startswith("t with "):
        sides = right.removeprefix("t with ").partition(", branch")[0].split(" = ")
        left, other = (evaluated(side, values, values[name]) for side in sides)
        assert left == pytest.approx(other, abs=1e-4)
        return
    if right.startswith("length of "):
        x, y = right.removeprefix("length of (")[:-1].split(", ")
        assert values[name] == pytest.approx(math.hypot(evaluated(x, values), evaluated(y, values)), abs=1e-4)
        return
    turned = re.fullmatch(r"([xy]) of \((.*), (.*)\) turned by (.*)", right)
    if turned:
        x, y, z = (evaluated(part, values) for part in turned.groups()[1:])
        c, s = math.cos(z), math.sin(z)
        expected = x * c - y * s if turned[1] == "x" else y * c + x * s
        assert values[name] == pytest.approx(expected, abs=1e-4)
        return
    assert values[name] == pytest.approx(evaluated(right, values), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("example", sorted(p.stem for p in EXAMPLES.glob("*.yaml")))
@pytest.mark.parametrize("units", ["auto", "standard"])
def test_formulas_are_right(example: str, units: str) -> None:
    plan = cordicc.compile(EXAMPLES / f"{example}.yaml", units=units)
    formulas = Formulas(plan)
    values = computed(plan)
    values |= {formulas.name(name): number for name, number in values.items()}
    seen = 0
    for operation in plan.operations:
        if operation.kind in CAU_KINDS:
            for line in formulas.unit(operation):
                check(line, values)
                seen += 1
        elif operation.results[0] is not None:
            text = formulas.value(operation.results[0])
            assert values[operation.results[0]] == pytest.approx(evaluated(text, values), rel=1e-4, abs=1e-4)
            assert len(text) <= 3 * LONGEST
    assert seen


def test_every_operation_of_plans_has_a_formula() -> None:
    wanted = {n for n, d in OPS.items() if d.level is Level.ARITHMETIC}
    assert set(_WRITERS) == wanted
    assert set(_UNIT_WRITERS) == {n for n, d in OPS.items() if d.level is Level.UNIT}


ATOM, SUM, MINUS, PRODUCT = ("a", 4), ("a + b", 1), ("-a", 2), ("a b", 3)


@pytest.mark.parametrize(
    ("op", "operands", "params", "text"),
    [
        ("add", [MINUS, SUM], {}, "a + b - a"),
        ("add", [SUM, MINUS], {}, "a + b - a"),
        ("add", [MINUS, MINUS], {}, "-a - a"),
        ("sub", [ATOM, MINUS], {}, "a + a"),
        ("sub", [ATOM, SUM], {}, "a - (a + b)"),
        ("mul", [SUM, ATOM], {}, "(a + b) a"),
        ("mul", [SUM, SUM], {}, "(a + b)^2"),
        ("mul", [MINUS, ATOM], {}, "(-a) a"),
        ("cmul", [SUM], {"factor": "-0.5"}, "-0.5 (a + b)"),
        ("cmul", [("2 a", 3)], {"factor": "3"}, "3 (2 a)"),
        ("shift", [SUM], {"exponent": 1}, "2 (a + b)"),
        ("shift", [ATOM], {"exponent": -1}, "0.5 a"),
        ("shift", [ATOM], {"exponent": -3}, "2^-3 a"),
        ("neg", [SUM], {}, "-(a + b)"),
        ("guard", [ATOM, SUM], {"condition": "positive"}, "valid(a if a + b is positive)"),
        ("select", [SUM, ATOM, PRODUCT], {}, "(a if a + b >= 0 else a b)"),
        ("flip", [ATOM, SUM], {}, "(a with the sign of a + b)"),
        ("wrap", [SUM], {}, "wrap(a + b)"),
        ("min", [SUM, ATOM], {}, "min(a + b, a)"),
    ],
)
def test_small_operations(op: str, operands: list, params: dict, text: str) -> None:
    assert _WRITERS[op](operands, params)[0] == text


ZERO, ONE = ("0", 4), ("1", 4)


@pytest.mark.parametrize(
    ("op", "operands", "params", "texts"),
    [
        ("vector", [ATOM, SUM, ZERO], {"m": 1, "sign": -1}, ["length of (a, a + b)", "-atan2(a + b, a)"]),
        ("vector", [ATOM, SUM, ATOM], {"m": 0, "sign": 1}, ["a", "a + (a + b) / a"]),
        ("vector", [ATOM, SUM, ZERO], {"m": -1, "sign": 1}, ["sqrt(a^2 - (a + b)^2)", "atanh((a + b) / a)"]),
        ("rotate", [ATOM, ZERO, SUM], {"m": 0}, ["a", "a (a + b)"]),
        ("rotate", [ATOM, ATOM, SUM], {"m": 0}, ["a", "a + a (a + b)"]),
        ("rotate", [ONE, ZERO, SUM], {"m": -1}, ["cosh(a + b)", "sinh(a + b)"]),
        ("rotate", [ATOM, ATOM, SUM], {"m": -1},
         [f"{axis} of (a, a) turned hyperbolically by a + b" for axis in "xy"]),
        ("lightcone", [SUM, ONE], {}, ["sqrt(a + b)", "0.5 log(a + b)"]),
        ("lightcone", [SUM, PRODUCT], {}, ["sqrt((a + b) a b)", "0.5 log((a + b) / (a b))"]),
        ("implicit", [ONE, ("-1", 2), SUM], {"m": 1, "branch": "+"},
         ["t with -cos(t) + sin(t) = a + b, branch +", "sqrt(1^2 + (-1)^2 - (a + b)^2)"]),
        ("implicit", [SUM, ZERO, ATOM], {"m": -1, "branch": "none"},
         ["t with (a + b) sinh(t) = a", "sqrt((a + b)^2 - 0^2 + a^2)"]),
    ],
)  # fmt: skip
def test_units(op: str, operands: list, params: dict, texts: list[str]) -> None:
    assert _UNIT_WRITERS[op](operands, params) == texts
