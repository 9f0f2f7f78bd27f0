"""The circuit of an implicit unit: B cos t + A sin t = C solved by turning (A, B) until y = C."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.circular_solving import Begun, Last, Solved, Start, circular
from cordicc.arith.circuits.hyperbolic_solving import hyperbolic
from cordicc.arith.circuits.near_end import Limit
from cordicc.arith.circuits.residual import Residual
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.uses import Modes, Use, format_of, of_system, word
from cordicc.arith.circuits.words import WordResult, encoded, encoded_angle
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, StepTable, exact_stretch
from cordicc.arith.unit.cau import Cau, implicit_steps


class _System(NamedTuple):
    m: int
    chosen: CircuitSignal
    table: StepTable
    begun: Begun


def implicit_unit(
    b: CircuitBuilder,
    unit: Cau,
    uses: tuple[Use, ...],
    operands: tuple[CircuitSignal, ...],
    mode: CircuitSignal,
) -> tuple[WordResult | None, WordResult | None]:
    """Return t and sqrt(A^2 + m B^2 - m C^2) as words.

    Args:
        b: the builder.
        unit: the sizes of the unit, and its rule.
        uses: what it is used for.
        operands: the words A, B and C.
        mode: the number of the use.

    Raises:
        NoCircuitError: a use has none.
    """
    modes = Modes(b, mode, uses)
    words = tuple(word(modes, bits, number) for number, bits in enumerate(operands))
    systems = []
    for m, make in ((1, circular), (-1, hyperbolic)):
        if any(use.m == m for use in uses):
            begun = make(b, modes, unit, words)
            systems.append(_System(m, modes.which(of_system(m)), implicit_steps(unit, m), begun))
    last = _Iterations(b, systems, unit).last()
    solved = systems[0].begun.finish(last)
    for system in systems[1:]:
        solved = Solved(
            *(b.mux(system.chosen, x, y) for x, y in zip(solved, system.begun.finish(last), strict=True))
        )
    formats = [format_of(modes, number, unit.angle_bits) for number in range(2)]
    results: list[WordResult | None] = [None, None]
    if formats[0] is not None:
        found = encoded_angle(b, solved.angle, -unit.angle_bits, formats[0], unit.angle_bits)
        angle = b.mux(solved.zero, found.word, 0)
        results[0] = WordResult(angle, (found.valid | solved.zero) & solved.possible)
    if formats[1] is not None:
        scaled = None
        for system in systems:
            product = times(b, solved.rest, system.table.inverse_gain)
            own = b.rounded(product, system.table.coordinate_bits + 1 - SCALE_BITS)
            scaled = own if scaled is None else b.mux(system.chosen, scaled, own)
        assert scaled is not None
        found = encoded(b, scaled, solved.place - SCALE_BITS, formats[1])
        results[1] = WordResult(found.word, found.valid & solved.possible)
    return results[0], results[1]


class _Iterations:
    """The steps that turn (x, y) until y is the target and x >= 0.

    In the last steps the target stands for y, see `shift_sequences.blended`. There what is left of y is how
    far it is from the target, a number of few bits.
    """

    def __init__(self, b: CircuitBuilder, systems: Sequence[_System], unit: Cau) -> None:
        self._b = b
        self._systems = systems
        self._unit = unit
        self._start = systems[0].begun.start
        for system in systems[1:]:
            moved = (b.mux(system.chosen, p, q) for p, q in zip(self._start, system.begun.start, strict=True))
            self._start = Start(*moved)
        self._bent = b.of(0)
        for system in systems:
            self._bent = system.chosen if system.m == -1 else self._bent
        self._residual = Residual(b, unit.angle_bits, steering=False, summing=len(systems) == 1)
        self._unsettled = max(system.table.unsettled for system in systems)
        self._beside = self._saves_a_cycle()
        self._ahead = math.inf

    def last(self) -> Last:
        """Return what all the steps end with."""
        b, start, unsettled = self._b, self._start, self._unsettled
        x, y, target, z = start.x, start.y, start.target, start.z
        goal = self._goal(0, target)
        for number in range(unsettled):
            with self._step(number):
                x, y, target, z, goal = self._turned(number, x, y, target, z, goal)
        gap, lost = target - y, b.of(0)
        if unsettled < self._unit.iterations:
            limit = self._largest_gap(unsettled)
            bits = limit.bit_length()
            if bits + 1 < gap.width:
                above = gap >> bits
                lost = b.named("lost", ~(above.equals(0) | above.equals(-1)))
                gap = b.narrowed(gap, -limit, limit, loose=True)
        for number in range(unsettled, self._unit.iterations):
            with self._step(number):
                x, gap, target, z = self._settled(number, x, gap, target, z)
        return Last(x, gap, self._residual.whole(z), lost)

    @contextmanager
    def _step(self, number: int) -> Iterator[None]:
        tables = [system.table for system in self._systems]
        turns = dict.fromkeys(
            f"{'twice ' * self._is_double(number, table)}the angle of 2^-{table.shifts[number]}"
            for table in tables
        )
        with self._b.scope(f"step{number + 1}"):
            self._b.note(f"Step {number + 1}: by {' or '.join(turns)}.")
            yield

    def _turned(
        self, number: int, *state: CircuitSignal
    ) -> tuple[CircuitSignal, CircuitSignal, CircuitSignal, CircuitSignal, CircuitSignal]:
        """Return x, y, the target, the angle and the goal after a step."""
        b = self._b
        moving = b.together(state, self._ahead)
        x, y, target, z, goal = moving
        if (parts := b.negif_of(state[1])) is not None:
            # A sign that waits beside its size costs no adder.
            size, minus, *_ = b.together((*parts, *moving), 0.0)
            y = b.negif(size, minus)
        gap = target - y
        if self._is_circular():
            limit = self._gap_to_go(number)
            gap = b.narrowed(gap, -limit, limit, loose=True)
        # Where x < 0 the vector turns back.
        up = b.mux(b.negative(x), ~b.negative(gap), b.negative(y) ^ self._bent)
        if self._beside:
            near = self._start.may_end & self._below("width", number, x)
            beyond = b.narrowed(goal - y, -limit, limit, loose=True)
            up = b.named("up", b.mux(near, up, ~b.negative(beyond)))
        else:
            up = self._or_to_the_end(number, x, gap, up)
        move = self._chosen([self._moves(number, system, x, y, target) for system in self._systems])
        # What does not depend on the direction comes first, beside the comparison.
        limit = self._limit(number + 1)
        x = b.named("x", self._narrowed(b.addsub(x - move.short_x, move.x, up ^ self._bent), limit))
        y = b.named("y", self._narrowed(b.addsub(y - move.short_y, move.y, ~up), limit))
        target = b.named("target", self._narrowed(target + move.target, limit))
        goal = b.named("goal", self._goal(number + 1, target))
        z = b.named("z", self._residual.after(z, move.angle, up))
        self._ahead = self._half(moving, up)
        return x, y, target, z, goal

    def _half(self, moving: Sequence[CircuitSignal], up: CircuitSignal) -> float:
        """Return the time to a step's direction: a step begins where that fits, and may end a cycle later."""
        taken = self._b.taken_ns(moving, (up,))
        return self._ahead if taken == math.inf else taken

    def _settled(
        self, number: int, *state: CircuitSignal
    ) -> tuple[CircuitSignal, CircuitSignal, CircuitSignal, CircuitSignal]:
        """Return x, the gap, the target, which stays, and the angle after a step."""
        b = self._b
        moving = b.together(state, self._ahead)
        x, gap, target, z = moving
        up = b.mux(b.negative(x), ~b.negative(gap), b.negative(target) ^ self._bent)
        up = self._or_to_the_end(number, x, gap, up)
        move = self._chosen([self._moves(number, system, x, target, target) for system in self._systems])
        limit, largest = self._largest_gap(number + 1), self._limit(number + 1)
        x = b.named("x", self._narrowed(b.addsub(x, move.x, up ^ self._bent), largest))
        gap = b.addsub(gap, move.y, up)
        gap = b.named("gap", b.narrowed(gap, -limit, limit, loose=True))
        z = b.named("z", self._residual.after(z, move.angle, up))
        self._ahead = self._half(moving, up)
        return x, gap, target, z

    def _or_to_the_end(
        self, number: int, x: CircuitSignal, gap: CircuitSignal, up: CircuitSignal
    ) -> CircuitSignal:
        """Return whether a step is upwards, from what it is elsewhere.

        Where x is within the width of the end of reach and the gap within a height, a turn is towards the
        end: upwards, for m = -1 downwards.
        """
        b, start, bent = self._b, self._start, self._bent
        near = start.may_end & self._below("width", number, x)
        # Only a gap that tells otherwise matters: a negative one, for m = -1 one that is not.
        close = self._below("height", number, b.bitwise("xor", gap, -(~bent)))
        end = b.named("end", near & close)
        return b.named("up", b.mux(bent, up | end, up & ~end))

    def _is_circular(self) -> bool:
        return len(self._systems) == 1 and self._systems[0].m == 1

    def _saves_a_cycle(self) -> bool:
        """Return whether a step takes fewer cycles if y is compared with the end of reach by itself."""
        free, delays = self._b.clocking.free_ns, self._b.clocking.delays
        if not self._is_circular() or free == math.inf:
            return False
        chain = delays.chain_ns + delays.carry_ns * self._unit.fraction_bits
        beside = 2 * chain + 3 * delays.table_ns
        known = self._systems[0].begun.height.is_known
        behind = beside + (2.5 * delays.table_ns if known else chain + 1.5 * delays.table_ns)
        # Of steps that fit into a cycle parts of two may share one.
        return beside <= free or math.ceil(beside / free) < math.ceil(behind / free)

    def _goal(self, number: int, target: CircuitSignal) -> CircuitSignal:
        """Return what y is at most before a step where the end of reach is near, if that is compared with."""
        if not self._beside:
            return self._b.of(0)
        system = self._systems[0]
        stretched = system.table.stretched[min(number, self._unit.iterations - 1)]
        return target + system.begun.height.before(self._b, stretched).value(self._b)

    def _below(self, which: str, number: int, value: CircuitSignal) -> CircuitSignal:
        """Return whether a value is not negative and below a threshold as it is before a step."""
        b, found = self._b, self._b.of(0)
        for system in self._systems:
            limit: Limit = getattr(system.begun, which)
            own = limit.before(b, system.table.stretched[number]).above(b, value)
            found = found | (system.chosen & own)
        return found

    def _chosen(self, moves: Sequence[_Moves]) -> _Moves:
        found = moves[0]
        for system, other in zip(self._systems[1:], moves[1:], strict=True):
            found = _Moves(*(self._b.mux(system.chosen, p, q) for p, q in zip(found, other, strict=True)))
        return found

    def _narrowed(self, a: CircuitSignal, limit: int) -> CircuitSignal:
        return self._b.narrowed(a, -limit, limit)

    def _limit(self, number: int) -> int:
        """Return the largest |x|, |y| and target before a step, which |target - y| has where it matters.

        On the circle a vector is at most the root of 2 times the gain so far, roundings and what x may lose
        where the target stands for y.
        """
        if any(system.m == -1 for system in self._systems):
            return 8 << self._unit.fraction_bits
        table, gain = self._systems[0].table, math.sqrt(2)
        for at, shift in enumerate(table.shifts[:number]):
            gain *= float(exact_stretch(1, shift, self._is_double(at, table)))
        return math.ceil(math.ldexp(gain * (1 + 2.0**-6), self._unit.fraction_bits)) + 64

    def _gap_to_go(self, number: int) -> int:
        """Return the largest |target - y| before a step on the circle where the direction matters.

        The vector is at most the turns to come from the target, or half a turn: the norm times this angle,
        the roundings, and what y may end from the target, or the end of reach be, are between them.
        """
        table, begun = self._systems[0].table, self._systems[0].begun
        angles = table.angles[number:] + table.angles[-1:]
        left = min(math.pi, math.ldexp(sum(angles), -self._unit.angle_bits))
        height = begun.height.largest
        return math.ceil(self._limit(number) * left) + 4 * begun.largest_gap + height

    def _largest_gap(self, number: int) -> int:
        """Return the largest |target - y| before a settled step of what ends within the largest gap."""
        moves = 0
        for at in range(number, self._unit.iterations):
            shift = min(system.table.shifts[at] for system in self._systems)
            moves += (self._limit(at) >> shift) + 1
        return max(system.begun.largest_gap for system in self._systems) + moves

    def _is_double(self, number: int, table: StepTable) -> bool:
        return self._unit.rule == "root-free" and number < table.doubles

    def _moves(
        self, number: int, system: _System, x: CircuitSignal, level: CircuitSignal, target: CircuitSignal
    ) -> _Moves:
        b, table = self._b, system.table
        shift, angle = table.shifts[number], b.of(table.angles[number])
        if self._is_double(number, table):
            squares = [b.rounded(each, 2 * shift) for each in (x, level, target)]
            if system.m < 0:
                squares = [-each for each in squares]
            x_squares, y_squares, grown = squares
            short = b.rounded(level, shift - 1), b.rounded(x, shift - 1)
            return _Moves(*short, x_squares, y_squares, grown, angle)
        if number >= table.unsettled:
            level, grown = target, b.of(0)
        elif self._unit.rule == "root-free":
            square = b.rounded(target, 2 * shift + 1)
            grown = square if system.m > 0 else -square
        else:
            factor = table.target_factors[number]
            grown = b.rounded(target * factor, FACTOR_BITS) if factor else b.of(0)
        return _Moves(b.rounded(level, shift), b.rounded(x, shift), b.of(0), b.of(0), grown, angle)


class _Moves(NamedTuple):
    """What a step adds or takes: x and y by the direction, and shortened; to the target; to z."""

    x: CircuitSignal
    y: CircuitSignal
    short_x: CircuitSignal
    short_y: CircuitSignal
    target: CircuitSignal
    angle: CircuitSignal
