"""Domains that simplification keeps, warnings, and what the front end does with many of anything."""

import math

import numpy as np
import pytest

from cordicc.base.diagnostics import Diagnostic, InvalidInput, Report, Source, Span, printable
from cordicc.frontend.load import parse_problem
from cordicc.ir.meaning.doubles import values_of
from cordicc.ir.well_formed import verify

HEAD = "inputs: {x: [-1, 1], y: [1, 2]}\n"


def load(text):
    return parse_problem(Source("t.yaml", text))


def value(problem, name, **inputs):
    nodes = problem.graph.nodes
    points = {name: np.array([float(number)]) for name, number in inputs.items()}
    return values_of(nodes, range(len(nodes)), points)[problem.graph.outputs[name].node][0]


def codes(text):
    try:
        return [d.code for d in load(text).warnings]
    except InvalidInput as error:
        return [d.code for d in error.diagnostics]


@pytest.mark.parametrize("written", ["(1/x)**0", "(2 + 1/x)**(1-1)", "y**((1 - 1)/2)*(1/x)**0"])
def test_zeroth_power_keeps_the_domain(written):
    problem = load(HEAD + f"equations: ['z = {written}']\n").problem
    verify(problem.graph)
    assert [n.params for n in problem.graph.nodes if n.op == "guard"] == [("any",)]
    assert value(problem, "z", x=0.5, y=1.0) == 1
    assert math.isnan(value(problem, "z", x=0.0, y=1.0))


def test_zeroth_power_of_an_input_is_a_constant():
    problem = load(HEAD + "constants: {k: 3}\nequations: [z = x**0 + k**0 + y]\n").problem
    assert not [n for n in problem.graph.nodes if n.op == "guard"]


@pytest.mark.parametrize(
    "equation",
    [
        "(cos(t)/x)**0*y/4 + cos(t) = y/4",
        "0*(cos(t)/x) + cos(t) = y/4",
        "(0*cos(t))/x + cos(t) = y/4",
        "(cos(t) - cos(t))/x + cos(t) = y/4",
    ],
)
def test_solve_keeps_the_domain_of_what_cancels(equation):
    problem = load(HEAD + f'equations: [{{solve: "{equation}", for: t, branch: "+"}}]\n').problem
    verify(problem.graph)
    assert math.isfinite(value(problem, "t", x=0.5, y=1.0))
    assert math.isnan(value(problem, "t", x=0.0, y=1.0))


def test_a_power_that_cancels_is_proven_zero():
    text = HEAD + "equations: [{solve: '((1/x)**0 - 1)*cos(t)**2 + cos(t) = y/4', for: t, branch: '+'}]\n"
    problem = load(text).problem
    assert math.isnan(value(problem, "t", x=0.0, y=1.0))
    assert math.isfinite(value(problem, "t", x=0.5, y=1.0))


@pytest.mark.parametrize("unit", ["deg", "DEG", "degree", "Degrees", "°"])
def test_degrees(unit):
    assert codes(f"inputs: {{x: {{range: [0, 90], unit: {unit}}}}}\nequations: [y = x]\n") == ["W106"]


@pytest.mark.parametrize("unit", ["mm", "rad", "m"])
def test_other_units(unit):
    assert codes(f"inputs: {{x: {{range: [0, 90], unit: {unit}}}}}\nequations: [y = x]\n") == []


@pytest.mark.parametrize(
    ("assumption", "found"),
    [
        ("y > 0", []),
        ("y < 0", ["E222"]),
        ("x < x", ["W108"]),
        ("y >= 2", ["W108"]),
        ("y >= 1", []),
        ("y <= 0.999", ["E222"]),
        ("x**2 + y**2 = 6", ["E222"]),
        ("x**2 + y**2 = 5", ["W108"]),
        ("log(-y) = x", ["E222"]),
        ("1 < 2", []),
        ("1/3 = 2/6", ["W108"]),
    ],
)
def test_assumptions_on_the_ranges(assumption, found):
    assert codes(HEAD + f"equations: [z = x*y]\nassume: ['{assumption}']\n") == found


def test_many_warnings_lose_nothing():
    names = [f"z{i}" for i in range(150)]
    text = HEAD + "equations:\n" + "".join(f"- {n} = x*y\n" for n in names)
    text += "outputs:\n" + "".join(f"  {n}: {{wrap: true}}\n" for n in names)
    loaded = load(text)
    assert [o.name for o in loaded.problem.outputs] == names
    assert {d.code for d in loaded.warnings} == {"W104"}
    with pytest.raises(InvalidInput) as caught:
        load(text + "assume: [q > 0]\n")
    assert "E203" in [d.code for d in caught.value.diagnostics]


def test_rendered_text_is_utf8():
    nasty = "a\ud800b\udfff\x1b"
    source = Source(nasty, nasty)
    shown = Diagnostic("E100", nasty, Span(1, 1, 3), nasty, source=source).render()
    assert shown.encode("utf-8").count(b"a?b??") == 4
    assert printable("\ud83d\ude00") == "??"
    assert codes(nasty) == codes("# \ud800\n" + HEAD) == codes('"\\ud800": 1\n') == ["E105"]


def test_equal_diagnostics_are_recorded_once():
    report = Report()
    for _ in range(3):
        report.error("E100", "a")
        report.warning("W101", "b")
    assert (len(report.diagnostics), report.errors) == (2, 1)
    assert [d.code for d in report.first(1)] == ["E100"]


def test_angles_through_chains():
    text = HEAD + (
        "equations:\n- a = asin(x)/2\n- b = a + y\n- c = 2*b\n- d = c/3\n- e = 3*d - x\n"
        "- f = b + b\n- g = a - b\n- h = sin(c)\n- k = 4*h + e\n- m = y*1\n- n = d + d + d + m\n"
        "outputs: [a, b, c, d, e, f, g, h, k, m, n]\n"
    )
    angles = {o.name for o in load(text).problem.outputs if o.is_angle}
    assert angles == {"c", "e", "f", "k", "n"}
