"""Builds circuits: arithmetic on signals, whose ranges follow, in as many cycles as a clock period asks for.

A cell is in the cycle in which the last of its operands exists, or in the next one if its result would come
too late in that; operands that exist earlier wait in registers.  So the depth of a pipeline follows from the
delays of its cells and from the period.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from cordicc.arith.circuits.circuit import SIGNAL_NAMES, Circuit, Gate, Port, pruned, width_of
from cordicc.arith.circuits.delays import COMBINATIONAL, Clocking


@dataclass(frozen=True, slots=True, eq=False)
class CircuitSignal:
    """A signal of a circuit that is being built; integers may stand for constant ones in its operations."""

    builder: CircuitBuilder
    number: int

    @property
    def cell(self) -> Gate:
        """The cell that makes the signal."""
        return self.builder.cells[self.number]

    @property
    def lo(self) -> int:
        """Its least value."""
        return self.cell.lo

    @property
    def hi(self) -> int:
        """Its largest value."""
        return self.cell.hi

    @property
    def width(self) -> int:
        """Its bits."""
        return self.cell.width

    def __add__(self, other: Operand) -> CircuitSignal:
        return self.builder.add(self, other)

    def __radd__(self, other: int) -> CircuitSignal:
        return self.builder.add(self, other)

    def __sub__(self, other: Operand) -> CircuitSignal:
        return self.builder.sub(self, other)

    def __rsub__(self, other: int) -> CircuitSignal:
        return self.builder.sub(other, self)

    def __neg__(self) -> CircuitSignal:
        return self.builder.sub(0, self)

    def __mul__(self, other: Operand) -> CircuitSignal:
        return self.builder.mul(self, other)

    def __lshift__(self, count: int) -> CircuitSignal:
        return self.builder.shl(self, count)

    def __rshift__(self, count: int) -> CircuitSignal:
        return self.builder.shr(self, count)

    def __and__(self, other: Operand) -> CircuitSignal:
        return self.builder.bitwise("and", self, other)

    def __or__(self, other: Operand) -> CircuitSignal:
        return self.builder.bitwise("or", self, other)

    def __xor__(self, other: Operand) -> CircuitSignal:
        return self.builder.bitwise("xor", self, other)

    def __invert__(self) -> CircuitSignal:
        """Return the other bit of a bit."""
        return self.builder.invert(self)

    def __lt__(self, other: Operand) -> CircuitSignal:
        return self.builder.less(self, other)

    def __gt__(self, other: Operand) -> CircuitSignal:
        return self.builder.less(other, self)

    def __le__(self, other: Operand) -> CircuitSignal:
        return ~self.builder.less(other, self)

    def __ge__(self, other: Operand) -> CircuitSignal:
        return ~self.builder.less(self, other)

    def equals(self, other: Operand) -> CircuitSignal:
        """Return a bit that tells whether both are equal."""
        return self.builder.equal(self, other)


Operand = CircuitSignal | int


class CircuitBuilder:
    """A circuit while it is built."""

    def __init__(self, name: str, clocking: Clocking = COMBINATIONAL) -> None:
        self.name = name
        self.cells: list[Gate] = []
        self.clocking = clocking
        self._arrivals: list[float] = []
        self._made: dict[tuple[object, ...], int] = {}
        self._later: dict[int, int] = {}
        self._inputs: list[Port] = []
        self._outputs: list[tuple[str, CircuitSignal]] = []
        self._notes: dict[int, str] = {}
        self._note: str | None = None
        self._names: set[str] = set()
        self._scope: list[str] = []

    def cycles(self) -> int:
        """Return the cycles after which all outputs are in registers, 0 if nothing is clocked."""
        if self.clocking.period_ns == math.inf:
            return 0
        last = max((signal.cell.cycle or 0 for _, signal in self._outputs), default=0)
        ends = [s for _, s in self._outputs if s.cell.cycle == last and self._arrivals[s.number] > 0]
        return last + bool(ends)

    def circuit(self, latency: int | None = None) -> Circuit:
        """Return what was built, with all outputs after some cycles, those that they need if None.

        Raises:
            ValueError: the outputs need more cycles.
        """
        cycles = self.cycles() if latency is None else latency
        if cycles < self.cycles():
            raise ValueError(f"{self.name} takes {self.cycles()} cycles, not {cycles}")
        outputs = [Port(name, self._at(signal, cycles).number) for name, signal in self._outputs]
        return pruned(self.name, self.cells, self._inputs, outputs, self._notes)

    def together(self, signals: Sequence[CircuitSignal], ahead_ns: float) -> list[CircuitSignal]:
        """Return signals as they exist in one cycle, in which what takes some time yet can follow."""
        clocked = [signal for signal in signals if signal.cell.cycle is not None]
        cycle = max((signal.cell.cycle or 0 for signal in clocked), default=0)
        late = max((self._arrivals[s.number] for s in clocked if s.cell.cycle == cycle), default=0.0)
        if late > 0 and late + ahead_ns > self.clocking.period_ns:
            cycle += 1
        return [self._at(signal, cycle) for signal in signals]

    def taken_ns(self, before: Sequence[CircuitSignal], after: Sequence[CircuitSignal]) -> float:
        """Return the time from signals to others, infinite if they are not in the same cycle."""
        cycles = {signal.cell.cycle for signal in (*before, *after)} - {None}
        if len(cycles) > 1:
            return math.inf
        start, end = (max(self._arrivals[each.number] for each in signals) for signals in (before, after))
        return end - start

    def note(self, text: str) -> None:
        """Say something of the cells that follow."""
        self._note = text

    @contextmanager
    def scope(self, prefix: str) -> Iterator[None]:
        """Let the names of cells begin with a prefix."""
        self._scope.append(prefix)
        yield
        self._scope.pop()

    def input(self, name: str, lo: int, hi: int) -> CircuitSignal:
        """Return an input with its range."""
        made = self._cell("input", (), (), lo, hi, name=name)
        self._inputs.append(Port(name, made.number))
        return made

    def word(self, name: str, width: int) -> CircuitSignal:
        """Return an input in two's complement."""
        return self.input(name, -(1 << (width - 1)), (1 << (width - 1)) - 1)

    def output(self, name: str, signal: Operand) -> None:
        """Let a signal leave."""
        self._outputs.append((name, self.of(signal)))

    def of(self, value: Operand) -> CircuitSignal:
        """Return a signal, of an integer a constant one."""
        if isinstance(value, CircuitSignal):
            return value
        return self._cell("constant", (), (value,), value, value)

    def named(self, name: str, signal: CircuitSignal) -> CircuitSignal:
        """Return a signal under a name of its own, if it has none that somebody chose."""
        cell = signal.cell
        if cell.kind not in ("input", "constant") and cell.name.endswith("_"):
            full = self._unique("_".join([*self._scope, name]))
            self.cells[signal.number] = Gate(
                cell.kind, cell.operands, cell.params, cell.lo, cell.hi, cell.cycle, full
            )
        return signal

    def add(self, a: Operand, b: Operand) -> CircuitSignal:
        """Return a + b."""
        a, b = self.of(a), self.of(b)
        if b.lo == b.hi == 0:
            return a
        if a.lo == a.hi == 0:
            return b
        for one, other in ((a, b), (b, a)):
            floor, half = self._parts(other)
            if half is not None:
                return self._cell("addc", (one, floor, half), (), a.lo + b.lo, a.hi + b.hi)
        return self._cell("add", (a, b), (), a.lo + b.lo, a.hi + b.hi)

    def addc(self, a: Operand, b: Operand, carry: CircuitSignal) -> CircuitSignal:
        """Return a + b + carry, a bit."""
        a, b = self.of(a), self.of(b)
        return self._cell("addc", (a, b, carry), (), a.lo + b.lo + carry.lo, a.hi + b.hi + carry.hi)

    def sub(self, a: Operand, b: Operand) -> CircuitSignal:
        """Return a - b."""
        a, b = self.of(a), self.of(b)
        if b.lo == b.hi == 0:
            return a
        floor, half = self._parts(b)
        if half is not None:
            parts = (a, floor, self.of(1), self.invert(half))
            return self._cell("addsub", parts, (), a.lo - b.hi, a.hi - b.lo)
        return self._cell("sub", (a, b), (), a.lo - b.hi, a.hi - b.lo)

    def addsub(self, a: Operand, b: Operand, minus: CircuitSignal) -> CircuitSignal:
        """Return a - b where a bit is 1, else a + b: one chain of carries, even if b is a rounded number."""
        a, b = self.of(a), self.of(b)
        if b.lo == b.hi == 0:
            return a
        if minus.lo == minus.hi:
            return self.sub(a, b) if minus.lo else self.add(a, b)
        ends = (a.lo + b.lo, a.lo - b.hi), (a.hi + b.hi, a.hi - b.lo)
        floor, half = self._parts(b)
        carry = minus if half is None else half ^ minus
        return self._cell("addsub", (a, floor, minus, carry), (), min(ends[0]), max(ends[1]))

    def _parts(self, a: CircuitSignal) -> tuple[CircuitSignal, CircuitSignal | None]:
        """Return what a rounded number is rounded down, and the bit that is added to it."""
        if a.cell.kind != "round":
            return a, None
        (number,), (count,) = a.cell.operands, a.cell.params
        inner = CircuitSignal(self, number)
        return self.shr(inner, count), self.bit(inner, count - 1)

    def negif(self, a: Operand, minus: CircuitSignal) -> CircuitSignal:
        """Return -a where a bit is 1, else a."""
        a = self.of(a)
        return self._cell("negif", (a, minus), (), min(a.lo, -a.hi), max(a.hi, -a.lo))

    def size(self, a: CircuitSignal) -> CircuitSignal:
        """Return |a|."""
        if a.lo >= 0:
            return a
        return self.narrowed(self.negif(a, self.negative(a)), 0, max(-a.lo, a.hi))

    def mul(self, a: Operand, b: Operand) -> CircuitSignal:
        """Return a b."""
        a, b = self.of(a), self.of(b)
        ends = [p * q for p in (a.lo, a.hi) for q in (b.lo, b.hi)]
        return self._cell("mul", (a, b), (), min(ends), max(ends))

    def shl(self, a: Operand, count: int) -> CircuitSignal:
        """Return a 2^count, of a negative count rounded down."""
        a = self.of(a)
        if count < 0:
            return self.shr(a, -count)
        return a if not count else self._cell("shl", (a,), (count,), a.lo << count, a.hi << count)

    def shr(self, a: Operand, count: int) -> CircuitSignal:
        """Return a / 2^count rounded down."""
        a = self.of(a)
        if count < 0:
            return self.shl(a, -count)
        return a if not count else self._cell("shr", (a,), (count,), a.lo >> count, a.hi >> count)

    def rounded(self, a: CircuitSignal, count: int) -> CircuitSignal:
        """Return a / 2^count rounded half up; a 2^-count of a negative count."""
        if count <= 0:
            return self.shl(a, -count)
        half = 1 << (count - 1)
        return self._cell("round", (a,), (count,), (a.lo + half) >> count, (a.hi + half) >> count)

    def shlv(self, a: Operand, count: CircuitSignal, within: tuple[int, int] | None = None) -> CircuitSignal:
        """Return a 2^count, a multiplexer a bit of the count; it is known to lie within a range perhaps."""
        found = self.of(a)
        for place in reversed(range(count.hi.bit_length())):
            found = self.mux(self.bit(count, place), found, found << (1 << place))
            if within is not None:
                found = self.narrowed(found, *within)
        return found if within is not None else self._between(found, self.of(a), count, self.shl)

    def shrv(self, a: Operand, count: CircuitSignal) -> CircuitSignal:
        """Return a / 2^count rounded down, a multiplexer a bit of the count."""
        found = self.of(a)
        for place in reversed(range(count.hi.bit_length())):
            found = self.mux(self.bit(count, place), found, found >> (1 << place))
        return self._between(found, self.of(a), count, self.shr)

    def _between(
        self,
        found: CircuitSignal,
        a: CircuitSignal,
        count: CircuitSignal,
        shift: Callable[[int, int], CircuitSignal],
    ) -> CircuitSignal:
        """Return a shifted number with the range that the ends of the count leave."""
        ends = [(shift(a.lo, n).lo, shift(a.hi, n).hi) for n in (count.lo, count.hi)]
        return self.narrowed(found, min(low for low, _ in ends), max(high for _, high in ends))

    def roundedv(self, a: CircuitSignal, count: CircuitSignal) -> CircuitSignal:
        """Return a / 2^count rounded half up."""
        return self.rounded(self.shrv(self.shl(a, 1), count), 1)

    def low(self, a: CircuitSignal, count: int) -> CircuitSignal:
        """Return a modulo 2^count."""
        if a.lo >= 0 and a.hi < 1 << count:
            return a
        return self._cell("low", (a,), (count,), 0, (1 << count) - 1)

    def bit(self, a: CircuitSignal, place: int) -> CircuitSignal:
        """Return a bit, of two's complement at any place."""
        return self.low(self.shr(a, place), 1)

    def negative(self, a: CircuitSignal) -> CircuitSignal:
        """Return a bit that tells whether a < 0."""
        if a.lo >= 0:
            return self.of(0)
        return self.of(1) if a.hi < 0 else self.bit(a, a.width - 1)

    def less(self, a: Operand, b: Operand) -> CircuitSignal:
        """Return a bit that tells whether a < b."""
        a, b = self.of(a), self.of(b)
        if b.lo == b.hi == 0:
            return self.negative(a)
        if a.hi < b.lo or a.lo >= b.hi:
            return self.of(int(a.hi < b.lo))
        return self._cell("lt", (a, b), (), 0, 1)

    def equal(self, a: Operand, b: Operand) -> CircuitSignal:
        """Return a bit that tells whether a = b."""
        a, b = self.of(a), self.of(b)
        if a.hi < b.lo or b.hi < a.lo:
            return self.of(0)
        return self._cell("eq", (a, b), (), 0, 1)

    def bitwise(self, kind: str, a: Operand, b: Operand) -> CircuitSignal:
        """Return "and", "or" or "xor" of all bits."""
        a, b = self.of(a), self.of(b)
        for x, y in ((a, b), (b, a)):
            if x.lo == x.hi and y.lo >= 0 and y.hi <= 1 and x.lo in (0, 1):
                plain = {"and": y if x.lo else self.of(0), "or": self.of(1) if x.lo else y}
                return plain[kind] if kind in plain else self.invert(y) if x.lo else y
        width = max(each.width + (each.lo >= 0) for each in (a, b))
        if a.lo >= 0 and b.lo >= 0:
            return self._cell(kind, (a, b), (), 0, (1 << (width - 1)) - 1)
        return self._cell(kind, (a, b), (), -(1 << (width - 1)), (1 << (width - 1)) - 1)

    def invert(self, a: CircuitSignal) -> CircuitSignal:
        """Return the other bit."""
        if a.lo == a.hi:
            return self.of(1 - a.lo)
        return self._cell("not", (a,), (), 0, 1)

    def mux(self, choice: CircuitSignal, a: Operand, b: Operand) -> CircuitSignal:
        """Return b where a bit is 1, else a."""
        a, b = self.of(a), self.of(b)
        if choice.lo == choice.hi:
            return b if choice.lo else a
        if a.number == b.number:
            return a
        return self._cell("mux", (choice, a, b), (), min(a.lo, b.lo), max(a.hi, b.hi))

    def pick(self, index: CircuitSignal, values: Sequence[int]) -> CircuitSignal:
        """Return the value with a number; those beyond the last are the last."""
        values = list(values)[: index.hi + 1]
        if len(set(values)) == 1:
            return self.of(values[0])
        values += [values[-1]] * (index.hi + 1 - len(values))
        return self._cell("pick", (index,), tuple(values), min(values), max(values))

    def join(self, bits: Sequence[CircuitSignal], place: int) -> CircuitSignal:
        """Return the number of some bits, the highest first, of which the last has the value 2^place."""
        return self._cell("join", bits, (place,), 0, ((1 << len(bits)) - 1) << place)

    def recentred(self, a: CircuitSignal, place: int) -> CircuitSignal:
        """Return a - 2^place of an a that is not negative, else a + 2^place, without an adder.

        |a| is at most 2^(place + 1), and less if positive.
        """
        half = 1 << place
        assert -2 * half <= a.lo
        assert a.hi < 2 * half
        return self._cell("cut", (self.bitwise("xor", self.low(a, place + 1), half),), (), -half, half - 1)

    def narrowed(self, a: CircuitSignal, lo: int, hi: int, *, loose: bool = False) -> CircuitSignal:
        """Return a signal that is known to lie in a smaller range; if `loose`, where anybody looks at it."""
        lo, hi = max(lo, a.lo), min(hi, a.hi)
        if width_of(lo, hi) == a.width and (lo < 0) == (a.lo < 0):
            return a
        if loose:
            bits = width_of(lo, hi)
            ends = (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) if lo < 0 else (0, (1 << bits) - 1)
            return self._cell("cut", (a,), (), *ends)
        return self._cell("narrow", (a,), (), lo, hi)

    def as_word(self, a: CircuitSignal, width: int) -> CircuitSignal:
        """Return a number, which a word of a width holds, as such a word."""
        return self._cell("narrow", (a,), (), -(1 << (width - 1)), (1 << (width - 1)) - 1)

    def within(self, a: CircuitSignal, limit: Operand) -> CircuitSignal:
        """Return whether |a| is at most a limit that is not negative; of 2^k - 1 the leading bits tell."""
        limit = self.of(limit)
        if limit.lo == limit.hi and limit.hi & (limit.hi + 1) == 0 and a.lo < -limit.hi and a.hi > limit.hi:
            # All leading bits are the sign, and the rest is not 0 of a negative number.
            places = limit.hi.bit_length()
            top, sign = a >> places, self.negative(a)
            return self.mux(sign, top.equals(0), top.equals(-1) & ~self.low(a, places).equals(0))
        return (a <= limit) & (a >= -limit)

    def clipped(self, a: CircuitSignal, lo: Operand, hi: Operand) -> CircuitSignal:
        """Return the nearest value from `lo` to `hi`."""
        lo, hi = self.of(lo), self.of(hi)
        low = self.mux(self.less(a, lo), a, lo)
        both = self.mux(self.less(hi, a), low, hi)
        return self.narrowed(both, lo.lo, hi.hi)

    def _at(self, signal: CircuitSignal, cycle: int) -> CircuitSignal:
        """Return a signal as it exists in a cycle, behind registers."""
        while signal.cell.cycle is not None and signal.cell.cycle < cycle:
            later = self._later.get(signal.number)
            if later is None:
                cell = signal.cell
                assert cell.cycle is not None
                base = cell.name.rstrip("_")
                name = self._unique(f"{base.rpartition('_q')[0] or base}_q{cell.cycle + 1}")
                later = len(self.cells)
                self.cells.append(
                    Gate("register", (signal.number,), (), cell.lo, cell.hi, cell.cycle + 1, name)
                )
                self._arrivals.append(0.0)
                self._later[signal.number] = later
            signal = CircuitSignal(self, later)
        return signal

    def _cell(
        self,
        kind: str,
        operands: Sequence[CircuitSignal],
        params: tuple[int, ...],
        lo: int,
        hi: int,
        name: str | None = None,
    ) -> CircuitSignal:
        if kind not in ("input", "constant") and lo == hi:
            return self.of(lo)
        key = (kind, *(each.number for each in operands), params, lo, hi)
        if name is None and key in self._made:
            return CircuitSignal(self, self._made[key])
        cycles = [each.cell.cycle for each in operands if each.cell.cycle is not None]
        constant = kind == "constant" or (bool(operands) and not cycles)
        cycle = max(cycles, default=0)
        start = max(
            (self._arrivals[each.number] for each in operands if each.cell.cycle == cycle), default=0.0
        )
        taken = 0.0 if constant else self.clocking.delay_ns(kind, [each.cell for each in operands], lo, hi)
        if start > 0 and taken > 0 and start + taken > self.clocking.period_ns:
            cycle, start = cycle + 1, 0.0
        numbers = tuple(self._at(each, cycle).number for each in operands)
        number = len(self.cells)
        if name is None:
            name = self._unique("_".join([*self._scope, SIGNAL_NAMES.get(kind, kind)])) + "_"
        else:
            self._names.add(name)
        self.cells.append(Gate(kind, numbers, params, lo, hi, None if constant else cycle, name))
        self._arrivals.append(self.clocking.entry_ns if kind == "input" else start + taken)
        self._made[key] = number
        if self._note is not None and kind != "constant":
            self._notes[number] = self._note
            self._note = None
        return CircuitSignal(self, number)

    def _unique(self, name: str) -> str:
        found, count = name, 2
        while found in self._names:
            found, count = f"{name}{count}", count + 1
        self._names.add(found)
        return found
