"""Poles at the ends of ranges, on whichever side the rounding of an end falls, and what is none."""

from pathlib import Path

import pytest

from cordicc.base.diagnostics import Source
from cordicc.frontend.domain import check_domain
from cordicc.frontend.load import parse_problem
from tests.support.command_line import run


def found(a: str, expression: str) -> list[tuple[str, str]]:
    """Return the codes and messages of what is found in `y = b*(expression)`, `b` in [1, 2]."""
    text = f"inputs: {{a: {a}, b: [1, 2]}}\nequations: ['y = b*({expression})']\n"
    loaded = parse_problem(Source("t.yaml", text))
    return [(d.code, d.message) for d in check_domain(loaded.problem, loaded.source)]


@pytest.mark.parametrize(
    ("a", "expression", "pole"),
    [
        ("[-90 deg, 90 deg]", "tan(a)", "a pole of tan"),
        ("[0, pi/2]", "tan(a)", "a pole of tan"),
        ("[-270 deg, -91 deg]", "tan(a)", "a pole of tan"),
        ("[91 deg, 270 deg]", "tan(a)", "a pole of tan"),
        ("[0, 45 deg]", "tan(2*a)", "a pole of tan"),
        ("[0, 1]", "1/a", "a division by 0"),
        ("[-1, 0]", "a**-1", "a division by 0"),
        ("[0, 0.3]", "1/(a - 0.3)", "a division by 0"),
        ("[0, 0.7]", "1/(0.3 + 0.4 - a)", "a division by 0"),
        ("[0.1, 1]", "1/sqrt(a - 0.1)", "a division by 0"),
        ("[0, 180 deg]", "cos(a)/sin(a)", "a division by 0"),
        ("[0, 90 deg]", "1/(1 - sin(a))", "a division by 0"),
        ("[-1, 1]", "atanh(a)", "a pole of atanh"),
        ("[0, 90 deg]", "atanh(sin(a))", "a pole of atanh"),
        ("[0, 1]", "log(a)", "a pole of log"),
        ("[0, 90 deg]", "log(cos(a))", "a pole of log"),
    ],
)
def test_a_pole_at_an_end(a: str, expression: str, pole: str) -> None:
    assert found(a, expression) == [("W321", f"the range of the inputs ends at {pole}")]


def test_an_end_whose_rounding_is_beyond_the_pole() -> None:
    # 0.3 as a double is less: the pole is inside.
    assert found("[0.3, 1]", "1/(a - 0.3)") == [("W321", "the range of the inputs holds a division by 0")]


@pytest.mark.parametrize(
    ("a", "expression"),
    [
        ("[1e-12, 1]", "1/a"),
        ("[1e-12, 1]", "log(a)"),
        ("[-89.9999 deg, 89.9999 deg]", "tan(a)"),
        ("[-0.999999, 0.999999]", "atanh(a)"),
        ("[0, 1]", "1/(a + 1e-9)"),
        ("[0, 1]", "sqrt(a) + log(a + 1)"),
        ("[-1, 1]", "acos(a)"),
        ("[1, 710]", "1/exp(a)"),
        ("[-300, 300]", "1/cosh(a)"),
        ("[1, 1e9]", "a**-8"),
    ],
)
def test_no_pole(a: str, expression: str) -> None:
    assert found(a, expression) == []


@pytest.mark.parametrize(
    ("a", "expression"),
    [
        ("[0, 2]", "acos(a)/(a - 2)"),
        ("[-1, 3]", "sqrt(a - 1)/a"),
        ("[-1, 1]", "log(a)"),
        ("[-1, 0]", "a**-0.5 + sqrt(a + 1/2)"),
    ],
)
def test_a_pole_among_inputs_without_a_value_is_not_told(a: str, expression: str) -> None:
    assert [code for code, _ in found(a, expression)] == ["W320"]


def test_a_domain_that_ends_and_a_pole_are_both_told() -> None:
    assert [code for code, _ in found("[0, 2]", "acos(a)/a")] == ["W320", "W321"]


def test_facts_keep_inputs_from_a_pole() -> None:
    text = "inputs: {a: [0, 1], b: [1, 2]}\nassume: [a > 1/4]\nequations: ['y = b/a']\n"
    loaded = parse_problem(Source("t.yaml", text))
    assert check_domain(loaded.problem, loaded.source) == []


def test_ranges_as_wide_as_numbers_go() -> None:
    assert found("[-1e300, 1e300]", "1/a") == [("W321", "the range of the inputs holds a division by 0")]
    assert found("[0, 1e300]", "1/a") == [("W321", "the range of the inputs ends at a division by 0")]


@pytest.mark.parametrize("target", ["kinematic", "fixed24"])
def test_it_is_told_whether_or_not_there_is_a_plan(target: str, tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text("inputs: {a: [-90 deg, 90 deg]}\nequations: ['t = tan(a)']\n", encoding="utf-8")
    result = run("compile", path, "--target", target, "-o", tmp_path / "out", "--effort", 0.1)
    assert result.exit_code == (1 if target == "fixed24" else 0)
    assert "warning[W321]: the range of the inputs ends at a pole of tan" in result.stderr
    assert ("error[E412]" in result.stderr) is (target == "fixed24")


@pytest.mark.parametrize(
    ("a", "expression", "where"),
    [
        ("[-3, 7]", "1/a", "a = 0,"),
        ("[-1, 1]", "1/(a - 0.25)", "a = 0.25,"),
        ("[-1e-9, 2e-9]", "1/(a - 1e-9)", "a = 1e-09,"),
    ],
)
def test_the_place_of_a_pole_has_no_more_digits_than_it_needs(a: str, expression: str, where: str) -> None:
    text = f"inputs: {{a: {a}, b: [1, 2]}}\nequations: ['y = b*({expression})']\n"
    loaded = parse_problem(Source("t.yaml", text))
    (warning,) = check_domain(loaded.problem, loaded.source)
    assert f" {warning.hint}".startswith(f" near {where}")
