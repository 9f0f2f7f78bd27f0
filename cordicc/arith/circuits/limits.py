"""Blocks of circuits: comparisons with limits."""

from __future__ import annotations

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal, Operand


def greater(b: CircuitBuilder, first: CircuitSignal, second: CircuitSignal) -> CircuitSignal:
    """Return the larger of two numbers."""
    return b.narrowed(
        b.mux(first < second, first, second), max(first.lo, second.lo), max(first.hi, second.hi)
    )


def limited(b: CircuitBuilder, count: CircuitSignal, most: int) -> CircuitSignal:
    """Return a count of places, of more than `most` that many."""
    if count.hi <= most:
        return count
    return b.narrowed(b.mux(count > most, count, most), count.lo, most)


def within(b: CircuitBuilder, a: CircuitSignal, limit: Operand) -> CircuitSignal:
    """Return whether |a| is at most a limit that is not negative; of 2^k - 1 the leading bits tell."""
    limit = b.of(limit)
    if limit.lo == limit.hi and limit.hi & (limit.hi + 1) == 0 and a.lo < -limit.hi and a.hi > limit.hi:
        # All leading bits are the sign, and the rest is not 0 of a negative number.
        places = limit.hi.bit_length()
        top, sign = a >> places, b.negative(a)
        return b.mux(sign, top.equals(0), top.equals(-1) & ~b.low(a, places).equals(0))
    return (a <= limit) & (a >= -limit)


def clipped(b: CircuitBuilder, a: CircuitSignal, lo: Operand, hi: Operand) -> CircuitSignal:
    """Return the nearest value from `lo` to `hi`."""
    lo, hi = b.of(lo), b.of(hi)
    low = b.mux(b.less(a, lo), a, lo)
    both = b.mux(b.less(hi, a), low, hi)
    return b.narrowed(both, lo.lo, hi.hi)
