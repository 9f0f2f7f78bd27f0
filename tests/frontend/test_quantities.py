"""Numbers with a unit wherever they may stand, units of inputs, and warnings of numbers that lack theirs."""

import json
import re
from fractions import Fraction

import pytest

import cordicc
from cordicc.artefacts import artefacts
from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.frontend.load import parse_problem
from cordicc.frontend.reading import option_number
from cordicc.ir.meaning.exact import DEG
from cordicc.ir.text import print_graph

ARM = """\
inputs: {q: [-1, 1], r: [-1, 1]}
equations:
  - dh: {frame: T, convention: standard,
         joints: [{theta: q, d: D, alpha: -A}, {theta: r, a: -D, alpha: A}, {theta: -A, d: D}]}
outputs: [T_px, T_py, T_pz, T_r11]
"""


def warned(text):
    return parse_problem(Source("t.yaml", text)).warnings


def refused(text):
    with pytest.raises(InvalidInput) as caught:
        parse_problem(Source("t.yaml", text))
    return [(d.code, d.hint) for d in caught.value.diagnostics]


def graph(text):
    return print_graph(parse_problem(Source("t.yaml", text)).problem.graph)


@pytest.mark.parametrize(
    ("length", "angle"), [("100 mm", "90 deg"), ("10cm", "0.125 turn"), ("2 in", "1 rad")]
)
def test_tables_of_joints(length, angle):
    number, unit = re.fullmatch(r"([\d.]+) ?(\w+)", angle).groups()
    factor = {"deg": "deg", "turn": "2*pi", "rad": "1"}[unit]
    size = {"100 mm": "0.1", "10cm": "0.1", "2 in": "0.0508"}[length]
    by_hand = ARM.replace("-A", f"-({number}*{factor})").replace("A}", f"{number}*{factor}}}")
    assert graph(ARM.replace("A", angle).replace("D", length)) == graph(by_hand.replace("D", size))


@pytest.mark.parametrize(
    ("item", "same"),
    [
        ('vector: "p = rotate([x, 3 mm, -5cm], z, -90 deg)"',
         'vector: "p = rotate([x, 0.003, -0.05], z, -90*deg)"'),
        ('"p_x = max(x, -250 mm) + sin(- 30 deg)"', '"p_x = max(x, -0.25) + sin(-30*deg)"'),
        ('"p_x = norm([x, +3 mm])"', '"p_x = norm([x, 0.003])"'),
        ('"p_x = 1 in"', '"p_x = 0.0254"'),
        ('solve: "x*cos(p_x) + sin(p_x) = -5 mm"\n    for: p_x\n    branch: p_x > -90 deg',
         'solve: "x*cos(p_x) + sin(p_x) = -0.005"\n    for: p_x\n    branch: p_x > -90*deg'),
    ],
)  # fmt: skip
def test_arguments_components_and_sides(item, same):
    text = "inputs: {x: [-1, 1]}\nequations:\n  - ITEM\noutputs: [p_x]\n"
    assert graph(text.replace("ITEM", item)) == graph(text.replace("ITEM", same))


def test_constants_ranges_errors_facts_and_options():
    problem = parse_problem(
        Source(
            "t.yaml",
            "constants: {a: -90 deg, b: +3 mm}\ninputs: {x: [-20 mm, 1 m]}\nequations: [y = x + a*b]\n"
            "outputs: {y: {max_error: 2 um}}\nassume: [x > -25 mm]\n",
        )
    ).problem
    assert problem.constants == {"a": -90 * DEG, "b": Fraction(3, 1000)}
    assert (problem.inputs[0].lo, problem.inputs[0].hi) == (Fraction(-1, 50), 1)
    assert problem.outputs[0].max_error == Fraction(2, 1_000_000)
    right = problem.assumptions[0].right
    assert problem.facts.graph.constant(right) == Fraction(-1, 40)
    assert option_number("-30 deg", "--z") == -30 * DEG


@pytest.mark.parametrize(
    ("equation", "code"),
    [
        ("y = x*4 cm", "E116"),
        ("y = x + 4 mm", "E116"),
        ("y = x*(4 mm)", "E116"),
        ("y = max(x, 2 kg)", "E223"),
        ("y = max(x, 2 m)", "E116"),  # m is a name here
    ],
)
def test_a_number_with_a_unit_stands_alone(equation, code):
    text = f"constants: {{m: 3}}\ninputs: {{x: [0, 1]}}\nequations: ['{equation}']\n"
    assert [found for found, _ in refused(text)] == [code]


FILE = "constants: {{{constants}}}\ninputs: {{x: {x}, y: [0, 1]}}\nequations: [z = x + y + a]\n"


