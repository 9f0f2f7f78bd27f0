"""The formulas of a plan are what its operations compute."""

import math
import re
from collections.abc import Callable
from typing import Any

import pytest

from cordicc.backends.text.formulas import MOST_PARTS, WRITERS, Formulas
from cordicc.ir.ops import OPS, Level
from cordicc.plan.model import Operation, Plan, dependence_order
from cordicc.targets.target import CAU_KINDS
from tests.support.paths import EXAMPLES
from tests.support.plans import planned
from tests.support.selection import quick

NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*(?:\.\w+)?")
FUNCTIONS = {
    name: getattr(math, name) for name in ("cos", "sin", "sqrt", "atan2", "atanh", "log", "cosh", "sinh")
}


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
    samples = plan.problem.samples
    values = {
        i.name: samples[i.name][7] if samples else i.lo + 0.55 * (i.hi - i.lo) for i in plan.problem.inputs
    }
    for operation in dependence_order(plan):
        operands = [float(o.constant) if o.value is None else values[o.value] for o in operation.operands]
        if operation.kind in CAU_KINDS:
            results = cau(operation, *operands)
        else:
            results = (SMALL[operation.op](operation.params, *operands),)
        values |= {n: r for n, r in zip(operation.results, results, strict=True) if n is not None}
    return values


def evaluated(text: str, values: dict[str, float]) -> float:
    """Return the number of a formula."""
    inner, modulo, _ = text.partition(" modulo 2*pi")
    if modulo:
        return wrapped(evaluated(inner, values))
    names: dict[str, Any] = {**FUNCTIONS, "abs": abs, "min": min, "max": max, "pi": math.pi}
    python = NAME.sub(lambda found: found[0] if found[0] in names else f"v[{found[0]!r}]", text)
    return float(eval(python, {"__builtins__": {}, **names, "v": values}))


NAMES = sorted(p.stem for p in EXAMPLES.glob("*.yaml"))


@pytest.mark.parametrize("example", quick(NAMES, "planar_2r", "wheel_suspension"))
@pytest.mark.parametrize("units", ["auto", "standard"])
def test_formulas_are_right(example: str, units: str) -> None:
    plan = planned(EXAMPLES / f"{example}.yaml", units=units)
    formulas = Formulas(plan)
    values = computed(plan)
    values |= {formulas.symbol(name).text: number for name, number in values.items()}
    for operation in plan.operations:
        made = formulas.of(operation)
        assert made or not any(operation.results)
        for formula in made:
            left, right = (evaluated(side, values) for side in formula.text.split(" = "))
            assert left == pytest.approx(right, rel=1e-4, abs=1e-4), formula.text
            assert formula.text.count("+") <= 4 * MOST_PARTS


def test_every_operation_of_plans_has_a_formula() -> None:
    assert set(WRITERS) == {n for n, d in OPS.items() if d.level in (Level.ARITHMETIC, Level.UNIT)}
