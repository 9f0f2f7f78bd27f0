"""Vectors, tables of joints, conditions, loops, all branches and units, against equations by hand."""

import re

import numpy as np
import pytest

from cordicc.base.diagnostics import InvalidInput, Source
from cordicc.frontend.load import load_problem, parse_problem
from cordicc.ir.meaning.reference import reference_outputs
from cordicc.ir.text import print_graph
from cordicc.ir.well_formed import verify
from tests.support.paths import EXAMPLES

EXACT = 5e-16
"""Of two values of order 1 that agree at 113 bits and are rounded to double precision."""


def load(text):
    problem = parse_problem(Source("t.yaml", text)).problem
    verify(problem.graph)
    return problem


def run(text, count=60, **fixed):
    """Return samples of the inputs, the outputs at 113 bits, and which samples are valid."""
    problem = load(text)
    source = np.random.default_rng(1)
    inputs = {i.name: source.uniform(float(i.lo), float(i.hi), count) for i in problem.inputs} | fixed
    return inputs, *reference_outputs(problem.graph, inputs)


def graph(text):
    """Return the printed graph without the names of the equations."""
    return re.sub(r" @\w+", "", print_graph(load(text).graph))


def assert_same(text, other):
    """Check that two problems have the same operations and, at 113 bits, the same values."""
    ops, other_ops = (sorted(n.op for n in load(t).graph.nodes if n.op != "const") for t in (text, other))
    assert ops == other_ops
    _, found, _ = run(text)
    _, wanted, _ = run(other)
    for name, column in wanted.items():
        assert np.max(abs(found[name] - column)) <= EXACT * max(1, np.max(abs(column)))


def codes(text):
    with pytest.raises(InvalidInput) as caught:
        load(text)
    return [d.code for d in caught.value.diagnostics]


