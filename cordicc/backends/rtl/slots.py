"""The slots of an interval in a core: which of them it is, as bits in registers."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from cordicc.backends.rtl.module_text import literal

RING_SLOTS = 64
"""Slots up to which each has a register, in a ring; of more those that are used have one, and a counter."""

_DIGIT_BITS = 4
"""Of a digit of such a counter, which is decoded at once."""


class Slots:
    """The registers of the slots of a core.

    In reset it is the last slot, so that no sample is taken; then the first one.  The slots that are used are
    those whose bits have been asked for.
    """

    def __init__(self, interval: int, name: Callable[[str], str]) -> None:
        """Take the interval, and what makes the names of signals."""
        self._interval = interval
        self._places: set[int] = set()
        self._name = name
        self._slot = name("slot") if interval > 1 else ""
        self._bits = (interval - 1).bit_length()
        self._counts = interval > RING_SLOTS

    def bit(self, cycle: int) -> str:
        """Return the bit of the slot of a cycle, nothing where every cycle is alike."""
        if self._interval == 1:
            return ""
        place = cycle % self._interval
        self._places.add(place)
        return self._register(place) if self._counts else f"{self._slot}[{place}]"

    @property
    def registers(self) -> int:
        """Bits of their registers."""
        if self._interval == 1:
            return 0
        return self._bits + len(self._places) if self._counts else self._interval

    def declared(self) -> Iterator[str]:
        """Yield the registers, and what follows from them."""
        if self._interval == 1:
            return
        if not self._counts:
            yield "    // One-hot: one slot after the other; samples enter in slot 0.  It is the last in"
            yield "    // reset, so that in_ready is low."
            yield f"    reg [{self._interval - 1}:0] {self._slot};"
        else:
            yield "    // The slot; samples enter in slot 0.  In reset it is the last: in_ready is low."
            yield "    // A slot in which something is taken has a register."
            yield f"    reg [{self._bits - 1}:0] {self._slot};"
            for low in range(0, self._bits, _DIGIT_BITS):
                count = min(_DIGIT_BITS, self._bits - low)
                part = f"{self._slot}[{low + count - 1}:{low}]" if count > 1 else f"{self._slot}[{low}]"
                for value in sorted({self._digit(place, low) for place in self._used}):
                    yield f"    wire {self._is(low, value)} = {part} == {literal(value, count)};"
            yield f"    reg {', '.join(map(self._register, self._used))};"
        yield f"    assign in_ready = {self.bit(0)};"
        yield ""

    def resets(self) -> list[str]:
        """Return what they are in reset."""
        if self._interval == 1:
            return []
        if not self._counts:
            return [f"{self._slot} <= {literal(1 << (self._interval - 1), self._interval)};"]
        none = [f"{self._register(place)} <= 1'd0;" for place in self._used]
        return [f"{self._slot} <= {literal(self._interval - 1, self._bits)};", *none]

    def steps(self) -> list[str]:
        """Return what they become in each cycle."""
        slot, last = self._slot, self._interval - 1
        if self._interval == 1:
            return []
        if not self._counts:
            return [f"{slot} <= {{{slot}[{last - 1}:0], {slot}[{last}]}};"]
        first, one, end = (literal(value, self._bits) for value in (0, 1, last))
        counted = f"{slot} <= ({slot} == {end}) ? {first} : {slot} + {one};"
        return [counted, *(f"{self._register(place)} <= {self._before(place)};" for place in self._used)]

    def _register(self, place: int) -> str:
        return self._name(f"at_{place}")

    @property
    def _used(self) -> list[int]:
        return sorted(self._places)

    def _digit(self, place: int, low: int) -> int:
        """Return a digit, from a bit on, of the slot before a place."""
        return (place - 1) % self._interval >> low & (1 << _DIGIT_BITS) - 1

    def _is(self, low: int, value: int) -> str:
        """Return the wire that tells whether a digit of the counter has a value."""
        return self._name(f"slot_digit{low // _DIGIT_BITS}_is_{value}")

    def _before(self, place: int) -> str:
        """Return whether it is the slot before a place."""
        lows = range(0, self._bits, _DIGIT_BITS)
        return " && ".join(self._is(low, self._digit(place, low)) for low in lows)
