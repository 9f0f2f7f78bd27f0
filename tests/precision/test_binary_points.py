"""Ranges, tightened and contracted; binary points; guard bits; what a fixed-point target refuses."""

import math
from pathlib import Path

import numpy as np
import pytest

import cordicc
from cordicc.arith.numbers.formats import BinaryPoint
from cordicc.base.diagnostics import Unattainable
from cordicc.ir.graph import Graph, Value
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.ranges.contraction import contracted
from cordicc.ir.ranges.forward import value_ranges
from cordicc.ir.ranges.subdivision import Tightness, tightened
from cordicc.ir.text import parse_graph
from cordicc.pipeline import read_problem, rewrite
from cordicc.precision.binary_points import magnitudes
from cordicc.targets.target_file import load_target
from tests.support.corpus import LITTLE
from tests.support.paths import CORPUS
from tests.support.plans import compiled, planned
from tests.support.selection import quick, slow

DIFFERENCE = "%0 = input[name=x]\n%1 = mul(%0, %0)\n%2 = sub(%1, %0)\noutput y = %2\n"
UNIT = {"x": Interval(-1.0, 1.0)}


def graph_of(text: str) -> Graph:
    return parse_graph(text, "test")


def problem_file(folder: Path, text: str) -> Path:
    path = folder / "problem.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_difference_of_dependent_values_is_tightened() -> None:
    graph = graph_of(DIFFERENCE)
    inputs = {"x": Interval(0.0, 1.0)}
    loose = value_ranges(graph, inputs)
    assert loose[2][0] == Interval(-1.0, 1.0)
    tight = tightened(graph, loose, {Value(2): Tightness(0.25)}, 10_000)[2][0]
    assert tight is not None
    assert -0.26 < tight.lo <= -0.25
    assert 0.0 <= tight.hi < 0.26


def test_a_divisor_is_tightened_away_from_zero() -> None:
    graph = graph_of(
        "%0 = input[name=x]\n%1 = mul(%0, %0)\n%2 = sub(%1, %0)\n"
        "%3 = const[value=1/2]\n%4 = add(%2, %3)\noutput y = %4\n"
    )
    loose = value_ranges(graph, {"x": Interval(0.0, 1.0)})
    tight = tightened(graph, loose, {Value(4): Tightness(0.5, 1, 0.125)}, 10_000)[4][0]
    assert tight is not None
    assert tight.lo >= 0.125


def test_no_work_leaves_enclosures_as_they_are() -> None:
    graph = graph_of(DIFFERENCE)
    loose = value_ranges(graph, UNIT)
    assert tightened(graph, loose, {Value(2): Tightness(0.25)}, 0) == loose


def test_an_implicit_equation_bounds_its_target_and_what_that_is_made_of() -> None:
    graph = graph_of(
        "%0 = input[name=x]\n%1 = input[name=y]\n%2 = const[value=1]\n%3 = const[value=0]\n"
        "%4 = add(%0, %1)\n%5:2 = implicit[m=1, branch=-](%2, %3, %4)\noutput t = %5#0\n"
    )
    loose = value_ranges(graph, {"x": Interval(-10.0, 10.0), "y": Interval(-0.5, 0.5)})
    narrow = contracted(graph, loose)
    assert narrow[4][0] == Interval(-1.0, 1.0)
    x = narrow[0][0]
    assert x is not None
    assert Interval(-1.5, 1.5).intersect(x) == x.intersect(Interval(-1.5, 1.5))
    assert x.magnitude <= 1.5 + 1e-9


@pytest.mark.parametrize(
    "name",
    [
        "planar_2r_solve",
        slow("catenary_two_supports"),
        slow("double_wishbone_2d"),
        slow("humanoid_leg_6dof"),
        "lorentz_boost",
    ],
)
def test_contracted_and_tightened_enclosures_hold_every_valid_sample(name: str) -> None:
    from cordicc.ir.problem import input_intervals
    from cordicc.ir.sampling import draw_with_corners

    loaded = read_problem(CORPUS / f"{name}.yaml")
    graph = rewrite(loaded.problem, load_target("fixed24"), implicit=True, goal="processors").graph
    values = sorted(graph.used_results())
    samples = draw_with_corners(loaded.problem.workspace, 300)
    columns, valid = reference_outputs(Graph(graph.nodes, {str(i): v for i, v in enumerate(values)}), samples)
    goals = {v: Tightness(float(np.max(np.abs(columns[str(i)][valid])))) for i, v in enumerate(values)}
    enclosures = contracted(graph, value_ranges(graph, input_intervals(loaded.problem)))
    enclosures = tightened(graph, enclosures, goals, 20_000)
    for i, value in enumerate(values):
        interval = enclosures[value.node][value.result]
        column = columns[str(i)][valid]
        assert interval is not None
        assert interval.lo - 1e-12 <= column.min()
        assert column.max() <= interval.hi + 1e-12


