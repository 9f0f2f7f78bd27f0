"""Coefficients of equations in an unknown, and the corpus against its expected values."""

import csv
import math

import numpy as np
import pytest

from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.frontend.load import load_problem, parse_problem
from cordicc.ir.meaning.doubles import values_of
from cordicc.ir.well_formed import verify
from tests.support.paths import CORPUS

ACCEPTED = sorted(p for p in CORPUS.glob("*.yaml") if not p.stem.startswith("rej_"))
REFUSED = {
    "rej_cyclic": ("E206", 11, "t1 -> t2 -> t1"),
    "rej_degenerate_form": ("E304", 9, "no unknown left"),
    "rej_duplicate": ("E204", 8, "'y' is defined twice"),
    "rej_kepler": ("E301", 9, "'Ea' appears outside sin and cos: the equation is transcendental in Ea"),
    "rej_undefined_symbol": ("E205", 9, "'b' is used before it is defined (line 10)"),
    "rej_unknown_function": ("E114", 7, "unknown function 'erf'"),
}


def load(*equations, inputs="a: [0.5, 1.0], b: [0.2, 0.4], x: [-0.3, 0.3]", constants=""):
    lines = ["name: t", f"constants: {{{constants}}}", f"inputs: {{{inputs}}}", "equations:"]
    lines += [f"  - {e}" for e in equations]
    return parse_problem(Source("t.yaml", "\n".join(lines) + "\n")).problem


def solved(equation, branch="+", **kwargs):
    suffix = f', branch: "{branch}"' if branch else ""
    return load(f'{{solve: "{equation}", for: t{suffix}}}', **kwargs)


def value(problem, name="t", **inputs):
    nodes = problem.graph.nodes
    points = {name: np.array([float(number)]) for name, number in inputs.items()}
    return values_of(nodes, range(len(nodes)), points)[problem.graph.outputs[name].node][0]


def codes(call):
    with pytest.raises(InvalidInput) as caught:
        call()
    return [d.code for d in caught.value.diagnostics]


@pytest.mark.skipif(not ACCEPTED, reason="the corpus is not here")
@pytest.mark.parametrize("path", ACCEPTED, ids=lambda p: p.stem)
def test_corpus_agrees_with_its_expected_values(path):
    problem = load_problem(path).problem
    verify(problem.graph)
    assert [s.name for s in problem.inputs] == [n.params[0] for n in problem.graph.nodes if n.op == "input"]
    nodes = problem.graph.nodes
    inputs = list(csv.DictReader(path.with_name(path.stem + ".inputs.csv").read_text().splitlines()))
    expected = list(csv.DictReader(path.with_name(path.stem + ".expected.csv").read_text().splitlines()))
    points = {name: np.array([float(row[name]) for row in inputs]) for name in inputs[0]}
    values = values_of(nodes, range(len(nodes)), points)
    for spec in problem.outputs:
        wanted, tolerance = (
            np.array([float(row[column]) for row in expected]) for column in (spec.name, "tol_" + spec.name)
        )
        error = values[problem.graph.outputs[spec.name].node] - wanted
        if spec.is_angle:
            error = np.angle(np.exp(1j * error))
        assert np.all(np.abs(error) <= 1e-3 * tolerance + 1e-12)


@pytest.mark.skipif(not ACCEPTED, reason="the corpus is not here")
@pytest.mark.parametrize("stem", REFUSED)
def test_corpus_refusals(stem):
    with pytest.raises(InvalidInput) as caught:
        load_problem(CORPUS / f"{stem}.yaml")
    (diagnostic,) = caught.value.diagnostics
    code, line, text = REFUSED[stem]
    assert diagnostic.code == code
    assert diagnostic.span is not None
    assert diagnostic.span.line == line
    assert text in diagnostic.message


@pytest.mark.parametrize(
    "equation",
    [
        "a*cos(t) + b*sin(t) = x",
        "a*cos(t + b) = x",
        "a*sin(t - b) + b*cos(b - t) = x",
        "a*cos(-t) - sin(t)/b = x/2",
        "2*(a*cos(t) + b*(sin(t) - x)) = x",
        "(cos(t) + a)**2 + (sin(t) - b)**2 = 1.5 + x",
        "cos(2*t) + 2*sin(t)**2 + a*cos(t) = x + 1",
        "cos(t)**2 + sin(t)**2 + a*cos(t) + b*sin(t) = 1 + x",
        "sin(2*t) - 2*sin(t)*cos(t) + a*sin(t) = x",
        "(a + b)**2*cos(t)**2 - (a**2 + 2*a*b + b**2)*cos(t)**2 + a*cos(t) = x",
        "cos(3*t) - 4*cos(t)**3 + 3*cos(t) + a*sin(t + 1) = x",
        "(sin(a)**2 + cos(a)**2 - 1)*sin(t)*cos(t) + a*sin(t) = x",
    ],
)
@pytest.mark.parametrize("branch", ["+", "-"])
def test_root_satisfies_the_equation(equation, branch):
    problem = solved(equation, branch)
    point = {"a": 0.8, "b": 0.3, "x": 0.21}
    root = value(problem, **point)
    left, right = equation.split("=")
    names = {**point, **vars(math), "t": root}
    assert eval(left, names) == pytest.approx(eval(right, names), abs=1e-12)


