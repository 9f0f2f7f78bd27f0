"""Units keep to their formulas; intervals hold every point; words and texts round-trip."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cordicc.arith.numbers.floating import SingleSystem, wrapped
from cordicc.arith.numbers.formats import SINGLE
from cordicc.ir.graph import Builder, Value
from cordicc.ir.meaning.enclosures import result_ranges
from cordicc.ir.meaning.intervals import Interval
from cordicc.ir.meaning.reference import reference_outputs as reference
from cordicc.ir.ops import OPS, Level
from tests.support.selection import examples
from tests.support.single_unit import SingleUnit

SYSTEM = SingleSystem()
WORD = st.floats(width=32)
FINITE = st.floats(width=32, allow_nan=False, allow_infinity=False)


@given(FINITE, FINITE, FINITE, st.sampled_from(["+", "-"]), st.sampled_from(["single-rotation", "root-free"]))
@settings(deadline=None)
def test_a_circular_solution_satisfies_its_equation(a, b, c, branch, rule):
    angle, rest = SingleUnit(rule=rule).implicit(1, branch, *(np.array([v], np.float32) for v in (a, b, c)))
    radius = math.hypot(a, b)
    if radius == 0 or abs(c) > radius * (1 + 2.0**-22):
        assert np.isnan(angle[0])
    elif not np.isnan(angle[0]):
        t = float(angle[0])
        assert -2 * math.pi - 1e-6 < t < 2 * math.pi + 1e-6
        assert abs(b * math.cos(t) + a * math.sin(t) - c) <= radius * 2.0**-21
        assert rest[0] >= 0
    else:
        assert abs(c) > radius * (1 - 2.0**-22)


@given(FINITE, FINITE)
@settings(deadline=None)
def test_principal_angles_never_leave_the_half_turn(x, y):
    zero = np.zeros(1, np.float32)
    norm, angle = SingleUnit().vector(1, 1, np.array([x], np.float32), np.array([y], np.float32), zero)
    if x == 0 and y == 0:
        assert norm[0] == 0
        assert np.isnan(angle[0])
    else:
        assert abs(float(angle[0])) <= math.pi
        assert abs(float(angle[0]) - math.atan2(y if y else 0.0, x)) <= 2.0**-22


@given(WORD)
def test_words_round_trip(value):
    word = np.float32(value)
    back = SINGLE.encode(SINGLE.decode(np.array([word])))
    assert np.isnan(back[0]) if not np.isfinite(word) else back[0] == word


@given(FINITE)
def test_constants_round_trip_as_text(value):
    assume(value == 0 or abs(value) >= 2.0**-126)  # smaller ones are refused
    text = SYSTEM.constant_text(Fraction(value))
    assert SYSTEM.constant(text).words == np.float32(value)


@given(st.fractions(min_value=-1000, max_value=1000))
def test_constants_are_the_nearest_words(number):
    word = SYSTEM.constant(SYSTEM.constant_text(number)).words[()]
    error = abs(Fraction(float(word)) - number)
    for neighbour in (np.nextafter(word, np.float32(np.inf)), np.nextafter(word, np.float32(-np.inf))):
        assert error <= abs(Fraction(float(neighbour)) - number)


@given(FINITE)
def test_wrapping_is_within_the_half_turn(value):
    assert abs(wrapped(np.array([value]))[0]) <= math.pi + 1e-15


END = st.one_of(
    st.sampled_from([-3.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0]),
    st.floats(-4, 4, width=32),
    st.floats(-1e6, 1e6, width=32),
)


@st.composite
def intervals_with_points(draw, count):
    pairs = []
    for _ in range(count):
        lo, hi = sorted((draw(END), draw(END)))
        points = [lo, hi, *(lo + (hi - lo) * draw(st.floats(0, 1)) for _ in range(3))]
        pairs.append((Interval(lo, hi), [min(max(p, lo), hi) for p in points]))
    return pairs


def parameters(op):
    choices = {
        "m": [1, -1] if op in ("solve", "implicit") else [1, 0, -1],
        "sign": [1, -1],
        "branch": ["+", "-", "none"],
        "exponent": [-3, 0, 4] if op == "shift" else [Fraction(n, 2) for n in range(-5, 8)],
        "factor": [Fraction(1, 3), Fraction(-7)],
        "value": [Fraction(1, 3)],
        "condition": ["any", "nonzero", "nonnegative", "positive"],
    }
    return st.tuples(*(st.sampled_from(choices[name]) for name in OPS[op].params)).filter(
        lambda p: op not in ("solve", "implicit") or p != (1, "none")
    )


@pytest.mark.parametrize("op", [d.name for d in OPS.values() if d.name != "input"])
@given(data=st.data())
@settings(deadline=None, max_examples=examples(60))
def test_intervals_hold_every_value(op, data):
    definition = OPS[op]
    params = data.draw(parameters(op))
    pairs = data.draw(intervals_with_points(definition.arity))
    enclosures = result_ranges(op, params, [interval for interval, _ in pairs])
    named = result_ranges(
        op, dict(zip(definition.params, params, strict=True)), [interval for interval, _ in pairs]
    )
    assert enclosures == named
    assert len(enclosures) == len(definition.results)
    builder = Builder()
    inputs = [builder.input(f"i{k}") for k in range(definition.arity)]
    value = builder.const(params[0]) if op == "const" else builder.emit(op, inputs, params)
    names = {f"r{k}": Value(value.node, k) for k in range(len(definition.results))}
    for name, result in names.items():
        graph = builder.build({name: result})
        samples = {f"i{k}": np.array(points, dtype=float) for k, (_, points) in enumerate(pairs)}
        used = {str(n.params[0]) for n in graph.nodes if n.op == "input"}
        outputs, _ = reference(graph, {k: v for k, v in samples.items() if k in used})
        enclosure = enclosures[int(name[1:])]
        for number in outputs[name]:
            if not np.isnan(number):
                assert enclosure is not None, (op, params, pairs, number)
                slack = 1e-13 * max(1.0, abs(number))  # the reference rounds to double, and cancels
                assert enclosure.lo - slack <= number <= enclosure.hi + slack, (enclosure, number)


def test_every_operation_has_an_enclosure():
    for definition in OPS.values():
        if definition.name != "input":
            empty = [None] * definition.arity
            if definition.arity:
                params = [None] * len(definition.params)
                assert result_ranges(definition.name, params, empty) == (None,) * len(definition.results)
    assert OPS["vector"].level is Level.UNIT
    with pytest.raises(ValueError, match="no enclosure"):
        result_ranges("input", ["x"], [])


@pytest.mark.parametrize(
    ("op", "params", "operands", "lo", "hi"),
    [
        ("sin", (), [(0, 1)], 0, math.sin(1)),
        ("sin", (), [(1, 2)], math.sin(1), 1),
        ("cos", (), [(3, 4)], -1, math.cos(4)),
        ("cos", (), [(1e9, 1e9)], math.cos(1e9), math.cos(1e9)),
        ("tan", (), [(1, 2)], -math.inf, math.inf),
        ("atan2", (), [(0, 1), (-1, 1)], 0, math.pi),
        ("atan2", (), [(-1, 1), (-1, 1)], -math.pi, math.pi),
        ("atan2", (), [(-1, 1), (1, math.inf)], -math.pi / 4, math.pi / 4),
        ("atan2", (), [(1, math.inf), (1, math.inf)], 0, math.pi / 2),
        ("hypot", (), [(-3, 1), (0, 4)], 0, 5),
        ("acos", (), [(0, 7)], 0, math.pi / 2),
        ("div", (), [(1, 2), (0, 4)], 0.25, math.inf),
        ("div", (), [(1, 2), (-1, 4)], -math.inf, math.inf),
        ("pow", (Fraction(-2),), [(-1, 2)], 0.25, math.inf),
        ("wrap", (), [(4, 5)], 4 - math.tau, 5 - math.tau),
        ("log", (), [(-1, math.e)], -math.inf, 1),
        ("solve", (1, "-"), [(0, 0), (1, 1), (0, 0.5)], -math.pi / 2, -math.acos(0.5)),
        ("flip", (), [(1, 2), (-2, -1)], -2, -1),
        ("vector", (0, -1), [(2, 4), (1, 2), (0, 1)], 2, 4),
    ],
)
def test_enclosures_are_tight(op, params, operands, lo, hi):
    result = result_ranges(op, params, [Interval(*o) for o in operands])[0]
    assert result is not None
    assert result.lo == pytest.approx(lo, abs=1e-14)
    assert result.hi == pytest.approx(hi, abs=1e-14)


@pytest.mark.parametrize(
    ("op", "params", "operands"),
    [
        ("acos", (), [(2, 3)]),
        ("sqrt", (), [(-2, -1)]),
        ("log", (), [(-2, 0)]),
        ("div", (), [(1, 1), (0, 0)]),
        ("atan2", (), [(0, 0), (0, 0)]),
        ("atanh", (), [(1, 2)]),
        ("acosh", (), [(0, 0.5)]),
        ("pow", (Fraction(1, 2),), [(-3, -1)]),
        ("guard", ("positive",), [(1, 2), (-1, 0)]),
        ("solve", (1, "+"), [(0, 1), (0, 1), (2, 3)]),
        ("solve", (-1, "none"), [(0, 0.5), (1, 2), (2, 3)]),
    ],
)
def test_provably_undefined(op, params, operands):
    assert result_ranges(op, params, [Interval(*o) for o in operands]) == (None,)


@pytest.mark.parametrize(("lo", "hi"), [(1, 0), (math.nan, 1), (math.inf, math.inf)])
def test_an_interval_must_be_one(lo, hi):
    with pytest.raises(ValueError, match="not an interval"):
        Interval(lo, hi)


def test_interval_queries():
    interval = Interval(-3.0, 1.0)
    assert interval.magnitude == 3
    assert interval.finite
    assert 0.5 in interval
    assert 2 not in interval
    assert interval.union(Interval(2, 4)) == Interval(-3, 4)
    assert interval.intersect(Interval(2, 4)) is None


@pytest.mark.parametrize(
    ("op", "operands", "lo", "hi"),
    [
        ("mul", [(0, math.inf), (-2, 3)], -math.inf, math.inf),
        ("div", [(1, math.inf), (1, math.inf)], 0, math.inf),
        ("div", [(1, 2), (2, math.inf)], 0, 1),
        ("wrap", [(0, math.inf)], -math.pi, math.pi),
        ("sin", [(-math.inf, 0)], -1, 1),
        ("exp", [(-math.inf, 1000)], 0, math.inf),
        ("tanh", [(-math.inf, math.inf)], -1, 1),
        ("rotate", [(1, 1), (0, 0), (-math.inf, math.inf)], -1, 1),
        ("atan2", [(-math.inf, -1), (-math.inf, -1)], -math.pi, -math.pi / 2),
    ],
)
def test_unbounded_operands(op, operands, lo, hi):
    params = (1,) if op == "rotate" else ()
    result = result_ranges(op, params, [Interval(*o) for o in operands])[0]
    assert result is not None
    assert (result.lo, result.hi) == pytest.approx((lo, hi), abs=1e-14)
