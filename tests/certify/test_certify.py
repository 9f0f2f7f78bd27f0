"""Proven bounds of whole plans: interval arithmetic, predicates, search, and what is stated."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from cordicc.arith.numbers.formats import SINGLE
from cordicc.arith.unit.cau import Cau
from cordicc.base.diagnostics import Unattainable
from cordicc.certify import boxes
from cordicc.certify.boxes import Boxes
from cordicc.certify.error_network import Constant, Step, network
from cordicc.certify.operator_models import local, margin_square
from cordicc.certify.own_bounds import inside
from cordicc.certify.plans import StatedBounds, bounds_of
from cordicc.certify.predicates import OWN_BOUND
from cordicc.certify.refine import Search, largest
from cordicc.certify.sweep import errors, forward
from cordicc.certify.twins import twins
from cordicc.emulate import functional
from cordicc.emulate.climb import climb, climbing
from cordicc.emulate.observation import exact
from cordicc.ir import sampling
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ops import OPS, Level
from cordicc.pipeline import Options, plan_file
from cordicc.plan.model import Plan
from tests.support import plans
from tests.support.operations import cases, graph_of
from tests.support.selection import slow

NUMBERS = st.floats(-50, 50, allow_subnormal=False)
FUNCTIONS = {
    "cos": (boxes.cosine, lambda t: t.cos()),
    "sin": (boxes.sine, lambda t: t.sin()),
    "cosh": (boxes.cosh, lambda t: t.cosh()),
    "sinh": (boxes.sinh, lambda t: t.sinh()),
}
BINARY = {
    "add": (lambda a, b: a + b, lambda a, b: a + b),
    "sub": (lambda a, b: a - b, lambda a, b: a - b),
    "mul": (lambda a, b: a * b, lambda a, b: a * b),
    "hypot": (boxes.hypot, lambda a, b: (a * a + b * b).sqrt()),
}


def one(lo: float, hi: float) -> Boxes:
    return Boxes(np.array([lo]), np.array([hi]))


def holds(box: Boxes, number: arb) -> bool:
    return not (number < arb(float(box.lo[0])) or number > arb(float(box.hi[0])))


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
@given(lo=NUMBERS, width=st.floats(0, 10), share=st.floats(0, 1))
def test_functions_hold_their_values(name: str, lo: float, width: float, share: float) -> None:
    enclose, function = FUNCTIONS[name]
    hi = lo + width
    inner = min(max(lo + share * width, lo), hi)
    for number in (lo, inner, hi):
        assert holds(enclose(one(lo, hi)), function(arb(number)))


@pytest.mark.parametrize("name", sorted(BINARY))
@given(a=NUMBERS, b=NUMBERS, wide=st.floats(0, 3), high=st.floats(0, 3))
def test_operations_hold_their_values(name: str, a: float, b: float, wide: float, high: float) -> None:
    enclose, function = BINARY[name]
    made = enclose(one(a, a + wide), one(b, b + high))
    for p, q in itertools.product((a, a + wide), (b, b + high)):
        assert holds(made, function(arb(p), arb(q)))


@given(x=NUMBERS, y=NUMBERS, wide=st.floats(0, 3), high=st.floats(0, 3), share=st.floats(0, 1))
def test_direction_holds_every_angle_modulo_a_turn(
    x: float, y: float, wide: float, high: float, share: float
) -> None:
    made = boxes.direction(one(y, y + high), one(x, x + wide))
    for p, q in ((x, y), (x + wide, y), (x + share * wide, y + share * high)):
        if p or q:
            angle = math.atan2(q, p)
            assert any(made.lo[0] - 1e-12 <= angle + k * math.tau <= made.hi[0] + 1e-12 for k in (-1, 0, 1))


INVERSES = {
    "acos": (boxes.arc_cosine, lambda t: t.acos(), -1, 1),
    "atan": (lambda b: b.monotone(np.arctan), lambda t: t.atan(), -50, 50),
    "atanh": (lambda b: b.monotone(np.arctanh), lambda t: t.atanh(), -0.999, 0.999),
    "log": (lambda b: b.monotone(np.log), lambda t: t.log(), 1e-9, 50),
    "sqrt": (lambda b: b.sqrt(), lambda t: t.sqrt(), 0, 50),
}


@pytest.mark.parametrize("name", sorted(INVERSES))
@given(low=st.floats(0, 1), high=st.floats(0, 1))
def test_inverse_functions_hold_their_values(name: str, low: float, high: float) -> None:
    enclose, function, least, most = INVERSES[name]
    ends = sorted(min(max(least + share * (most - least), least), most) for share in (low, high))
    made = enclose(one(*ends))
    assert holds(made, function(arb(ends[0])))
    assert holds(made, function(arb(ends[1])))


def test_unbounded_intervals() -> None:
    with np.errstate(invalid="ignore"):
        inverse = one(-1.0, 2.0).reciprocal()
        assert inverse.lo[0] == -math.inf
        assert inverse.hi[0] == math.inf
        nothing = one(0.0, 0.0) * inverse
        assert abs(nothing.lo[0]) < 1e-299
        assert abs(nothing.hi[0]) < 1e-299
        assert (inverse + inverse).hi[0] == math.inf


def test_largest_finds_a_tight_bound() -> None:
    """x - x^2 on [0, 1] is at most 1/4; its interval evaluation gives 1."""
    search = Search(0.2501, 2000)
    found = largest({"x": Interval(0, 1)}, ["x"], lambda b: (b["x"] - b["x"].square()).hi, search)
    assert 0.25 <= found <= 0.2502


def test_climb_finds_a_peak() -> None:
    start = {"x": np.linspace(0, 1, 5)}
    points, heights = climb(
        climbing({"x": Interval(0, 1)}, start, climbers=4, rounds=60), lambda p: -np.abs(p["x"] - 0.7123)
    )
    assert abs(points["x"][int(np.argmax(heights))] - 0.7123) < 1e-3


def planned(folder: Path, text: str, target: str = "fixed24") -> Plan:
    path = folder / "problem.yaml"
    path.write_text(text, encoding="utf-8")
    return plans.planned(path, target=target, effort=0.1)


SMALL = """\
name: small
clock_hz: 1000000
format: {kind: fixed-point, width: 8, guard: 1, rounding: half-up}
units:
  standard: {latency: 20, functions: [rotate-circular, rotate-linear, rotate-hyperbolic, vector-circular,
             vector-linear, vector-hyperbolic, lightcone], area: 1,
             arithmetic: {mantissa_bits: 21, exponent_bits: 10, angle_bits: 17, iterations: 16}}
  implicit: {latency: 20, functions: [implicit-circular, implicit-hyperbolic], area: 1,
             arithmetic: {mantissa_bits: 21, exponent_bits: 10, angle_bits: 17, iterations: 16,
             rule: single-rotation}}
  add: {latency: 1, functions: [add, sub, min, max, select, wrap], area: 1}
  mul: {latency: 1, functions: [mul], area: 1}
  cmul: {latency: 1, functions: [cmul], area: 1}
  shift: {latency: 0, functions: [shift], area: 0}
  sign: {latency: 0, functions: [neg, abs, flip, sign, guard], area: 0}
