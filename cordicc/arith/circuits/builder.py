"""Builds circuits: arithmetic on signals, whose ranges follow, in the cycles that a clock period asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cordicc.arith.circuits.cell_delays import COMBINATIONAL, Clocking
from cordicc.arith.circuits.cell_pipeline import CellPipeline
from cordicc.arith.circuits.circuit import Circuit, Gate, Loop, Port, pruned, width_of


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

    def __init__(self, name: str, clocking: Clocking = COMBINATIONAL, interval: int = 1) -> None:
        self.name = name
        self.clocking = clocking
        self.interval = interval  # cycles from one operation to the next
        self._pipeline = CellPipeline(clocking)
        self._inputs: list[Port] = []
        self._outputs: list[tuple[str, int]] = []
        self._loops: list[Loop] = []
        # The longest step of a loop, with the way to its registers.
        self.step_ns = 0.0
        # Comments and prefixes of names for the cells that follow.
        self.note = self._pipeline.comment
        self.scope = self._pipeline.scope

    @property
    def cells(self) -> Sequence[Gate]:
        """The cells so far."""
        return self._pipeline.cells

    def cycles(self) -> int:
        """Return the cycles after which all outputs are in registers, 0 if nothing is clocked."""
        return self._pipeline.cycles([number for _, number in self._outputs])

    def circuit(self, latency: int | None = None) -> Circuit:
        """Return what was built, with all outputs after some cycles, those that they need if None.

        Raises:
            ValueError: the outputs need more cycles.
        """
        cycles = self.cycles() if latency is None else latency
        if cycles < self.cycles():
            raise ValueError(f"{self.name} takes {self.cycles()} cycles, not {cycles}")
        outputs = [Port(name, self._pipeline.at(number, cycles)) for name, number in self._outputs]
        return pruned(self.name, self.cells, self._inputs, outputs, self._pipeline.notes, self._loops)

    def turning(
        self, loop: Loop, operands: Sequence[CircuitSignal], spans: Sequence[tuple[int, int]], step_ns: float
    ) -> list[CircuitSignal]:
        """Return the states of a loop after its steps, each of which takes some time; see `looping`."""
        self.step_ns = max(self.step_ns, step_ns)
        self._loops.append(loop)
        numbers = [signal.number for signal in operands]
        found = self._pipeline.loop(numbers, len(self._loops) - 1, spans, loop.steps)
        return [CircuitSignal(self, number) for number in found]

    def latest_ns(self) -> float:
        """Return when the last output exists in its cycle."""
        return self._pipeline.latest_ns([number for _, number in self._outputs])

    def together(self, signals: Sequence[CircuitSignal], ahead_ns: float) -> list[CircuitSignal]:
        """Return signals as they exist in one cycle, in which what takes some time yet can follow."""
        numbers = self._pipeline.together([signal.number for signal in signals], ahead_ns)
        return [CircuitSignal(self, number) for number in numbers]

    def taken_ns(self, before: Sequence[CircuitSignal], after: Sequence[CircuitSignal]) -> float:
        """Return the time from signals to others, infinite if they are not in the same cycle."""
        return self._pipeline.taken_ns(*([each.number for each in signals] for signals in (before, after)))

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
        self._outputs.append((name, self.of(signal).number))

    def of(self, value: Operand) -> CircuitSignal:
        """Return a signal, of an integer a constant one."""
        if isinstance(value, CircuitSignal):
            return value
        return self._cell("constant", (), (value,), value, value)

    def named(self, name: str, signal: CircuitSignal) -> CircuitSignal:
        """Return a signal under a name of its own, if it has none that somebody chose."""
        self._pipeline.call(signal.number, name)
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
        if a.number == b.number:
            return self.of(0)
        if (parts := self.negif_of(b)) is not None:
            return self.addsub(a, parts[0], ~parts[1])
        floor, half = self._parts(b)
        if half is not None:
            return self._cell("subc", (a, floor, half), (), a.lo - b.hi, a.hi - b.lo)
        return self._cell("sub", (a, b), (), a.lo - b.hi, a.hi - b.lo)

    def addsub(self, a: Operand, b: Operand, minus: CircuitSignal) -> CircuitSignal:
        """Return a - b where a bit is 1, else a + b: one chain of carries, even if b is a rounded number."""
        a, b = self.of(a), self.of(b)
        if b.lo == b.hi == 0:
            return a
        if minus.lo == minus.hi:
            return self.sub(a, b) if minus.lo else self.add(a, b)
        if a.lo == a.hi == 0:
            return self.negif(b, minus)
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
        if (parts := self.negif_of(a)) is not None:
            return self.negif(parts[0], parts[1] ^ minus)
        return self._cell("negif", (a, minus), (), min(a.lo, -a.hi), max(a.hi, -a.lo))

    def negif_of(self, a: CircuitSignal) -> tuple[CircuitSignal, CircuitSignal] | None:
        """Return a number and the bit that negates it, of which a signal is made, else None."""
        if a.cell.kind != "negif":
            return None
        number, minus = (CircuitSignal(self, each) for each in a.cell.operands)
        return number, minus

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
        if count and (parts := self.negif_of(a)) is not None:
            return self.negif(self.shl(parts[0], count), parts[1])
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
        """Return a bit that tells whether a < b: the sign of their difference, which a carry would be too.

        A carry that leaves its chain takes longer than the chain's last sum.
        """
        a, b = self.of(a), self.of(b)
        if b.lo == b.hi == 0:
            return self.negative(a)
        if a.hi < b.lo or a.lo >= b.hi:
            return self.of(int(a.hi < b.lo))
        return self.negative(self.sub(a, b))

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
        if values == list(range(len(values))):
            return index
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
        numbers = [each.number for each in operands]
        return CircuitSignal(self, self._pipeline.place(kind, numbers, params, lo, hi, name))
