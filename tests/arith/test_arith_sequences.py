"""Published figures of the shift sequences."""

import numpy as np
import pytest

from cordicc.arith.kernels import shift_sequences


def test_walther_gains_and_domains():
    circular, hyperbolic = shift_sequences.standard(1, 40), shift_sequences.standard(-1, 40)
    assert circular.gain == pytest.approx(1.646760258, abs=1e-9)
    assert hyperbolic.gain == pytest.approx(0.82816, abs=1e-5)
    assert circular.domain == pytest.approx(1.7433, abs=1e-4)
    assert hyperbolic.domain == pytest.approx(1.1182, abs=1e-4)
    assert np.tanh(hyperbolic.domain) == pytest.approx(0.8069, abs=1e-4)


def test_hyperbolic_shifts_repeat():
    shifts = shift_sequences.hyperbolic_shifts(44)
    assert [s for s in set(shifts) if shifts.count(s) == 2] == [4, 13, 40]


@pytest.mark.parametrize("sequence", shift_sequences.shipped(), ids=lambda s: s.name)
def test_shipped_sequences_converge(sequence):
    assert sequence.converges


def test_a_hyperbolic_sequence_without_repeats_fails():
    assert not shift_sequences.Sequence("plain", -1, tuple(range(1, 20))).converges


def test_krieger96_figures():
    paper = shift_sequences.krieger96()
    assert 1 / paper.gain == pytest.approx(0.5779666273350, abs=1e-13)
    assert float(shift_sequences.exact_scaling(paper)) == pytest.approx(0.5779666273255, abs=1e-13)
    assert paper.domain / 2 == pytest.approx(1.6551734327, abs=1e-10)


def test_root_free_gain():
    assert shift_sequences.root_free(1, 18).gain == pytest.approx(2.711819, abs=1e-6)
    assert shift_sequences.root_free(-1, 20).domain == pytest.approx(2.2363, abs=1e-4)