"""

TINY = """\
inputs: {x: [-0.9, 0.9], y: [0.1, 0.9]}
equations:
  - a = atan2(y, x)
  - b = (x + 2*y) / (y + 0.7)
  - c = sqrt(x**2 + y) * cos(3*a)
  - d = max(abs(x), y) - min(x*y, 0.3)
  - e = asinh(x) + y*exp(x)
  - f = acos(x*y)
outputs: [a, b, c, d, e, f]
"""


@pytest.mark.exhaustive(
    reason="all words of a format; quick ones run samples of plans and of their own bounds"
)
def test_no_input_of_a_small_format_is_beyond(tmp_path: Path) -> None:
    """Every pair of 8-bit words, and of the points half-way between them."""
    target = tmp_path / "small.yaml"
    target.write_text(SMALL, encoding="utf-8")
    plan = planned(tmp_path, TINY, str(target))
    bounds = bounds_of(plan)
    grids = []
    for item in plan.problem.inputs:
        half = math.ldexp(1.0, -plan.formats.values[item.name].fraction - 1)
        grids.append(np.arange(math.ceil(item.lo / half), math.floor(item.hi / half) + 1) * half)
    columns = np.meshgrid(*grids)
    points = {name: c.ravel() for name, c in zip(plan.problem.input_names, columns, strict=True)}
    simulated = functional.run(plan, plan.arithmetic, points)
    some = {name: column[::7] for name, column in points.items()}
    values, defined = exact(plan.problem, some)
    for output, bound in bounds.items():
        assert bound.value is not None, output
        held = inside(network(plan), {output: bound.where}, some)[output] & simulated["valid"][::7] & defined
        assert held.mean() > 0.9
        error = np.abs(simulated[output][::7] - values[output])[held]
        assert error.max() <= bound.value
        assert bound.value <= 12 * error.max()


SINGULAR = """\
inputs: {x: [-1, 1], y: [-1, 1], z: [-1, 1]}
equations:
  - a = atan2(y, x)
  - b = z / hypot(x, y)
