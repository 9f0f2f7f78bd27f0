"""The angle of iterations in circuits."""

from __future__ import annotations

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal


class Residual:
    """The angle of iterations: what is left of it where it steers them, else the sum of what they turned by.

    Late angles are powers of two, each half of the one before.  Of the angle that is left, a step by such a
    one moves the sign alone; of a sum they are the bits of the directions.  Of a sum nothing is added before
    the end: until then there are the directions.
    """

    def __init__(self, b: CircuitBuilder, angle_bits: int, *, steering: bool, summing: bool) -> None:
        self._b = b
        self._limit = 12 << angle_bits
        self._steering = steering
        self._summing = summing
        self._turns: list[tuple[CircuitSignal, int]] = []

    def after(self, z: CircuitSignal, angle: CircuitSignal, back: CircuitSignal) -> CircuitSignal:
        """Return z less an angle, or with it where a bit is 1."""
        b = self._b
        if self._steering:
            place = angle.hi.bit_length() - 1
            halves = angle.lo == angle.hi == 1 << max(place, 0)
            if halves and -2 * angle.hi <= z.lo and z.hi < 2 * angle.hi:
                return b.recentred(z, place)
            rest = b.addsub(z, angle, ~back)
            return b.narrowed(rest, min(-angle.hi, z.lo + angle.hi), max(angle.hi - 1, z.hi - angle.hi))
        if self._summing and angle.lo == angle.hi:
            self._turns.append((back, angle.lo))
            return z
        return b.narrowed(b.addsub(z, angle, ~back), -self._limit, self._limit)

    def whole(self, z: CircuitSignal) -> CircuitSignal:
        """Return the angle with what the directions stand for: of a few a table, of powers of two bits."""
        b, turns = self._b, self._turns
        if not turns:
            return z
        halving = len(turns) - 1
        while halving and _halves(turns[halving - 1][1], turns[halving][1]):
            halving -= 1
        halving = len(turns) if halving == len(turns) - 1 else halving
        # Directions wait, in the place of what they stand for, until the last ones are near.
        waiting = b.together([bit for bit, _ in turns[:-_LAST]] + [turns[-_LAST][0]], 0.0) if halving else []
        total = z
        for at in range(0, halving, _TABLE):
            group = turns[at : min(at + _TABLE, halving)]
            bits = [waiting[at + n] if at + n < len(waiting) else bit for n, (bit, _) in enumerate(group)]
            sums = [0]
            for _, angle in group:
                sums = [each + sign * angle for each in sums for sign in (-1, 1)]
            total = total + b.pick(b.join(bits, 0), sums)
        late = turns[halving:]
        if late:
            # A bit b is +2^k or -2^k: twice the bits less all of them.
            last = _place(late[-1][1])
            every = (1 << len(late) + last) - (1 << last)
            total = (b.join([bit for bit, _ in late], last) << 1) + (total - every)
        return b.narrowed(total, -self._limit, self._limit)


_TABLE = 4
"""Directions whose sum of angles a table has: a LUT a bit."""

_LAST = 5
"""The directions that are not waited for."""


def _halves(angle: int, following: int) -> bool:
    """Return whether an angle is a power of two, and the following one half of it."""
    return angle == 2 * following == 1 << _place(angle)


def _place(power: int) -> int:
    return power.bit_length() - 1