def wrapped(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


HEAD = "constants: {k: 3}\ninputs: {a: [-1, 1], x: [1, 2], y: [1, 2], z: [1, 2]}\nequations:\n"


@pytest.mark.parametrize(
    ("sugar", "plain"),
    [
        (["s = dot([x, y], [y, a])"], ["s = x*y + y*a"]),
        (["s = dot([x, y, 0], [1, a, z])"], ["s = x + y*a"]),
        (["vector: p = [x, y, z]", "s = norm(p)"], ["s = sqrt(x**2 + y**2 + z**2)"]),
        (["s = norm([x, y])"], ["s = hypot(x, y)"]),
        (["s = cross([x, y], [z, a])"], ["s = x*a - y*z"]),
        (["vector: p = cross([x, y, z], [a, 1, 0])", "s = p_z"], ["s = x - y*a"]),
        (["vector: p = cross([x, y, z], [a, 1, 0])", "s = p_x"], ["s = -z"]),
        (["vector: p = rotate([x, y], a)", "s = p_x"], ["s = x*cos(a) - y*sin(a)"]),
        (["vector: p = rotate([x, y, z], z, a)", "s = p_y"], ["s = y*cos(a) + x*sin(a)"]),
        (["vector: p = rotate([x, y, z], x, a)", "s = p_y"], ["s = y*cos(a) - z*sin(a)"]),
        (["vector: p = rotate([x, y, z], y, a)", "s = p_x"], ["s = x*cos(a) + z*sin(a)"]),
        (["vector: p = rotate([x, y, z], y, a)", "s = p_z"], ["s = z*cos(a) - x*sin(a)"]),
        (["vector: p = rotate([x, y], pi/2)", "s = p_x*p_y"], ["s = (-y)*x"]),
        (["vector: p = rotate([x, y], -90*deg - a)", "s = p_x"], ["s = y*cos(a) - x*sin(a)"]),
        (["vector: p = 2*k*[x, y] - [y, x]/a", "s = p_y"], ["s = 2*k*y - x/a"]),
        (["vector: p = vector(x, y)", "vector: q = -p", "s = q_y"], ["s = -y"]),
        (["s = dot(cross([x, y, z], [1, 0, 0]), [0, 0, 1])"], ["s = -y"]),
    ],
)
def test_vectors(sugar, plain):
    ends = "outputs: [s]\n"
    written, by_hand = ("".join(f"- {line}\n" for line in lines) for lines in (sugar, plain))
    assert_same(HEAD + written + ends, HEAD + by_hand + ends)


def test_names_of_vector_functions_are_free():
    text = HEAD + "- norm = hypot(x, y)\n- dot = 2*norm\n- rotate = dot + norm\n- vector = rotate\n"
    assert [e.target for e in load(text).equations] == ["norm", "dot", "rotate", "vector"]


def test_a_vector_is_one_equation_and_one_output_is_enough():
    loaded = parse_problem(Source("t.yaml", HEAD + "- vector: p = [x*a, y, z]\noutputs: [p_x, p_y]\n"))
    assert [(e.target, e.text, e.line) for e in loaded.problem.equations] == [("p", "p = [x*a, y, z]", 4)]
    assert [d.code for d in loaded.warnings] == ["W103"]
    unused = parse_problem(
        Source("t.yaml", HEAD + "- vector: p = [x*a, y, z]\n- s = x*y*z*a\noutputs: [s]\n")
    )
    assert [d.code for d in unused.warnings] == ["W102"]


def test_default_outputs_leave_out_a_vector_that_is_used():
    assert [o.name for o in load(HEAD + "- vector: p = [x*a, y, z]\n- s = p_x*2\n").outputs] == ["s"]
    assert [o.name for o in load(HEAD + "- vector: p = [x*a, y*z]\n").outputs] == ["p_x", "p_y"]


def test_components_may_be_angles():
    text = HEAD + "- vector: p = [atan2(y, x), 2*a]\n- vector: q = 2*p\noutputs: [p_x, p_y, q_x, q_y]\n"
    assert [o.name for o in load(text).outputs if o.is_angle] == ["p_x", "q_x"]


def test_nested_rotations_are_named_not_copied():
    text = "rotate(" * 60 + "[x, y, z]" + ", x, a)" * 30 + ", z, y)" * 30
    assert len(load(HEAD + f"- vector: p = {text}\n").graph.nodes) < 700


def test_nested_rotations_of_an_unknown_are_bounded():
    text = "rotate(" * 60 + "[x, y]" + ", t)" * 60
    found = codes(HEAD + f"- solve: dot({text}, [1, z]) = 1\n  for: t\n  branch: all\n")
    assert found == ["E104"]


def test_long_sums_of_vectors():
    text = " + ".join(["[x, y]"] * 2500)
    assert len(load(HEAD + f"- vector: p = {text}\n- s = norm(p)*a*z\n").graph.nodes) < 5100


def by_matrices(convention, rows):
    """Return the 4x4 matrix of a table of (theta, d, a, alpha)."""
    total = np.eye(4)
    for theta, d, a, alpha in rows:
        c, s, u, v = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        about_z = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])
        about_x = np.array([[1, 0, 0, a], [0, u, -v, 0], [0, v, u, 0], [0, 0, 0, 1]])
        total = total @ (about_z @ about_x if convention == "standard" else about_x @ about_z)
    return total


JOINTS = [
    ("q1 + pi/2", "d1", "0", "-pi/2"),
    ("q2", "0", "a2", "0"),
    ("q3 - q1", "d3", "a3", "90*deg"),
    ("-q4", "0.43", "0", "pi"),
    ("pi", "q5/5", "0.1", "tilt"),
    ("-(q6 - q2) - pi/2", "0.1", "0.2", "q6/3"),
    ("0.3", "0", "0", "-pi"),
]


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("joints", [JOINTS, JOINTS[::-1], JOINTS[1:4], JOINTS[:1], JOINTS[4:5]])
def test_tables_of_joints(convention, joints):
    constants = {"d1": 0.66, "a2": 0.432, "a3": 0.02, "d3": -0.15, "tilt": np.deg2rad(20)}
    text = "constants: {d1: 660 mm, a2: 432 mm, a3: 20 mm, d3: -0.15, tilt: 20 deg}\ninputs:\n"
    text += "".join(f"  q{i}: [-3, 3]\n" for i in range(1, 7))
    text += f"equations:\n- dh:\n    frame: T\n    convention: {convention}\n    joints:\n"
    for row in joints:
        fields = zip(("theta", "d", "a", "alpha"), row, strict=True)
        text += "    - {" + ", ".join(f"{k}: {v}" for k, v in fields if v != "0") + "}\n"
    inputs, outputs, valid = run(text, 8)
    assert valid.all()
    assert len(outputs) == 12
    for i in range(8):
        known = {name: column[i] for name, column in inputs.items()} | constants
        known |= {"pi": np.pi, "deg": np.pi / 180}
        rows = [tuple(eval(v, {}, known) for v in row) for row in joints]
        matrix = by_matrices(convention, rows)
        for row, axis in enumerate("xyz"):
            assert abs(matrix[row, 3] - outputs[f"T_p{axis}"][i]) < 2e-15
            for column in range(3):
                assert abs(matrix[row, column] - outputs[f"T_r{row + 1}{column + 1}"][i]) < 2e-15