@pytest.mark.parametrize(
    ("constants", "x"),
    [
        ("a: 260 mm", "{range: [500, 900], unit: mm}"),
        ("a: 26 cm", "{range: [-500, 900], unit: Millimetres}"),
        ("a: 0.26 m", "{range: [50, 90], unit: cm}"),
        ("a: 1, b: -3 in", "{range: [a, 90], unit: inch}"),
        ("a: 1", "{range: [500 mm, 900], unit: mm}"),
        ("a: 1", "[500 mm, 900]"),
        ("a: 1", "{range: [-500, 900 mm], unit: m}"),
        ("a: 1", "[-90, 90 deg]"),
    ],
)
def test_a_number_without_a_unit_beside_numbers_with_one(constants, x):
    found = [d for d in warned(FILE.format(constants=constants, x=x)) if d.code == "W109"]
    assert len(found) == 1
    assert "'x'" in found[0].message


def test_an_empty_range_is_told_with_the_unit_that_lacks():
    text = FILE.format(constants="a: 1", x="[500, 900 mm]")
    assert [code for code, _ in refused(text)] == ["E211", "W109"]


@pytest.mark.parametrize(
    ("constants", "x"),
    [
        ("a: 260", "{range: [500, 900], unit: mm}"),  # all in millimetres
        ("a: 90 deg", "{range: [500, 900], unit: mm}"),  # an angle says nothing of lengths
        ("a: 260 mm", "{range: [0.5, 0.9], unit: m}"),
        ("a: 260 mm", "{range: [0.5, 0.9], unit: N}"),
        ("a: 260 mm", "[100 mm, 0.4]"),
        ("a: 260 mm", "[0, 400 mm]"),
        ("a: 260 mm", "{range: [0, 400 mm], unit: mm}"),
        ("a: 260 mm", "{range: [0.4 m, 500 mm], unit: cm}"),
        ("a: 260 mm", "{range: [-90 deg, 90 deg], unit: deg}"),
    ],
)
def test_no_warning_where_numbers_are_what_they_seem(constants, x):
    assert warned(FILE.format(constants=constants, x=x)) == ()


@pytest.mark.parametrize(
    ("x", "hint"),
    [
        ("{range: [0, 1], unit: turn}", "write the range as [0*2*pi, 1*2*pi]"),
        ("{range: [0, 5 mm], unit: deg}", "write 'unit: mm'"),
    ],
)
def test_labels_that_are_not_the_unit_of_the_numbers(x, hint):
    (found,) = warned(FILE.format(constants="a: 1", x=x))
    assert (found.code, found.hint) == ("W106", hint)


def test_ranges_are_shown_in_the_unit_they_are_given_in(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(
        "inputs:\n  x: {range: [500 mm, 900 mm], unit: mm}\n  a: {range: [0, 90 deg], unit: deg}\n"
        "  y: {range: [500, 900], unit: N}\nequations:\n  - z = x*sin(a) + y + sin(-30 deg)\n"
    )
    plan = cordicc.compile(path, effort=0.1)
    x, a, y = json.loads(plan.to_json())["problem"]["inputs"]
    assert (x["lo"], x["hi"], x["unit"], x["scale"]) == (0.5, 0.9, "mm", 0.001)
    assert (y["lo"], y["unit"], "scale" in y) == (500, "N", False)
    assert a["scale"] == pytest.approx(float(DEG))
    files = artefacts(plan, ["c"])
    assert '<td class="n">500</td><td class="n">900</td><td>mm, samples in m</td>' in files["report.html"]
    assert '<td class="n">0</td><td class="n">90</td><td>deg, samples in rad</td>' in files["report.html"]
    assert '<td class="n">500</td><td class="n">900</td><td>N</td>' in files["report.html"]
    assert "<mn>30</mn><mtext>°</mtext>" in files["report.html"]
    assert "input x: 500.0 to 900.0 mm, samples in m<" in files["datapath.svg"]
    assert "500.0 to 900.0; mm, samples in m" in files["p.h"]
    (tmp_path / "plan.json").write_text(plan.to_json())
    assert cordicc.load_plan(tmp_path).to_json() == plan.to_json()


@pytest.mark.parametrize("call", ["atan(y, x)", "arctan(y, x)", "arctan2(y, x)", "atan(hypot(x, y), [1, 2])"])
def test_an_angle_of_two_arguments_is_atan2(call):
    text = f'inputs: {{x: [1, 2], y: [1, 2]}}\nequations: ["z = {call}"]\n'
    assert "atan2" in refused(text)[0][1]


@pytest.mark.parametrize("equations", ["[x = x + v]", "[x = y + v, y = z, z = 2*x]"])
def test_a_circle_is_told_that_there_is_no_state(equations):
    ((code, hint),) = refused(f"inputs: {{v: [0, 1]}}\nequations: {equations}\n")
    assert code == "E206"
    assert "there is no state: one sample knows nothing of the one before, feed in as an input" in hint


def test_constants_in_a_circle_have_no_samples():
    ((code, hint), *_) = refused("constants: {a: b, b: a}\ninputs: {v: [0, 1]}\nequations: [x = v]\n")
    assert code == "E206"
    assert "state" not in hint
