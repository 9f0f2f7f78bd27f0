"""Coordinates over the gain of the iterations, in circuits."""

from __future__ import annotations

from collections.abc import Mapping

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.circuit import INDEX
from cordicc.arith.circuits.looping import looped
from cordicc.arith.circuits.shifting import times
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import StepTable


def over_gain(b: CircuitBuilder, coordinate: CircuitSignal, table: StepTable) -> CircuitSignal:
    """Return a coordinate over the gain, with `SCALE_BITS` more bits, rounded half up.

    With the time for it, two digits of 1/gain a cycle: an adder does.
    """
    right = table.coordinate_bits + 1 - SCALE_BITS
    digits = booth_digits(table.inverse_gain)
    if b.interval < len(digits):
        return b.rounded(times(b, coordinate, table.inverse_gain), right)
    # The product is high * 4^steps and two bits for each step, of which those from the last before the
    # rounded ones on are held.
    held = 2 * len(digits) - (right - 1)
    size = max(-coordinate.lo, coordinate.hi)

    def step(inner: CircuitBuilder, now: Mapping[str, CircuitSignal]) -> dict[str, CircuitSignal]:
        digit = inner.pick(now[INDEX], [abs(each) for each in digits])
        minus = inner.pick(now[INDEX], [int(each < 0) for each in digits])
        coordinate = now["coordinate"]
        twice = inner.mux(inner.bit(digit, 1), coordinate, coordinate << 1)
        none = digit.equals(0)
        total = inner.addsub(now["high"], inner.mux(none, twice, 0), minus)
        low = (now["low"] >> 2) + (inner.low(total, 2) << (held - 2))
        return {"high": total >> 2, "low": inner.narrowed(low, 0, (1 << held) - 1)}

    b.note("Over the gain: two digits a cycle.")
    # |high| is at most (|high| + 2 |coordinate|) / 4, rounded down.
    states = {"high": (b.of(0), (-size, size)), "low": (b.of(0), (0, (1 << held) - 1))}
    last = looped(b, len(digits), states, {"coordinate": coordinate}, step)
    exact = (last["high"] << held) + last["low"]
    product = coordinate.lo * table.inverse_gain, coordinate.hi * table.inverse_gain
    return b.rounded(b.narrowed(exact, *(end >> (right - 1) for end in product)), 1)


def booth_digits(constant: int) -> list[int]:
    """Return a positive integer to the base of 4 with digits from -2 to 2, the lowest first."""
    found = []
    while constant:
        digit = (constant + 2) % 4 - 2
        if digit == -2 and constant % 8 == 2:
            digit = 2
        found.append(digit)
        constant = (constant - digit) >> 2
    return found