TABLE = "- dh: {frame: T, convention: standard, joints: [%s]}\n"


def test_parallel_joints_add_their_angles():
    inputs = "constants: {b: 2, c: 3}\ninputs: {q1: [-1, 1], q2: [-1, 1], q3: [-1, 1]}\nequations:\n"
    ends = "outputs: [T_px, T_py, T_r11]\n"
    table = TABLE % "{theta: q1, a: b}, {theta: q2, a: c}, {theta: q3}"
    plain = "- T_px = c*cos(q1 + q2) + b*cos(q1)\n- T_py = c*sin(q1 + q2) + b*sin(q1)\n"
    plain += "- T_r11 = cos(q1 + q2 + q3)\n"
    assert_same(inputs + table + ends, inputs + plain + ends)
    scara = TABLE % "{theta: q1, a: b, alpha: pi}, {theta: q2, a: c, d: q3}"
    assert graph(inputs + scara + "outputs: [T_pz]\n") == graph(inputs + "- T_pz = -q3\n")
    axis = load(inputs + scara + "outputs: [T_r33]\n").graph
    assert axis.constant(axis.outputs["T_r33"]) == -1


def test_quarter_turns_leave_zeros_and_ones():
    inputs = "inputs: {q1: [-1, 1], q2: [-1, 1]}\nequations:\n"
    table = TABLE % "{theta: q1, alpha: pi/2}, {theta: q2 - pi, d: 2, alpha: -pi/2}"
    problem = load(inputs + table)
    numbers = {n.params[0] for n in problem.graph.nodes if n.op == "const"}
    assert numbers == {0, -2}
    assert all(n.op in ("const", "input", "sin", "cos", "mul", "neg") for n in problem.graph.nodes)


def test_what_a_table_leaves_out_is_not_used():
    text = (
        "inputs: {q1: [-1, 1], d: [0, 1]}\nequations:\n" + TABLE % "{theta: q1, d: d}" + "outputs: [T_r11]\n"
    )
    assert [d.code for d in parse_problem(Source("t.yaml", text)).warnings] == ["W103"]


def test_large_tables():
    long = "+".join(["q1", "q2"] * 100)
    joints = ", ".join(f"{{theta: {long}, d: {long}, a: q2, alpha: q1}}" for _ in range(32))
    inputs = "inputs: {q1: [-1, 1], q2: [-1, 1]}\nequations:\n"
    assert len(load(inputs + TABLE % joints).graph.nodes) < 4000
    assert codes(inputs + TABLE % (joints + ", {theta: q1}")) == ["E104"]
    short = ", ".join(["{theta: q1}"] * 32)
    tables = "".join((TABLE % short).replace("T,", f"T{i},") for i in range(17))
    assert codes(inputs + tables) == ["E104"]


CONDITIONS = {
    "q > 0": lambda q, a, b: wrapped(q),
    "0 >= q": lambda q, a, b: -wrapped(q),
    "cos(q) >= 0.1": lambda q, a, b: np.cos(q) - 0.1,
    "0 < k*cos(q) - 2*sin(q)": lambda q, a, b: 3 * np.cos(q) - 2 * np.sin(q),
    "q < 1": lambda q, a, b: 1 - wrapped(q),
    "q + cos(q) > k/10": lambda q, a, b: wrapped(q) + np.cos(q) - 0.3,
    "sin(q - atan2(A, B)) > 0": lambda q, a, b: np.sin(q - np.arctan2(a, b)),
    "sin(q/2) > 0.2": lambda q, a, b: np.sin(wrapped(q) / 2) - 0.2,
    "A*cos(q) < B*sin(q)": lambda q, a, b: b * np.sin(q) - a * np.cos(q),
    "dot([cos(q), sin(q)], [1, 2]) > 0": lambda q, a, b: np.cos(q) + 2 * np.sin(q),
}