outputs: [a, b]
"""


def test_bounds_of_singular_outputs_say_where(tmp_path: Path) -> None:
    plan = planned(tmp_path, SINGULAR)
    net, bounds = network(plan), bounds_of(plan)
    points = sampling.draw(plan.problem.workspace, 2000, 5)
    points["x"][:50] *= 1e-6
    points["y"][:50] *= 1e-6
    simulated = functional.run(plan, plan.arithmetic, points)
    values, _ = exact(plan.problem, points)
    for output, bound in bounds.items():
        assert bound.where
        held = inside(net, {output: bound.where}, points)[output] & simulated["valid"]
        assert not held[:50].any()
        assert held[50:].mean() > 0.98
        error = np.abs(simulated[output] - values[output])
        if output == "a":
            error = np.minimum(error, np.abs(error - math.tau))
        assert error[held].max() <= bound.value


def test_a_choice_at_a_switch_is_counted_or_excluded(tmp_path: Path) -> None:
    text = "inputs: {x: [-1, 1], y: [0.5, 1]}\nequations:\n  - d = x - y/3\n  - a = y*sign(d)\noutputs: [a]\n"
    plan = planned(tmp_path, text)
    bound = bounds_of(plan)["a"]
    x = np.linspace(-1, 1, 4001)
    points = {"x": x, "y": np.clip(3 * x, 0.5, 1)}
    simulated = functional.run(plan, plan.arithmetic, points)
    values, defined = exact(plan.problem, points)
    held = inside(network(plan), {"a": bound.where}, points)["a"] & simulated["valid"] & defined
    assert bound.value is not None
    assert np.abs(simulated["a"] - values["a"])[held].max() <= bound.value


JUMPS = ("sign", "wrap")
"""Their derivatives say nothing of where they jump."""


@pytest.mark.parametrize(
    ("op", "params"), [case for case in cases(Level.ARITHMETIC, Level.UNIT) if case[0] not in JUMPS]
)
def test_values_and_derivatives(op: str, params: tuple) -> None:
    """Against differences of the reference evaluation."""
    graph = graph_of(op, params)
    count, results = OPS[op].arity, range(len(OPS[op].results))
    columns = np.random.Generator(np.random.PCG64(7)).uniform(-1.5, 1.5, (count, 400))
    if op == "vector" and params[0] == -1:
        columns[1] *= 0.6 * np.abs(columns[0])
    named = OPS[op].named(params)
    factor = Constant(Interval(*[float(params[0])] * 2), 0.0) if op == "cmul" else None
    step = Step(
        "o1", op, named, "e", Cau(rule="single-rotation"), tuple(f"x{k}" for k in range(count)),
        tuple(f"r{k}" for k in results), (SINGLE,) * len(results),
        factor, (False,) * len(results), False, 0.0, (0.0,) * len(results),
    )  # fmt: skip
    w = [Boxes(column, column) for column in columns]
    with np.errstate(all="ignore"):
        found = local(step, w, margin_square(step, w), [np.zeros(400)] * count)
    middle, valid = reference_outputs(graph, dict(zip((f"x{k}" for k in range(count)), columns, strict=True)))
    assert valid.sum() > 50
    for port in range(count):
        ends = []
        for side in (1, -1):
            moved = columns.copy()
            moved[port] += side * 2.0**-20
            values, fine = reference_outputs(graph, {f"x{k}": moved[k] for k in range(count)})
            valid &= fine
            ends.append(values)
        for k in results:
            slope = (ends[0][f"r{k}"] - ends[1][f"r{k}"]) * 2.0**19
            partial = found.partials[k][port]
            near = valid & (np.abs(slope) < 10)
            assert near.sum() > 50
            off = np.maximum(partial.lo - slope, slope - partial.hi)[near]
            assert np.quantile(off, 0.97) < 1e-6
    for k in results:
        value, number = found.values[k], middle[f"r{k}"]
        turn = math.tau if named.get("m") == 1 and op in ("vector", "implicit") else math.inf
        low, high = (value.lo - number)[valid], (number - value.hi)[valid]
        wrapped = np.isfinite(turn) & (np.abs(number[valid] - value.lo[valid]) > 3)
        assert np.all((np.maximum(low, high) <= 1e-12) | wrapped)


def test_own_bounds_hold_for_each_sample(tmp_path: Path) -> None:
    plan = planned(tmp_path, TINY)
    net = network(plan)
    points = sampling.draw(plan.problem.workspace, 500, 3)
    simulated = functional.run(plan, plan.arithmetic, points)
    values, _ = exact(plan.problem, points)
    columns = {name: Boxes(column, column) for name, column in points.items()}
    for output in net.outputs:
        steps = net.upstream(output)
        own = errors(net, steps, output, forward(net, steps, columns, {}))
        held = simulated["valid"]
        assert np.all(np.abs(simulated[output] - values[output])[held] <= own[held])


def test_exact_enclosures_hold_the_reference(tmp_path: Path) -> None:
    plan = planned(tmp_path, TINY)
    net = network(plan)
    points = sampling.draw(plan.problem.workspace, 200, 4)
    values, _ = exact(plan.problem, points)
    columns = {name: Boxes(column, column) for name, column in points.items()}
    for output, source in net.outputs.items():
        box, _ = forward(net, net.upstream(output), columns, {}, exact=True).operand(source)
        assert np.all((box.lo <= values[output]) & (values[output] <= box.hi))
        assert np.max(box.hi - box.lo) < 1e-11


def test_a_plan_states_and_judges_its_bounds(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(TINY.replace("[a, b, c, d, e, f]", "[b, c]"), encoding="utf-8")
    plan = plans.compiled(path, target="fixed24", effort=0.1)
    for figures in plan.accuracy.values():
        bound = figures.bound
        assert bound is not None
        assert figures.observed.max is not None
        assert figures.observed.max <= bound.value
        assert bound.share_of_samples == 1
        assert bound.where
    stated = StatedBounds.of(plan)
    assert stated is not None
    held = stated.inside(sampling.draw(plan.problem.workspace, 10_000, 3))
    assert set(held) == set(plan.outputs)
    assert all(inside.all() for inside in held.values())
    path.write_text("inputs: {x: [0.5, 1]}\nequations: ['a = 3*x']\n", encoding="utf-8")
    assert plans.compiled(path, target="fixed24").accuracy["a"].bound is not None
    assert plans.compiled(path, target="fixed24", certify=False).accuracy["a"].bound is None


ALLOWED = """\
inputs: {{x: [0.3, 0.9], y: [0.1, 0.9]}}
equations:
  - a = atan2(y, x)
  - r = hypot(x, y)
