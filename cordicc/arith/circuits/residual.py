"""The angle of iterations in circuits."""

from __future__ import annotations

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal


class Residual:
    """The angle of iterations: what is left of it where it steers them, else the sum of what they turned by.

    Late angles are powers of two, each half of the one before.  Of the angle that is left, a step by such a
    one moves the sign alone; of a sum they are the bits of the directions.
    """

    def __init__(self, b: CircuitBuilder, angle_bits: int, *, steering: bool, summing: bool) -> None:
        self._b = b
        self._limit = 12 << angle_bits
        self._steering = steering
        self._summing = summing
        self._bits: list[CircuitSignal] = []
        self._next: int | None = None

    def after(self, z: CircuitSignal, angle: CircuitSignal, back: CircuitSignal) -> CircuitSignal:
        """Return z less an angle, or with it where a bit is 1."""
        b = self._b
        place = angle.hi.bit_length() - 1
        halves = angle.lo == angle.hi == 1 << max(place, 0)
        if self._steering:
            if halves and -2 * angle.hi <= z.lo and z.hi < 2 * angle.hi:
                return b.recentred(z, place)
            rest = b.addsub(z, angle, ~back)
            return b.narrowed(rest, min(-angle.hi, z.lo + angle.hi), max(angle.hi - 1, z.hi - angle.hi))
        if self._summing and halves and self._next in (None, place):
            self._bits.append(back)
            self._next = place - 1
            return z
        return b.narrowed(b.addsub(z, angle, ~back), -self._limit, self._limit)

    def whole(self, z: CircuitSignal) -> CircuitSignal:
        """Return the angle with what bits stand for."""
        if not self._bits:
            return z
        b, last = self._b, (self._next or 0) + 1
        # A bit b is +2^k or -2^k: twice the bits less all of them.
        every = (1 << len(self._bits) + last) - (1 << last)
        total = (b.join(self._bits, last) << 1) + (z - every)
        return b.narrowed(total, -self._limit, self._limit)