@pytest.mark.parametrize("condition", CONDITIONS)
@pytest.mark.parametrize("high", [1, -0.1])
def test_conditions(condition, high):
    """The solution is +, if the condition holds there, else -, if it holds there, else there is none."""
    head = f"constants: {{k: 3}}\ninputs: {{A: [-1, 1], B: [-1, {high}], C: [-1, 1]}}\nequations:\n"
    solve = f"- solve: B*cos(q) + A*sin(q) = C\n  for: q\n  branch: {condition}\n"
    inputs, outputs, _ = run(head + solve + "outputs: {q: {wrap: false}}\n", 300)
    A, B, C = (inputs[name] for name in "ABC")
    excess = CONDITIONS[condition]
    with np.errstate(invalid="ignore"):
        half = np.arccos(C / np.hypot(A, B))
        plus, minus = (np.arctan2(A, B) + sign * half for sign in (1, -1))
        at = [excess(q, A, B) for q in (plus, minus)]
        wanted = np.where(at[0] >= 0, plus, np.where(at[1] >= 0, minus, np.nan))
        clear = np.minimum(abs(at[0]), abs(at[1])) > 1e-9
    found = outputs["q"]
    assert clear.sum() > 20
    assert np.isnan(found[clear]).tolist() == np.isnan(wanted[clear]).tolist()
    assert np.nanmax(abs(found - wanted)[clear]) < 1e-9


@pytest.mark.parametrize(
    ("equation", "condition", "branch"),
    [
        ("cos(q) = C", "q > 0", "+"),
        ("cos(q) = C", "q < 0", "-"),
        ("cos(q) = C", "sin(q) >= 0", "+"),
        ("-2*cos(q) = C", "q > 0", "-"),
        ("(B + 2)*cos(q) = C", "0 < q", "+"),
        ("(B - 2)*cos(q) = C", "-q < 0", "-"),
        ("sin(q) = C", "cos(q) > 0", "-"),
        ("sin(q) = C", "cos(q) < 0", "+"),
        ("-sin(q) = C", "2*cos(q) > 0", "+"),
        ("cos(q + 0.5) = C", "sin(q + 0.5) > 0", "+"),
        ("B*cos(q) + (B + 3)*sin(q) = C", "B*sin(q) - (B + 3)*cos(q) > 0", "+"),
        ("k*cosh(q) = k + C + 1", "q > 0", "+"),
        ("k*cosh(q) = k + C + 1", "sinh(q) < 0", "-"),
    ],
)
def test_proven_conditions(equation, condition, branch):
    head = "constants: {k: 3}\ninputs: {B: [-1, 1], C: [-1, 1]}\nequations:\n"
    ends = "- s = B + C\noutputs: [q, s]\n"
    by_condition, by_sign = (
        graph(head + f"- solve: {equation}\n  for: q\n  branch: {b}\n" + ends)
        for b in (condition, f'"{branch}"')
    )
    assert by_condition == by_sign


def test_a_sign_that_decides_needs_no_solutions():
    text = "inputs: {A: [-1, 1], C: [-0.1, 0.1]}\nequations:\n"
    text += "- solve: cos(q)*A = C\n  for: q\n  branch: q > 0\n"
    ops = [n.op for n in load(text).graph.nodes]
    assert "guard" not in ops
    assert ops.count("select") == 1
    _, outputs, valid = run(text)
    assert (outputs["q"][valid] > 0).all()


def test_a_condition_keeps_its_domain():
    text = "inputs: {B: [-1, 1], C: [-1, 1]}\nequations:\n"
    text += "- solve: cos(q) = C\n  for: q\n  branch: sin(q)*sqrt(B) > 0\n"
    inputs, outputs, valid = run(text)
    assert (valid == (inputs["B"] >= 0)).all()
    assert (outputs["q"][valid] > 0).all()


def test_hyperbolic_condition_at_run_time():
    text = "inputs: {a: [1, 2], b: [-0.5, 0.5], C: [2, 5]}\nequations:\n"
    text += "- solve: a*cosh(t) + b*sinh(t) = C\n  for: t\n  branch: t > 0.5\n"
    inputs, outputs, valid = run(text)
    t = outputs["t"][valid]
    assert (t >= 0.5).all()
    a, b, C = (inputs[name][valid] for name in "abC")
    assert np.allclose(a * np.cosh(t) + b * np.sinh(t), C, rtol=1e-14)


