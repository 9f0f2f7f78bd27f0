"""Quotients of two small results: where their accuracy ends, told and seen; and quotients that are none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.emulate import vanishing
from cordicc.emulate.observation import compare
from cordicc.plan.stated_accuracy import AccuracyEnd
from tests.support.command_line import run
from tests.support.selection import slow

INPUTS = "inputs: {a: [-1, 1], b: [-1, 1], c: [0, 1], d: [1, 2], e: [0.1, 1], unused: [0, 900]}\n"


def compiled(folder: Path, equations: list[str], target: str, more: str = "") -> cordicc.Plan:
    path = folder / "p.yaml"
    listed = "".join(f"  - {equation}\n" for equation in equations)
    path.write_text(f"{INPUTS}{more}equations:\n{listed}", encoding="utf-8")
    return cordicc.compile(path, target=target, effort=0.1, certify=False)


def ends(plan: cordicc.Plan) -> dict[str, list[AccuracyEnd]]:
    return {name: list(figures.ends) for name, figures in plan.accuracy.items() if figures.ends}


def test_on_floating_point(tmp_path: Path) -> None:
    plan = compiled(
        tmp_path,
        [
            "t = d*sin(a)/a",
            "u = d*(1/b)*tan(b)",
            "v = (1 - cos(c))/c",
            "w = sin(a - 0.3)/(2*a - 0.6)",
            "x = (exp(a*b) - 1)/(a*b)",
            "q = log(d)",
            "z = sin(q)/q",
        ],
        "kinematic",
    )
    found = ends(plan)
    assert set(found) == {"t", "u", "v", "w", "x", "z"}
    assert {name: [end.denominator for end in each] for name, each in found.items()} == {
        "t": ["a"], "u": ["b"], "v": ["c"], "w": [""], "x": [""], "z": ["q"],
    }  # fmt: skip
    assert all(end.worst >= 4 * end.error for each in found.values() for end in each)
    warnings = [text for text in plan.problem.warnings if text.startswith("W418")]
    assert len(warnings) == 6


def test_on_fixed_point(tmp_path: Path) -> None:
    plan = compiled(tmp_path, ["t = (1 - cos(a))/a", "u = sin(b)/b"], "fixed24")
    # The sine of a small word is that word: its quotient keeps its accuracy.
    assert set(ends(plan)) == {"t"}


def test_what_is_said_is_what_is_seen(tmp_path: Path) -> None:
    plan = compiled(tmp_path, ["t = d*sin(a)/a"], "kinematic")
    (end,) = plan.accuracy["t"].ends
    assert end.equation == "equation of 't'"
    others = {name: np.full(4000, 0.5) for name in ("b", "c", "e", "unused")} | {"d": np.full(4000, 1.7)}

    def largest(low: float, high: float) -> float:
        samples = others | {"a": np.geomspace(low, high, 4000)}
        seen = compare(plan, samples, plan.simulate(samples)).observed["t"].max
        assert seen is not None
        return seen

    assert largest(end.below / 8, end.below) > end.error
    assert largest(4 * end.below, 1) <= end.error
    at = {name: np.array([number]) for name, number in end.at.items()}
    assert compare(plan, at, plan.simulate(at)).observed["t"].max == end.worst


@pytest.mark.parametrize("target", [slow("kinematic"), "fixed24"])
def test_quotients_that_keep_their_accuracy(target: str, tmp_path: Path) -> None:
    equations = ["t = d/(a + 2)", "u = a/hypot(a, d)", "v = atan2(sin(a)*b, b)", "w = a*d/a", "x = sin(e)/e"]
    equations += ["y = d/a"] if target == "kinematic" else []  # a pole is no end of accuracy
    assert ends(compiled(tmp_path, equations, target)) == {}


def test_the_error_that_a_problem_allows_counts(tmp_path: Path) -> None:
    plan = compiled(tmp_path, ["t = sin(a)/a"], "kinematic")
    (usual,) = plan.accuracy["t"].ends
    outputs = tuple(replace(output, max_error=1e-2) for output in plan.problem.outputs)
    again, _ = vanishing.with_ends(replace(plan, problem=replace(plan.problem, outputs=outputs)))
    (allowed,) = again.accuracy["t"].ends
    assert allowed.error == 1e-2
    assert allowed.below < usual.below / 100


def test_own_samples_are_all_that_is_looked_at(tmp_path: Path) -> None:
    small = (np.linspace(1, 1.9, 8) * 2.0**-20).tolist()
    rows = [f"{x!r},0.5,0.5,1.5,0.5,1\n" for x in [*np.linspace(0.2, 1, 1000).tolist(), *small]]
    (tmp_path / "s.csv").write_text("a,b,c,d,e,unused\n" + "".join(rows), encoding="utf-8")
    plan = compiled(tmp_path, ["t = d*sin(a)/a", "u = sin(b)/b"], "kinematic", "samples: s.csv\n")
    (end,) = plan.accuracy["t"].ends
    assert small[0] <= end.at["a"] <= small[-1] <= end.below < 2e-6
    assert not plan.accuracy["u"].ends


def test_summary_and_file(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(
        "inputs: {a: [-1, 1], d: [1, 2]}\nequations: ['t = d*sin(a)/a', 'u = t**2']\noutputs: [t, u]"
    )
    result = run("compile", path, "-o", tmp_path / "out", "--effort", 0.1)
    assert (
        "warning[W418]: a quotient of two small results in the equation of 't': where |a| is below"
        in result.stderr
    )
    assert "'t' and 'u' may be wrong by more than" in result.stderr
    assert "\n  accuracy of t, u ends where |a| < 0.00" in result.stdout
    plan = cordicc.load_plan(tmp_path / "out")
    assert plan.accuracy["u"].ends[0].denominator == "a"
    assert plan.to_json() == (tmp_path / "out" / "plan.json").read_text(encoding="utf-8")


def test_denominators_that_are_left_out_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = compiled(tmp_path, ["t = sin(a)/a", "u = sin(b)/b"], "kinematic")
    monkeypatch.setattr(vanishing, "reference_samples", lambda graph: 250)
    again, warnings = vanishing.with_ends(plan)
    assert [warning.code for warning in warnings] == ["W418", "W322"]
    assert "the equation of 'u'" in warnings[1].message
    assert list(ends(again)) == ["t"]
