"""Properties of vectors, tables, loops and conditions: whatever is written, a graph or diagnostics."""

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.diagnosed import check_text

HEAD = "inputs: {x: [0.5, 1], y: [-1, 1]}\nconstants: {a: 2, b: 30 deg}\nequations:\n"

scalars = st.sampled_from(["x", "y", "a", "b", "pi/2", "-1", "0", "2*x", "t", "u", "t + u", "p_x", "q_z"])
functions = ["dot({}, {})", "cross({}, {})", "norm({})", "rotate({}, {})", "rotate({}, x, {})"]
forms = [*functions, "[{}, {}]", "[{}, {}, {}]", "({} + {})", "{}*{}", "{}/{}", "-{}", "sin({})", "cos({})"]


def filled(form, parts):
    return form.format(*parts)


mixed = st.recursive(
    st.one_of(scalars, st.sampled_from(["p", "q", "[x, y]", "[1, 0, a]", "T", "T_r12"])),
    lambda inner: st.sampled_from(forms).flatmap(
        lambda form: st.lists(inner, min_size=3, max_size=3).map(lambda parts: filled(form, parts))
    ),
    max_leaves=8,
)
trigonometric = st.recursive(
    st.sampled_from(["cos(t)", "sin(t)", "cos(u)", "sin(u)", "cos(t - u)", "sin(u + b)", "x", "a", "y"]),
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(" + ".join),
        st.tuples(inner, inner).map(" - ".join),
        st.tuples(st.sampled_from(["x", "2", "0", "(a - 2)"]), inner).map(lambda p: f"{p[0]}*({p[1]})"),
    ),
    max_leaves=8,
)
branches = st.one_of(
    st.sampled_from(['"+"', '"-"', "all", "t > 0", "0 > u", "cos(t) > x"]),
    st.tuples(mixed, st.sampled_from("<>"), mixed).map(lambda p: f"'{p[0]} {p[1]} {p[2]}'"),
)
VECTORS = "- vector: p = [x, 1, y]\n- vector: q = rotate([x, y], b)\n"
TABLE = "- dh: {frame: T, convention: standard, joints: [{theta: x, a: 1}, {theta: y, alpha: b}]}\n"


@settings(deadline=None)
@given(st.lists(mixed, min_size=1, max_size=3), mixed)
def test_any_vectors(vectors, number):
    lines = [f"- 'vector: v{i} = {e}'\n- vector: '  w{i} = {e}'\n" for i, e in enumerate(vectors)]
    check_text(HEAD + VECTORS + TABLE + "".join(lines) + f"- 'z = {number}'\n- n = x + w0_y\n")


@settings(deadline=None)
@given(mixed, mixed, st.sampled_from(["t", "[t, u]", "u"]), branches)
def test_any_solve_with_vectors(left, right, unknowns, branch):
    solve = f"- solve: '{left} = {right}'\n  for: {unknowns}\n  branch: {branch}\n- z = t + u\n"
    check_text(HEAD + VECTORS + TABLE + solve)


@settings(deadline=None)
@given(st.lists(trigonometric, min_size=4, max_size=4), branches)
def test_any_loop(sides, branch):
    a, b, c, d = sides
    check_text(HEAD + f"- solve: ['{a} = {b}', '{c} = {d}']\n  for: [t, u]\n  branch: {branch}\n")


@settings(deadline=None)
@given(trigonometric, branches)
def test_any_condition(side, branch):
    check_text(
        HEAD + VECTORS + f"- u = 2*x\n- solve: '{side} = y'\n  for: t\n  branch: {branch}\n- z = t*u\n"
    )


@settings(deadline=None)
@given(
    st.lists(st.dictionaries(st.sampled_from(["theta", "d", "a", "alpha", "b"]), mixed), max_size=4),
    st.sampled_from(["standard", "modified", "both"]),
)
def test_any_table(joints, convention):
    rows = ["{" + ", ".join(f"{key}: '{value}'" for key, value in row.items()) + "}" for row in joints]
    table = f"- dh: {{frame: A, convention: {convention}, joints: [{', '.join(rows)}]}}\n"
    check_text(HEAD + VECTORS + TABLE + table + "- z = A_px + A_r12\n")