def test_a_circular_condition_on_a_hyperbolic_angle():
    text = "inputs: {b: [-3, -1], C: [2, 5]}\nequations:\n"
    text += "- solve: 3.5*cosh(t) + b*sinh(t) = C + 2\n  for: t\n  branch: cos(t) - sin(t) > 0\n"
    inputs, outputs, valid = run(text, 200)
    b, C = inputs["b"], inputs["C"] + 2
    size = np.arccosh(C / np.sqrt(3.5**2 - b**2))
    plus, minus = (-np.arctanh(b / 3.5) + sign * size for sign in (1, -1))
    at = [np.cos(t) - np.sin(t) for t in (plus, minus)]
    wanted = np.where(at[0] >= 0, plus, np.where(at[1] >= 0, minus, np.nan))
    assert (valid == ~np.isnan(wanted)).all()
    assert np.nanmax(abs(outputs["t"] - wanted)) < 1e-13


LOOP = """\
constants: {l: 0.4, m: 0.3, o: 0.2}
inputs: {x: [0.25, 0.45], y: [-0.2, 0.4], a: [0.3, 0.5]}
equations:
"""

LOOPS = {
    "[l*cos(u) + m*cos(u + v) = x, l*sin(u) + m*sin(u + v) = y]": lambda u, v, i: (
        0.4 * np.cos(u) + 0.3 * np.cos(u + v) - i["x"],
        0.4 * np.sin(u) + 0.3 * np.sin(u + v) - i["y"],
    ),
    "rotate([m, 0], v) + a*[cos(u), sin(u)] = [x, y]": lambda u, v, i: (
        0.3 * np.cos(v) + i["a"] * np.cos(u) - i["x"],
        0.3 * np.sin(v) + i["a"] * np.sin(u) - i["y"],
    ),
    "[a*cos(u + o) = x - m*sin(v), a*sin(u + o) = y + m*cos(v)]": lambda u, v, i: (
        i["a"] * np.cos(u + 0.2) - i["x"] + 0.3 * np.sin(v),
        i["a"] * np.sin(u + 0.2) - i["y"] - 0.3 * np.cos(v),
    ),
    "[l*cos(u) + m*cos(v) = x, l*sin(u) - m*sin(v) = y]": lambda u, v, i: (
        0.4 * np.cos(u) + 0.3 * np.cos(v) - i["x"],
        0.4 * np.sin(u) - 0.3 * np.sin(v) - i["y"],
    ),
    "[l*sin(u) + m*sin(u - v + a) = x, l*cos(u) + m*cos(u - v + a) = y]": lambda u, v, i: (
        0.4 * np.sin(u) + 0.3 * np.sin(u - v + i["a"]) - i["x"],
        0.4 * np.cos(u) + 0.3 * np.cos(u - v + i["a"]) - i["y"],
    ),
    "[-l*cos(u) + m*(cos(v) - 2*sin(v)) = x, -l*sin(u) + m*(sin(v) + 2*cos(v)) = y]": lambda u, v, i: (
        -0.4 * np.cos(u) + 0.3 * (np.cos(v) - 2 * np.sin(v)) - i["x"],
        -0.4 * np.sin(u) + 0.3 * (np.sin(v) + 2 * np.cos(v)) - i["y"],
    ),
    "[cos(-u)*l + 2*m/2*cos(v+o) = x, -sin(-u)*l + m*(sin(v)*cos(o) + cos(v)*sin(o)) = y]": lambda u, v, i: (
        0.4 * np.cos(u) + 0.3 * np.cos(v + 0.2) - i["x"],
        0.4 * np.sin(u) + 0.3 * np.sin(v + 0.2) - i["y"],
    ),
    "[a*cos(v - u) + a*cos(v) = x, a*sin(v - u) + a*sin(v) = y]": lambda u, v, i: (
        i["a"] * (np.cos(v - u) + np.cos(v)) - i["x"],
        i["a"] * (np.sin(v - u) + np.sin(v)) - i["y"],
    ),
}