def test_formats_hold_the_proven_range_and_no_more() -> None:
    plan = planned(CORPUS / "planar_2r.yaml", target="fixed24", effort=LITTLE)
    guard = plan.arithmetic.spec["format"]["guard"]
    assert plan.formats.outputs == dict.fromkeys(("q1", "q2"), BinaryPoint(24, 21))
    inputs = {item.name: item for item in plan.problem.inputs}
    for name, spec in plan.formats.values.items():
        assert spec.width in (24, 24 + guard)
        if name in inputs:
            largest = max(abs(inputs[name].lo), abs(inputs[name].hi))
            assert spec.width == 24
            assert largest * 2.0**spec.fraction <= 2**23 - 1 < largest * 2.0 ** (spec.fraction + 1)
    for fifo in plan.fifos:
        assert fifo.width == plan.formats.values[fifo.value].width


def test_an_unbounded_value_is_refused_with_an_input(tmp_path: Path) -> None:
    text = "inputs: {x: [-1, 1], y: [0.1, 1]}\nequations:\n  - q = y/x\n  - t = atan(q) + q\n"
    with pytest.raises(Unattainable) as caught:
        cordicc.compile(problem_file(tmp_path, text), target="fixed24")
    (found,) = caught.value.diagnostics
    assert found.code == "E412"
    assert found.span is not None
    assert found.span.line == 3
    assert found.hint is not None
    assert "at x = " in found.hint
    assert caught.value.exit_status == 1


@pytest.mark.exhaustive(reason="eight seconds for a problem of which no smaller example is known")
def test_a_range_that_is_not_proven_is_told() -> None:
    # b never vanishes where the second equation has a solution, which no rule of ours sees.
    loaded = read_problem(CORPUS / "franka_panda_q7.yaml")
    graph = rewrite(loaded.problem, load_target("fixed24"), implicit=True, goal="processors").graph
    found = magnitudes(loaded.problem, loaded.source, graph)
    assert found.warnings
    assert {w.code for w in found.warnings} == {"W412"}
    assert all(w.span is not None and w.hint for w in found.warnings)


@pytest.mark.exhaustive(reason="compiles two chains; fixed24 chooses guard bits for each quick plan too")
def test_guard_bits_follow_the_length_of_the_chain() -> None:
    plain = compiled(CORPUS / "magnetic_encoder.yaml", target="fixed24")
    chained = compiled(CORPUS / "planar_3r.yaml", target="fixed24")
    guards = [plan.arithmetic.spec["format"]["guard"] for plan in (plain, chained)]
    assert guards[0] < guards[1]
    for plan in (plain, chained):
        for name, spec in plan.formats.outputs.items():
            assert plan.accuracy[name].observed.max <= 2 * math.ldexp(1.0, -spec.fraction), name


@pytest.mark.parametrize("guard", [0, 3, 6])
def test_units_are_sized_for_the_words_between_operations(guard: int) -> None:
    target = load_target("fixed24", guard)
    assert target.guard_is_open
    caus = target.machine().caus
    for kind, cau in caus.items():
        unit = target.units[kind]
        assert cau.operand_bits == 24 + guard
        assert unit.stages["iterations"] == cau.iterations
        assert unit.latency == sum(unit.stages.values())
    assert load_target("fixed24", 0).units["standard"].area < load_target("fixed24", 6).units["standard"].area


def test_a_fixed_point_plan_reads_back_and_refuses_other_formats(tmp_path: Path) -> None:
    import json

    from cordicc.base.diagnostics import InvalidInput

    plan = planned(CORPUS / "planar_2r.yaml", target="fixed24", effort=LITTLE)
    path = tmp_path / "plan.json"
    path.write_text(plan.to_json(), encoding="utf-8")
    again = cordicc.load_plan(path)
    samples = {"x": [0.3, 0.4, 9.0], "y": [0.1, 0.2, 0.1]}
    before, after = plan.simulate(samples), again.simulate(samples)
    assert all(before[name].tobytes() == after[name].tobytes() for name in before)
    assert before["valid"].tolist() == [True, True, False]
    data = json.loads(plan.to_json())
    for change in ({"width": 25, "fraction": 21}, {"width": 24, "fraction": 5000}, None):
        if change is None:
            del data["formats"]["outputs"]["q1"]
        else:
            data["formats"]["outputs"]["q1"] = change
        path.write_text(json.dumps(data), encoding="utf-8")
        with pytest.raises(InvalidInput, match=r"contradicts|E60"):
            cordicc.load_plan(path)


