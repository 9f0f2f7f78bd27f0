"""Ranges up to those of doubles, and beyond: a diagnostic on every target, no traceback and no warning."""

from pathlib import Path

import pytest

import cordicc
from cordicc.arith.numbers.fixed_system import FixedSystem
from cordicc.base.diagnostics import InvalidInput, Unattainable
from cordicc.ir.meaning.exact import Fraction
from cordicc.pipeline import Options, compile_file
from tests.support.selection import quick

TARGETS = ["fixed24", "kinematic"]
PROBLEMS = {
    "exponential": ("[1, 710]", "exp(x)"),
    "reciprocal": ("[1, 700]", "1/exp(x)"),
    "pole": ("[0.001, 0.01]", "cosh(1/x)"),
    "largest-cosh": ("[1, 709.7]", "cosh(x)"),
    "cube": ("[1, 1e300]", "(x/0.5)**3"),
    "large-constant": ("[-700, 3]", "1e200 + 0*x"),
    "unbounded-derivative": ("[-1e3, 1e20]", "tanh(x)*(2*x)"),
    "power-of-power": ("[-88, 1e5]", "((x/1e-200)**10)**(-10)"),
}
CASES = [(name, target) for name in PROBLEMS for target in TARGETS]
QUICK = [(name, "fixed24") for name in ("pole", "cube")] + [("power-of-power", "kinematic")]


@pytest.mark.parametrize(("name", "target"), quick(CASES, *QUICK))
def test_a_diagnostic_or_a_plan(name: str, target: str, tmp_path: Path) -> None:
    ends, expression = PROBLEMS[name]
    path = tmp_path / "problem.yaml"
    path.write_text(f"inputs: {{x: {ends}}}\nequations: ['w = {expression}']\n", encoding="utf-8")
    try:
        plan = compile_file(path, Options(target, certify=True)).plan
    except (InvalidInput, Unattainable) as error:
        codes = {each.code for each in error.diagnostics}
        assert codes <= {"E410", "E411", "E412"}, codes
    else:
        assert plan.accuracy["w"].observed.max is not None


def test_what_no_double_holds_is_told_in_words(tmp_path: Path) -> None:
    path = tmp_path / "problem.yaml"
    path.write_text("inputs: {x: [1, 710]}\nequations: ['w = 1/exp(x)']\n", encoding="utf-8")
    with pytest.raises(Unattainable) as raised:
        cordicc.compile(path, target="fixed24")
    (refusal,) = raised.value.diagnostics
    assert refusal.code == "E412"
    assert refusal.message == "no fixed-point format holds a value that may be beyond 1e+308"


@pytest.mark.parametrize("width", [23, 24, 29, 30])
def test_a_constant_beside_the_middle_of_two_words_has_a_text(width: int) -> None:
    """The nearest double is the middle, which is rounded to even; the number itself is not."""
    system = FixedSystem(width)
    middle = Fraction(2 * (1 << (width - 2)) + 1, 2)
    for number in (middle + Fraction(1, 1 << 90), middle - Fraction(1, 1 << 90)):
        words, _ = system.constant(system.constant_text(number))
        assert int(words) == round(number)


ROUNDED = {
    "a denominator of 0 but for rounding": (
        "inputs: {x: [-1, 1]}\nequations:\n"
        "  - solve: cos(acos(x))*cos(q) + exp(x)*sin(q) = x\n    for: q\n    branch: '-'\n  - w = 1/q\n",
        5,
    ),
    "a pole for all inputs": (
        "inputs: {x: [-4, -1]}\nequations:\n  - v = acosh(atanh(cos(x)**2 + sin(x)**2))\n"
        "  - solve: cos(x)*cos(w) + x*sin(w) = sign(v)\n    for: w\n    branch: sin(w) < 0\n"
        "outputs: [v, w]\n",
        1,
    ),
    "terms of a polynomial": (
        "inputs: {x: [0.25, 0.75]}\nequations:\n"
        "  - solve: ['x*x*cos(a) + (0.35 + x)*sin(a) = sqrt(0.7)*sqrt(0.7)', "
        "'x*cos(a) + x*sin(a) = sqrt(x*3)*sqrt(3)']\n    for: a\n"
        "  - u = tanh(tan(atan2(pi, a)))\n"
        "  - solve: (x - a)*cos(b) + a**0.5*sin(b) = a*2\n    for: b\n    branch: b < 0\n"
        "  - solve: cos(b)*cos(w) + b*sin(w) = sqrt(a)**2\n    for: w\n    branch: '+'\noutputs: [u, w]\n",
        1,
    ),
}


@pytest.mark.parametrize("name", list(ROUNDED))
def test_what_rounding_makes_of_the_largest_doubles_is_no_warning(name: str, tmp_path: Path) -> None:
    text, interval = ROUNDED[name]
    path = tmp_path / "problem.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(Unattainable) as raised:
        cordicc.compile(path, target="fixed24", ii=interval, effort=0.05)
    assert raised.value.diagnostics[0].code in ("E410", "E412")