def test_multiplying_by_minus_one_swaps_the_branches():
    point = {"a": 0.8, "b": 0.3, "x": 0.21}
    plus = value(solved("a*cos(t) + b*sin(t) = x", "+"), **point)
    minus = value(solved("0 - x = -(a*cos(t) + b*sin(t)) - 2*x", "-"), **point)
    other = value(solved("x = a*cos(t) + b*sin(t)", "-"), **point)
    assert math.cos(plus - other) == pytest.approx(1)
    assert math.isfinite(minus)


def test_coefficients_are_in_order_and_kept_as_written():
    graph = solved("(a + x)*cos(t) + b*sin(t) = x").graph
    node = graph.nodes[graph.node(graph.outputs["t"]).operands[0].node]
    A, B, C = (graph.nodes[v.node] for v in node.operands)
    assert (node.op, node.params) == ("solve", (1, "+"))
    assert (A.op, A.params) == ("input", ("b",))
    assert B.op == "add"
    assert (C.op, C.params) == ("input", ("x",))


def test_one_absent_coefficient_is_zero():
    graph = solved("a*cos(t) + (b - b)*sin(t) = x").graph
    node = graph.nodes[graph.node(graph.outputs["t"]).operands[0].node]
    assert graph.constant(node.operands[0]) == 0


def test_a_cancelled_coefficient_keeps_its_domain():
    graph = solved("a*cos(t) + (sqrt(x) - sqrt(x))*sin(t) = b").graph
    assert [n.params for n in graph.nodes if n.op == "guard"] == [("any",)]


@pytest.mark.parametrize(("branch", "param"), [(None, "none"), ("-", "-")])
def test_hyperbolic(branch, param):
    problem = solved("a*cosh(t + b) + 0.1*sinh(t) = x + 2", branch)
    assert [n.params for n in problem.graph.nodes if n.op == "solve"] == [(-1, param)]
    assert not problem.outputs[0].is_angle


def test_pair():
    problem = load('{solve: ["a*cos(t) - b*sin(t) = x", "b*cos(t) + a*sin(t) = 1"], for: t}')
    root = value(problem, a=0.8, b=0.3, x=0.2)
    determinant = 0.8**2 + 0.3**2
    assert root == pytest.approx(math.atan2((0.8 - 0.3 * 0.2) / determinant, (0.8 * 0.2 + 0.3) / determinant))
    assert problem.outputs[0].is_angle
    assert problem.equations[0].text == "solve [a*cos(t) - b*sin(t) = x, b*cos(t) + a*sin(t) = 1] for t"


@pytest.mark.parametrize(
    ("equation", "branch", "code"),
    [
        ("t = cos(t)", "+", "E301"),
        ("tan(t) = x", "+", "E301"),
        ("exp(t) = a", "+", "E301"),
        ("cos(t)**2 = x", "+", "E302"),
        ("cos(2*t) = x", "+", "E302"),
        ("cos(t/2) = x", "+", "E302"),
        ("cos(a*t) = x", "+", "E302"),
        ("a/cos(t) = x", "+", "E302"),
        ("sqrt(cos(t)) = x", "+", "E301"),
        ("cos(t)**0.5 = x", "+", "E302"),
        ("cos(t)*cosh(t) = x", "+", "E303"),
        ("cos(t - t) = x", "+", "E304"),
        ("(a - a)*cos(t) = x", "+", "E304"),
        ("a = x", "+", "E305"),
        ("cos(sin(t)) = x", "+", "E306"),
        ("cos(t) = x", None, "E307"),
        ("cos(t) = x", "*", "E307"),
        ("cosh(t) = x", "*", "E307"),
        ("cos(t)**40 = x", "+", "E302"),
        ("3*cos(t) = 4", "+", "E209"),
    ],
)
def test_refused(equation, branch, code):
    assert codes(lambda: solved(equation, branch)) == [code]


@pytest.mark.parametrize(
    ("pair", "code"),
    [
        ('["cos(t) = x", "2*cos(t) = a"]', "E308"),
        ('["a*cos(t) + b*sin(t) = x", "a**2*cos(t) + a*b*sin(t) = 1"]', "E308"),
        ('["cosh(t) = x", "sinh(t) = a"]', "E303"),
        ('["cos(t) = x"]', "E202"),
    ],
)
def test_refused_pair(pair, code):
    assert codes(lambda: load(f"{{solve: {pair}, for: t}}")) == [code]


@pytest.mark.parametrize(
    ("expression", "angle"),
    [
        ("asin(x)", True),
        ("-2*asin(x) + a", True),
        ("asin(x)/2", False),
        ("asin(x)/2*4", True),
        ("asin(x)/deg", False),
        ("x + (a - atan2(a, b))", True),
        ("a*asin(x)", False),
        ("sin(asin(x))", False),
        ("x + atan2(1, 2)", True),
        ("2*atan2(1, 2)", True),
        ("half*2", True),
        ("half", False),
        ("q - q", False),
    ],
)
def test_angles(expression, angle):
    problem = load("half = asin(x)/2", "q = acos(x)", f"out = {expression} + half - half", "zz = half + q")
    assert next(o.is_angle for o in problem.outputs if o.name == "out") is angle