@pytest.mark.parametrize(
    ("inputs", "equations", "codes"),
    [
        ("{x: [1, 2], unused: [0, 3]}", ["a = x + 1"], set()),
        ("{x: [-1, 0], y: [0.1, 0.4]}", ["a = y/x"], {"E412"}),
        ("{y: [-3, -1]}", ["a = atanh(y*y)"], set()),  # valid nowhere, but that is not proven at y = -1
        ("{x: [0, 1], y: [1, 2]}", ["a = y/y", "b = x"], set()),
        ("{x: [-1e60, 1e60]}", ["y = x/1e60"], {"E412"}),
        ("{x: [1, 100]}", ["y = exp(x)*exp(x)"], {"E412"}),
        ("{x: [1, 2], unused: [-1e300, 1e300]}", ["y = x"], set()),
        ("{x: [0, 1]}", ["a = 1e60", "b = x"], {"E412"}),
        ("{x: [-1, 1], y: [-1, 1]}", ["q = 1/(x**2 + y**2 + 2*x*y + 1e-4)"], set()),
        ("{x: [0, 1], y: [0, 0]}", ["q = x + y"], set()),
    ],
)
def test_odd_problems(tmp_path: Path, inputs: str, equations: list[str], codes: set[str]) -> None:
    from cordicc.base.diagnostics import CordiccError

    lines = "".join(f"  - {equation}\n" for equation in equations)
    path = problem_file(tmp_path, f"inputs: {inputs}\nequations:\n{lines}")
    found: set[str] = set()
    try:
        plan = cordicc.compile(path, target="fixed24", effort=0.1)
        assert set(plan.formats.values) >= set(plan.problem.input_names)
    except CordiccError as error:
        found = {d.code for d in error.diagnostics}
    assert found == codes


def test_samples_without_a_solution_stay_invalid(tmp_path: Path) -> None:
    text = (
        "inputs: {A: [-1, 1], B: [-1, 1], C: [-1, 1]}\nequations:\n"
        "  - {solve: 'B*cos(t) + A*sin(t) = C', for: t, branch: '-'}\n"
    )
    plan = cordicc.compile(problem_file(tmp_path, text), target="fixed24", effort=0.1, certify=False)
    A, B, C = np.random.default_rng(3).uniform(-1, 1, (3, 5000))
    valid = plan.simulate({"A": A, "B": B, "C": C})["valid"]
    radius = np.hypot(A, B)
    assert not valid[np.abs(C) > radius + 1e-6].any()
    assert valid[np.abs(C) < radius - 1e-6].all()


@pytest.mark.parametrize(
    ("inputs", "equation"),
    [
        ("{x: [9e-10, 9.3132e-10], y: [1, 1]}", "t = atan2(x, y)"),
        ("{x: [1e-10, 1e-9], y: [1, 2]}", "t = atan2(x, y)"),
        ("{x: [1e-9, 2e-9], y: [0.5, 1]}", "s = y*sin(x)"),
    ],
)
def test_words_are_not_finer_than_the_units_that_make_them(
    tmp_path: Path, inputs: str, equation: str
) -> None:
    path = problem_file(tmp_path, f"inputs: {inputs}\nequations:\n  - {equation}\n")
    plan = cordicc.compile(path, target="fixed24", effort=0.1, certify=False)
    ((name, spec),) = plan.formats.outputs.items()
    assert plan.accuracy[name].observed.max <= 2 * math.ldexp(1.0, -spec.fraction)


@pytest.mark.parametrize("width", quick([10, 16, 26, 28], 28))
@pytest.mark.parametrize("rounding", ["half-up", slow("half-even"), slow("floor")])
def test_targets_of_other_widths(tmp_path: Path, width: int, rounding: str) -> None:
    from cordicc.targets.target_file import target_text

    text = target_text("fixed24").text.replace("width: 24", f"width: {width}")
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace("rounding: half-up", f"rounding: {rounding}"), encoding="utf-8")
    plan = cordicc.compile(CORPUS / "planar_2r_solve.yaml", target=str(path), effort=0.1, certify=False)
    for name, spec in plan.formats.outputs.items():
        assert spec.width == width
        assert plan.accuracy[name].observed.max <= 6 * math.ldexp(1.0, -spec.fraction)
