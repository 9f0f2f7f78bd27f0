"""The circuit of a standard unit: the iterations, shared by the functions that it is used for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from cordicc.arith.circuits import circular, hyperbolic, linear
from cordicc.arith.circuits.builder import CircuitBuilder, CircuitSignal
from cordicc.arith.circuits.circuit import INDEX
from cordicc.arith.circuits.looping import looped
from cordicc.arith.circuits.residual import Residual
from cordicc.arith.circuits.scaling import over_gain
from cordicc.arith.circuits.shifting import shifted
from cordicc.arith.circuits.uses import (
    Coordinates,
    Modes,
    NoCircuitError,
    Raw,
    Turned,
    UnitFunction,
    Use,
    format_of,
    of_system,
    word,
)
from cordicc.arith.circuits.words import WordResult, encoded_angle
from cordicc.arith.unit.cau import Cau, standard_table

_FUNCTIONS: Mapping[str, Callable[..., UnitFunction]] = {
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
) -> tuple[WordResult | None, WordResult | None]:
    """Return both results as words.

    Args:
        b: the builder.
        unit: the sizes of the unit.
        uses: what it is used for.
        operands: the words at its ports.
        mode: the number of the use.

    Raises:
        NoCircuitError: a use has none.
    """
    modes = Modes(b, mode, uses)
    words = tuple(word(modes, bits, number) for number, bits in enumerate(operands))
    functions = tuple(dict.fromkeys(use.function for use in uses))
    unknown = [name for name in functions if name not in _FUNCTIONS]
    if unknown:
        raise NoCircuitError(f"{unknown[0]} on a standard unit")
    around = []
    for name in functions:
        with b.scope(name.split("_")[0] if len(functions) > 1 else ""):
            around.append(_FUNCTIONS[name](b, modes, unit, words))
    chosen = [modes.which(_has_function(name)) for name in functions]
    start = around[0].start
    for bit, each in zip(chosen[1:], around[1:], strict=True):
        start = Turned(*(b.mux(bit, one, other) for one, other in zip(start, each.start, strict=True)))
    make = _one_after_the_other if b.interval >= unit.iterations else _iterations
    last = make(b, modes, unit, start)
    wanted = [(_taken(uses, name, 0), _taken(uses, name, 1)) for name in functions]
    taken = [each.coordinates(last, results) for each, results in zip(around, wanted, strict=True)]
    systems = [next(use.m for use in uses if use.function == name) for name in functions]
    scaled = _over_the_gains(b, unit, list(zip(chosen, systems, taken, strict=True)))
    raws = [
        each.finish(last, coordinates, results)
        for each, coordinates, results in zip(around, scaled, wanted, strict=True)
    ]
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


def _taken(uses: Sequence[Use], function: str, number: int) -> bool:
    """Tell whether a result of a function is taken in some use."""
    return any(use.function == function and use.results[number] is not None for use in uses)


def _over_the_gains(
    b: CircuitBuilder, unit: Cau, functions: Sequence[tuple[CircuitSignal, int, Coordinates]]
) -> list[Coordinates]:
    """Return the coordinates of functions over the gains of their systems, with `SCALE_BITS` more bits.

    Of the functions of a system one is at work at a time, and so they share two products.
    """
    found: list[list[CircuitSignal | None]] = [[None, None] for _ in functions]
    for place in range(2):
        for m in (1, -1):
            of_system = [
                (number, bit, coordinate)
                for number, (bit, system, coordinates) in enumerate(functions)
                if system == m and (coordinate := coordinates[place]) is not None
            ]
            if not of_system:
                continue
            coordinate = of_system[0][2]
            for _, bit, other in of_system[1:]:
                coordinate = b.mux(bit, coordinate, other)
            quotient = b.named("scaled", over_gain(b, coordinate, standard_table(unit, m)))
            for number, _, _ in of_system:
                found[number][place] = quotient
    return [(first, second) for first, second in found]


def _has_function(name: str) -> Callable[[Use], bool]:
    return lambda use: use.function == name


class _System(NamedTuple):
    m: int
    chosen: CircuitSignal
    steps: Sequence[tuple[int, int]]


def _systems(modes: Modes, unit: Cau) -> list[_System]:
    found = []
    for m in (1, 0, -1):
        if any(use.m == m for use in modes.uses):
            table = standard_table(unit, m)
            chosen = modes.which(of_system(m))
            found.append(_System(m, chosen, list(zip(table.shifts, table.angles, strict=True))))
    return found


def _one_after_the_other(b: CircuitBuilder, modes: Modes, unit: Cau, start: Turned) -> Turned:
    """Turn (x, y) as `_iterations` does, with the hardware of one step."""
    systems = _systems(modes, unit)
    largest = 4 << unit.fraction_bits
    turns = max(sum(angle for _, angle in system.steps) for system in systems)
    span = min(start.z.lo, 0) - turns, max(start.z.hi, 0) + turns
    kept = {f"system{number}": system.chosen for number, system in enumerate(systems)}
    kept["turning"] = modes.which(lambda use: use.op == "rotate")

    def step(inner: CircuitBuilder, now: Mapping[str, CircuitSignal]) -> dict[str, CircuitSignal]:
        x, y, z, index = now["x"], now["y"], now["z"], now[INDEX]
        back = inner.named("back", inner.mux(now["turning"], ~inner.negative(y), inner.negative(z)))
        shift, angle, flat, bent = (inner.of(0) for _ in range(4))
        for number, system in enumerate(systems):
            chosen = now[f"system{number}"]
            shifts, angles = (inner.pick(index, column) for column in zip(*system.steps, strict=True))
            shift = shifts if not number else inner.mux(chosen, shift, shifts)
            angle = angles if not number else inner.mux(chosen, angle, angles)
            flat = chosen if system.m == 0 else flat
            bent = chosen if system.m == -1 else bent
        with inner.scope("tall"):
            dy = shifted(inner, x, shift, x.width + 1)
        with inner.scope("flat"):
            dx = inner.mux(flat, shifted(inner, y, shift, y.width + 1), 0)
        return {
            "x": inner.addsub(x, dx, ~back ^ bent),
            "y": inner.addsub(y, dy, back),
            "z": inner.addsub(z, angle, ~back),
        }

    b.note(f"{unit.iterations} steps, one after the other.")
    sizes = -largest, largest
    states = {"x": (start.x, sizes), "y": (start.y, sizes), "z": (start.z, span)}
    last = looped(b, unit.iterations, states, kept, step)
    return Turned(*(b.named(name, last[name]) for name in ("x", "y", "z")))


def _iterations(b: CircuitBuilder, modes: Modes, unit: Cau, start: Turned) -> Turned:
    """Turn (x, y) step by step: by z, or until y is nearly 0."""
    systems = _systems(modes, unit)
    turning = modes.which(lambda use: use.op == "rotate")
    largest = 4 << unit.fraction_bits
    alone = len(systems) == 1
    x, y, z = start
    bounds = (
        _Bounds.of(systems[0].m, unit, turning=bool(turning.lo))
        if alone and turning.lo == turning.hi
        else None
    )
    ending = alone and turning.lo == 1
    residual = Residual(b, unit.angle_bits, steering=ending, summing=alone and turning.hi == 0)
    ahead = math.inf
    for number in range(unit.iterations):
        state = b.together((x, y, z), ahead)
        x, y, z = state
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
            left = b.addsub(y, dy, back)
            if bounds is not None:
                bounds = bounds.after(systems[0].steps[number][0])
                turned = b.narrowed(turned, bounds.least, bounds.length, loose=bounds.m == 0)
                left = b.narrowed(left, -bounds.height, bounds.height, loose=bounds.m == 0)
            x = b.named("x", b.narrowed(turned, -largest, largest))
            y = b.named("y", b.narrowed(left, -largest, largest))
            z = b.named("z", residual.after(z, angle, back))
            ahead = b.taken_ns(state, (x, y, z))
    return Turned(x, y, residual.whole(z))


class _Bounds(NamedTuple):
    """The largest length of a vector; vectoring leaves of one with x >= 0 |y| <= slope * x + excess.

    A step by 2^-S makes |y| - x 2^-S of |y|, and x longer by |y| 2^-S on the circle, each rounded half up.
    So slope' = max(slope - 2^-S, 2^-S) holds, with half a place more, and on the circle as many as x' may be
    too short.
    """

    m: int
    turning: bool
    slope: float
    excess: float
    norm: float

    @classmethod
    def of(cls, m: int, unit: Cau, *, turning: bool) -> _Bounds | None:
        """Return the bounds of what begins, None of hyperbolic iterations and of products."""
        if m < 0 or (m == 0 and turning):
            return None
        if m == 0:
            return cls(m, turning, 2.0, 0.0, math.ldexp(1.0, unit.fraction_bits + 1))
        return cls(m, turning, math.inf, 0.0, math.ldexp(math.sqrt(2), unit.fraction_bits) + 1)

    def after(self, shift: int) -> _Bounds:
        """Return the bounds after a step by 2^-shift."""
        move = 2.0**-shift
        if self.m == 0:
            return self._replace(slope=max(self.slope - move, move), excess=self.excess + 0.5)
        if self.slope == math.inf:
            # The first step, by 1: |y| - x is at most x + |y|, and so is x - |y|.
            assert shift == 0
            slope, excess = 1.0, 1.0
        else:
            slope = max(self.slope - move, move)
            excess = self.excess + 0.5 + 0.5 * slope
        return self._replace(
            slope=slope, excess=excess, norm=math.hypot(1.0, move) * self.norm + math.sqrt(0.5)
        )

    @property
    def least(self) -> int:
        """The least x."""
        return -self.length if self.turning else 0

    @property
    def length(self) -> int:
        """The largest x."""
        return math.ceil(self.norm)

    @property
    def height(self) -> int:
        """The largest |y|."""
        if self.turning:
            return self.length
        return min(math.ceil(self.slope * self.norm + self.excess), self.length)


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
