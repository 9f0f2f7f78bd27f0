"""`cordicc trace --bits` turns to the end of reach as units do."""

import pytest

from cordicc.arith.kernels import shift_sequences
from cordicc.studies import fixed_iterations, iterations

mp = iterations.mp


@pytest.mark.parametrize(("A", "B", "C"), [(3, 4, 5), (8, 6, 10), (11, 60, 61)])
def test_a_target_at_the_end_ends_with_x_at_0(A: int, B: int, C: int) -> None:
    start = iterations.State(mp.mpf(A) / C, mp.mpf(B) / C, mp.mpf(0), mp.mpf(1))
    sequence = shift_sequences.standard(1, 18)
    run = iterations.implicit(sequence, start, "-")
    _, rows = fixed_iterations.fixed_rows("implicit", sequence, run, 16)
    assert abs(rows[-1].x) <= 2
    exact = mp.ldexp(mp.pi / 2 - mp.atan2(B, A), 16)
    assert abs(rows[-1].z - exact) <= 3