@pytest.mark.parametrize("loop", LOOPS)
@pytest.mark.parametrize("branch", ['"+"', '"-"', "sin(v) > 0", "u < v", "cos(u) > 0.5"])
def test_loops(loop, branch):
    ends = f"  for: [u, v]\n  branch: {branch}\n- s = x + y + a\noutputs: [u, v, s]\n"
    inputs, outputs, valid = run(LOOP + f"- solve: {loop}\n{ends}", 200)
    u, v = outputs["u"], outputs["v"]
    for residual in LOOPS[loop](u, v, inputs):
        assert np.nanmax(abs(residual), initial=0) < 2e-15
    if branch == "sin(v) > 0":
        assert (np.sin(v[valid]) > -1e-15).all()
    if branch == "u < v":
        assert (u[valid] <= v[valid]).all()
    if branch == "cos(u) > 0.5":
        assert (np.cos(u[valid]) >= 0.5 - 1e-15).all()
    if branch in ('"+"', '"-"'):
        assert valid.sum() > 100


def test_branches_of_a_loop_are_its_two_solutions():
    loop = "- solve: [l*cos(u) + m*cos(u + v) = x, l*sin(u) + m*sin(u + v) = y]\n  for: [u, v]\n"
    _, outputs, valid = run(LOOP + loop + "  branch: all\n- s = x*y*a\noutputs: [u, v]\n")
    assert valid.all()
    assert np.allclose(outputs["v_p"], -outputs["v_m"], rtol=1e-14)
    assert (outputs["v_m"] > 0).all()


def test_a_loop_is_two_equations_by_hand():
    loop = "- solve: [l*cos(u) + m*cos(u + v) = x, l*sin(u) + m*sin(u + v) = y]\n  for: [u, v]\n"
    hand = """\
- solve: x*cos(u) + y*sin(u) = (l**2 + (x**2 + y**2) - m**2)/(2*l)
  for: u
  branch: "-"
- solve: x*cos(w) + y*sin(w) = (m**2 + (x**2 + y**2) - l**2)/(2*m)
  for: w
  branch: "+"
- v = w - u
"""
    ends = "- s = a*x\noutputs: [u, v, s]\n"
    for branch in ("v > 0", "sin(v) >= 0", '"-"'):
        by_loop = run(LOOP + loop + f"  branch: {branch}\n" + ends)[1]
        by_hand = run(LOOP + hand + ends)[1]
        assert all(np.max(abs(by_loop[name] - by_hand[name])) <= EXACT for name in by_hand)
        assert [n.op for n in load(LOOP + loop + f"  branch: {branch}\n").graph.nodes].count("solve") == 2


def test_graph_of_a_loop():
    problem = load_problem(EXAMPLES / "two_link_loop.yaml").problem
    assert (
        print_graph(problem.graph)
        == """\
%0 = input[name=x]
%1 = input[name=y]
%2 = const[value=49/400] @q1
%3 = pow[exponent=2](%0) @q1
%4 = pow[exponent=2](%1) @q1
%5 = add(%3, %4) @q1
%6 = add(%2, %5) @q1
%7 = const[value=1/16] @q1
%8 = sub(%6, %7) @q1
%9 = const[value=7/10] @q1
%10 = div(%8, %9) @q1
%11 = solve[m=1, branch=-](%1, %0, %10) @q1
%12 = add(%5, %7) @q1
%13 = sub(%12, %2) @q1
%14 = const[value=1/2] @q1
%15 = div(%13, %14) @q1
%16 = solve[m=1, branch=+](%1, %0, %15) @q1
%17 = sub(%16, %11) @q1
%18 = wrap(%11) @q1
%19 = wrap(%17) @q2
output q1 = %18
output q2 = %19
"""
    )


def test_all_branches_of_a_chain():
    text = """\
constants: {l: 0.4, m: 0.3}
inputs: {x: [0.25, 0.45], y: [-0.2, 0.4], z: [-0.9, 0.9]}
equations:
- solve: 2*l*m*cos(q) = x**2 + y**2 - l**2 - m**2
  for: q
  branch: all
- vector: tip = [l, 0] + rotate([m, 0], q)
- solve: rotate(tip, p) = [x, y]
  for: p
- solve: sin(r) = z*tip_y
  for: r
  branch: all
- s = r + p
outputs: {p: {wrap: false}, q: , s: }
"""
    problem = load(text)
    names = ["p_p", "p_m", "q_p", "q_m", "s_pp", "s_pm", "s_mp", "s_mm"]
    assert [o.name for o in problem.outputs] == names
    assert [o.wrap for o in problem.outputs] == [False, False, *[True] * 6]
    assert ("r_pm", "solve sin(r_pm) = z*tip_y_p for r_pm, branch -") in [
        (e.target, e.text) for e in problem.equations
    ]
    inputs, outputs, valid = run(text)
    assert valid.all()
    for letter in "pm":
        p, q = outputs[f"p_{letter}"], outputs[f"q_{letter}"]
        assert np.max(abs(0.4 * np.cos(p) + 0.3 * np.cos(p + q) - inputs["x"])) < EXACT
        for other, sign in (("p", 1), ("m", -1)):
            r = np.pi / 2 + sign * np.arccos(inputs["z"] * 0.3 * np.sin(q))
            assert np.max(abs(wrapped(outputs[f"s_{letter}{other}"] - p - r))) < 4e-15


