"""The circuit of an implicit unit: B cos t + A sin t = C solved by turning (A, B) until y = C."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.circular_solving import Solved, Start, circular
from cordicc.arith.circuits.hyperbolic_solving import hyperbolic
from cordicc.arith.circuits.residual import Residual
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.uses import Modes, Use, format_of, of_system, word
from cordicc.arith.circuits.words import WordResult, encoded, encoded_angle
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.kernels.shift_sequences import FACTOR_BITS, SHARES, StepTable
from cordicc.arith.unit.cau import Cau, implicit_table


class _System(NamedTuple):
    m: int
    chosen: CircuitSignal
    table: StepTable
    start: Start
    finish: Callable[[Start], Solved]


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
            start, finish = make(b, modes, unit, words)
            chosen = modes.which(of_system(m))
            systems.append(_System(m, chosen, implicit_table(unit, m).steps, start, finish))
    state = systems[0].start
    for system in systems[1:]:
        state = Start(*(b.mux(system.chosen, x, y) for x, y in zip(state, system.start, strict=True)))
    state = _steps(b, state, systems, unit)
    solved = systems[0].finish(state)
    for system in systems[1:]:
        solved = Solved(
            *(b.mux(system.chosen, x, y) for x, y in zip(solved, system.finish(state), strict=True))
        )
    formats = [format_of(modes, number, unit.angle_bits) for number in range(2)]
    results: list[WordResult | None] = [None, None]
    if formats[0] is not None:
        found = encoded_angle(b, solved.angle, -unit.angle_bits, formats[0], unit.angle_bits)
        results[0] = WordResult(found.word, found.valid & solved.possible)
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


def _steps(b: CircuitBuilder, state: Start, systems: Sequence[_System], unit: Cau) -> Start:
    """Turn (x, y) step by step until y is the target and x >= 0."""
    largest = 8 << unit.fraction_bits
    bent = b.of(0)
    for system in systems:
        bent = system.chosen if system.m == -1 else bent
    root_free = unit.rule == "root-free"
    # The target keeps its sign.  Towards the end of reach is its own direction, or against it.
    end = _End(b, systems, state, b.negative(state.target), bent)
    residual = Residual(b, unit.angle_bits, steering=False, summing=len(systems) == 1)
    goal = b.named("goal", state.target + end.bias(0))
    ahead = math.inf
    for number in range(unit.iterations):
        moving = b.together((state.x, state.y, state.target, goal, state.z), ahead)
        x, y, target, goal, z = moving
        state = state._replace(x=x, y=y, target=target, z=z)
        with b.scope(f"step{number + 1}"):
            shifts = " or ".join(dict.fromkeys(f"2^-{system.table.shifts[number]}" for system in systems))
            b.note(f"Step {number + 1}: by {'twice ' * root_free}the angle of {shifts}.")
            gap, beyond = target - y, goal - y
            if len(systems) == 1 and systems[0].m == 1:
                limit = end.largest_gap(systems[0].table, number, unit)
                gap, beyond = (b.narrowed(each, -limit, limit, loose=True) for each in (gap, beyond))
            forward = ~b.mux(end.near(number, x), b.negative(gap), b.negative(beyond))
            up = b.named("up", b.mux(b.negative(x), forward, b.negative(y) ^ bent))
            moves = [_moves(b, state, system, number, root_free=root_free) for system in systems]
            chosen = moves[0]
            for system, other in zip(systems[1:], moves[1:], strict=True):
                chosen = _Moves(*(b.mux(system.chosen, p, q) for p, q in zip(chosen, other, strict=True)))
            # What does not depend on the direction comes first, beside the comparison.
            x = b.named("x", b.narrowed(b.addsub(x - chosen.short_x, chosen.x, up ^ bent), -largest, largest))
            y = b.named("y", b.narrowed(b.addsub(y - chosen.short_y, chosen.y, ~up), -largest, largest))
            bias, following = end.bias(number), end.bias(number + 1)
            grown = goal if following.number == bias.number else target + following
            goal = b.named("goal", b.narrowed(grown + chosen.target, -2 * largest, 2 * largest))
            target = b.named("target", b.narrowed(target + chosen.target, -largest, largest))
            z = b.named("z", residual.after(z, chosen.angle, up))
            state = state._replace(x=x, y=y, target=target, z=z)
            ahead = b.taken_ns(moving, (x, y, z))
    return state._replace(z=residual.whole(state.z))


class _End:
    """Where the sign of x decides: within a width of the end of reach, and a height of the target.

    There a turn is in the target's direction, against it for m = -1: for a height h that is sgn(T - y + h)
    upwards and sgn(T - y - h - 1) downwards, which a number beside the target gives.
    """

    def __init__(
        self,
        b: CircuitBuilder,
        systems: Sequence[_System],
        state: Start,
        negative: CircuitSignal,
        bent: CircuitSignal,
    ) -> None:
        self._b = b
        self._systems = systems
        self._state = state
        self._down = b.named("down", negative ^ bent)

    def bias(self, number: int) -> CircuitSignal:
        """Return what is added to the target before a step, or after the last one."""
        b, height = self._b, self._before(self._state.height, number)
        return b.narrowed(b.bitwise("xor", height, -self._down), -height.hi - 1, height.hi)

    def near(self, number: int, x: CircuitSignal) -> CircuitSignal:
        """Return whether an x that is not negative is positive and within the width."""
        width = self._before(self._state.width, number)
        return (~x.equals(0) & self._state.may_end) & (x <= width)

    def largest_gap(self, table: StepTable, number: int, unit: Cau) -> int:
        """Return the largest |T - y|, biased or not, before a circular step where there is a solution.

        The vector is at most the turns to come from the target, or half a turn: the norm times this angle,
        the roundings, and what y may end from the target are between them.
        """
        left = min(math.pi, math.ldexp(sum(table.angles[number:]) + table.angles[-1], -unit.angle_bits))
        norm = math.ldexp(math.sqrt(2), unit.fraction_bits) * _STRETCH
        return math.ceil(norm * left) + 4 * self._state.short.hi + self._state.height.hi

    def _before(self, size: CircuitSignal, number: int) -> CircuitSignal:
        found: CircuitSignal | None = None
        for system in self._systems:
            shares = system.table.stretched
            own = _share(self._b, size, shares[min(number, len(shares) - 1)])
            found = own if found is None else self._b.mux(system.chosen, found, own)
        assert found is not None
        return found


_STRETCH = 2.75
"""More than the gain of root-free iterations on the circle, the larger one."""


def _share(b: CircuitBuilder, size: CircuitSignal, stretched: int) -> CircuitSignal:
    """Return a threshold as it is before a step, from the gain so far as a share of the whole one."""
    if stretched == SHARES:
        return size
    return (times(b, size, stretched) + (SHARES - 1)) >> (SHARES.bit_length() - 1)


class _Moves(NamedTuple):
    """What a step adds or takes: x and y by the direction, and shortened; to the target; to z."""

    x: CircuitSignal
    y: CircuitSignal
    short_x: CircuitSignal
    short_y: CircuitSignal
    target: CircuitSignal
    angle: CircuitSignal


def _moves(b: CircuitBuilder, state: Start, system: _System, number: int, *, root_free: bool) -> _Moves:
    shift, angle = system.table.shifts[number], b.of(system.table.angles[number])
    x, y, target = state.x, state.y, state.target
    if root_free:
        squares = [b.rounded(each, 2 * shift) for each in (x, y, target)]
        if system.m < 0:
            squares = [-each for each in squares]
        short_x, short_y, grown = squares
        return _Moves(b.rounded(y, shift - 1), b.rounded(x, shift - 1), short_x, short_y, grown, angle)
    factor = system.table.target_factors[number]
    grown = b.rounded(target * factor, FACTOR_BITS) if factor else b.of(0)
    return _Moves(b.rounded(y, shift), b.rounded(x, shift), b.of(0), b.of(0), grown, angle)
