"""Numbers mantissa * 2^exponent in circuits, as `arith.kernels.blocks` has them."""

from __future__ import annotations

from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.limits import greater
from cordicc.arith.circuits.shifting import length_of, shifted


class Floating(NamedTuple):
    """A number mantissa * 2^exponent."""

    mantissa: CircuitSignal
    exponent: CircuitSignal


def normalised(b: CircuitBuilder, mantissa: CircuitSignal, exponent: CircuitSignal, bits: int) -> Floating:
    """Return a number with a mantissa of `bits` bits, rounded half up; that of 0 is 0."""
    length = length_of(b, b.size(mantissa))
    right = length - bits
    within = (-(1 << bits) if mantissa.lo < 0 else 0, 1 << bits)
    return Floating(shifted(b, mantissa, right, mantissa.width + 1, within), exponent + right)


def widened(number: Floating, bits: int) -> Floating:
    """Append zero bits at the low end."""
    return Floating(number.mantissa << bits, number.exponent - bits)


def added(b: CircuitBuilder, first: Floating, second: Floating) -> Floating:
    """Return a sum at the larger exponent of two numbers, of which 0 has none."""
    least = min(first.exponent.lo, second.exponent.lo)
    own = [b.mux(each.mantissa.equals(0), each.exponent, least) for each in (first, second)]
    exponent = greater(b, own[0], own[1])
    moved = [
        shifted(b, each.mantissa, _below(b, exponent - e), each.mantissa.width + 1)
        for each, e in zip((first, second), own, strict=True)
    ]
    return Floating(moved[0] + moved[1], exponent)


def _below(b: CircuitBuilder, count: CircuitSignal) -> CircuitSignal:
    """Return how far an exponent is below the larger one, which is not negative."""
    return b.narrowed(count, 0, count.hi)