outputs: {{a: {{max_error: {}}}, r: }}
"""


@pytest.mark.parametrize(("error", "width"), [slow(("1e-4", 24)), slow(("1e-6", 24)), ("1e-8", 30)])
def test_max_error_is_met_with_wider_words(tmp_path: Path, error: str, width: int) -> None:
    plan = planned(tmp_path, ALLOWED.format(error))
    bound = bounds_of(plan, {"a": float(error)})["a"]
    assert bound.value is not None
    assert bound.value <= float(error)
    assert not bound.where
    assert plan.arithmetic.system.spec()["width"] == width


def test_max_error_that_no_words_meet(tmp_path: Path) -> None:
    with pytest.raises(Unattainable) as caught:
        planned(tmp_path, ALLOWED.format("1e-12"))
    (found,) = caught.value.diagnostics
    assert found.code == "E413"
    assert "nearest" in str(found.hint)


def test_max_error_on_a_target_with_fixed_words(tmp_path: Path) -> None:
    planned(tmp_path, ALLOWED.format("1e-5"), "kinematic")
    with pytest.raises(Unattainable):
        planned(tmp_path, ALLOWED.format("1e-8"), "kinematic")


def test_conditions_are_met_by_what_is_wanted(tmp_path: Path) -> None:
    text = "inputs: {x: [-1, 1], y: [-1, 1]}\nequations: ['a = atan2(y, x)']\n"
    text += "outputs: {a: {max_error: 1e-4}}\n"
    bound = bounds_of(planned(tmp_path, text), {"a": 1e-4})["a"]
    assert bound.value is not None
    assert bound.value <= 1e-4
    assert {p.kind for p in bound.where} <= {OWN_BOUND, "norm"}


def test_twins_share_a_proof(tmp_path: Path) -> None:
    (tmp_path / "legs.yaml").write_text(SINGULAR, encoding="utf-8")
    plan = plan_file(tmp_path / "legs.yaml", Options("fixed24", copies=2)).plan
    net, bounds = network(plan), bounds_of(plan)
    alike = twins(net, {})
    assert len(alike.representatives(net).steps) < len(net.steps)
    assert twins(net, {"b_2": 1e-5}).of["b_2"] == "b_2"
    for name in ("a", "b"):
        first, second = bounds[f"{name}_1"], bounds[f"{name}_2"]
        assert alike.of[f"{name}_2"] == f"{name}_1"
        assert first.value == second.value is not None
        assert [p.threshold for p in first.where] == [p.threshold for p in second.where]
        margins = [p for p in second.where if p.kind != OWN_BOUND]
        assert {p.operation for p in margins} <= {step.id for step in net.upstream(f"{name}_2")}
        assert all("y_2" in p.text and "y_1" not in p.text for p in margins)
