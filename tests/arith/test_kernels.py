"""Kernels on int64 and on Python integers agree bit for bit, in every format, mode and coordinate system."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cordicc.arith.kernels import micro_rotations, shift_sequences
from cordicc.arith.kernels.shift_sequences import COORDINATE_BITS, FACTOR_BITS
from cordicc.studies import scaled_kernels
from tests.support.selection import examples, quick

SAFE_BITS = 3
"""A start of 1 grows below 8 in every kernel: gain up to 2.72, norm up to sqrt 2, hyperbolic exp(1.12)."""


def quarter_turn(x, y, target, z, table):
    return micro_rotations.quarter_turn(x, y, target, z, table.angles[0] * 2)


UNITS = {
    "rotate": (micro_rotations.rotate, 3, shift_sequences.standard, (1, 0, -1)),
    "vector": (micro_rotations.vector, 3, shift_sequences.standard, (1, 0, -1)),
    "implicit": (micro_rotations.implicit, 4, shift_sequences.standard, (1, -1)),
    "implicit-root-free": (micro_rotations.implicit_root_free, 4, shift_sequences.root_free, (1, -1)),
    "quarter-turn": (quarter_turn, 4, shift_sequences.standard, (1,)),
    "rotate-scaled": (scaled_kernels.rotate_scaled, 3, None, (1, -1)),
    "vector-scaled": (scaled_kernels.vector_scaled, 3, None, (1, -1)),
    "implicit-scaled": (scaled_kernels.implicit_scaled, 4, None, (1, -1)),
}
CASES = [(name, m) for name, unit in UNITS.items() for m in unit[3]]


def scaled(draw, m, iterations):
    """A sequence with digits: the paper's, or any, as the kernels do not depend on what digits amount to."""
    if m == 1 and draw(st.booleans()):
        return shift_sequences.krieger96()
    digits = draw(st.lists(st.sampled_from((-1, 0, 1)), min_size=iterations, max_size=iterations))
    base = shift_sequences.root_free(m, iterations)
    shifts = tuple(s or 1 for s in base.shifts)
    return replace(base, shifts=shifts, eta=tuple(digits))


@st.composite
def runs(draw, name, m):
    """Return a kernel's table and columns of a format: fraction bits, angle bits, iterations, words."""
    _, operands, make, _ = UNITS[name]
    fraction_bits = draw(st.integers(4, 40))
    angle_bits = draw(st.integers(4, 44))
    iterations = draw(st.integers(1, 48))
    sequence = scaled(draw, m, iterations) if make is None else make(m, iterations)
    coordinate_bits = draw(st.sampled_from((fraction_bits + SAFE_BITS, COORDINATE_BITS)))
    table = shift_sequences.step_table(sequence, angle_bits, coordinate_bits)
    one, turn = 1 << fraction_bits, 8 << angle_bits
    coordinate = st.one_of(st.integers(-one, one), st.sampled_from((-one, -one + 1, -1, 0, 1, one - 1, one)))
    angle = st.one_of(st.integers(-turn, turn), st.sampled_from((-turn, -1, 0, 1, turn)))
    row = st.tuples(*[coordinate] * (operands - 1), angle)
    rows = draw(st.lists(row, min_size=1, max_size=6))
    return table, [list(column) for column in zip(*rows, strict=True)]


@pytest.mark.parametrize(("name", "m"), quick(CASES, *CASES[::2]), ids=lambda v: str(v))
@given(data=st.data())
@settings(deadline=None, max_examples=examples(60))
def test_every_kernel_is_the_same_on_int64_and_on_python_integers(name, m, data):
    table, columns = data.draw(runs(name, m))
    kernel = UNITS[name][0]
    fast = [np.array(c, dtype=np.int64) for c in columns]
    narrow = kernel(*fast, table)
    wide = kernel(*(np.array(c, dtype=object) for c in columns), table)
    assert [a.tolist() for a in fast] == columns
    assert len(narrow) == len(wide)
    for a, b in zip(narrow, wide, strict=True):
        assert a.dtype == (np.bool_ if b.dtype == np.bool_ else np.int64)
        assert b.dtype in (object, np.bool_)
        assert b.dtype == np.bool_ or all(isinstance(value, int) for value in b)
        assert a.tolist() == b.tolist()


@given(data=st.data())
@settings(deadline=None)
def test_the_bits_of_coordinates_do_not_change_the_result(data):
    table, columns = data.draw(runs("implicit", 1))
    arrays = [np.array(c, dtype=np.int64) for c in columns]
    widest = micro_rotations.implicit(*arrays, replace(table, coordinate_bits=COORDINATE_BITS))
    for a, b in zip(micro_rotations.implicit(*arrays, table), widest, strict=True):
        assert a.tolist() == b.tolist()


@given(st.integers(0, 44), st.integers(0, 43), st.integers(1, 62), st.data())
@settings(deadline=None, max_examples=examples(400))
def test_products_round_half_up_in_either_arithmetic(value_bits, constant_bits, shift, data):
    largest, limit = 1 << value_bits, 1 << constant_bits
    constant = data.draw(st.integers(1 - limit, limit - 1))
    drawn = data.draw(st.lists(st.integers(-largest, largest), max_size=6))
    values = [*drawn, -largest, largest, 0, 1, -1]
    exact = [(value * constant + (1 << (shift - 1))) >> shift for value in values]
    wide = micro_rotations.multiply_round(np.array(values, dtype=object), constant, shift)
    assert wide.tolist() == exact
    for bits in {max(value_bits, 1), COORDINATE_BITS}:
        if shift >= bits or bits + constant_bits <= 62:
            narrow = micro_rotations.multiply_round(np.array(values, dtype=np.int64), constant, shift, bits)
            assert narrow.tolist() == exact


@pytest.mark.parametrize(("constant", "shift"), [(1 << 43, 10), (1 << 20, 63), (1, 0), (1 << 62, 44)])
def test_products_that_do_not_fit_are_refused(constant, shift):
    with pytest.raises(ValueError, match="do not fit int64"):
        micro_rotations.multiply_round(np.array([1]), constant, shift)


def test_factors_are_below_the_limb_width():
    table = shift_sequences.step_table(shift_sequences.standard(1, 40), 30)
    assert max(table.target_factors) < 1 << (FACTOR_BITS - 1)
    assert FACTOR_BITS >= COORDINATE_BITS
