"""The circuit of a standard unit: the iterations, shared by the functions that it is used for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

from cordicc.arith.circuits import circular, hyperbolic, linear
from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.shifting import times
from cordicc.arith.circuits.uses import (
    Modes,
    NoCircuitError,
    Raw,
    Raws,
    Turned,
    Use,
    Wanted,
    format_of,
    of_system,
    word,
)
from cordicc.arith.circuits.words import WordResult, encoded_angle
from cordicc.arith.kernels.reduction import SCALE_BITS
from cordicc.arith.unit.cau import Cau, standard_table

_FUNCTIONS: Mapping[str, Callable[..., tuple[Turned, Callable[[Turned, Wanted], Raws]]]] = {
    "rotate_circular": circular.rotation,
    "vector_circular": circular.vectoring,
    "rotate_linear": linear.rotation,
    "vector_linear": linear.vectoring,
    "rotate_hyperbolic": hyperbolic.rotation,
    "vector_hyperbolic": hyperbolic.vectoring,
    "lightcone": hyperbolic.lightcone,
}


def standard_unit(
    b: CircuitBuilder,
    unit: Cau,
    uses: tuple[Use, ...],
    operands: tuple[CircuitSignal, ...],
    mode: CircuitSignal,
    *,
    scale: int = 3,
) -> tuple[WordResult | None, WordResult | None]:
    """Return both results as words.

    Args:
        b: the builder.
        unit: the sizes of the unit.
        uses: what it is used for.
        operands: the words at its ports.
        mode: the number of the use.
        scale: registers in the products with the reciprocal gain.

    Raises:
        NoCircuitError: a use has none.
    """
    modes = Modes(b, mode, uses)
    words = tuple(word(modes, bits, number) for number, bits in enumerate(operands))
    functions = tuple(dict.fromkeys(use.function for use in uses))
    unknown = [name for name in functions if name not in _FUNCTIONS]
    if unknown:
        raise NoCircuitError(f"{unknown[0]} on a standard unit")
    begin, end = b.now, b.now
    states, finishes = [], []
    for name in functions:
        b.now = begin
        with b.scope(name.split("_")[0] if len(functions) > 1 else ""):
            state, finish = _FUNCTIONS[name](b, modes, unit, words, partial(_scaled, b, unit, scale))
        states.append(state)
        finishes.append(finish)
        end = max(end, b.now)
    b.now = end
    chosen = [modes.which(_has_function(name)) for name in functions]
    start = states[0]
    for bit, state in zip(chosen[1:], states[1:], strict=True):
        start = Turned(*(b.mux(bit, one, other) for one, other in zip(start, state, strict=True)))
    b.step()
    last = _iterations(b, modes, unit, start)
    begin, end = b.now, b.now
    raws = []
    for name, finish in zip(functions, finishes, strict=True):
        b.now = begin
        first, second = (
            any(use.function == name and use.results[number] is not None for use in uses)
            for number in range(2)
        )
        raws.append(finish(last, (first, second)))
        end = max(end, b.now)
    b.now = end
    results: list[WordResult | None] = [None, None]
    for number in range(2):
        format_ = format_of(modes, number, unit.angle_bits)
        if format_ is None:
            continue
        raw = None
        for bit, pair in zip(chosen, raws, strict=True):
            own = pair[number]
            if own is not None:
                raw = own if raw is None else Raw(*(b.mux(bit, x, y) for x, y in zip(raw, own, strict=True)))
        assert raw is not None
        found = encoded_angle(b, raw.mantissa, raw.exponent, format_, unit.angle_bits)
        results[number] = WordResult(found.word, found.valid & raw.valid)
    return results[0], results[1]


def _scaled(b: CircuitBuilder, unit: Cau, stages: int, m: int, coordinate: CircuitSignal) -> CircuitSignal:
    """Return a coordinate over the gain, with `SCALE_BITS` more bits."""
    table = standard_table(unit, m)
    product = times(b, coordinate, table.inverse_gain, stages)
    return b.named("scaled", b.rounded(product, table.coordinate_bits + 1 - SCALE_BITS))


def _has_function(name: str) -> Callable[[Use], bool]:
    return lambda use: use.function == name


class _System(NamedTuple):
    m: int
    chosen: CircuitSignal
    steps: Sequence[tuple[int, int]]


def _iterations(b: CircuitBuilder, modes: Modes, unit: Cau, start: Turned) -> Turned:
    """Turn (x, y) step by step: by z, or until y is nearly 0."""
    systems = []
    for m in (1, 0, -1):
        if any(use.m == m for use in modes.uses):
            table = standard_table(unit, m)
            chosen = modes.which(of_system(m))
            systems.append(_System(m, chosen, list(zip(table.shifts, table.angles, strict=True))))
    turning = modes.which(lambda use: use.op == "rotate")
    largest = 4 << unit.fraction_bits
    alone = len(systems) == 1
    x, y, z = start
    # Vectoring on the circle makes x longer only, and turning leaves ever less of the angle.
    growing = alone and systems[0].m == 1 and turning.hi == 0 and x.lo == 0
    ending = alone and systems[0].m != 0 and turning.lo == 1
    for number in range(unit.iterations):
        with b.scope(f"step{number + 1}"):
            shifts = " or ".join(dict.fromkeys(f"2^-{system.steps[number][0]}" for system in systems))
            b.note(f"Step {number + 1}: by the angle of {shifts}.")
            # Against the angle that is left, or towards the x axis.
            back = b.named("back", b.mux(turning, ~b.negative(y), b.negative(z)))
            dx, dy, angle = _moves(b, systems, number, x, y)
            away: CircuitSignal = ~back
            if any(system.m == -1 for system in systems):
                bent = b.of(0)
                for system in systems:
                    bent = system.chosen if system.m == -1 else bent
                away = away ^ bent
            turned = x if dx is None else b.addsub(x, dx, away)
            turned = b.named("x", b.narrowed(turned, 0 if growing else -largest, largest))
            y = b.named("y", b.narrowed(b.addsub(y, dy, back), -largest, largest))
            x = turned
            left = b.addsub(z, angle, ~back)
            if ending:
                left = b.narrowed(left, min(-angle.hi, z.lo + angle.hi), max(angle.hi - 1, z.hi - angle.hi))
            else:
                left = b.narrowed(left, -(7 << unit.angle_bits), 7 << unit.angle_bits)
            z = b.named("z", left)
            b.step()
    return Turned(x, y, z)


def _moves(
    b: CircuitBuilder, systems: Sequence[_System], number: int, x: CircuitSignal, y: CircuitSignal
) -> tuple[CircuitSignal | None, CircuitSignal, CircuitSignal]:
    """Return what a step adds to or takes from x, y and z."""
    dx: CircuitSignal | None = None
    dy: CircuitSignal | None = None
    angle: CircuitSignal | None = None
    for system in systems:
        shift, own = system.steps[number]
        flat = b.rounded(y, shift) if system.m else b.of(0)
        tall = b.rounded(x, shift)
        dx = flat if dx is None else b.mux(system.chosen, dx, flat)
        dy = tall if dy is None else b.mux(system.chosen, dy, tall)
        angle = b.of(own) if angle is None else b.mux(system.chosen, angle, own)
    assert dy is not None
    assert angle is not None
    return (None if all(system.m == 0 for system in systems) else dx), dy, angle