def test_all_branches_of_the_file():
    text = "inputs: {x: [0.1, 0.5]}\n%sequations:\n- solve: cos(t) = x\n  for: t\n%s"
    text += "- solve: [cos(u) = x, sin(u) = t]\n  for: u\n- solve: sinh(w) = x\n  for: w\n"
    whole = graph(text % ("branches: all\n", ""))
    assert whole == graph(text % ("branches: all\n", "  branch: t > 0\n"))
    assert whole == graph(text % ("", "  branch: all\n"))
    assert [o.name for o in load(text % ("branches: all\n", "")).outputs] == ["u_p", "u_m", "w"]
    assert codes(text % ("branches: all\n", "  branch: both\n")) == ["E307"]


def test_all_branches_are_bounded(monkeypatch):
    monkeypatch.setattr("cordicc.frontend.plain.alternatives.MAX_NODES", 2000)
    text = "inputs: {x: [0.1, 0.5]}\nequations:\n- solve: cos(t) = x\n  for: t\n  branch: all\n"
    text += "- y = t" + " + t" * 1000 + "\n"
    assert codes(text) == ["E104"]


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        ("400 mm", "0.4"),
        ("-3.5 cm", "-0.035"),
        ("2m", "2"),
        (".5 in", "0.0127"),
        ("1e3 um", "0.001"),
        ("30 deg", "pi/6"),
        ("0.25 turn", "pi/2"),
        ("-1 rad", "-1"),
    ],
)
def test_units(written, plain):
    one, other = (load(f"constants: {{k: {k}}}\ninputs: {{x: [0, 1]}}\nequations: [y = k*x]\n")
                  for k in (written, plain))  # fmt: skip
    assert abs(one.constants["k"] - other.constants["k"]) < 1e-70


@pytest.mark.parametrize("name", ["arm_6r", "two_link_loop", "four_bar_loop"])
def test_examples(name):
    problem = load_problem(EXAMPLES / f"{name}.yaml").problem
    source = np.random.default_rng(2)
    inputs = {i.name: source.uniform(float(i.lo), float(i.hi), 50) for i in problem.inputs}
    outputs, valid = reference_outputs(problem.graph, inputs)
    assert valid.all()
    if name == "two_link_loop":
        q1, q2 = outputs["q1"], outputs["q2"]
        assert np.max(abs(0.35 * np.cos(q1) + 0.25 * np.cos(q1 + q2) - inputs["x"])) < EXACT
        assert np.max(abs(0.35 * np.sin(q1) + 0.25 * np.sin(q1 + q2) - inputs["y"])) < EXACT
        assert (q2 > 0).all()
    if name == "four_bar_loop":
        for letter in "pm":
            coupler, rocker = outputs[f"coupler_{letter}"], outputs[f"rocker_{letter}"]
            closing = 0.04 * np.exp(1j * inputs["crank"]) + 0.12 * np.exp(1j * coupler)
            assert np.max(abs(closing - 0.1 - 0.08 * np.exp(1j * rocker))) < EXACT
    if name == "arm_6r":
        for i in range(50):
            q = [inputs[f"q{j}"][i] for j in range(1, 6)]
            rows = [
                (q[0], 0.352, 0.07, -np.pi / 2), (q[1] - np.pi / 2, 0, 0.36, 0), (q[2], 0, 0, -np.pi / 2),
                (q[3], 0.38, 0, np.pi / 2), (q[4], 0, 0, -np.pi / 2), (0, 0.065, 0, 0),
            ]  # fmt: skip
            matrix = by_matrices("standard", rows)
            tip = matrix[:3, 3] + 0.12 * matrix[:3, 2]
            assert np.max(abs(tip - [outputs[f"tip_{axis}"][i] for axis in "xyz"])) < 2e-15
